//! A request's way through the levels, and what comes back.

use breccia_shaders::kernels::{CORRECT, GATHER, START, UPSAMPLE};
use breccia_shaders::{Batch, Buffer, Gpu, GpuError, Groups};
use bytemuck::{Pod, Zeroable};

use super::level::{DeviceLevel, MASK, STATE, words};
use super::plan::{ABSENT, Bricks};
use super::tables::{DeviceTables, Level, packed, period};
use crate::control::Control;
use crate::data::VoxelSet;
use crate::lazy::domain::Domain;
use crate::lazy::field::{Brick, Field};
use crate::lazy::initial::Initial;
use crate::lazy::jitter::Gaussian;
use crate::lazy::kernel::Weights;
use crate::lazy::pyramid::Pixel;
use crate::lazy::schedule::Settings;
use crate::lazy::tables::Tables;

/// What is asked of a solid on the device, and what it is made of.
pub(in crate::lazy) struct Request<'a> {
    pub tables: &'a Tables,
    pub initial: &'a Initial,
    pub settings: &'a Settings,
    pub weights: &'a dyn Fn(usize) -> Weights,
    /// The voxels, wrapped.
    pub wanted: &'a VoxelSet,
    /// Where another solid has voxels: what is needed before the first sub-pass, which of it may be corrected, and
    /// the pixels that the rest looks like.
    pub taken: Option<(&'a VoxelSet, &'a VoxelSet, [Pixel; 3])>,
}

/// The finished bricks of a request in the device's memory.
pub(in crate::lazy) struct DeviceState {
    pub(super) bricks: Bricks,
    pub(super) state: Buffer,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct StartParams {
    seed: [u32; 2],
    slab: [i32; 2],
    taken: [u32; 2],
    bricks: u32,
    aligned: u32,
    wanted: u32,
    free: u32,
    jitter: u32,
    rest: u32,
}

impl Request<'_> {
    fn domain(&self, level: usize) -> Domain {
        Domain::at_level(self.settings.period, level)
    }

    /// The bricks that may take part at each level.
    fn plan(&self) -> Vec<Bricks> {
        let first = match self.taken {
            Some((before, ..)) => Bricks::new(before.bricks()),
            None => Bricks::around(self.wanted.bricks(), self.settings.steps(0).len(), &self.domain(0)),
        };
        let mut plan = vec![first];
        for level in 1..self.tables.levels.len() {
            let parents = plan[level - 1].keys.iter().map(|key| key.map(|c| c >> 1));
            let parents = Bricks::new(parents.collect::<rustc_hash::FxHashSet<_>>().into_iter().collect());
            plan.push(Bricks::around(parents.keys, self.settings.steps(level).len(), &self.domain(level)));
        }
        plan
    }

    /// How many bricks of the finest level a request may reach into, so that it fits the device.
    fn most_bricks(gpu: &Gpu) -> u64 {
        let state = (STATE * 4) as u64;
        // Two states, a list of voxels, links and masks; the coarser levels take less than a third of that.
        (gpu.largest_binding() / state).min(gpu.memory_budget() / (4 * state)).max(1)
    }

    /// Computes the voxels, in portions where they do not fit into the device's memory.
    pub fn run(&self, gpu: &Gpu, tables: &DeviceTables, control: &dyn Control) -> Result<Field, GpuError> {
        let plan = self.plan();
        if plan[0].keys.len() as u64 <= Self::most_bricks(gpu) || self.wanted.brick_count() < 2 {
            let state = gpu.scope(|| self.synthesise(gpu, tables, plan, control))?;
            return gpu.scope(|| state.download(gpu, self.wanted));
        }
        drop(plan);
        let keys = self.wanted.bricks();
        let (mut all_keys, mut all_bricks) = (Vec::new(), Vec::new());
        for half in [&keys[..keys.len() / 2], &keys[keys.len() / 2..]] {
            let mut wanted = VoxelSet::new();
            for &key in half {
                if let Some(mask) = self.wanted.mask(key) {
                    wanted.insert_mask(key, mask);
                }
            }
            let (keys, bricks) = Request { wanted: &wanted, ..*self }.run(gpu, tables, control)?.into_parts();
            all_keys.extend(keys);
            all_bricks.extend(bricks);
        }
        Ok(Field::of(all_keys, all_bricks))
    }

    /// Computes the voxels and leaves them on the device.
    ///
    /// [`GpuError::OutOfMemory`] if they are too many at once.
    pub fn resident(
        &self,
        gpu: &Gpu,
        tables: &DeviceTables,
        control: &dyn Control,
    ) -> Result<DeviceState, GpuError> {
        let plan = self.plan();
        if plan[0].keys.len() as u64 > Self::most_bricks(gpu) {
            return Err(GpuError::OutOfMemory(format!("{} bricks are too many at once", plan[0].keys.len())));
        }
        self.synthesise(gpu, tables, plan, control)
    }

    fn synthesise(
        &self,
        gpu: &Gpu,
        tables: &DeviceTables,
        plan: Vec<Bricks>,
        control: &dyn Control,
    ) -> Result<DeviceState, GpuError> {
        let cancelled = || control.is_cancelled();
        let mut batch = Batch::new(gpu);
        // Down: what matters.
        let mut levels: Vec<(DeviceLevel, Option<Buffer>)> = Vec::new();
        for (l, bricks) in plan.into_iter().enumerate() {
            if cancelled() {
                return Err(GpuError::Cancelled);
            }
            let family = levels.last().map(|(fine, _)| {
                let ancestors = fine.bricks.ancestors(&bricks);
                (fine.bricks.children(&bricks, &ancestors), ancestors)
            });
            let free: Option<Vec<[u32; MASK]>> = self.taken.map(|(_, free, _)| {
                bricks.keys.iter().map(|&key| free.mask(key).map_or([0; MASK], words)).collect()
            });
            let (period, steps) = (period(&self.domain(l)), self.settings.steps(l));
            let level = DeviceLevel::new(gpu, &mut batch, bricks, period, &steps, free.as_deref())?;
            match (levels.last_mut(), family) {
                (Some((fine, up)), Some((children, ancestors))) => {
                    *up = Some(gpu.upload(&ancestors)?);
                    level.want_parents(&mut batch, fine, &gpu.upload(&children)?)?;
                }
                _ => {
                    let mask = |&key| self.wanted.mask(key).map_or([0; MASK], words);
                    let masks: Vec<_> = level.bricks.keys.iter().map(mask).collect();
                    level.want(gpu, &masks);
                }
            }
            level.depend(&mut batch)?;
            levels.push((level, None));
        }
        // Up: the states.
        let mut coarse: Option<Buffer> = None;
        let mut finished = None;
        while let Some((level, up)) = levels.pop() {
            let l = levels.len();
            let color = crate::lazy::color::OneColor::new(self.settings.color, &self.tables.levels[l]);
            let (words, bases) = &tables.levels[l];
            let header = Level::new(&self.tables.levels[l], bases, (self.weights)(l), color, &self.domain(l));
            let header = gpu.upload(&[header])?;
            let bytes = (level.bricks.keys.len() * STATE * 4) as u64;
            let mut state = gpu.zeros(bytes)?;
            match (&coarse, &up) {
                (Some(coarse), Some(ancestors)) => {
                    let params = [level.bricks.keys.len() as u32, level.masks_before(0), 0, 0];
                    let buffers = [&header, words, &level.links, &level.masks, ancestors, coarse, &state];
                    let groups = Groups::for_threads(&UPSAMPLE, level.bricks.keys.len() * 512);
                    batch.dispatch(&UPSAMPLE, &params, &buffers, groups)?;
                }
                _ => self.start(gpu, &mut batch, tables, &level, [&header, words], &state)?,
            }
            coarse = None;
            let mut next = if level.steps() > 0 { gpu.zeros(bytes)? } else { gpu.zeros(0)? };
            for step in 0..level.steps() {
                batch.copy(&state, &next);
                let list = level.list(&mut batch, step)?;
                // As many threads as there could be voxels; those beyond the list's end do nothing.
                let groups = Groups::for_threads(&CORRECT, level.bricks.keys.len() * 512);
                let buffers = [&header, words, &level.links, list, &state, &next];
                batch.dispatch_long(&CORRECT, |first| [first, 0, 0, 0], &buffers, groups, &cancelled)?;
                std::mem::swap(&mut state, &mut next);
                if l == 0 {
                    control.progress((step + 1) as f32 / level.steps() as f32);
                }
            }
            if l == 0 {
                finished = Some(DeviceState { bricks: level.bricks, state });
            } else {
                coarse = Some(state);
            }
        }
        batch.finish()?;
        finished.ok_or_else(|| GpuError::Refused("a synthesis without levels".to_owned()))
    }

    fn start(
        &self,
        gpu: &Gpu,
        batch: &mut Batch<'_>,
        tables: &DeviceTables,
        level: &DeviceLevel,
        [header, words]: [&Buffer; 2],
        state: &Buffer,
    ) -> Result<(), GpuError> {
        use rayon::prelude::*;

        let domain = self.domain(self.tables.levels.len() - 1);
        let (keys, seed) = (&level.bricks.keys, self.settings.seed);
        // Where Gaussians lie is found in floats, which devices round as they like; what they do is done in integers there.
        let of_brick: Vec<Vec<Gaussian>> = match self.initial.jitter {
            Some(jitter) => keys.par_iter().map(|&key| jitter.gaussians(seed, &domain, key)).collect(),
            None => Vec::new(),
        };
        let mut ranges = vec![0u32];
        for found in &of_brick {
            ranges.push(ranges[ranges.len() - 1] + found.len() as u32);
        }
        ranges.resize(keys.len() + 1, 0);
        ranges.extend(&tables.falling);
        let (gaussians, ranges) = (gpu.upload(&of_brick.concat())?, gpu.upload(&ranges)?);
        let slab = if self.initial.slab.is_empty() { [0; 2] } else { self.initial.size };
        let params = StartParams {
            seed: [seed as u32, (seed >> 32) as u32],
            slab,
            taken: self.taken.map_or([0; 2], |(.., pixels)| packed(pixels)),
            bricks: keys.len() as u32,
            aligned: self.initial.aligned.into(),
            wanted: level.masks_before(0),
            free: level.free(),
            jitter: self.initial.jitter.is_some().into(),
            rest: 0,
        };
        let buffers = [header, words, &level.links, &level.masks, &tables.slab, &gaussians, &ranges, state];
        batch.dispatch(&START, &params, &buffers, Groups::for_threads(&START, keys.len() * 512))
    }
}

impl DeviceState {
    /// The bricks of a set.
    fn download(&self, gpu: &Gpu, wanted: &VoxelSet) -> Result<Field, GpuError> {
        use rayon::prelude::*;

        let keys = wanted.bricks();
        let slots: Vec<u32> = keys.iter().map(|&key| self.bricks.slot(key)).collect();
        if slots.contains(&ABSENT) {
            return Err(GpuError::Refused("a brick that was asked for is missing".to_owned()));
        }
        let mut batch = Batch::new(gpu);
        let mut planes = vec![0u32; keys.len() * STATE];
        if slots.len() == self.bricks.keys.len() {
            batch.read(&self.state, &mut planes)?;
        } else {
            let out = gpu.zeros((planes.len() * 4) as u64)?;
            let slots = gpu.upload(&slots)?;
            let groups = Groups(keys.len() as u32);
            batch.dispatch(&GATHER, &[keys.len() as u32, 0, 0, 0], &[&slots, &self.state, &out], groups)?;
            batch.read(&out, &mut planes)?;
        }
        let brick = |planes: &[u32]| {
            let mut brick = Brick::empty();
            brick.color.copy_from_slice(&planes[..512]);
            for (i, (&xy, &z)) in planes[512..1024].iter().zip(&planes[1024..]).enumerate() {
                brick.pixels[0][i] = xy as Pixel;
                brick.pixels[1][i] = (xy >> 16) as Pixel;
                brick.pixels[2][i] = z as Pixel;
                brick.shown[i] = (z >> 16) as u8;
            }
            brick
        };
        let bricks = planes.par_chunks(STATE).map(brick).collect();
        Ok(Field::of(keys, bricks))
    }
}
