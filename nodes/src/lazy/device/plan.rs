//! Which bricks of each level a request may need, and how the bricks of two levels belong together.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::lazy::domain::Domain;
use crate::lazy::pyramid::RADIUS;

/// No brick.
pub(super) const ABSENT: u32 = u32::MAX;

/// The bricks of one level; a brick's slot is its place in `keys`.
pub(super) struct Bricks {
    pub keys: Vec<[i32; 3]>,
    pub slots: FxHashMap<[i32; 3], u32>,
}

impl Bricks {
    pub fn new(mut keys: Vec<[i32; 3]>) -> Self {
        keys.sort_unstable_by_key(|key| [key[2], key[1], key[0]]);
        let slots = keys.iter().copied().zip(0..).collect();
        Self { keys, slots }
    }

    pub fn slot(&self, key: [i32; 3]) -> u32 {
        self.slots.get(&key).copied().unwrap_or(ABSENT)
    }

    /// All bricks that sub-passes over these can look into: more than they will, since the device decides by voxels.
    pub fn around(keys: impl IntoIterator<Item = [i32; 3]>, steps: usize, domain: &Domain) -> Self {
        let reach = RADIUS * steps as i32;
        let mut found = FxHashSet::default();
        for key in keys {
            let axes: [Vec<i32>; 3] = std::array::from_fn(|axis| {
                let first = key[axis].wrapping_mul(8);
                let end = domain.period.map_or(8, |period| (period[axis] - first).clamp(1, 8));
                let voxels = first.wrapping_sub(reach)..first.wrapping_add(end + reach);
                let mut bricks: Vec<i32> = voxels.map(|c| domain.wrap(axis, c) >> 3).collect();
                bricks.sort_unstable();
                bricks.dedup();
                bricks
            });
            for &z in &axes[2] {
                for &y in &axes[1] {
                    found.extend(axes[0].iter().map(|&x| [x, y, z]));
                }
            }
        }
        Self::new(found.into_iter().collect())
    }

    /// For each of these the slot of its parent among the bricks of the coarser level.
    pub fn ancestors(&self, coarse: &Self) -> Vec<u32> {
        self.keys.iter().map(|key| coarse.slot(key.map(|c| c >> 1))).collect()
    }

    /// For each brick of the coarser level the slots of its eight children among these.
    pub fn children(&self, coarse: &Self, ancestors: &[u32]) -> Vec<u32> {
        let mut children = vec![ABSENT; 8 * coarse.keys.len()];
        for ((key, &ancestor), slot) in self.keys.iter().zip(ancestors).zip(0..) {
            let [x, y, z] = key.map(|c| (c & 1) as usize);
            if let Some(child) = children.get_mut(8 * ancestor as usize + (x | y << 1 | z << 2)) {
                *child = slot;
            }
        }
        children
    }

    /// The table in which the device looks keys up: each with its slot at the place of its hash or behind it.
    pub fn places(&self) -> Vec<[i32; 4]> {
        let count = (2 * self.keys.len()).next_power_of_two();
        let mut places = vec![[0, 0, 0, -1]; count];
        for (&key, slot) in self.keys.iter().zip(0..) {
            let mut at = hash_key(key) as usize & (count - 1);
            while places[at][3] >= 0 {
                at = (at + 1) & (count - 1);
            }
            places[at] = [key[0], key[1], key[2], slot];
        }
        places
    }
}

/// The hash of a brick, as in `kernels/modules/bricks.wgsl`.
fn hash_key(key: [i32; 3]) -> u32 {
    let [x, y, z] = key.map(|c| c as u32);
    let h = x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791);
    let h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h ^ (h >> 13)
}
