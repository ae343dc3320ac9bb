//! Samples of a solid at any points. Whatever asks for points between voxels asks here, so that all of them find the same.

use breccia_shaders::GpuError;
use rayon::prelude::*;

use crate::control::{Control, check};
use crate::data::{
    BRICK_VOXELS, Map, MapInfo, Samples, Solid, SolidError, Tap, VoxelMap, VoxelSet, mean_byte,
};

/// Points handed to a thread at once.
const CHUNK: usize = 8192;
/// Points whose corners are held at once.
const PART: usize = 1 << 18;

/// The samples of these maps of `solid` at points, an entry a point; on the compute device where there is one and the solid can.
/// Each map has at most four channels. Points should be ordered so that neighbours follow each other.
///
/// # Errors
/// The solid's own, and [`SolidError::Incomplete`] if its answer lacks a map or voxels.
pub fn sample(
    solid: &dyn Solid,
    infos: &[MapInfo],
    taps: &[Tap],
    control: &dyn Control,
) -> Result<Vec<Map>, SolidError> {
    if let Some(gpu) = control.gpu() {
        match solid.sample(gpu, infos, taps, control) {
            Ok(Some(maps)) => return Ok(maps),
            Err(SolidError::Device(error @ GpuError::Lost(_))) => control.device_lost(&error),
            // What does not fit there may fit here.
            Ok(None) | Err(SolidError::Device(GpuError::OutOfMemory(_))) => {}
            Err(error) => return Err(error),
        }
    }
    let answer = solid.evaluate(&voxels_of(taps), control)?;
    let mut maps: Vec<Map> = infos.iter().map(|info| Map::zeros(info, taps.len())).collect();
    for (part, taps) in taps.chunks(PART).enumerate() {
        check(control)?;
        let corners = locate(taps, &answer).ok_or_else(|| SolidError::Incomplete("voxels".to_owned()))?;
        for map in &mut maps {
            let source = answer.map(&map.name).filter(|source| source.info() == map.info());
            if !source.is_some_and(|source| fill(map, part * PART, &corners, source)) {
                return Err(SolidError::Incomplete(format!("map `{}`, or has it in another form", map.name)));
            }
        }
    }
    Ok(maps)
}

/// The voxels that count at points.
pub(crate) fn voxels_of(taps: &[Tap]) -> VoxelSet {
    let sets: Vec<VoxelSet> = taps.par_chunks(CHUNK).map(voxels_of_some).collect();
    let mut sets = sets.into_iter();
    let mut all = sets.next().unwrap_or_default();
    sets.for_each(|set| all.union(&set));
    all
}

fn voxels_of_some(taps: &[Tap]) -> VoxelSet {
    let mut set = VoxelSet::new();
    for run in taps.chunk_by(|a, b| brick(a) == brick(b)) {
        // Rows of nine bits over nine by nine rows: the brick and one layer of its upper neighbours.
        let mut rows = [[0u16; 9]; 9];
        for tap in run {
            let [x, y, z] = tap.base.map(|c| (c & 7) as usize);
            let [more_x, more_y, more_z] = tap.fractions().map(|f| usize::from(f > 0));
            let reach = if more_x == 1 { 0b11u16 } else { 0b1 };
            for row in &mut rows[z..=z + more_z] {
                row[y..=y + more_y].iter_mut().for_each(|bits| *bits |= reach << x);
            }
        }
        let Some(first) = run.first() else { continue };
        for octant in 0..8usize {
            let [dx, dy, dz] = [octant & 1, octant >> 1 & 1, octant >> 2];
            let mut mask = [0u64; 8];
            for (z, word) in mask.iter_mut().enumerate().take(if dz == 1 { 1 } else { 8 }) {
                for y in 0..if dy == 1 { 1 } else { 8 } {
                    let bits = rows[z + 8 * dz][y + 8 * dy] >> (8 * dx) & 0xff;
                    *word |= u64::from(bits) << (8 * y);
                }
            }
            let [x, y, z] = brick(first);
            set.insert_mask([x + dx as i32, y + dy as i32, z + dz as i32], &mask);
        }
    }
    set
}

fn brick(tap: &Tap) -> [i32; 3] {
    tap.base.map(|c| c >> 3)
}

/// The entries of a point's voxels in the answer, and their weights.
#[derive(Clone, Copy, Default)]
struct Corners {
    entries: [u32; 8],
    weights: [u32; 8],
}

/// The corners of all points, or `None` if the answer lacks a voxel.
fn locate(taps: &[Tap], answer: &VoxelMap) -> Option<Vec<Corners>> {
    let mut corners = vec![Corners::default(); taps.len()];
    let chunks = corners.par_chunks_mut(CHUNK).zip(taps.par_chunks(CHUNK));
    let complete = chunks.map(|(corners, taps)| {
        let mut at = 0;
        for run in taps.chunk_by(|a, b| brick(a) == brick(b)) {
            let Some(first) = run.first() else { continue };
            let slots: [Option<usize>; 8] = std::array::from_fn(|octant| {
                let ([x, y, z], octant) = (brick(first), octant as i32);
                answer.slot([x + (octant & 1), y + (octant >> 1 & 1), z + (octant >> 2)])
            });
            for tap in run {
                let Some(found) = corners_of(tap, &slots) else { return false };
                corners[at] = found;
                at += 1;
            }
        }
        true
    });
    complete.reduce(|| true, |a, b| a && b).then_some(corners)
}

/// A point's corners, given the slots of its brick and of its seven upper neighbours.
fn corners_of(tap: &Tap, slots: &[Option<usize>; 8]) -> Option<Corners> {
    let local = tap.base.map(|c| (c & 7) as usize);
    let mut found = Corners { entries: [0; 8], weights: tap.weights() };
    for corner in (0..8).filter(|&corner| found.weights[corner] > 0) {
        let step = [corner & 1, corner >> 1 & 1, corner >> 2];
        let [x, y, z]: [usize; 3] = std::array::from_fn(|i| local[i] + step[i]);
        let slot = slots[x >> 3 | (y >> 3) << 1 | (z >> 3) << 2]?;
        let entry = slot * BRICK_VOXELS + (x & 7 | (y & 7) << 3 | (z & 7) << 6);
        found.entries[corner] = u32::try_from(entry).ok()?;
    }
    Some(found)
}

/// Fills a map's entries from `first` on; false if the source is too short or of another type.
fn fill(map: &mut Map, first: usize, corners: &[Corners], source: &Map) -> bool {
    let n = map.channels;
    let unit = is_unit(&map.info());
    let span = first * n..(first + corners.len()) * n;
    match (&mut map.samples, &source.samples) {
        (Samples::U8(out), Samples::U8(source)) => out.get_mut(span).is_some_and(|out| {
            fill_as(out, n, corners, source, |voxels| {
                let mut sums = [0u32; 4];
                for (weight, voxel) in voxels {
                    sums.iter_mut().zip(*voxel).for_each(|(sum, &v)| *sum += weight * u32::from(v));
                }
                if unit { unit_bytes(sums) } else { sums.map(mean_byte) }
            })
        }),
        (Samples::F32(out), Samples::F32(source)) => out.get_mut(span).is_some_and(|out| {
            fill_as(out, n, corners, source, |voxels| {
                let mut sums = [0.0f64; 4];
                for (weight, voxel) in voxels {
                    let weight = f64::from(*weight) / f64::from(Tap::FULL);
                    sums.iter_mut().zip(*voxel).for_each(|(sum, &v)| *sum += weight * f64::from(v));
                }
                let means = sums.map(|sum| sum as f32);
                if unit { unit_length(means, 1.0) } else { means }
            })
        }),
        (Samples::U32(out), Samples::U32(source)) => out.get_mut(span).is_some_and(|out| {
            fill_as(out, n, corners, source, |voxels| {
                // The heaviest is the nearest voxel; of equals the first.
                let heaviest = voxels.iter().fold(voxels[0], |best, &v| if v.0 > best.0 { v } else { best });
                std::array::from_fn(|c| heaviest.1.get(c).copied().unwrap_or(0))
            })
        }),
        _ => false,
    }
}

/// Fills entries from the voxels of each point and their weights; a voxel that counts alone is copied.
fn fill_as<T: Copy + Send + Sync>(
    out: &mut [T],
    channels: usize,
    corners: &[Corners],
    source: &[T],
    mix: impl Fn(&[(u32, &[T]); 8]) -> [T; 4] + Sync,
) -> bool {
    let chunks = out.par_chunks_mut(CHUNK * channels).zip(corners.par_chunks(CHUNK));
    let complete = chunks.map(|(out, corners)| {
        for (out, Corners { entries, weights }) in out.chunks_exact_mut(channels).zip(corners) {
            let voxel = |entry: u32| source.get(entry as usize * channels..(entry as usize + 1) * channels);
            let Some(first) = voxel(entries[0]) else { return false };
            if weights[0] == Tap::FULL {
                out.copy_from_slice(first);
                continue;
            }
            let mut voxels = [(0, first); 8];
            for (to, (&entry, &weight)) in voxels.iter_mut().zip(entries.iter().zip(weights)) {
                let Some(voxel) = voxel(entry) else { return false };
                *to = (weight, voxel);
            }
            out.iter_mut().zip(mix(&voxels)).for_each(|(out, v)| *out = v);
        }
        true
    });
    complete.reduce(|| true, |a, b| a && b)
}

/// Whether a map's samples are unit vectors, stored as (n + 1) / 2.
pub(crate) fn is_unit(info: &MapInfo) -> bool {
    info.name == "normal" && info.channels >= 3
}

/// The bytes of a normal, of unit length again, from the weighted sums of its voxels' bytes.
pub(crate) fn unit_bytes(sums: [u32; 4]) -> [u8; 4] {
    let means = sums.map(|sum| sum as f32 / Tap::FULL as f32);
    unit_length(means, 255.0).map(|v| (v + 0.5).clamp(0.0, 255.0) as u8)
}

/// Gives a normal stored as (n + 1) / 2 · full unit length again.
fn unit_length(mut stored: [f32; 4], full: f32) -> [f32; 4] {
    let n: [f32; 3] = std::array::from_fn(|i| stored[i] / full * 2.0 - 1.0);
    let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
    if length > 1e-6 {
        (0..3).for_each(|i| stored[i] = (n[i] / length * 0.5 + 0.5) * full);
    }
    stored
}
