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
    #[error("the solid's answer lacks map `{0}`, or holds it in another form than declared")]
    Incomplete(String),
    /// The solid's answer lacks voxels.
    #[error("the solid's answer lacks some of the voxels it was asked for")]
    MissingVoxels,
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
/// Points whose corners are held at once.
const PART: usize = 1 << 18;

/// A point: the voxel at the low corner of its filter's support, and its position in that.
#[derive(Clone, Copy)]
struct Point {
    base: [i32; 3],
    fraction: [f32; 3],
}

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
        let points: Vec<Point> = order.keys[range.clone()]
            .par_iter()
            .map(|&key| {
                support(at(order.point(key)), filter).unwrap_or(Point { base: [0; 3], fraction: [0.0; 3] })
            })
            .collect();
        let answer = solid.evaluate(&needed(&points, filter), control)?;
        check(control)?;
        for from in (0..points.len()).step_by(PART) {
            let part = &points[from..points.len().min(from + PART)];
            let corners = locate(part, &answer, filter).ok_or(SampleError::MissingVoxels)?;
            for map in &mut sampled.maps {
                let source = answer.map(&map.name).filter(|source| source.info() == map.info());
                if !source.is_some_and(|source| fill(map, range.start + from, &corners, source, filter)) {
                    return Err(SampleError::Incomplete(map.name.clone()));
                }
            }
            check(control)?;
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
    for (i, c) in coordinates.into_iter().enumerate() {
        let c = if filter == Filter::Trilinear { c - 0.5 } else { c };
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

/// The entries of a point's voxels in the answer, and their weights; only the first for [`Filter::Nearest`].
#[derive(Clone, Copy, Default)]
struct Corners {
    entries: [u32; 8],
    weights: [f32; 8],
}

/// The corners of all points, or `None` if the answer lacks a voxel.
fn locate(points: &[Point], answer: &VoxelMap, filter: Filter) -> Option<Vec<Corners>> {
    let mut corners = vec![Corners::default(); points.len()];
    let chunks = corners.par_chunks_mut(CHUNK).zip(points.par_chunks(CHUNK));
    let complete = chunks.map(|(corners, points)| {
        let mut at = 0;
        for run in points.chunk_by(|a, b| brick(a) == brick(b)) {
            let Some(first) = run.first() else { continue };
            let slots: [Option<usize>; 8] = std::array::from_fn(|octant| {
                let ([x, y, z], octant) = (brick(first), octant as i32);
                answer.slot([x + (octant & 1), y + (octant >> 1 & 1), z + (octant >> 2)])
            });
            for point in run {
                let Some(found) = corners_of(point, &slots, filter) else { return false };
                corners[at] = found;
                at += 1;
            }
        }
        true
    });
    complete.reduce(|| true, |a, b| a && b).then_some(corners)
}

/// A point's corners, given the slots of its brick and of its seven upper neighbours.
fn corners_of(point: &Point, slots: &[Option<usize>; 8], filter: Filter) -> Option<Corners> {
    let local = point.base.map(|c| (c & 7) as usize);
    let mut found = Corners::default();
    let count = if filter == Filter::Trilinear { 8 } else { 1 };
    for corner in 0..count {
        let step = [corner & 1, corner >> 1 & 1, corner >> 2];
        let [x, y, z]: [usize; 3] = std::array::from_fn(|i| local[i] + step[i]);
        let slot = slots[x >> 3 | (y >> 3) << 1 | (z >> 3) << 2]?;
        let entry = slot * BRICK_VOXELS + (x & 7 | (y & 7) << 3 | (z & 7) << 6);
        found.entries[corner] = u32::try_from(entry).ok()?;
        let [wx, wy, wz]: [f32; 3] =
            std::array::from_fn(|i| if step[i] == 1 { point.fraction[i] } else { 1.0 - point.fraction[i] });
        found.weights[corner] = wx * wy * wz;
    }
    Some(found)
}

/// Fills a map's entries from `first` on; false if the source is too short or of another type.
fn fill(map: &mut Map, first: usize, corners: &[Corners], source: &Map, filter: Filter) -> bool {
    let channels = map.channels;
    let unit = map.name == "normal" && channels >= 3;
    let span = first * channels..(first + corners.len()) * channels;
    match (&mut map.samples, &source.samples) {
        (Samples::U8(out), Samples::U8(source)) => out.get_mut(span).is_some_and(|out| {
            let write = |v: f32| (v + 0.5).clamp(0.0, 255.0) as u8;
            fill_as(out, channels, corners, source, filter, f32::from, |sums| {
                if unit { renormalize(sums, 255.0).map(write) } else { sums.map(write) }
            })
        }),
        (Samples::F32(out), Samples::F32(source)) => out.get_mut(span).is_some_and(|out| {
            fill_as(
                out,
                channels,
                corners,
                source,
                filter,
                |v| v,
                |sums| {
                    if unit { renormalize(sums, 1.0) } else { sums }
                },
            )
        }),
        _ => false,
    }
}

fn fill_as<T: Copy + Send + Sync>(
    out: &mut [T],
    channels: usize,
    corners: &[Corners],
    source: &[T],
    filter: Filter,
    read: impl Fn(T) -> f32 + Sync,
    write: impl Fn([f32; 4]) -> [T; 4] + Sync,
) -> bool {
    let chunks = out.par_chunks_mut(CHUNK * channels).zip(corners.par_chunks(CHUNK));
    let complete = chunks.map(|(out, corners)| {
        for (out, Corners { entries, weights }) in out.chunks_exact_mut(channels).zip(corners) {
            let voxel = |entry: u32| source.get(entry as usize * channels..(entry as usize + 1) * channels);
            if filter == Filter::Nearest {
                let Some(voxel) = voxel(entries[0]) else { return false };
                out.copy_from_slice(voxel);
                continue;
            }
            let mut sums = [0.0f32; 4];
            for (&entry, weight) in entries.iter().zip(weights) {
                let Some(voxel) = voxel(entry) else { return false };
                sums.iter_mut().zip(voxel).for_each(|(sum, &v)| *sum += weight * read(v));
            }
            out.iter_mut().zip(write(sums)).for_each(|(out, v)| *out = v);
        }
        true
    });
    complete.reduce(|| true, |a, b| a && b)
}

/// Gives a normal stored as (n + 1) / 2 · full unit length again.
fn renormalize(mut stored: [f32; 4], full: f32) -> [f32; 4] {
    let n: [f32; 3] = std::array::from_fn(|i| stored[i] / full * 2.0 - 1.0);
    let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
    if length > 1e-6 {
        (0..3).for_each(|i| stored[i] = (n[i] / length * 0.5 + 0.5) * full);
    }
    stored
}
