//! What synthesis starts from: a triple for every voxel of the coarsest level, for any seed.

use breccia_engine::{Data, Digest};

use super::jitter::Jitter;
use super::pyramid::{LevelView, Pixel};
use super::random::{hash, mix};
use crate::data::{Reader, Writer};

const SHIFT: u32 = 1;
const RANDOM: u32 = 2;

/// Layers of a slab: the neighbourhood's width.
pub(super) const LAYERS: i32 = 5;

/// How the coarsest level is filled before its first correction: with tiles of a candidate slab or at random,
/// then distorted.
#[derive(Clone, Debug, PartialEq)]
pub struct Initial {
    /// Size of the slab in voxels along x and y; it has five layers along z.
    pub size: [i32; 2],
    /// Triples of the slab, x fastest, then y, then layers; empty means random pixels.
    pub slab: Vec<[Pixel; 3]>,
    /// Whether the slab's layers lie exactly above each other, for structures that run along z.
    pub aligned: bool,
    /// The distortion, if any.
    pub jitter: Option<Jitter>,
}

impl Initial {
    /// The triple of an undistorted voxel. Unless columns are what is wanted, every layer of five voxels is shifted in its
    /// plane by a hash, since plain repetition shows as columns.
    pub(super) fn triple(&self, seed: u64, voxel: [i32; 3], views: [&LevelView; 3]) -> [Pixel; 3] {
        if self.slab.is_empty() {
            return std::array::from_fn(|e| {
                let view = views[e];
                let m = view.margin();
                let scale = |h: u32, n: i32| ((u64::from(h & 0xffff) * n as u64) >> 16) as i32;
                let draw = |h: u32| {
                    view.pixel(m + scale(h, view.width - 2 * m), m + scale(h >> 16, view.height - 2 * m))
                };
                let first = hash(seed, RANDOM + e as u32, voxel);
                // Of pixels that must not be copied, others are drawn; the search that follows finds the way out of the rest.
                let draws = (0..32).map(|k| draw(if k == 0 { first } else { mix(first, k) }));
                draws.into_iter().find(|&pixel| view.is_free(pixel)).unwrap_or_else(|| draw(first))
            });
        }
        let [w, h] = self.size;
        let layer = voxel[2].div_euclid(LAYERS);
        let shift = hash(seed, SHIFT, [0, 0, if self.aligned { 0 } else { layer }]);
        let x = voxel[0].wrapping_add((shift & 0xffff) as i32).rem_euclid(w);
        let y = voxel[1].wrapping_add((shift >> 16) as i32).rem_euclid(h);
        self.slab[((voxel[2].rem_euclid(LAYERS) * h + y) * w + x) as usize]
    }
}

impl Data for Initial {
    const TYPE: &'static str = "initial";
    const DOCS: &'static str = "What lazy synthesis starts from: a slab or random pixels, and a distortion.";

    fn byte_size(&self) -> u64 {
        self.slab.len() as u64 * 6
    }

    fn summary(&self) -> String {
        let start = match &self.slab[..] {
            [] => "random pixels".to_owned(),
            _ => format!("slab of {} × {} × {LAYERS}", self.size[0], self.size[1]),
        };
        self.jitter.map_or(start.clone(), |jitter| format!("{start}, jitter {}", jitter.amount))
    }

    fn digest(&self) -> Digest {
        Digest::of(&self.encode().unwrap_or_default())
    }

    fn encode(&self) -> Option<Vec<u8>> {
        let mut out = Writer::new();
        out.array(&self.size).array(&self.slab).u64(self.aligned.into());
        let jitter =
            self.jitter.map(|j| vec![j.amount, j.sigma_min, j.sigma_max, j.density]).unwrap_or_default();
        out.array(&jitter);
        Some(out.finish())
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = Reader::new(bytes);
        let size: [i32; 2] = reader.array()?.try_into().map_err(|_| "a slab's size is two numbers")?;
        let slab: Vec<[Pixel; 3]> = reader.array()?;
        if !slab.is_empty()
            && (size[0] < 1 || slab.len() as i64 != i64::from(size[0]) * i64::from(size[1]) * 5)
        {
            return Err("a slab does not fit its size".to_owned());
        }
        let aligned = reader.u64()? != 0;
        let jitter = match reader.array::<f64>()?[..] {
            [] => None,
            [amount, sigma_min, sigma_max, density] => Some(Jitter { amount, sigma_min, sigma_max, density }),
            _ => return Err("a jitter is four numbers".to_owned()),
        };
        reader.end()?;
        Ok(Self { size, slab, aligned, jitter })
    }
}
