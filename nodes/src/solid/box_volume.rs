//! A box of any solid as a dense volume.

use crate::control::Control;
use crate::data::{BRICK, Map, MapInfo, SampleType, Solid, SolidError, Volume, VoxelMap, VoxelSet, brick_of};

/// The longest edge of the blocks that the solid is asked for, in voxels: what a block needs on top of
/// the result stays small, and boxes up to this size are asked for in one go.
const BLOCK: u32 = 192;

/// The voxels of a box, every map. The solid is asked block by block, so that little more memory is held
/// than the result takes. The spacing is 1.
///
/// # Errors
/// [`SolidError::TooLarge`] before anything is allocated if the result takes more than `memory_limit`
/// bytes, or the box leaves the range of voxel coordinates; [`SolidError::Cancelled`].
pub fn box_volume(
    solid: &dyn Solid,
    origin: [i32; 3],
    size: [u32; 3],
    memory_limit: u64,
    control: &dyn Control,
) -> Result<Volume, SolidError> {
    let infos = solid.maps();
    let voxels = check_size(&infos, origin, size, memory_limit)?;
    let mut volume = Volume {
        size: size.map(|n| n as usize),
        origin,
        spacing: [1.0; 3],
        maps: infos.iter().map(|info| Map::zeros(info, voxels)).collect(),
    };
    let [xs, ys, zs]: [_; 3] = std::array::from_fn(|i| spans(origin[i], size[i]));
    let blocks = xs.len() * ys.len() * zs.len();
    let mut done = 0;
    for &(z0, z1) in &zs {
        for &(y0, y1) in &ys {
            for &(x0, x1) in &xs {
                let (from, to) = ([x0, y0, z0], [x1, y1, z1]);
                let edges = std::array::from_fn(|i| from[i].abs_diff(to[i]));
                let answer = solid.evaluate(&VoxelSet::from_box(from, edges), control)?;
                copy_block(&answer, &mut volume, from, to);
                done += 1;
                control.progress(done as f32 / blocks as f32);
            }
        }
    }
    Ok(volume)
}

/// How many voxels a box has, if it fits the lattice and the memory.
fn check_size(
    infos: &[MapInfo],
    origin: [i32; 3],
    size: [u32; 3],
    memory_limit: u64,
) -> Result<usize, SolidError> {
    let [x, y, z] = size;
    if size.contains(&0) {
        return Err(SolidError::TooLarge(format!("a box of {x} × {y} × {z} voxels is empty")));
    }
    if (0..3).any(|i| origin[i].checked_add_unsigned(size[i]).is_none()) {
        return Err(SolidError::TooLarge(format!(
            "a box of {x} × {y} × {z} voxels from {origin:?} on leaves the range of voxel coordinates"
        )));
    }
    let voxel: u128 = infos.iter().map(|info| info.channels as u128 * bytes(info.ty)).sum();
    let voxels = size.iter().map(|&n| u128::from(n)).product::<u128>();
    let needed = voxels.saturating_mul(voxel);
    let limit = u128::from(memory_limit).min(isize::MAX as u128);
    if needed > limit || voxels > isize::MAX as u128 {
        let mut edge = libm::cbrt(limit as f64 / voxel.max(1) as f64) as u128 + 1;
        while edge.pow(3) * voxel > limit {
            edge -= 1;
        }
        return Err(SolidError::TooLarge(format!(
            "a box of {x} × {y} × {z} voxels needs {:.2} GB, {:.2} GB may be used: the largest cube that fits has {edge}³ voxels",
            needed as f64 / 1e9,
            limit as f64 / 1e9,
        )));
    }
    Ok(voxels as usize)
}

fn bytes(ty: SampleType) -> u128 {
    match ty {
        SampleType::U8 => 1,
        SampleType::U32 | SampleType::F32 => 4,
    }
}

/// Cuts an axis into blocks of about equal length, at brick boundaries so that no brick is asked for twice.
fn spans(origin: i32, size: u32) -> Vec<(i32, i32)> {
    let count = i64::from(size.div_ceil(BLOCK).max(1));
    let (start, end) = (i64::from(origin), i64::from(origin) + i64::from(size));
    let brick = i64::from(BRICK);
    let mut cuts = vec![start];
    for i in 1..count {
        let cut = (start + i64::from(size) * i / count).div_euclid(brick) * brick;
        if cut > start {
            cuts.push(cut);
        }
    }
    cuts.push(end);
    cuts.dedup();
    // The caller has checked that the end is a coordinate.
    cuts.windows(2).map(|pair| (pair[0] as i32, pair[1] as i32)).collect()
}

/// Copies the voxels from `from` to `to` (exclusive) of an answer into the volume, run by run.
fn copy_block(answer: &VoxelMap, volume: &mut Volume, from: [i32; 3], to: [i32; 3]) {
    let origin = volume.origin;
    for z in from[2]..to[2] {
        for y in from[1]..to[1] {
            let mut x = from[0];
            while x < to[0] {
                let run = (BRICK - x.rem_euclid(BRICK)).min(to[0] - x);
                let voxel = [x, y, z];
                debug_assert!(answer.slot(brick_of(voxel)).is_some(), "the answer lacks {voxel:?}");
                if let Some(at) = answer.index(voxel) {
                    let [i, j, k]: [usize; 3] =
                        std::array::from_fn(|axis| voxel[axis].abs_diff(origin[axis]) as usize);
                    let to = volume.index(i, j, k);
                    for (map, answered) in volume.maps.iter_mut().zip(&answer.maps) {
                        let n = map.channels;
                        map.samples.copy_from(to * n, &answered.samples, at * n, run as usize * n);
                    }
                }
                x += run;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::CheckerSolid;

    const SOLID: CheckerSolid =
        CheckerSolid { colors: [[40, 90, 160], [220, 180, 120]], cell: 5, noise: 20, seed: 3 };

    #[test]
    fn every_voxel_of_the_box_is_the_solids() {
        let (origin, size) = ([-7, 100, -13], [211u32, 9, 17]);
        let volume = box_volume(&SOLID, origin, size, u64::MAX, &()).unwrap();
        let color = volume.map("color").unwrap();
        for z in 0..17 {
            for y in 0..9 {
                for x in 0..211 {
                    let at = volume.index(x, y, z) * 3;
                    let found = [0, 1, 2].map(|c| color.samples.get_u8(at + c));
                    let voxel = [origin[0] + x as i32, origin[1] + y as i32, origin[2] + z as i32];
                    assert_eq!(found, SOLID.color(voxel), "{voxel:?}");
                }
            }
        }
    }

    #[test]
    fn a_box_beyond_the_memory_names_what_fits() {
        let error = box_volume(&SOLID, [0; 3], [2000, 2000, 2000], 3_000_000, &()).unwrap_err();
        let text = error.to_string();
        assert!(text.contains("24.00 GB") && text.contains("100³"), "{text}");
    }

    #[test]
    fn a_box_that_leaves_the_lattice_is_refused() {
        let error = box_volume(&SOLID, [i32::MAX - 3, 0, 0], [4; 3], u64::MAX, &()).unwrap_err();
        assert!(error.to_string().contains("leaves the range"), "{error}");
    }

    #[test]
    fn blocks_cover_an_axis_without_gaps() {
        for (origin, size) in [(0, 1), (-5, 193), (3, 192), (-1000, 1001), (7, 400)] {
            let spans = spans(origin, size);
            assert_eq!(spans.first().unwrap().0, origin);
            assert_eq!(spans.last().unwrap().1, origin + size as i32);
            assert!(spans.windows(2).all(|pair| pair[0].1 == pair[1].0 && pair[0].1 % 8 == 0));
        }
    }
}
