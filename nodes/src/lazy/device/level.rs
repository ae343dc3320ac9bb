//! One level on the device: its bricks, the masks of the voxels that matter, and its state.

use breccia_shaders::kernels::{COUNT, DILATE, LINK, PARENTS, SCAN, SCATTER};
use breccia_shaders::{Batch, Buffer, Gpu, GpuError, Groups};
use bytemuck::{Pod, Zeroable};

use super::plan::{ABSENT, Bricks};

/// Words of a brick's mask.
pub(super) const MASK: usize = 16;
/// Words of a brick's state.
pub(super) const STATE: usize = 1536;
/// Words of a brick's links.
const LINKS: usize = 128;

/// A sub-pass's voxels of a brick, as the device reads them.
type Subset = [u32; MASK];

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct LinkParams {
    period: [i32; 4],
    bricks: u32,
    mask: u32,
    rest: [u32; 2],
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct DilateParams {
    period: [i32; 4],
    subset: Subset,
    bricks: u32,
    after: u32,
    before: u32,
    free: u32,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct CompactParams {
    subset: Subset,
    bricks: u32,
    after: u32,
    free: u32,
    rest: u32,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct ParentsParams {
    bricks: u32,
    fine: u32,
    coarse: u32,
    rest: u32,
}

/// The bricks of a level and which of their voxels matter.
pub(super) struct DeviceLevel {
    pub bricks: Bricks,
    pub period: [i32; 4],
    /// The voxels of a brick that each sub-pass changes, in the order of time.
    steps: Vec<Subset>,
    pub links: Buffer,
    /// What must be known before each sub-pass, in the order of time, and after the last; then the voxels that may be
    /// corrected, if not all may.
    pub masks: Buffer,
    has_free: bool,
    counts: Buffer,
    list: Buffer,
}

/// The bits of a mask in the device's words.
pub(super) fn words(mask: &[u64; 8]) -> [u32; MASK] {
    bytemuck::cast(mask.map(u64::to_le))
}

impl DeviceLevel {
    /// A level of which nothing is wanted yet; `free` are the masks of the voxels that may be corrected.
    pub fn new(
        gpu: &Gpu,
        batch: &mut Batch<'_>,
        bricks: Bricks,
        period: [i32; 4],
        steps: &[[u64; 8]],
        free: Option<&[[u32; MASK]]>,
    ) -> Result<Self, GpuError> {
        let count = bricks.keys.len();
        let places = bricks.places();
        let keys: Vec<[i32; 4]> = bricks.keys.iter().map(|k| [k[0], k[1], k[2], 0]).collect();
        let (table, keys) = (gpu.upload(&places)?, gpu.upload(&keys)?);
        let links = gpu.zeros((count * LINKS * 4) as u64)?;
        let params = LinkParams { period, bricks: count as u32, mask: places.len() as u32 - 1, rest: [0; 2] };
        batch.dispatch(&LINK, &params, &[&table, &keys, &links], Groups(count as u32))?;
        let all = (steps.len() + 1 + usize::from(free.is_some())) * count * MASK;
        let masks = gpu.zeros((all * 4) as u64)?;
        if let Some(free) = free {
            gpu.write(&masks, ((steps.len() + 1) * count * MASK * 4) as u64, free);
        }
        Ok(Self {
            period,
            steps: steps.iter().map(words).collect(),
            links,
            masks,
            has_free: free.is_some(),
            counts: gpu.zeros((count as u64 + 1) * 4)?,
            list: gpu.zeros((count as u64 * 512 + 1) * 4)?,
            bricks,
        })
    }

    /// How many sub-passes there are.
    pub fn steps(&self) -> usize {
        self.steps.len()
    }

    fn count(&self) -> u32 {
        self.bricks.keys.len() as u32
    }

    /// Where the masks before a sub-pass begin; those after the last follow.
    pub fn masks_before(&self, step: usize) -> u32 {
        (step * self.bricks.keys.len() * MASK) as u32
    }

    /// Where the masks of the voxels that may be corrected begin.
    pub fn free(&self) -> u32 {
        if self.has_free { self.masks_before(self.steps.len() + 1) } else { ABSENT }
    }

    /// Wants voxels, given as a mask a brick.
    pub fn want(&self, gpu: &Gpu, masks: &[[u32; MASK]]) {
        gpu.write(&self.masks, u64::from(self.masks_before(self.steps.len())) * 4, masks);
    }

    /// Wants the parents of what a finer level needs before its first sub-pass.
    pub fn want_parents(
        &self,
        batch: &mut Batch<'_>,
        fine: &Self,
        children: &Buffer,
    ) -> Result<(), GpuError> {
        let params = ParentsParams {
            bricks: self.count(),
            fine: fine.masks_before(0),
            coarse: self.masks_before(self.steps.len()),
            rest: 0,
        };
        let groups = Groups::for_threads(&PARENTS, self.bricks.keys.len() * MASK);
        batch.dispatch(&PARENTS, &params, &[children, &fine.masks, &self.masks], groups)
    }

    /// Finds out what each sub-pass needs, the last first.
    pub fn depend(&self, batch: &mut Batch<'_>) -> Result<(), GpuError> {
        for (step, &subset) in self.steps.iter().enumerate().rev() {
            let params = DilateParams {
                period: self.period,
                subset,
                bricks: self.count(),
                after: self.masks_before(step + 1),
                before: self.masks_before(step),
                free: self.free(),
            };
            let groups = Groups::for_threads(&DILATE, self.bricks.keys.len() * MASK);
            batch.dispatch(&DILATE, &params, &[&self.links, &self.masks], groups)?;
        }
        Ok(())
    }

    /// Lists the voxels that a sub-pass corrects: their number, then slot times 512 plus index.
    pub fn list(&self, batch: &mut Batch<'_>, step: usize) -> Result<&Buffer, GpuError> {
        let bricks = self.count();
        let params = CompactParams {
            subset: self.steps[step],
            bricks,
            after: self.masks_before(step + 1),
            free: self.free(),
            rest: 0,
        };
        let groups = Groups::for_threads(&COUNT, bricks as usize);
        batch.dispatch(&COUNT, &params, &[&self.masks, &self.counts], groups)?;
        batch.dispatch(&SCAN, &[bricks, 0, 0, 0], &[&self.counts], Groups(1))?;
        batch.dispatch(&SCATTER, &params, &[&self.masks, &self.counts, &self.list], groups)?;
        Ok(&self.list)
    }
}
