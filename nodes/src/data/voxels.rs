//! Sparse sets of voxels, and sparse maps of samples over such sets, in bricks of 8³.

use breccia_engine::{Data, Digest};
use rustc_hash::FxHashMap;

use super::{Map, MapInfo};

/// Voxels along a brick's edge.
pub const BRICK: i32 = 8;
/// Voxels in a brick.
pub const BRICK_VOXELS: usize = 512;

/// The brick that holds a voxel.
pub fn brick_of(voxel: [i32; 3]) -> [i32; 3] {
    voxel.map(|c| c >> 3)
}

/// A voxel's index in its brick: x + 8 y + 64 z of its position there.
pub fn local_index(voxel: [i32; 3]) -> usize {
    let [x, y, z] = voxel.map(|c| (c & 7) as usize);
    x | y << 3 | z << 6
}

/// The voxel of a brick at a local index.
pub fn voxel_at(brick: [i32; 3], at: usize) -> [i32; 3] {
    let local = [at & 7, at >> 3 & 7, at >> 6];
    std::array::from_fn(|i| brick[i].wrapping_mul(BRICK).wrapping_add(local[i] as i32))
}

/// The local indices of a mask's voxels.
pub fn indices(mask: &[u64; 8]) -> impl Iterator<Item = usize> + '_ {
    mask.iter().enumerate().flat_map(|(z, &word)| {
        let mut left = word;
        std::iter::from_fn(move || {
            (left != 0).then(|| {
                let i = left.trailing_zeros() as usize;
                left &= left - 1;
                z * 64 + i
            })
        })
    })
}

/// Any set of voxels of the integer lattice, as bit masks of bricks. Word `z` of a mask holds the bits
/// `x + 8 y` of its layer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct VoxelSet {
    bricks: FxHashMap<[i32; 3], [u64; 8]>,
}

impl VoxelSet {
    /// The empty set.
    pub fn new() -> Self {
        Self::default()
    }

    /// Every voxel from `origin` (inclusive) to `origin + size` (exclusive).
    pub fn from_box(origin: [i32; 3], size: [u32; 3]) -> Self {
        let mut set = Self::new();
        if size.contains(&0) {
            return set;
        }
        let end: [i32; 3] = std::array::from_fn(|i| origin[i].saturating_add_unsigned(size[i]));
        let first = brick_of(origin);
        let last = brick_of(end.map(|c| c - 1));
        // Bits of one axis of a brick that lie inside the box.
        let span = |axis: usize, brick: i32| -> (i32, i32) {
            let lo = (origin[axis] - brick * BRICK).max(0);
            let hi = (end[axis] - brick * BRICK).min(BRICK);
            (lo, hi)
        };
        for bz in first[2]..=last[2] {
            let (z0, z1) = span(2, bz);
            for by in first[1]..=last[1] {
                let (y0, y1) = span(1, by);
                for bx in first[0]..=last[0] {
                    let (x0, x1) = span(0, bx);
                    let row = ((1u64 << (x1 - x0)) - 1) << x0;
                    let layer = (y0..y1).fold(0u64, |bits, y| bits | row << (8 * y));
                    let mut mask = [0; 8];
                    mask[z0 as usize..z1 as usize].fill(layer);
                    set.bricks.insert([bx, by, bz], mask);
                }
            }
        }
        set
    }

    /// Adds a voxel.
    pub fn insert(&mut self, voxel: [i32; 3]) {
        let at = local_index(voxel);
        self.bricks.entry(brick_of(voxel)).or_insert([0; 8])[at >> 6] |= 1 << (at & 63);
    }

    /// Whether the voxel is in the set.
    pub fn contains(&self, voxel: [i32; 3]) -> bool {
        let at = local_index(voxel);
        self.bricks.get(&brick_of(voxel)).is_some_and(|mask| mask[at >> 6] >> (at & 63) & 1 == 1)
    }

    /// Adds the voxels of one brick's mask.
    pub fn insert_mask(&mut self, brick: [i32; 3], mask: &[u64; 8]) {
        if mask.iter().all(|&word| word == 0) {
            return;
        }
        let entry = self.bricks.entry(brick).or_insert([0; 8]);
        entry.iter_mut().zip(mask).for_each(|(a, b)| *a |= b);
    }

    /// Adds every voxel of another set.
    pub fn union(&mut self, other: &Self) {
        for (&brick, mask) in &other.bricks {
            self.insert_mask(brick, mask);
        }
    }

    /// The voxels that another set has too.
    pub fn intersection(&self, other: &Self) -> Self {
        self.by_bricks(|brick, mask| {
            let theirs = other.bricks.get(&brick).copied().unwrap_or_default();
            std::array::from_fn(|z| mask[z] & theirs[z])
        })
    }

    /// The voxels that another set does not have.
    pub fn difference(&self, other: &Self) -> Self {
        self.by_bricks(|brick, mask| {
            let theirs = other.bricks.get(&brick).copied().unwrap_or_default();
            std::array::from_fn(|z| mask[z] & !theirs[z])
        })
    }

    /// The set with the mask of every brick changed.
    fn by_bricks(&self, change: impl Fn([i32; 3], &[u64; 8]) -> [u64; 8]) -> Self {
        let mut out = Self::new();
        self.bricks.iter().for_each(|(&brick, mask)| out.insert_mask(brick, &change(brick, mask)));
        out
    }

    /// The mask of a brick, if any of its voxels may be in the set.
    pub fn mask(&self, brick: [i32; 3]) -> Option<&[u64; 8]> {
        self.bricks.get(&brick)
    }

    /// The bricks, sorted by z, y, x.
    pub fn bricks(&self) -> Vec<[i32; 3]> {
        let mut bricks: Vec<_> = self.bricks.keys().copied().collect();
        bricks.sort_unstable_by_key(|b| [b[2], b[1], b[0]]);
        bricks
    }

    /// How many bricks are touched.
    pub fn brick_count(&self) -> usize {
        self.bricks.len()
    }

    /// How many voxels are in the set.
    pub fn len(&self) -> usize {
        self.bricks.values().flatten().map(|word| word.count_ones() as usize).sum()
    }

    /// Whether the set is empty.
    pub fn is_empty(&self) -> bool {
        self.bricks.values().flatten().all(|&word| word == 0)
    }

    /// The voxels, sorted by brick and then by z, y, x.
    pub fn voxels(&self) -> impl Iterator<Item = [i32; 3]> + '_ {
        self.bricks().into_iter().flat_map(|brick| {
            let mask = self.bricks[&brick];
            let inside = move |&at: &usize| mask[at >> 6] >> (at & 63) & 1 == 1;
            (0..BRICK_VOXELS).filter(inside).map(move |at| voxel_at(brick, at))
        })
    }
}

impl FromIterator<[i32; 3]> for VoxelSet {
    fn from_iter<I: IntoIterator<Item = [i32; 3]>>(voxels: I) -> Self {
        let mut set = Self::new();
        voxels.into_iter().for_each(|voxel| set.insert(voxel));
        set
    }
}

impl Data for VoxelSet {
    const TYPE: &'static str = "voxel_set";
    const DOCS: &'static str = "Any set of voxels, in sparse bricks.";

    fn byte_size(&self) -> u64 {
        self.bricks.len() as u64 * 80
    }

    fn summary(&self) -> String {
        format!("{} voxels in {} bricks", self.len(), self.bricks.len())
    }

    fn digest(&self) -> Digest {
        let mut hasher = blake3::Hasher::new();
        for brick in self.bricks() {
            let mask = &self.bricks[&brick];
            if mask.iter().any(|&word| word != 0) {
                hasher.update(bytemuck::cast_slice(&brick)).update(bytemuck::cast_slice(mask));
            }
        }
        hasher.finalize().into()
    }
}

/// Samples for a sparse set of voxels, in bricks of 8³ with 512 entries a brick for each map.
///
/// Entries of voxels that were not asked for hold no meaning.
#[derive(Clone, Debug, Default)]
pub struct VoxelMap {
    slots: FxHashMap<[i32; 3], u32>,
    /// The maps, [`BRICK_VOXELS`] × channels samples a brick slot.
    pub maps: Vec<Map>,
}

impl VoxelMap {
    /// Room for the bricks in the order given, all zeros.
    pub fn new(bricks: &[[i32; 3]], maps: &[MapInfo]) -> Self {
        let slots = bricks.iter().enumerate().map(|(slot, &brick)| (brick, slot as u32)).collect();
        let maps = maps.iter().map(|info| Map::zeros(info, bricks.len() * BRICK_VOXELS)).collect();
        Self { slots, maps }
    }

    /// The slot of a brick.
    pub fn slot(&self, brick: [i32; 3]) -> Option<usize> {
        self.slots.get(&brick).map(|&slot| slot as usize)
    }

    /// The index of a voxel, to be multiplied by a map's channels; `None` outside the bricks.
    pub fn index(&self, voxel: [i32; 3]) -> Option<usize> {
        self.slot(brick_of(voxel)).map(|slot| slot * BRICK_VOXELS + local_index(voxel))
    }

    /// The map of that name.
    pub fn map(&self, name: &str) -> Option<&Map> {
        self.maps.iter().find(|map| map.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_holds_exactly_its_voxels() {
        let set = VoxelSet::from_box([-3, 5, 7], [12, 1, 20]);
        let other: VoxelSet = (7..27).flat_map(|z| (-3..9).map(move |x| [x, 5, z])).collect();
        assert_eq!(set, other);
        assert_eq!(set.len(), 240);
        assert!(set.voxels().all(|v| set.contains(v)));
    }

    #[test]
    fn sets_meet_and_differ_voxel_by_voxel() {
        let a = VoxelSet::from_box([-3, 0, 2], [13, 9, 5]);
        let b = VoxelSet::from_box([4, -6, 4], [9, 11, 9]);
        let (both, rest) = (a.intersection(&b), a.difference(&b));
        assert!(both.len() + rest.len() == a.len() && !both.is_empty() && !rest.is_empty());
        assert!(a.voxels().all(|v| both.contains(v) == b.contains(v) && rest.contains(v) != b.contains(v)));
        for brick in a.bricks() {
            let mask = a.mask(brick).unwrap();
            assert!(indices(mask).all(|at| a.contains(voxel_at(brick, at))));
            assert_eq!(
                indices(mask).count(),
                mask.iter().map(|word| word.count_ones() as usize).sum::<usize>()
            );
        }
    }
}
