//! The tables of a synthesis on the device.

use breccia_shaders::{Buffer, Gpu, GpuError};
use bytemuck::{Pod, Zeroable};

use crate::lazy::basis::DIMS;
use crate::lazy::candidates::SET;
use crate::lazy::color::OneColor;
use crate::lazy::domain::Domain;
use crate::lazy::initial::Initial;
use crate::lazy::jitter::falling;
use crate::lazy::kernel::{Weights, crossbar_factor};
use crate::lazy::tables::{LevelTables, Tables, ViewTables};

/// What stays on the device while a solid is in use.
pub(in crate::lazy) struct DeviceTables {
    /// For each level, finest first, its tables, and where those of each view begin.
    pub(super) levels: Vec<(Buffer, Vec<[u32; 3]>)>,
    /// The slab's triples, as in a state.
    pub(super) slab: Buffer,
    /// The falling exponential of the jitter.
    pub(super) falling: Vec<u32>,
}

/// `View` of `kernels/modules/level.wgsl`.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct View {
    size: [i32; 4],
    base: [u32; 4],
    bias: [i32; DIMS],
    weights: [[u32; DIMS]; 25],
}

/// `Level` of `kernels/modules/level.wgsl`.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Level {
    views: [View; 3],
    middle: [i32; 4],
    costs: [u32; 4],
    color: [u32; 4],
    period: [i32; 4],
}

/// A period for the device: behind it 0 if there is none, 1 if it is of whole bricks, else 2.
pub(super) fn period(domain: &Domain) -> [i32; 4] {
    let kind = if domain.aligned() { 1 } else { 2 };
    domain.period.map_or([0; 4], |[x, y, z]| [x, y, z, kind])
}

/// Two words of a state from three pixels, the first shown.
pub(super) fn packed(pixels: [u16; 3]) -> [u32; 2] {
    [u32::from(pixels[0]) | u32::from(pixels[1]) << 16, u32::from(pixels[2])]
}

impl DeviceTables {
    pub fn new(gpu: &Gpu, tables: &Tables, initial: &Initial) -> Result<Self, GpuError> {
        let level = |level: &LevelTables| {
            let (words, bases) = level_words(level);
            Ok((gpu.upload(&words)?, bases))
        };
        let coarsest = tables.levels.last();
        let slab: Vec<[u32; 2]> = initial
            .slab
            .iter()
            .map(|triple| {
                // A slab may come from another exemplar than the tables.
                let within = |e: usize| match coarsest {
                    Some(level) => level.view(e).view.shifted(triple[e], 0, 0),
                    None => triple[e],
                };
                packed([within(0), within(1), within(2)])
            })
            .collect();
        Ok(Self {
            levels: tables.levels.iter().map(level).collect::<Result<_, _>>()?,
            slab: gpu.upload(&slab)?,
            falling: falling(),
        })
    }
}

/// The records, triples and strips of a level's views, and where they begin.
fn level_words(level: &LevelTables) -> (Vec<[u32; 4]>, Vec<[u32; 3]>) {
    let mut words = Vec::new();
    let mut bases = Vec::new();
    for tables in &level.views {
        let records = words.len() as u32;
        words.extend((0..tables.records.len()).flat_map(|i| record_words(level, tables, i)));
        let triples = words.len() as u32;
        for i in 0..tables.records.len() {
            words.extend((0..SET / 2).map(|k| {
                let [a, b] = tables.triples[k][i];
                let pair = |next: u16, last: u16| u32::from(next) | u32::from(last) << 16;
                [pair(a.next, a.last), a.crossbar, pair(b.next, b.last), b.crossbar]
            }));
        }
        let strips = words.len() as u32;
        for (i, texel) in tables.view.texels.iter().enumerate() {
            let row: [u32; 8] = bytemuck::pod_read_unaligned(&tables.rows[i]);
            let column: [u32; 8] = bytemuck::pod_read_unaligned(&tables.columns[i]);
            words.push([row[0], row[1], row[2], row[3]]);
            words.push([row[4], column[0], column[1], column[2]]);
            words.push([column[3], column[4], u32::from_le_bytes(*texel), 0]);
        }
        bases.push([records, triples, strips]);
    }
    (words, bases)
}

fn record_words(level: &LevelTables, tables: &ViewTables, i: usize) -> [[u32; 4]; 2] {
    let record = &tables.records[i];
    let mut descriptor = record.descriptor;
    if level.narrow {
        descriptor.rotate_left(DIMS / 2);
    }
    let barred = tables.view.barred.get(i).copied().unwrap_or(false);
    let norm: u32 = descriptor.iter().map(|&d| u32::from(d) * u32::from(d)).sum();
    let [a, b, c, d] = record.similar.map(u32::from);
    [
        bytemuck::cast(descriptor),
        [record.usage as u32, norm << 1 | u32::from(barred), a | b << 16, c | d << 16],
    ]
}

impl Level {
    pub fn new(
        level: &LevelTables,
        bases: &[[u32; 3]],
        weights: Weights,
        color: OneColor,
        domain: &Domain,
    ) -> Self {
        let view = |e: usize| {
            let ViewTables { view, basis, .. } = level.view(e);
            let [records, triples, strips] = bases[if bases.len() == 1 { 0 } else { e }];
            // Colours are given from −128 on; 128 times the sum of a component's weights makes up for it.
            let bias = std::array::from_fn(|d| {
                let sum: i32 = basis.weights.iter().flat_map(|w| w[d]).map(i32::from).sum();
                basis.bias[d] + 128 * sum
            });
            View {
                size: [view.width, view.height, view.tileable.into(), view.margin()],
                base: [records, triples, strips, basis.shift],
                bias,
                weights: basis.weights.map(|pixel| pixel.map(|w| u32::from_le_bytes(w.map(|w| w as u8)))),
            }
        };
        let middle = level.middle.map(i32::from);
        Self {
            views: [view(0), view(1), view(2)],
            middle,
            costs: [
                weights.similar as u32,
                weights.triples as u32,
                weights.incoherent as u32,
                crossbar_factor(level, weights),
            ],
            color: [color.stretch as u32, color.takes_one().into(), if level.narrow { 2 } else { 4 }, 0],
            period: period(domain),
        }
    }
}
