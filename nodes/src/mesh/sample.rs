//! Samples of a solid at any points of voxel space, block after block, so that memory stays bounded and
//! only the voxels that the points need are ever asked for.

use std::ops::Range;

use rayon::prelude::*;

use crate::control::{Cancelled, Control, check};
use crate::data::{BRICK_VOXELS, Map, MapInfo, SampleType, Samples, Solid, SolidError, VoxelMap, VoxelSet};

/// How samples between voxel centres are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// Weighted mean of the eight nearest voxels. Bytes are averaged as they are stored; maps named
    /// `normal` keep unit length.
    Trilinear,
    /// The voxel that holds the point.
    Nearest,
}

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
    /// The solid's answer lacks what was asked for.
    #[error("the solid's answer lacks map `{0}` or some of its voxels")]
    Incomplete(String),
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

/// A point: the voxel at the low corner of its filter's support, and its position in that.
#[derive(Clone, Copy)]
struct Point {
    base: [i32; 3],
    fraction: [f32; 3],
}

/// Samples `solid` at the `count` points `at(0)`, `at(1)`, … given in voxel coordinates.
///
/// Voxels are asked for in cubes of `block` voxels a side (a power of two, at least 8); the result does
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
        let points: Vec<Point> = order.keys[range.clone()]
            .par_iter()
            .map(|&key| {
                support(at(order.point(key)), filter).unwrap_or(Point { base: [0; 3], fraction: [0.0; 3] })
            })
            .collect();
        let answer = solid.evaluate(&needed(&points, filter), control)?;
        check(control)?;
        for map in &mut sampled.maps {
            let source = answer.map(&map.name).filter(|source| source.info() == map.info());
            let incomplete = || SampleError::Incomplete(map.name.clone());
            let source = source.ok_or_else(incomplete)?;
            if !fill(map, &range, &points, &answer, source, filter) {
                return Err(SampleError::Incomplete(map.name.clone()));
            }
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
        let block_shift = block.clamp(8, 1 << 16).next_power_of_two().trailing_zeros();
        let mut bases = Vec::new();
        bases.resize(count, [0i32; 3]);
        bases.par_chunks_mut(CHUNK).enumerate().try_for_each(|(chunk, bases)| {
            check(control)?;
            for (offset, base) in bases.iter_mut().enumerate() {
                let i = chunk * CHUNK + offset;
                *base = support(at(i), filter).ok_or(SampleError::OutOfRange(i))?.base;
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

/// The voxel at the low corner of the filter's support and the weights' fractions.
fn support(coordinates: [f64; 3], filter: Filter) -> Option<Point> {
    let mut point = Point { base: [0; 3], fraction: [0.0; 3] };
    for i in 0..3 {
        let c = if filter == Filter::Trilinear { coordinates[i] - 0.5 } else { coordinates[i] };
        let floor = c.floor();
        // A margin of one brick keeps the neighbours' numbers in range, too.
        if !(floor > f64::from(i32::MIN) + 16.0 && floor < f64::from(i32::MAX) - 16.0) {
            return None;
        }
        point.base[i] = floor as i32;
        point.fraction[i] = (c - floor) as f32;
    }
    Some(point)
}

/// The voxels that the points need.
fn needed(points: &[Point], filter: Filter) -> VoxelSet {
    let sets: Vec<VoxelSet> = points.par_chunks(CHUNK).map(|points| needed_by(points, filter)).collect();
    let mut sets = sets.into_iter();
    let mut all = sets.next().unwrap_or_default();
    sets.for_each(|set| all.union(&set));
    all
}

fn needed_by(points: &[Point], filter: Filter) -> VoxelSet {
    let mut set = VoxelSet::new();
    let reach = if filter == Filter::Trilinear { 0b11u16 } else { 0b1 };
    let more = usize::from(filter == Filter::Trilinear);
    for run in points.chunk_by(|a, b| brick(a) == brick(b)) {
        // Rows of nine bits over nine by nine rows: the brick and one layer of its upper neighbours.
        let mut rows = [[0u16; 9]; 9];
        for point in run {
            let [x, y, z] = point.base.map(|c| (c & 7) as usize);
            for row in &mut rows[z..=z + more] {
                row[y..=y + more].iter_mut().for_each(|bits| *bits |= reach << x);
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

fn brick(point: &Point) -> [i32; 3] {
    point.base.map(|c| c >> 3)
}

/// The entries of a point's voxels in the answer, with their weights.
struct Corners<'a> {
    answer: &'a VoxelMap,
    filter: Filter,
    brick: Option<[i32; 3]>,
    slots: [Option<usize>; 8],
}

impl<'a> Corners<'a> {
    fn new(answer: &'a VoxelMap, filter: Filter) -> Self {
        Self { answer, filter, brick: None, slots: [None; 8] }
    }

    /// Entry and weight of each voxel, weights last; `None` if the answer lacks a voxel.
    fn of(&mut self, point: &Point) -> Option<([usize; 8], [f32; 8])> {
        let brick = brick(point);
        if self.brick != Some(brick) {
            self.brick = Some(brick);
            self.slots = std::array::from_fn(|octant| {
                let step = [octant & 1, octant >> 1 & 1, octant >> 2];
                self.answer.slot(std::array::from_fn(|i| brick[i] + step[i] as i32))
            });
        }
        let local = point.base.map(|c| (c & 7) as usize);
        let (mut entries, mut weights) = ([0; 8], [0.0; 8]);
        let corners = if self.filter == Filter::Trilinear { 8 } else { 1 };
        for corner in 0..corners {
            let step = [corner & 1, corner >> 1 & 1, corner >> 2];
            let [x, y, z]: [usize; 3] = std::array::from_fn(|i| local[i] + step[i]);
            let slot = self.slots[x >> 3 | (y >> 3) << 1 | (z >> 3) << 2]?;
            entries[corner] = slot * BRICK_VOXELS + (x & 7 | (y & 7) << 3 | (z & 7) << 6);
            let [wx, wy, wz]: [f32; 3] =
                std::array::from_fn(
                    |i| {
                        if step[i] == 1 { point.fraction[i] } else { 1.0 - point.fraction[i] }
                    },
                );
            weights[corner] = if corners == 1 { 1.0 } else { wx * wy * wz };
        }
        Some((entries, weights))
    }
}

/// Fills a map's entries of `range`; false if the answer lacks a voxel.
fn fill(
    map: &mut Map,
    range: &Range<usize>,
    points: &[Point],
    answer: &VoxelMap,
    source: &Map,
    filter: Filter,
) -> bool {
    let channels = map.channels;
    let unit = map.name == "normal" && channels >= 3;
    let span = range.start * channels..range.end * channels;
    match (&mut map.samples, &source.samples) {
        (Samples::U8(out), Samples::U8(source)) => {
            let Some(out) = out.get_mut(span) else { return false };
            fill_as(
                out,
                channels,
                points,
                answer,
                source,
                filter,
                unit,
                f32::from,
                |v| (v + 0.5).clamp(0.0, 255.0) as u8,
                255.0,
            )
        }
        (Samples::F32(out), Samples::F32(source)) => {
            let Some(out) = out.get_mut(span) else { return false };
            fill_as(out, channels, points, answer, source, filter, unit, |v| v, |v| v, 1.0)
        }
        _ => false,
    }
}

#[expect(clippy::too_many_arguments, reason = "one loop serves both sample types")]
fn fill_as<T: Copy + Send + Sync>(
    out: &mut [T],
    channels: usize,
    points: &[Point],
    answer: &VoxelMap,
    source: &[T],
    filter: Filter,
    unit: bool,
    read: impl Fn(T) -> f32 + Sync,
    write: impl Fn(f32) -> T + Sync,
    full: f32,
) -> bool {
    let chunks = out.par_chunks_mut(CHUNK * channels).zip(points.par_chunks(CHUNK));
    chunks
        .map(|(out, points)| {
            let mut corners = Corners::new(answer, filter);
            for (out, point) in out.chunks_exact_mut(channels).zip(points) {
                let Some((entries, weights)) = corners.of(point) else { return false };
                if filter == Filter::Nearest {
                    let from = entries[0] * channels;
                    let Some(voxel) = source.get(from..from + channels) else { return false };
                    out.copy_from_slice(voxel);
                    continue;
                }
                let mut sums = [0.0f32; 4];
                for (entry, weight) in entries.iter().zip(weights) {
                    let from = entry * channels;
                    let Some(voxel) = source.get(from..from + channels) else { return false };
                    sums.iter_mut().zip(voxel).for_each(|(sum, &v)| *sum += weight * read(v));
                }
                if unit {
                    renormalize(&mut sums, full);
                }
                out.iter_mut().zip(sums).for_each(|(out, sum)| *out = write(sum));
            }
            true
        })
        .reduce(|| true, |a, b| a && b)
}

/// Gives a normal stored as (n + 1) / 2 · full unit length again.
fn renormalize(stored: &mut [f32; 4], full: f32) {
    let n: [f32; 3] = std::array::from_fn(|i| stored[i] / full * 2.0 - 1.0);
    let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
    if length > 1e-6 {
        (0..3).for_each(|i| stored[i] = (n[i] / length * 0.5 + 0.5) * full);
    }
}
