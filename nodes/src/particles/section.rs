//! Cross-sections of particles in a picture, as they come from a mask (Du et al. 2013, section 3.1).

use breccia_engine::{Data, Digest};
use serde::{Deserialize, Serialize};

use crate::data::{Reader, Writer, pack, unpack};
use crate::exemplar::{Exemplar, View};

/// One cross-section: a connected set of pixels.
///
/// Pixels may lie beyond the picture: around its edges if it is tileable, mirrored at them if the section was completed by
/// symmetry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Section {
    /// Column and row of the first pixel of the bounding box.
    pub low: [i32; 2],
    /// Columns and rows of the bounding box.
    pub size: [u32; 2],
    /// Which pixels of the box belong to the section, row by row.
    pub inside: Vec<bool>,
    /// Pixels.
    pub area: u32,
    /// The mean of the pixels' columns and rows; a pixel's centre is at its whole coordinates.
    pub centroid: [f32; 2],
    /// Whether the border of the picture cuts it.
    pub cut: bool,
}

impl Section {
    /// A section from its pixels; `None` without any.
    pub fn of(pixels: &[[i32; 2]], cut: bool) -> Option<Self> {
        let &first = pixels.first()?;
        let (mut low, mut high, mut sum) = (first, first, [0i64; 2]);
        for pixel in pixels {
            for i in 0..2 {
                low[i] = low[i].min(pixel[i]);
                high[i] = high[i].max(pixel[i]);
                sum[i] += i64::from(pixel[i]);
            }
        }
        let size: [u32; 2] = std::array::from_fn(|i| high[i].abs_diff(low[i]) + 1);
        let mut inside = vec![false; (size[0] * size[1]) as usize];
        for [x, y] in pixels {
            inside[((y - low[1]) * size[0] as i32 + x - low[0]) as usize] = true;
        }
        let area = inside.iter().filter(|&&i| i).count() as u32;
        let centroid = sum.map(|s| (s as f64 / pixels.len() as f64) as f32);
        Some(Self { low, size, inside, area, centroid, cut })
    }

    /// Whether a pixel belongs to the section.
    #[inline]
    pub fn holds(&self, x: i32, y: i32) -> bool {
        let (x, y) = (x - self.low[0], y - self.low[1]);
        x >= 0
            && y >= 0
            && (x as u32) < self.size[0]
            && (y as u32) < self.size[1]
            && self.inside[(y as u32 * self.size[0] + x as u32) as usize]
    }

    /// The pixels, row by row.
    pub fn pixels(&self) -> impl Iterator<Item = [i32; 2]> + '_ {
        let width = self.size[0] as usize;
        self.inside
            .iter()
            .enumerate()
            .filter(|(_, inside)| **inside)
            .map(move |(i, _)| [self.low[0] + (i % width) as i32, self.low[1] + (i / width) as i32])
    }

    /// For every pixel of the box, how far it lies from the nearest pixel outside the section; 0 outside.
    pub fn depth(&self) -> Vec<f32> {
        let (w, h) = (self.size[0] as usize + 2, self.size[1] as usize + 2);
        let mut outside = vec![1u32; w * h];
        for (i, &inside) in self.inside.iter().enumerate() {
            if inside {
                outside[(i / (w - 2) + 1) * w + i % (w - 2) + 1] = 0;
            }
        }
        let found = super::cells::cells(&outside, [w, h, 1], false, &());
        let squared = found.map(|cells| cells.squared).unwrap_or_default();
        (0..self.inside.len())
            .map(|i| {
                let at = (i / (w - 2) + 1) * w + i % (w - 2) + 1;
                libm::sqrt(f64::from(squared.get(at).copied().unwrap_or(0))) as f32
            })
            .collect()
    }
}

/// The cross-sections of one picture, and what surrounds them.
#[derive(Clone, Debug, PartialEq)]
pub struct Sections {
    /// The picture with its carried maps.
    pub view: View,
    /// For each pixel of the picture, whether the mask says that it belongs to a particle.
    pub mask: Vec<bool>,
    /// The sections, by their first pixels, row by row.
    pub sections: Vec<Section>,
    /// Particles of the mask that were left out: cut by the border, too small, too large.
    pub left_out: u32,
    /// The fraction of the picture that the mask covers.
    pub fraction: f32,
    /// How thin the matrix is where it is thinnest between a section and another, in pixels, mean over the sections.
    pub thickness: f32,
}

/// The parts of [`Sections`] whose form on disk is derived.
#[derive(Serialize, Deserialize)]
struct Packed {
    mask: Vec<bool>,
    sections: Vec<Section>,
    left_out: u32,
    fraction: f32,
    thickness: f32,
}

impl Sections {
    /// The index of a pixel in the picture: around the edges if it is tileable, else mirrored at them.
    #[inline]
    pub fn pixel(&self, x: i32, y: i32) -> usize {
        pixel_index(&self.view, x, y)
    }
}

/// See [`Sections::pixel`].
#[inline]
pub(crate) fn pixel_index(view: &View, x: i32, y: i32) -> usize {
    let place = |c: i32, n: i32| {
        if (0..n).contains(&c) {
            c
        } else if view.tileable {
            c.rem_euclid(n)
        } else {
            let c = c.rem_euclid(2 * n);
            if c < n { c } else { 2 * n - 1 - c }
        }
    };
    let (w, h) = (view.width as i32, view.height as i32);
    (place(y, h) * w + place(x, w)) as usize
}

impl Data for Sections {
    const TYPE: &'static str = "sections";
    const DOCS: &'static str = "The cross-sections of particles in one picture.";

    fn byte_size(&self) -> u64 {
        let pixels = self.view.texels.len() as u64;
        pixels * 9 + self.sections.iter().map(|s| s.inside.len() as u64 + 48).sum::<u64>()
    }

    fn summary(&self) -> String {
        let percent = self.fraction * 100.0;
        format!(
            "{} cross-sections ({} left out), {percent:.1} % of the picture, {:.1} pixels apart",
            self.sections.len(),
            self.left_out,
            self.thickness
        )
    }

    fn digest(&self) -> Digest {
        Digest::of(&self.encode().unwrap_or_default())
    }

    fn encode(&self) -> Option<Vec<u8>> {
        let packed = Packed {
            mask: self.mask.clone(),
            sections: self.sections.clone(),
            left_out: self.left_out,
            fraction: self.fraction,
            thickness: self.thickness,
        };
        let mut out = Writer::new();
        out.bytes(&Exemplar { views: vec![self.view.clone()] }.encode()?).bytes(&pack(&packed)?);
        Some(out.finish())
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = Reader::new(bytes);
        let view = Exemplar::decode(reader.bytes()?)?.views.remove(0);
        let packed: Packed = unpack(reader.bytes()?)?;
        reader.end()?;
        let fits = |s: &Section| {
            s.inside.len() as u64 == u64::from(s.size[0]) * u64::from(s.size[1])
                && s.size.iter().all(|&n| n < 1 << 16)
        };
        if packed.mask.len() != view.texels.len() || !packed.sections.iter().all(fits) {
            return Err("cross-sections do not fit their picture".to_owned());
        }
        let Packed { mask, sections, left_out, fraction, thickness } = packed;
        Ok(Self { view, mask, sections, left_out, fraction, thickness })
    }
}
