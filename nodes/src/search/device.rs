//! Similarity sets on a compute device: every pixel against every other, the same sets bit for bit.

use breccia_shaders::kernels::SIMILAR;
use breccia_shaders::{Batch, Gpu, GpuError, Groups};
use bytemuck::{Pod, Zeroable};

use crate::control::Control;
use crate::lazy::Pixel;

/// Members of the largest set that the kernel has room for.
pub(crate) const MOST_MEMBERS: usize = 32;
/// Coefficients come in blocks of this many, and no more than so many blocks.
const BLOCK: usize = 8;
const MOST_BLOCKS: usize = 8;

/// What makes the sets of one view.
pub(crate) struct SimilarityJob<'a> {
    /// Pixels in a row and rows.
    pub size: [i32; 2],
    /// Whether the picture continues at the opposite edge.
    pub tileable: bool,
    /// For every pixel, row by row, `dims` coefficients from −8192 to 8191.
    pub coefficients: &'a [i16],
    /// Coefficients of a pixel, a multiple of 8, at most 64.
    pub dims: usize,
    /// The pixels that can be members.
    pub centres: &'a [Pixel],
    /// For every pixel the centre nearest to it, and whether that is the first of the set.
    pub own: &'a [(Pixel, bool)],
    /// Pixels in a set, at most [`MOST_MEMBERS`].
    pub members: usize,
    /// Least distance between members along columns or rows.
    pub spread: i32,
    /// So many of the nearest can be members.
    pub keep: usize,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Params {
    size: [i32; 4],
    eights: u32,
    centres: u32,
    members: u32,
    keep: u32,
    count: u32,
    first: u32,
    rest: [u32; 2],
}

impl SimilarityJob<'_> {
    /// Whether the kernel has room for it.
    pub fn fits(&self) -> bool {
        (1..=MOST_MEMBERS).contains(&self.members)
            && self.dims.is_multiple_of(BLOCK)
            && self.dims <= BLOCK * MOST_BLOCKS
    }

    /// For every pixel the members that were found, in order, in `members` places; what is missing is `None`.
    pub fn run(&self, gpu: &Gpu, control: &dyn Control) -> Result<Vec<Option<Pixel>>, GpuError> {
        let params = Params {
            size: [self.size[0], self.size[1], self.tileable.into(), self.spread.max(1)],
            eights: (self.dims / BLOCK) as u32,
            centres: self.centres.len() as u32,
            members: self.members as u32,
            keep: self.keep.min(self.centres.len()) as u32,
            count: self.own.len() as u32,
            first: 0,
            rest: [0; 2],
        };
        let coefficients = gpu.upload(self.coefficients)?;
        let centres: Vec<u32> = self.centres.iter().map(|&pixel| pixel.into()).collect();
        let own: Vec<u32> =
            self.own.iter().map(|&(p, first)| u32::from(p) | u32::from(first) << 16).collect();
        let (centres, own) = (gpu.upload(&centres)?, gpu.upload(&own)?);
        let mut sets = vec![0u32; self.own.len() * self.members];
        let out = gpu.zeros((sets.len() * 4) as u64)?;
        let mut batch = Batch::new(gpu);
        let work = self.centres.len() as f64 * self.members as f64 * self.dims as f64;
        batch.dispatch_weighed(
            &SIMILAR,
            work,
            |first| Params { first, ..params },
            &[&coefficients, &centres, &own, &out],
            Groups(self.own.len() as u32),
            &|| control.is_cancelled(),
        )?;
        batch.read(&out, &mut sets)?;
        Ok(sets.into_iter().map(|word| Pixel::try_from(word).ok()).collect())
    }
}
