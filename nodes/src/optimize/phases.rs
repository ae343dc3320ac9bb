//! The order in which voxels are updated: 64 phases by a hash of their place, so that histograms are brought up to date between
//! voxels that lie anywhere. Longer runs of one phase would show as streaks, since all of them see the same histograms.

use std::ops::Range;

use rayon::prelude::*;

use crate::lazy::random::hash;

/// Phases of a sweep.
pub const PHASES: usize = 64;
/// Voxels that a thread takes at once.
pub const PORTION: usize = 128;

/// Edge of the bricks in whose order voxels are taken.
const BRICK: usize = 16;

/// The voxels of a box, phase by phase, brick by brick within each.
pub struct Phases {
    voxels: Vec<u32>,
    starts: Vec<usize>,
}

impl Phases {
    /// The phases of a sweep; every sweep has others.
    pub fn new(size: [usize; 3], seed: u64, purpose: u32, sweep: u32) -> Self {
        let [width, height, depth] = size;
        let count = width * height * depth;
        let purpose = purpose.wrapping_add(sweep.wrapping_mul(0x9e37_79b1));
        let mut phases = vec![0u8; count];
        phases.par_chunks_mut(width).enumerate().for_each(|(row, phases)| {
            let (y, z) = ((row % height) as i32, (row / height) as i32);
            for (x, phase) in phases.iter_mut().enumerate() {
                *phase = (hash(seed, purpose, [x as i32 / 2, y / 2, z / 2]) % PHASES as u32) as u8;
            }
        });
        let mut starts = vec![0; PHASES + 1];
        phases.iter().for_each(|&phase| starts[usize::from(phase) + 1] += 1);
        for phase in 0..PHASES {
            starts[phase + 1] += starts[phase];
        }
        let mut next = starts.clone();
        let mut voxels = vec![0; count];
        // Brick by brick, so that voxels that share surroundings follow each other.
        let bricks = |n: usize| (0..n).step_by(BRICK).map(move |start| start..(start + BRICK).min(n));
        for zs in bricks(depth) {
            for ys in bricks(height) {
                for xs in bricks(width) {
                    for z in zs.clone() {
                        for y in ys.clone() {
                            let row = (z * height + y) * width;
                            for i in row + xs.start..row + xs.end {
                                let slot = &mut next[usize::from(phases[i])];
                                voxels[*slot] = i as u32;
                                *slot += 1;
                            }
                        }
                    }
                }
            }
        }
        Self { voxels, starts }
    }

    /// The voxels of each phase.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        self.ranges().map(|range| &self.voxels[range])
    }

    /// All voxels, phase by phase.
    pub fn voxels(&self) -> &[u32] {
        &self.voxels
    }

    /// Where among [`Phases::voxels`] each phase lies.
    pub fn ranges(&self) -> impl Iterator<Item = Range<usize>> {
        self.starts.windows(2).map(|ends| ends[0]..ends[1])
    }
}

/// The farthest that a window reaches.
const REACH: usize = 32;

/// Indices of the voxels around a voxel of a box that repeats. They count brick by brick, so that what is near lies together in
/// memory; bricks are whole, also where the box ends.
pub struct Around {
    size: [usize; 3],
    /// Voxels along the edges of a brick, powers of two.
    brick: [usize; 3],
    /// Bricks along the edges of the box.
    bricks: [usize; 3],
    /// For each axis and coordinate, from [`REACH`] before the box to as many behind it, its share of the index.
    axes: [Vec<u32>; 3],
}

impl Around {
    /// For a box of this size.
    pub fn new(size: [usize; 3]) -> Self {
        let brick = size.map(|n| n.next_power_of_two().min(BRICK));
        let bricks: [usize; 3] = std::array::from_fn(|a| size[a].div_ceil(brick[a]));
        let within = [1, brick[0], brick[0] * brick[1]];
        let volume = within[2] * brick[2];
        let across = [volume, volume * bricks[0], volume * bricks[0] * bricks[1]];
        let axes = std::array::from_fn(|a| {
            let share = |x: i32| {
                let x = x.rem_euclid(size[a] as i32) as usize;
                (x % brick[a] * within[a] + x / brick[a] * across[a]) as u32
            };
            (-(REACH as i32)..(size[a] + REACH) as i32).map(share).collect()
        });
        Self { size, brick, bricks, axes }
    }

    /// Values of all voxels in this order, from a function of their usual indices.
    pub fn arrange<T: Copy + Default + Send + Sync>(&self, value: impl Fn(usize) -> T + Sync) -> Vec<T> {
        let ([width, height, depth], [bx, by, bz], [nx, ny, nz]) = (self.size, self.brick, self.bricks);
        let mut out = vec![T::default(); bx * by * bz * nx * ny * nz];
        out.par_chunks_mut(bx * by * bz).enumerate().for_each(|(i, brick)| {
            let (x0, y0, z0) = (i % nx * bx, i / nx % ny * by, i / (nx * ny) * bz);
            for (j, row) in brick.chunks_exact_mut(bx).enumerate() {
                let (y, z) = (y0 + j % by, z0 + j / by);
                if y < height && z < depth {
                    let from = (z * height + y) * width;
                    let row = row.iter_mut().zip(from + x0..from + width);
                    row.for_each(|(to, i)| *to = value(i));
                }
            }
        });
        out
    }

    /// A voxel's own index in this order.
    #[inline(always)]
    pub fn own(&self, voxel: usize) -> usize {
        let (own, columns, rows) = self.plane(voxel, 0, 0, 1);
        (own + columns[0] + rows[0]) as usize
    }

    /// The surroundings of a voxel in the plane of a direction's exemplar: what the voxel's place along the direction adds to
    /// an index, and what the places from `before` before to `after` after it along columns and rows add.
    #[inline(always)]
    pub fn plane(&self, voxel: usize, direction: usize, before: i32, size: i32) -> (u32, &[u32], &[u32]) {
        let [width, height, _] = self.size;
        let at = [voxel % width, voxel / width % height, voxel / (width * height)];
        let (c, r) = ((direction + 1) % 3, (direction + 2) % 3);
        let part = |axis: usize| {
            let start = at[axis] + REACH - before as usize;
            &self.axes[axis][start..start + size as usize]
        };
        (self.axes[direction][at[direction] + REACH], part(c), part(r))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_follow_the_cyclic_order_and_wrap() {
        let size = [5, 6, 7];
        let around = Around::new(size);
        let index = |x: usize, y: usize, z: usize| (z * 6 + y) * 5 + x;
        let places = around.arrange(|i| i);
        let at = |voxel, direction, (along, across): (i32, i32)| {
            let (own, columns, rows) = around.plane(voxel, direction, 4, 9);
            places[(own + columns[(along + 4) as usize] + rows[(across + 4) as usize]) as usize]
        };
        // Direction x: columns along y, rows along z.
        assert_eq!(at(index(3, 5, 0), 0, (1, -1)), index(3, 0, 6));
        // Direction y: columns along z, rows along x.
        assert_eq!(at(index(3, 2, 6), 1, (1, 3)), index(1, 2, 0));
        // Direction z: columns along x, rows along y.
        assert_eq!(at(index(2, 0, 3), 2, (-4, -1)), index(3, 5, 3));
    }

    #[test]
    fn bricks_hold_every_voxel_once() {
        for size in [[1, 1, 1], [40, 3, 17], [16, 33, 1]] {
            let around = Around::new(size);
            let places = around.arrange(|i| i + 1);
            assert!((0..size.iter().product::<usize>()).all(|i| places[around.own(i)] == i + 1));
            assert_eq!(places.iter().filter(|&&i| i > 0).count(), size.iter().product::<usize>());
        }
    }

    #[test]
    fn every_voxel_has_one_phase_and_every_phase_voxels() {
        let phases = Phases::new([16, 20, 30], 5, 7, 2);
        let mut seen = vec![0; 16 * 20 * 30];
        for voxels in phases.iter() {
            assert!((30..400).contains(&voxels.len()));
            voxels.iter().for_each(|&v| seen[v as usize] += 1);
        }
        assert!(seen.iter().all(|&n| n == 1));
    }
}
