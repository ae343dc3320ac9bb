//! The voxels that a mesh's surface runs through.

use rayon::prelude::*;

use super::space::Space;
use super::vector::{cross, dot, sub};
use crate::control::{Cancelled, Control, check};
use crate::data::{Mesh, VoxelSet};

/// Voxels of a surface could not be collected.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VoxelsError {
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The set would not fit into memory.
    #[error(
        "the surface runs through about {0:.0} million voxels, more than the {MAX_MILLIONS} million that are allowed; lower the resolution"
    )]
    TooLarge(f64),
}

/// Largest estimated number of voxels in a surface, in millions.
pub const MAX_MILLIONS: f64 = 1000.0;

/// The voxels whose cubes, widened by `thickness` voxels to every side, meet the surface. Touching counts.
///
/// # Errors
/// If cancelled, or if the surface is too large for the resolution.
pub fn surface_voxels(
    mesh: &Mesh,
    space: &Space,
    thickness: f32,
    control: &dyn Control,
) -> Result<VoxelSet, VoxelsError> {
    let thickness = f64::from(thickness.clamp(0.0, 64.0));
    let corners = |t: &[u32; 3]| -> Option<[[f64; 3]; 3]> {
        let mut out = [[0.0; 3]; 3];
        for (out, &i) in out.iter_mut().zip(t) {
            *out = space.to_voxels(mesh.positions.get(i as usize)?.map(f64::from));
            // Beyond this a voxel has no number.
            out.iter().all(|c| c.abs() < 2e9).then_some(())?;
        }
        Some(out)
    };
    let triangles: Vec<[[f64; 3]; 3]> = mesh.triangles.iter().filter_map(corners).collect();
    // A slanted surface crosses up to three voxels a unit of area.
    let area: f64 = triangles.iter().map(area).sum();
    let millions = area * (2.0 + 2.0 * thickness) / 1e6;
    if millions > MAX_MILLIONS {
        return Err(VoxelsError::TooLarge(millions));
    }
    let sets: Vec<VoxelSet> = triangles
        .par_chunks(64)
        .map(|triangles| {
            let mut set = VoxelSet::new();
            for triangle in triangles {
                check(control)?;
                let (lo, hi) = bounds(triangle);
                let extent = (0..3).map(|i| hi[i] - lo[i]).fold(0.0, f64::max) + 2.0 * thickness + 2.0;
                let side = (extent as u64).next_power_of_two().max(8) as i64 * 2;
                let corner = lo.map(|c| (c - thickness).floor() as i64);
                descend(triangle, corner, side, thickness, &mut set);
            }
            Ok(set)
        })
        .collect::<Result<_, Cancelled>>()?;
    let mut all = VoxelSet::new();
    sets.iter().for_each(|set| all.union(set));
    Ok(all)
}

fn area(t: &[[f64; 3]; 3]) -> f64 {
    let n = cross(sub(t[1], t[0]), sub(t[2], t[0]));
    0.5 * (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt()
}

fn bounds(t: &[[f64; 3]; 3]) -> ([f64; 3], [f64; 3]) {
    let fold = |pick: fn(f64, f64) -> f64| std::array::from_fn(|i| pick(pick(t[0][i], t[1][i]), t[2][i]));
    (fold(f64::min), fold(f64::max))
}

/// Adds the voxels of a cube that the triangle meets, halving the cube until it is one voxel.
fn descend(triangle: &[[f64; 3]; 3], corner: [i64; 3], side: i64, thickness: f64, set: &mut VoxelSet) {
    let half = side as f64 / 2.0;
    let center = corner.map(|c| c as f64 + half);
    if !meets(triangle, center, half + thickness) {
        return;
    }
    if side == 1 {
        if let [Ok(x), Ok(y), Ok(z)] = corner.map(i32::try_from) {
            set.insert([x, y, z]);
        }
        return;
    }
    for octant in 0..8 {
        let step = [octant & 1, octant >> 1 & 1, octant >> 2];
        let corner = std::array::from_fn(|i| corner[i] + step[i] * side / 2);
        descend(triangle, corner, side / 2, thickness, set);
    }
}

/// Whether a triangle meets a cube (separating axes, Akenine-Möller 2001).
fn meets(triangle: &[[f64; 3]; 3], center: [f64; 3], half: f64) -> bool {
    let t = triangle.map(|p| sub(p, center));
    let separates = |axis: [f64; 3]| {
        let reach = half * (axis[0].abs() + axis[1].abs() + axis[2].abs());
        let [a, b, c] = t.map(|p| dot(p, axis));
        a.min(b).min(c) > reach || a.max(b).max(c) < -reach
    };
    const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let edges = [sub(t[1], t[0]), sub(t[2], t[1]), sub(t[0], t[2])];
    !AXES.into_iter().any(separates)
        && !separates(cross(edges[0], edges[1]))
        && !AXES.into_iter().any(|axis| edges.into_iter().any(|edge| separates(cross(axis, edge))))
}
