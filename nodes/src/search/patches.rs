//! The coefficients of every neighbourhood of an exemplar at one level.

use breccia_engine::{Data, Digest};
use rayon::prelude::*;

use super::basis::PatchBasis;
use super::nearest::is_wide;
use super::window::Window;
use crate::control::{Cancelled, Control, check};
use crate::data::{Reader, Writer};
use crate::lazy::{Isa, Pyramid, available_instruction_sets};

/// The neighbourhoods of one view.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchView {
    /// Pixels in a row.
    pub width: i32,
    /// Rows.
    pub height: i32,
    /// Whether the picture continues at the opposite edge.
    pub tileable: bool,
    /// Coefficients of a neighbourhood.
    pub dims: usize,
    /// For every pixel, row by row, its neighbourhood's coefficients; for pixels that are no centre those of the nearest centre.
    pub table: Vec<i16>,
}

impl PatchView {
    /// The coefficients of the pixel with that index.
    #[inline(always)]
    pub fn coefficients(&self, index: usize) -> &[i16] {
        &self.table[index * self.dims..][..self.dims]
    }
}

/// The neighbourhoods of all views at one level, and the basis that they are written in.
#[derive(Clone, Debug, PartialEq)]
pub struct Patches {
    /// The basis.
    pub basis: PatchBasis,
    /// One view for all directions, or one each.
    pub views: Vec<PatchView>,
}

impl Patches {
    /// The view of a direction.
    pub fn view(&self, direction: usize) -> usize {
        direction.min(self.views.len() - 1)
    }

    /// The neighbourhood.
    pub fn window(&self) -> Window {
        self.basis.window
    }
}

/// Projects every neighbourhood of the basis's level.
///
/// # Errors
/// [`Cancelled`].
pub fn patches(pyramid: &Pyramid, basis: &PatchBasis, control: &dyn Control) -> Result<Patches, Cancelled> {
    let isa = available_instruction_sets().last().copied().unwrap_or(Isa::Portable);
    let levels = pyramid.levels.get(basis.level).into_iter().flatten();
    let mut views = Vec::new();
    for (v, view) in levels.enumerate() {
        let rows: Vec<Vec<i16>> = (0..view.height)
            .into_par_iter()
            .map(|y| {
                check(control)?;
                let mut row = Vec::with_capacity(view.width as usize * basis.dims);
                let mut samples = Vec::new();
                for x in 0..view.width {
                    basis.window.samples(view, basis.window.centre(view, x, y), &mut samples);
                    project_any(&samples, basis, v, is_wide(isa), &mut row);
                }
                Ok(row)
            })
            .collect::<Result<_, Cancelled>>()?;
        let (width, height, tileable) = (view.width, view.height, view.tileable);
        views.push(PatchView { width, height, tileable, dims: basis.dims, table: rows.concat() });
    }
    Ok(Patches { basis: basis.clone(), views })
}

fn project_any(samples: &[i16], basis: &PatchBasis, view: usize, wide: bool, out: &mut Vec<i16>) {
    let (weights, bias) = (&basis.weights[view], &basis.bias[view]);
    macro_rules! dims {
        ($($d:literal)*) => {
            match basis.dims {
                $($d => out.extend(super::nearest::project::<$d>(samples, weights, bias, wide)),)*
                other => out.resize(out.len() + other, 0),
            }
        };
    }
    dims!(8 16 24 32 40 48 56 64);
}

impl Data for Patches {
    const TYPE: &'static str = "patches";
    const DOCS: &'static str = "The neighbourhoods of an exemplar at one level, in few coefficients.";

    fn byte_size(&self) -> u64 {
        self.basis.byte_size() + self.views.iter().map(|view| view.table.len() as u64 * 2).sum::<u64>()
    }

    fn summary(&self) -> String {
        let sizes: Vec<_> = self.views.iter().map(|v| format!("{} × {}", v.width, v.height)).collect();
        format!("{} neighbourhoods; {}", sizes.join(", "), self.basis.summary())
    }

    fn digest(&self) -> Digest {
        Digest::of(&self.encode().unwrap_or_default())
    }

    fn encode(&self) -> Option<Vec<u8>> {
        let mut out = Writer::new();
        out.array(&self.basis.encode()?).u64(self.views.len() as u64);
        for view in &self.views {
            out.u64(view.width as u64).u64(view.height as u64).u64(view.tileable.into()).array(&view.table);
        }
        Some(out.finish())
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = Reader::new(bytes);
        let basis = PatchBasis::decode(&reader.array::<u8>()?)?;
        let mut views = Vec::new();
        for _ in 0..reader.u64()? {
            let (width, height) = (reader.u32()? as i32, reader.u32()? as i32);
            let view = PatchView {
                width,
                height,
                tileable: reader.u64()? != 0,
                dims: basis.dims,
                table: reader.array()?,
            };
            let sides = 1..=256;
            let fits = sides.contains(&width) && sides.contains(&height);
            if !fits || view.table.len() != (width * height) as usize * view.dims {
                return Err("the neighbourhoods do not fit their number".to_owned());
            }
            views.push(view);
        }
        reader.end()?;
        if views.is_empty() || views.len() != basis.weights.len() {
            return Err("there are no views".to_owned());
        }
        Ok(Self { basis, views })
    }
}
