//! The solver on a compute device: the same sums in the same order, up to rounding.
//!
//! Powers of distances and the weights of histograms are found on the host in 64 bits and go to the device in 32: they lie between
//! 10⁻³⁴ and 1, so that neither a product nor a mean leaves the range of normal floats. Between phases the voxels come back, are
//! counted in integers, and new weights go out.

use breccia_shaders::kernels::SOLVE;
use breccia_shaders::{Batch, Gpu, GpuError, Groups};
use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::field::Field;
use super::phases::PHASES;
use super::solve::{Solved, Solver, Sweep, Texel, packed};
use crate::control::Control;
use crate::lazy::Pixel;

/// `Params` of `kernels/optimize/solve.wgsl`.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Params {
    size: [u32; 4],
    directions: [[u32; 4]; 3],
    views: [[u32; 4]; 3],
    wanted: u32,
    count_of_views: u32,
    window: u32,
    lead: i32,
    mean: u32,
    start: u32,
    count: u32,
    first: u32,
}

fn params(sweep: &Sweep<'_>, wanted: &[usize]) -> Params {
    let mut views = [[0; 4]; 3];
    let mut begin = 0;
    for (view, table) in views.iter_mut().zip(&sweep.tables) {
        *view = [begin, table.pitch as u32, table.margin as u32, 0];
        begin += table.texels.len() as u32;
    }
    let mut directions = [[0; 4]; 3];
    for (slot, &direction) in directions.iter_mut().zip(wanted) {
        *slot = [direction as u32, direction.min(sweep.tables.len() - 1) as u32, 0, 0];
    }
    let [x, y, z] = sweep.matches.size.map(|n| n as u32);
    let window = sweep.matches.window;
    Params {
        size: [x, y, z, x * y * z],
        directions,
        views,
        wanted: wanted.len() as u32,
        count_of_views: sweep.tables.len() as u32,
        window: window.size as u32,
        lead: window.after(),
        mean: (sweep.settings.solver == Solver::Mean).into(),
        start: 0,
        count: 0,
        first: 0,
    }
}

/// Solves for all voxels of a sweep.
///
/// # Errors
/// [`GpuError`], [`GpuError::Cancelled`] among them.
pub(super) fn run(gpu: &Gpu, mut sweep: Sweep<'_>, control: &dyn Control) -> Result<Field, GpuError> {
    let matches = sweep.matches;
    let wanted: Vec<usize> = (0..3).filter(|&d| !matches.directions[d].pixels.is_empty()).collect();
    let of_sweep = params(&sweep, &wanted);
    let phases = sweep.phases();
    let longest = phases.ranges().map(|range| range.len()).max().unwrap_or(0);

    let weights = gpu.upload(&sweep.distance_weights)?;
    let words: Vec<u32> = wanted
        .iter()
        .flat_map(|&d| {
            (0..matches.directions[d].pixels.len()).map(move |i| packed(&matches.directions[d], i))
        })
        .collect();
    let matched = gpu.upload(&words)?;
    drop(words);
    let texels: usize = sweep.tables.iter().map(|table| table.texels.len()).sum();
    let texels = gpu.zeros((texels * size_of::<Texel>()) as u64)?;
    let pixels: Vec<Pixel> = sweep.tables.iter().flat_map(|table| table.sources.iter().copied()).collect();
    let pixels = gpu.upload(&pixels)?;
    let list = gpu.upload(phases.voxels())?;
    let found = gpu.zeros(longest as u64 * 12)?;

    let mut words = vec![[0u32; 3]; longest];
    let mut solved = vec![Solved::default(); longest];
    let mut batch = Batch::new(gpu);
    let cancelled = || control.is_cancelled();
    let overlapping = (matches.window.pixels() * wanted.len()).max(1) as f64;
    for (p, range) in phases.ranges().enumerate() {
        if cancelled() {
            return Err(GpuError::Cancelled);
        }
        control.progress(p as f32 / PHASES as f32);
        sweep.weigh();
        let mut at = 0;
        for table in &sweep.tables {
            gpu.write(&texels, at, &table.texels);
            at += size_of_val(&table.texels[..]) as u64;
        }
        let (start, count) = (range.start as u32, range.len() as u32);
        let params = |first| Params { start, count, first, ..of_sweep };
        let groups = Groups::for_threads(&SOLVE, range.len());
        let buffers = [&weights, &matched, &texels, &pixels, &list, &found];
        batch.dispatch_weighed(&SOLVE, overlapping, params, &buffers, groups, &cancelled)?;
        let (words, solved) = (&mut words[..range.len()], &mut solved[..range.len()]);
        batch.read(&found, words)?;
        solved.par_iter_mut().zip(&*words).for_each(|(solved, &words)| *solved = unpacked(words));
        sweep.keep(&phases.voxels()[range], solved);
    }
    Ok(sweep.field)
}

/// What the kernel says of a voxel.
fn unpacked([color, two, last]: [u32; 3]) -> Solved {
    Solved {
        color: color.to_le_bytes(),
        sources: [two as Pixel, (two >> 16) as Pixel, last as Pixel],
        chosen: (last >> 16) as u8,
    }
}
