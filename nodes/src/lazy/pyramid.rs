//! The exemplar pyramid (Dong et al. 2008, section 4: candidates are made on each level of it).

use breccia_engine::{Data, Digest};

use crate::data::{Reader, Writer};
use crate::exemplar::{Exemplar, ExemplarError, halve};

/// The neighbourhood is 5 × 5 pixels, in the paper's terms N = 5.
pub const N: usize = 5;
/// Pixels from the centre of a neighbourhood to its border.
pub const RADIUS: i32 = 2;
/// The coarsest level keeps at least this many pixels a side.
pub const LEAST_SIDE: u32 = 8;

/// A pixel coordinate in two bytes: x + 256 y.
pub type Pixel = u16;

/// One view of an exemplar at one level.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelView {
    /// Pixels in a row, 1 to 256.
    pub width: i32,
    /// Rows, 1 to 256.
    pub height: i32,
    /// Whether the picture continues at the opposite edge.
    pub tileable: bool,
    /// Colour and feature channel.
    pub texels: Vec<[u8; 4]>,
    /// Pixels that a synthesis must not copy, row by row; empty if it may copy all of them.
    pub barred: Vec<bool>,
}

impl LevelView {
    /// Pixels between the edge and the first pixel whose neighbourhood lies inside; 0 if tileable.
    pub fn margin(&self) -> i32 {
        if self.tileable { 0 } else { RADIUS.min((self.width.min(self.height) - 1) / 2) }
    }

    /// The pixel nearest to `(x, y)` that can be the centre of a neighbourhood: around the edges if the
    /// picture continues there, else clamped.
    #[inline(always)]
    pub fn pixel(&self, x: i32, y: i32) -> Pixel {
        let (x, y) = if self.tileable {
            (x.rem_euclid(self.width), y.rem_euclid(self.height))
        } else {
            let m = self.margin();
            (x.clamp(m, self.width - 1 - m), y.clamp(m, self.height - 1 - m))
        };
        (x | y << 8) as Pixel
    }

    /// The pixel at an offset from another.
    #[inline(always)]
    pub fn shifted(&self, pixel: Pixel, dx: i32, dy: i32) -> Pixel {
        self.pixel(i32::from(pixel & 255) + dx, i32::from(pixel >> 8) + dy)
    }

    /// A pixel's index in [`LevelView::texels`].
    #[inline(always)]
    pub fn index(&self, pixel: Pixel) -> usize {
        usize::from(pixel >> 8) * self.width as usize + usize::from(pixel & 255)
    }

    /// Whether a pixel lies in the view.
    pub fn holds(&self, pixel: Pixel) -> bool {
        i32::from(pixel & 255) < self.width && i32::from(pixel >> 8) < self.height
    }

    /// The texel at `(x, y)`, around or clamped to the edges.
    pub fn texel(&self, x: i32, y: i32) -> [u8; 4] {
        let (x, y) = if self.tileable {
            (x.rem_euclid(self.width), y.rem_euclid(self.height))
        } else {
            (x.clamp(0, self.width - 1), y.clamp(0, self.height - 1))
        };
        self.texels[(y * self.width + x) as usize]
    }

    /// Whether a synthesis may copy a pixel.
    #[inline(always)]
    pub fn is_free(&self, pixel: Pixel) -> bool {
        self.barred.is_empty() || !self.barred[self.index(pixel)]
    }

    /// All pixels that can be centres of neighbourhoods, row by row: those that may be copied, if there are any.
    pub fn centres(&self) -> Vec<Pixel> {
        let m = self.margin();
        let all = (m..self.height - m).flat_map(|y| (m..self.width - m).map(move |x| (x | y << 8) as Pixel));
        let free: Vec<Pixel> = all.clone().filter(|&pixel| self.is_free(pixel)).collect();
        if free.is_empty() { all.collect() } else { free }
    }

    /// The 5 × 5 neighbourhood of a pixel, row by row.
    pub fn neighbourhood(&self, pixel: Pixel) -> [[u8; 4]; N * N] {
        let (x, y) = (i32::from(pixel & 255), i32::from(pixel >> 8));
        std::array::from_fn(|k| self.texel(x + k as i32 % 5 - RADIUS, y + k as i32 / 5 - RADIUS))
    }
}

/// The views of an exemplar at every level, finest first.
#[derive(Clone, Debug, PartialEq)]
pub struct Pyramid {
    /// For each level, one view for all three directions or one a direction.
    pub levels: Vec<Vec<LevelView>>,
}

impl Pyramid {
    /// Halves every view `levels - 1` times. `levels` 0 goes on while the coarsest level keeps 32 pixels a side, or, with one
    /// view without a mask or guide, twice as many after the first halving: a feature distance survives more halving than
    /// colours do, whose fine structures come out as blotches and diagonals if synthesis starts too coarse. Three views
    /// describe directed materials, whose long structures want a coarse start.
    ///
    /// # Errors
    /// If a view would be smaller than [`LEAST_SIDE`] at the coarsest level.
    pub fn new(exemplar: &Exemplar, levels: usize) -> Result<Self, ExemplarError> {
        let smallest = exemplar.views.iter().map(|v| v.width.min(v.height)).min().unwrap_or(0);
        let keeping = |side: u32| (smallest / side).max(1).ilog2() as usize + 1;
        let coarse = exemplar.views.len() > 1 || exemplar.views.iter().all(|view| view.guided);
        let most = if coarse { keeping(32) } else { keeping(64).max(keeping(32).min(2)) };
        let levels = if levels == 0 { most } else { levels };
        for view in &exemplar.views {
            let least = LEAST_SIDE << (levels - 1);
            if view.width.min(view.height) < least {
                let (width, height) = (view.width, view.height);
                let hint =
                    " for that many levels (a neighbourhood must fit into every level): ask for fewer levels";
                return Err(ExemplarError::TooSmall { width, height, least, hint });
            }
        }
        let mut all: Vec<Vec<LevelView>> = vec![
            exemplar
                .views
                .iter()
                .map(|view| LevelView {
                    width: view.width as i32,
                    height: view.height as i32,
                    tileable: view.tileable,
                    texels: view.texels.clone(),
                    barred: view.barred.clone(),
                })
                .collect(),
        ];
        for _ in 1..levels {
            let next = all[all.len() - 1].iter().map(|view| {
                let barred: Vec<u8> = view.barred.iter().map(|&b| u8::from(b)).collect();
                let barred = if barred.is_empty() {
                    Vec::new()
                } else {
                    // One of four that may not be copied bars the pixel that they become.
                    let grown: Vec<u8> = barred.iter().map(|&b| 4 * b).collect();
                    halve(&grown, view.width as usize, view.height as usize, 1).0
                };
                let flat: &[u8] = bytemuck::cast_slice(&view.texels);
                let (pixels, w, h) = halve(flat, view.width as usize, view.height as usize, 4);
                LevelView {
                    width: w as i32,
                    height: h as i32,
                    tileable: view.tileable,
                    texels: bytemuck::cast_slice(&pixels).to_vec(),
                    barred: barred.iter().map(|&b| b > 0).collect(),
                }
            });
            let next = next.collect();
            all.push(next);
        }
        Ok(Self { levels: all })
    }

    /// The view of a direction at a level.
    pub fn view(&self, level: usize, direction: usize) -> &LevelView {
        let views = &self.levels[level];
        &views[direction.min(views.len() - 1)]
    }
}

impl Data for Pyramid {
    const TYPE: &'static str = "pyramid";
    const DOCS: &'static str = "The views of an exemplar at every level of resolution.";

    fn byte_size(&self) -> u64 {
        self.levels.iter().flatten().map(|view| view.texels.len() as u64 * 4).sum()
    }

    fn summary(&self) -> String {
        let sizes: Vec<_> = self.levels.iter().map(|l| format!("{} × {}", l[0].width, l[0].height)).collect();
        sizes.join(", ")
    }

    fn digest(&self) -> Digest {
        Digest::of(&self.encode().unwrap_or_default())
    }

    fn encode(&self) -> Option<Vec<u8>> {
        let mut out = Writer::new();
        out.u64(self.levels.len() as u64).u64(self.levels.first().map_or(0, Vec::len) as u64);
        for view in self.levels.iter().flatten() {
            out.u64(view.width as u64).u64(view.height as u64).u64(view.tileable.into()).array(&view.texels);
            out.bytes(&view.barred.iter().map(|&b| u8::from(b)).collect::<Vec<_>>());
        }
        Some(out.finish())
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = Reader::new(bytes);
        let (levels, views) = (reader.u64()?, reader.u64()?);
        let mut pyramid = Self { levels: Vec::new() };
        for _ in 0..levels {
            let mut level = Vec::new();
            for _ in 0..views {
                let (width, height) = (reader.u32()? as i32, reader.u32()? as i32);
                let (tileable, texels) = (reader.u64()? != 0, reader.array()?);
                let barred = reader.bytes()?.iter().map(|&b| b != 0).collect();
                let view = LevelView { width, height, tileable, texels, barred };
                let sides = 1..=256;
                if !sides.contains(&width)
                    || !sides.contains(&height)
                    || view.texels.len() != (width * height) as usize
                    || !view.barred.is_empty() && view.barred.len() != view.texels.len()
                {
                    return Err("a level's texels do not fit its size".to_owned());
                }
                level.push(view);
            }
            pyramid.levels.push(level);
        }
        reader.end()?;
        Ok(pyramid)
    }
}
