//! The search on a compute device: the same matches bit for bit.
//!
//! Everything is integer arithmetic but the weights of the index histogram, which are floats of 64 bits and stay with the
//! processor: between phases the matches come back and new weights go out. Without an index histogram nothing depends on phases, and
//! all voxels go at once.

use std::ops::Range;

use breccia_engine::Data;
use breccia_shaders::kernels::{COHERENT, EXHAUSTIVE, PROJECT};
use breccia_shaders::{Batch, Buffer, Gpu, GpuError, Groups};
use bytemuck::{Pod, Zeroable};

use super::coherence::Candidates;
use super::control_map::ControlMap;
use super::field::Field;
use super::matches::{DirectionMatches, Matches};
use super::phases::Phases;
use super::search::{IndexUsage, Method, PURPOSE, SearchSettings};
use crate::control::Control;
use crate::lazy::Pixel;
use crate::search::{Patches, SimilarSets, Window};

/// Pixels along the largest window, and in the largest set, that the kernels have room for.
const MOST: usize = 32;
/// Bytes of coefficients of voxels that are on the device at once.
const QUERIES: u64 = 64 << 20;

/// What a search asks of the device.
pub(super) struct Job<'a> {
    pub field: &'a Field,
    pub patches: &'a Patches,
    pub sets: Option<&'a SimilarSets>,
    pub phi: Option<&'a ControlMap>,
    pub settings: &'a SearchSettings,
}

/// `Matching` of `kernels/modules/matching.wgsl`.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Matching {
    size: [u32; 4],
    directions: [Direction; 3],
    wanted: u32,
    eights: u32,
    window: i32,
    lead: i32,
    reach: i32,
    members: u32,
    room: u32,
    start: u32,
    count: u32,
    first: u32,
    rest: [u32; 2],
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Direction {
    size: [i32; 4],
    bounds: [i32; 4],
    base: [u32; 4],
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Projecting {
    size: [u32; 4],
    directions: [[u32; 4]; 3],
    wanted: u32,
    fours: u32,
    window: i32,
    lead: i32,
    start: u32,
    count: u32,
    first: u32,
    rest: u32,
}

/// What stays on the device from one search of a level to the next.
struct Tables {
    basis: Buffer,
    coefficients: Buffer,
    sets: Buffer,
    members: u32,
    room: u32,
    views: Vec<Places>,
}

/// Where what belongs to a view begins.
struct Places {
    weights: u32,
    bias: u32,
    coefficients: u32,
    sets: u32,
    index: u32,
}

impl Tables {
    fn new(gpu: &Gpu, job: &Job<'_>) -> Result<Self, GpuError> {
        let (mut basis, mut coefficients, mut sets) = (Vec::<u8>::new(), Vec::<u8>::new(), Vec::<u16>::new());
        let (mut views, mut index) = (Vec::new(), 0);
        let (mut members, mut room) = (1, 1);
        for (v, view) in job.patches.views.iter().enumerate() {
            let weights = basis.len() / 16;
            basis.extend_from_slice(bytemuck::cast_slice(&job.patches.basis.weights[v]));
            let bias = basis.len() / 16;
            basis.extend_from_slice(bytemuck::cast_slice(&job.patches.basis.bias[v]));
            views.push(Places {
                weights: weights as u32,
                bias: bias as u32,
                coefficients: (coefficients.len() / 16) as u32,
                sets: sets.len() as u32,
                index,
            });
            coefficients.extend_from_slice(bytemuck::cast_slice(&view.table));
            index += (view.width * view.height) as u32;
            if job.settings.method == Method::Coherent {
                let known = Candidates::new(job.patches, v, job.sets, Method::Coherent);
                (members, room) = (known.members() as u32, known.stride() as u32);
                sets.extend_from_slice(known.sets());
            }
        }
        let (basis, coefficients) = (gpu.upload(&basis)?, gpu.upload(&coefficients)?);
        Ok(Self { basis, coefficients, sets: gpu.upload(&sets)?, members, room, views })
    }
}

impl Job<'_> {
    /// Whether the kernels have room for it.
    pub fn fits(&self) -> bool {
        let Window { size } = self.patches.window();
        (1..=MOST as i32).contains(&size) && self.sets.is_none_or(|sets| sets.k <= MOST)
    }

    fn tables_id(&self) -> [u8; 32] {
        let mut hasher = blake3::Hasher::new();
        hasher.update(b"optimize.search").update(&self.patches.digest().0);
        match self.sets.filter(|_| self.settings.method == Method::Coherent) {
            Some(sets) => hasher.update(b"sets").update(&sets.digest().0),
            None => hasher.update(if self.settings.method == Method::Coherent { b"self" } else { b"none" }),
        };
        hasher.finalize().into()
    }

    fn projecting(&self, tables: &Tables, directions: &[usize]) -> Projecting {
        let window = self.patches.window();
        let of = |slot: usize| {
            let direction = directions.get(slot).copied().unwrap_or(0);
            let places = &tables.views[self.patches.view(direction)];
            [direction as u32, places.weights, places.bias, 0]
        };
        let [x, y, z] = self.field.size.map(|n| n as u32);
        Projecting {
            size: [x, y, z, 0],
            directions: [of(0), of(1), of(2)],
            wanted: directions.len() as u32,
            fours: (self.patches.basis.dims / 4) as u32,
            window: window.size,
            lead: window.before(),
            start: 0,
            count: 0,
            first: 0,
            rest: 0,
        }
    }

    fn matching(&self, tables: &Tables, directions: &[usize]) -> Matching {
        let window = self.patches.window();
        let of = |slot: usize| {
            let direction = directions.get(slot).copied().unwrap_or(0);
            let v = self.patches.view(direction);
            let (view, places) = (&self.patches.views[v], &tables.views[v]);
            let [columns, rows] = [view.width, view.height]
                .map(|n| if view.tileable { [0, n - 1] } else { [window.before(), n - 1 - window.after()] });
            let sources = v.min(self.field.sources.len() - 1) * self.field.voxels();
            Direction {
                size: [view.width, view.height, view.tileable.into(), direction as i32],
                bounds: [columns[0], columns[1], rows[0], rows[1]],
                base: [places.coefficients, places.sets, places.index, sources as u32],
            }
        };
        let [x, y, z] = self.field.size.map(|n| n as u32);
        Matching {
            size: [x, y, z, 0],
            directions: [of(0), of(1), of(2)],
            wanted: directions.len() as u32,
            eights: (self.patches.basis.dims / 8) as u32,
            window: window.size,
            lead: window.before(),
            reach: self.settings.reach,
            members: tables.members,
            room: tables.room,
            start: 0,
            count: 0,
            first: 0,
            rest: [0; 2],
        }
    }

    /// About how many candidates a workgroup compares.
    fn candidates(&self, tables: &Tables) -> f64 {
        let window = self.patches.window();
        match self.settings.method {
            Method::Exhaustive => {
                self.patches.views.iter().map(|view| f64::from(view.width * view.height)).fold(0.0, f64::max)
            }
            Method::Coherent => {
                let near = (2 * self.settings.reach + 1).clamp(0, window.size).pow(2);
                window.pixels() as f64 + f64::from(near) * f64::from(tables.members)
            }
        }
    }

    /// Finds the matches.
    pub fn run(&self, gpu: &Gpu, control: &dyn Control) -> Result<Matches, GpuError> {
        let (field, patches, settings) = (self.field, self.patches, self.settings);
        let tables = gpu.resident(self.tables_id(), || Tables::new(gpu, self))?;
        let phases = Phases::new(field.size, settings.seed, PURPOSE, settings.sweep);
        let wanted: Vec<usize> = (0..3).filter(|&d| settings.directions[d]).collect();
        let (projecting, matching) = (self.projecting(&tables, &wanted), self.matching(&tables, &wanted));
        let colors = gpu.upload(&field.colors)?;
        let sources = gpu.upload(&field.sources.concat())?;
        let list = gpu.upload(phases.voxels())?;
        let pixels: usize = patches.views.iter().map(|view| (view.width * view.height) as usize).sum();
        let weights = gpu.zeros((pixels * 4) as u64)?;

        // Without an index histogram no phase depends on those before.
        let steady = settings.index == 0.0 && self.phi.is_none();
        let all = std::iter::once(0..field.voxels());
        let spans: Vec<Range<usize>> = if steady { all.collect() } else { phases.ranges().collect() };
        let longest = spans.iter().map(Range::len).max().unwrap_or(0);
        let of_voxel = (wanted.len() * patches.basis.dims * 2) as u64;
        let portion =
            (QUERIES.min(gpu.largest_binding()) / of_voxel.max(1)).max(1).min(longest.max(1) as u64);
        let queries = gpu.zeros(portion * of_voxel)?;
        let found = gpu.zeros(portion * wanted.len() as u64 * 4)?;
        let mut words = vec![0u32; portion as usize * wanted.len()];

        let mut directions = <[DirectionMatches; 3]>::default();
        for &d in &wanted {
            directions[d] =
                DirectionMatches { pixels: vec![0; field.voxels()], codes: vec![0; field.voxels()] };
        }
        let mut usage = IndexUsage::new(field, patches, settings);
        let mut batch = Batch::new(gpu);
        let cancelled = || control.is_cancelled();
        let length = patches.window().pixels() as f64;
        let candidates = self.candidates(&tables) * patches.basis.dims as f64;
        for span in spans {
            gpu.write(&weights, 0, &usage.weights(self.phi, settings.index).concat());
            for start in span.clone().step_by(portion as usize) {
                control.progress(start as f32 / field.voxels() as f32);
                let count = (span.end - start).min(portion as usize);
                let (from, many) = (start as u32, count as u32);
                let params = |first| Projecting { start: from, count: many, first, ..projecting };
                let groups = Groups::for_threads(&PROJECT, count * wanted.len() * patches.basis.dims / 4);
                let buffers = [&tables.basis, &colors, &list, &queries];
                batch.dispatch_weighed(&PROJECT, length, params, &buffers, groups, &cancelled)?;
                let params = |first| Matching { start: from, count: many, first, ..matching };
                let groups = Groups((count * wanted.len()) as u32);
                match settings.method {
                    Method::Coherent => {
                        let Tables { coefficients, sets, .. } = &*tables;
                        let buffers = [coefficients, sets, &weights, &sources, &list, &queries, &found];
                        batch
                            .dispatch_weighed(&COHERENT, candidates, params, &buffers, groups, &cancelled)?;
                    }
                    Method::Exhaustive => {
                        let buffers = [&tables.coefficients, &weights, &queries, &found];
                        batch.dispatch_weighed(
                            &EXHAUSTIVE,
                            candidates,
                            params,
                            &buffers,
                            groups,
                            &cancelled,
                        )?;
                    }
                }
                let words = &mut words[..count * wanted.len()];
                batch.read(&found, words)?;
                for (&voxel, words) in phases.voxels()[start..].iter().zip(words.chunks_exact(wanted.len())) {
                    for (&direction, &word) in wanted.iter().zip(words) {
                        let matched = &mut directions[direction];
                        matched.pixels[voxel as usize] = word as Pixel;
                        matched.codes[voxel as usize] = (word >> 16) as u16;
                        usage.add(patches.view(direction), word as Pixel);
                    }
                }
            }
        }
        Ok(Matches { size: field.size, level: field.level, window: patches.window(), directions })
    }
}
