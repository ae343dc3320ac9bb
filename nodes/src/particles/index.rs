//! Which placed particles may have voxels in a brick.

use rustc_hash::FxHashMap;

use super::packing::Packing;
use crate::data::{BRICK, BRICK_VOXELS, voxel_at};

/// Edge of the index's cells in voxels.
const CELL: i32 = 2 * BRICK;

/// Placed particles by the cells of a grid that their boxes touch.
pub struct Index {
    cells: FxHashMap<[i32; 3], Vec<u32>>,
}

impl Index {
    /// The index of a packing's particles, in their places within the domain and, if it repeats, beyond its ends.
    pub fn new(packing: &Packing) -> Self {
        let mut cells: FxHashMap<[i32; 3], Vec<u32>> = FxHashMap::default();
        for (placed, i) in packing.placed.iter().zip(0..) {
            let (low, size) = packing.bounds(placed);
            let first: [i32; 3] = std::array::from_fn(|a| (placed.center[a] + low[a]).div_euclid(CELL));
            let last: [i32; 3] =
                std::array::from_fn(|a| (placed.center[a] + low[a] + size[a] as i32 - 1).div_euclid(CELL));
            for z in first[2]..=last[2] {
                for y in first[1]..=last[1] {
                    for x in first[0]..=last[0] {
                        cells.entry([x, y, z]).or_default().push(i);
                    }
                }
            }
        }
        Self { cells }
    }

    /// Bytes held.
    pub fn byte_size(&self) -> u64 {
        self.cells.values().map(|cell| 48 + 4 * cell.capacity() as u64).sum()
    }

    /// Calls `f` for each placed particle that may have voxels among `size` voxels from `origin` on, with its centre there; a
    /// particle comes once for each of its repetitions. The order is that of the packing.
    fn around(&self, packing: &Packing, origin: [i32; 3], size: i32, mut f: impl FnMut(u32, [i32; 3])) {
        let mut found: Vec<(u32, [i32; 3])> = Vec::new();
        let shifts = |a: usize| {
            if !packing.wrap {
                return 0..=0;
            }
            // Boxes reach less than a domain beyond its ends.
            let n = packing.size[a] as i32;
            (origin[a].div_euclid(n) - 1)..=((origin[a] + size - 1).div_euclid(n) + 1)
        };
        for sz in shifts(2) {
            for sy in shifts(1) {
                for sx in shifts(0) {
                    let shift = [sx, sy, sz];
                    let shift: [i32; 3] =
                        std::array::from_fn(|a| shift[a].wrapping_mul(packing.size[a] as i32));
                    let from: [i32; 3] = std::array::from_fn(|a| origin[a].wrapping_sub(shift[a]));
                    let cell = |a: usize| from[a].div_euclid(CELL)..=(from[a] + size - 1).div_euclid(CELL);
                    for z in cell(2) {
                        for y in cell(1) {
                            for x in cell(0) {
                                for &i in self.cells.get(&[x, y, z]).into_iter().flatten() {
                                    found.push((i, shift));
                                }
                            }
                        }
                    }
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        for (i, shift) in found {
            let center = packing.placed[i as usize].center;
            f(i, std::array::from_fn(|a| center[a].wrapping_add(shift[a])));
        }
    }

    /// For each voxel of a brick the placed particle that has it, from 1 on, and the voxel from that particle's centre; 0 for
    /// the matrix. In a domain that ends, voxels beyond it are those nearest to them within.
    pub fn label_brick(&self, packing: &Packing, brick: [i32; 3]) -> Vec<(u32, [i32; 3])> {
        let mut found = vec![(0u32, [0i32; 3]); BRICK_VOXELS];
        let origin = brick.map(|b| b.wrapping_mul(BRICK));
        if !packing.wrap {
            let inside = (0..3).all(|a| origin[a] >= 0 && origin[a] + BRICK <= packing.size[a] as i32);
            if !inside {
                self.clamped(packing, brick, &mut found);
                return found;
            }
        }
        self.around(packing, origin, BRICK, |i, center| {
            let placed = &packing.placed[i as usize];
            let (low, size) = packing.bounds(placed);
            let span = |a: usize| {
                let first = i64::from(center[a]) + i64::from(low[a]) - i64::from(origin[a]);
                (first.max(0), (first + i64::from(size[a])).min(BRICK.into()))
            };
            let [xs, ys, zs] = [span(0), span(1), span(2)];
            for z in zs.0..zs.1 {
                for y in ys.0..ys.1 {
                    for x in xs.0..xs.1 {
                        let at = (x + 8 * y + 64 * z) as usize;
                        if found[at].0 != 0 {
                            continue;
                        }
                        let local = [x, y, z];
                        let voxel = std::array::from_fn(|a| {
                            (i64::from(origin[a]) + local[a] - i64::from(center[a])) as i32
                        });
                        if packing.holds(placed, voxel) {
                            found[at] = (i + 1, voxel);
                        }
                    }
                }
            }
        });
        found
    }

    fn clamped(&self, packing: &Packing, brick: [i32; 3], found: &mut [(u32, [i32; 3])]) {
        for (at, found) in found.iter_mut().enumerate() {
            let place = voxel_at(brick, at);
            let voxel: [i32; 3] = std::array::from_fn(|a| place[a].clamp(0, packing.size[a] as i32 - 1));
            self.around(packing, voxel, 1, |i, center| {
                let from = std::array::from_fn(|a| voxel[a] - center[a]);
                if found.0 == 0 && packing.holds(&packing.placed[i as usize], from) {
                    *found = (i + 1, from);
                }
            });
        }
    }
}
