//! The exact nearest vectors of a table without comparing all: a k-d tree (Bentley 1975) of leaves that are compared whole, those
//! whose bounds lie nearest first (Friedman, Bentley & Finkel 1977), until none can hold a nearer one.

use super::nearest::PatchTable;
use crate::lazy::Isa;

/// Vectors in a leaf, whole blocks of a table.
const LEAF: usize = 64;
/// Leaves whose bounds lie side by side.
const LANES: usize = 8;

/// Vectors in leaves.
pub(super) struct Tree {
    dims: usize,
    /// The vectors, leaf by leaf.
    table: PatchTable,
    /// For each of them its number.
    numbers: Vec<u32>,
    /// For each number its place in the table.
    places: Vec<u32>,
    /// The least and the greatest coefficients of leaves, `[eight leaves][coefficient][leaf]`.
    bounds: Vec<[[i16; LANES]; 2]>,
}

/// What a search of a tree needs, kept from one to the next.
#[derive(Default)]
pub(super) struct Room {
    distances: Vec<u32>,
    leaves: Vec<(u32, u32)>,
}

impl Tree {
    /// A tree of vectors of `dims` coefficients.
    pub fn new(vectors: &[&[i16]], dims: usize) -> Self {
        let mut numbers: Vec<u32> = (0..vectors.len() as u32).collect();
        split(&mut numbers, vectors, dims);
        let mut places = vec![0; numbers.len()];
        numbers.iter().enumerate().for_each(|(place, &number)| places[number as usize] = place as u32);
        let sorted: Vec<&[i16]> = numbers.iter().map(|&number| vectors[number as usize]).collect();
        let leaves = sorted.len().div_ceil(LEAF);
        // Leaves that are not there are as far away as can be.
        let mut bounds = vec![[[i16::MAX; LANES]; 2]; leaves.div_ceil(LANES) * dims];
        for (leaf, vectors) in sorted.chunks(LEAF).enumerate() {
            for d in 0..dims {
                let [low, high] = &mut bounds[leaf / LANES * dims + d];
                low[leaf % LANES] = vectors.iter().map(|vector| vector[d]).min().unwrap_or(0);
                high[leaf % LANES] = vectors.iter().map(|vector| vector[d]).max().unwrap_or(0);
            }
        }
        Self { dims, table: PatchTable::new(sorted.into_iter(), dims), numbers, places, bounds }
    }

    /// The `count` vectors nearest to that of a number, with their squared distances, smallest first, ties to the first number.
    pub fn nearest(
        &self,
        number: usize,
        query: &[i16],
        count: usize,
        isa: Isa,
        room: &mut Room,
        out: &mut Vec<(u32, u32)>,
    ) {
        out.clear();
        let own = self.places[number] as usize / LEAF;
        let mut worst = self.compare(own, query, count, u32::MAX, isa, room, out);
        room.leaves.clear();
        let leaves = self.numbers.len().div_ceil(LEAF);
        for (block, bounds) in self.bounds.chunks_exact(self.dims).enumerate() {
            let mut gaps = [0u32; LANES];
            for ([low, high], &q) in bounds.iter().zip(query) {
                for lane in 0..LANES {
                    let (low, high) = (i32::from(low[lane]), i32::from(high[lane]));
                    let gap = (low - i32::from(q)).max(i32::from(q) - high).max(0);
                    gaps[lane] = gaps[lane].saturating_add((gap * gap) as u32);
                }
            }
            for (lane, gap) in gaps.into_iter().enumerate() {
                let leaf = block * LANES + lane;
                if gap <= worst && leaf != own && leaf < leaves {
                    room.leaves.push((gap, leaf as u32));
                }
            }
        }
        room.leaves.sort_unstable();
        for i in 0..room.leaves.len() {
            let (gap, leaf) = room.leaves[i];
            if gap > worst {
                break;
            }
            worst = self.compare(leaf as usize, query, count, worst, isa, room, out);
        }
        out.sort_unstable();
        out.truncate(count);
    }

    /// Takes what a leaf has that is no farther than `worst`, and gives the greatest distance that still matters.
    #[expect(clippy::too_many_arguments, reason = "a step of `nearest`, whose state it is")]
    fn compare(
        &self,
        leaf: usize,
        query: &[i16],
        count: usize,
        worst: u32,
        isa: Isa,
        room: &mut Room,
        out: &mut Vec<(u32, u32)>,
    ) -> u32 {
        let numbers = &self.numbers[leaf * LEAF..];
        let numbers = &numbers[..numbers.len().min(LEAF)];
        self.table.distances_within(leaf * LEAF / 8, LEAF / 8, query, &mut room.distances, isa);
        for (&distance, &number) in room.distances.iter().zip(numbers) {
            if distance <= worst {
                out.push((distance, number));
            }
        }
        if out.len() < count {
            return worst;
        }
        out.select_nth_unstable(count - 1);
        out.truncate(count);
        out[count - 1].0
    }
}

/// Orders numbers so that each [`LEAF`] of them are a leaf: again and again halves along the coefficient that varies most.
fn split(numbers: &mut [u32], vectors: &[&[i16]], dims: usize) {
    if numbers.len() <= LEAF {
        return;
    }
    let spread = |d: usize| {
        let values = numbers.iter().map(|&number| i32::from(vectors[number as usize][d]));
        let (low, high) = values.fold((i32::MAX, i32::MIN), |(low, high), v| (low.min(v), high.max(v)));
        (high - low, std::cmp::Reverse(d))
    };
    let d = (0..dims).max_by_key(|&d| spread(d)).unwrap_or(0);
    let middle = numbers.len().div_ceil(LEAF).div_ceil(2) * LEAF;
    numbers.select_nth_unstable_by_key(middle, |&number| (vectors[number as usize][d], number));
    let (left, right) = numbers.split_at_mut(middle);
    rayon::join(|| split(left, vectors, dims), || split(right, vectors, dims));
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::lazy::available_instruction_sets;

    proptest! {
        #[test]
        fn a_tree_finds_what_comparing_with_all_finds(
            values in prop::collection::vec(-9i16..9, 8..8 * 400), count in 1usize..20, scale in 1i16..400
        ) {
            let values: Vec<i16> = values.iter().map(|v| v * scale).collect();
            let vectors: Vec<&[i16]> = values.chunks_exact(8).collect();
            let tree = Tree::new(&vectors, 8);
            let (mut room, mut found) = (Room::default(), Vec::new());
            for isa in available_instruction_sets() {
                for (number, query) in vectors.iter().enumerate().step_by(7) {
                    tree.nearest(number, query, count, isa, &mut room, &mut found);
                    let gap = |v: &[i16]| {
                        v.iter().zip(*query).map(|(a, b)| (i32::from(*a) - i32::from(*b)).pow(2) as u32).sum()
                    };
                    let mut all: Vec<(u32, u32)> =
                        vectors.iter().enumerate().map(|(i, v)| (gap(v), i as u32)).collect();
                    all.sort_unstable();
                    all.truncate(count);
                    prop_assert_eq!(&found, &all);
                }
            }
        }
    }
}
