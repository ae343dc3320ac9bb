//! Samples of a solid at any points of voxel space, block after block, so that memory stays bounded and
//! only the voxels that the points need are ever asked for.

use std::ops::Range;

use rayon::prelude::*;

use crate::control::{Cancelled, Control, check};
pub use crate::data::Filter;
use crate::data::{Map, MapInfo, SampleType, Solid, SolidError, Tap};
use crate::solid::sample;

/// Why points could not be sampled.
#[derive(Clone, Debug, thiserror::Error)]
pub enum SampleError {
    /// The solid gave no answer.
    #[error(transparent)]
    Solid(#[from] SolidError),
    /// The points are too many, or spread too far, for the sort that orders them.
    #[error(
        "{points} points spread over {blocks} blocks of {block} voxels a side are too many; lower the resolution"
    )]
    TooLarge {
        /// How many points.
        points: usize,
        /// How many blocks their bounding box spans.
        blocks: u64,
        /// Voxels along a block's edge.
        block: u32,
    },
    /// A coordinate is not a number, or far outside.
    #[error("point {0} has no voxel: its coordinates are not finite or beyond ±2³¹")]
    OutOfRange(usize),
}

impl From<Cancelled> for SampleError {
    fn from(cancelled: Cancelled) -> Self {
        Self::Solid(cancelled.into())
    }
}

/// Samples at points.
pub struct Sampled {
    /// Where each point's samples lie in the maps.
    pub rank: Vec<u32>,
    /// The solid's maps without its labels, one entry (of `channels` samples) a point, ordered by `rank`.
    pub maps: Vec<Map>,
}

/// The maps that can be sampled between voxels: labels and maps of over four channels are not.
pub fn filterable(maps: Vec<MapInfo>) -> Vec<MapInfo> {
    maps.into_iter().filter(|map| map.ty != SampleType::U32 && (1..=4).contains(&map.channels)).collect()
}

/// Points handed to a thread at once.
const CHUNK: usize = 8192;

/// Samples `solid` at the `count` points `at(0)`, `at(1)`, … given in voxel coordinates.
///
/// Voxels are asked for in cubes of `block` voxels a side (a power of two from 8 to 1024); the result does
/// not depend on it.
///
/// # Errors
/// See [`SampleError`].
pub fn sample_solid(
    solid: &dyn Solid,
    count: usize,
    at: &(dyn Fn(usize) -> [f64; 3] + Sync),
    filter: Filter,
    block: u32,
    control: &dyn Control,
) -> Result<Sampled, SampleError> {
    let infos = filterable(solid.maps());
    let mut sampled = Sampled { rank: Vec::new(), maps: Vec::new() };
    sampled.maps = infos.iter().map(|info| Map::zeros(info, count)).collect();
    let order = Order::new(count, at, filter, block, control)?;
    sampled.rank = vec![0; count];
    for (place, &key) in order.keys.iter().enumerate() {
        sampled.rank[order.point(key)] = place as u32;
    }
    for range in order.blocks() {
        check(control)?;
        let taps: Vec<Tap> = order.keys[range.clone()]
            .par_iter()
            .map(|&key| Tap::new(at(order.point(key)), filter).unwrap_or_default())
            .collect();
        let found = sample(solid, &infos, &taps, control)?;
        for (to, found) in sampled.maps.iter_mut().zip(&found) {
            let n = to.channels;
            to.samples.copy_from(range.start * n, &found.samples, 0, range.len() * n);
        }
        control.progress(range.end as f32 / count as f32);
    }
    Ok(sampled)
}

/// The points sorted by block, by brick, and by number: keys hold all three.
struct Order {
    keys: Vec<u64>,
    point_bits: u32,
    brick_bits: u32,
}

impl Order {
    fn new(
        count: usize,
        at: &(dyn Fn(usize) -> [f64; 3] + Sync),
        filter: Filter,
        block: u32,
        control: &dyn Control,
    ) -> Result<Self, SampleError> {
        let block_shift = block.clamp(8, 1 << 10).next_power_of_two().trailing_zeros();
        let mut bases = Vec::new();
        bases.resize(count, [0i32; 3]);
        bases.par_chunks_mut(CHUNK).enumerate().try_for_each(|(chunk, bases)| {
            check(control)?;
            for (offset, base) in bases.iter_mut().enumerate() {
                let i = chunk * CHUNK + offset;
                *base = Tap::new(at(i), filter).ok_or(SampleError::OutOfRange(i))?.base;
            }
            Ok::<(), SampleError>(())
        })?;
        let extremes = |pick: fn(i32, i32) -> i32, start: i32| {
            bases.iter().fold([start; 3], |a, b| std::array::from_fn(|i| pick(a[i], b[i])))
        };
        let first = extremes(i32::min, i32::MAX).map(|c| c >> block_shift);
        let last = extremes(i32::max, i32::MIN).map(|c| c >> block_shift);
        let spans: [u64; 3] =
            std::array::from_fn(|i| (i64::from(last[i]) - i64::from(first[i]) + 1).max(1) as u64);
        let blocks = spans.iter().fold(1u64, |a, &b| a.saturating_mul(b));
        let bits = |n: u64| u64::BITS - n.saturating_sub(1).leading_zeros();
        let (point_bits, brick_bits) = (bits(count as u64), 3 * (block_shift - 3));
        if count > u32::MAX as usize || point_bits + brick_bits + bits(blocks).max(1) > u64::BITS {
            return Err(SampleError::TooLarge { points: count, blocks, block: 1 << block_shift });
        }
        let mut keys: Vec<u64> = bases
            .par_iter()
            .enumerate()
            .map(|(i, &base)| {
                let [x, y, z]: [u64; 3] =
                    std::array::from_fn(|i| (i64::from(base[i] >> block_shift) - i64::from(first[i])) as u64);
                let block = (z * spans[1] + y) * spans[0] + x;
                let side = block_shift - 3;
                let [x, y, z] = base.map(|c| (c >> 3) as u64 & ((1 << side) - 1));
                let brick = (z << side | y) << side | x;
                (block << brick_bits | brick).checked_shl(point_bits).unwrap_or(0) | i as u64
            })
            .collect();
        drop(bases);
        keys.par_sort_unstable();
        check(control)?;
        Ok(Self { keys, point_bits, brick_bits })
    }

    fn point(&self, key: u64) -> usize {
        (key & ((1 << self.point_bits) - 1)) as usize
    }

    /// The places of each block's points.
    fn blocks(&self) -> Vec<Range<usize>> {
        let shift = self.point_bits + self.brick_bits;
        let same = |a: &u64, b: &u64| a >> shift == b >> shift;
        let ends = self.keys.chunk_by(same).scan(0, |end, block| {
            let start = *end;
            *end += block.len();
            Some(start..*end)
        });
        ends.collect()
    }
}
