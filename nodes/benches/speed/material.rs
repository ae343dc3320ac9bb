//! The material that is synthesised: a picture of cells, made here, and everything precomputed from it.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use breccia_engine::Digest;
use breccia_nodes::data::Image;
use breccia_nodes::exemplar::{Exemplar, MakeSettings, make_exemplar};
use breccia_nodes::lazy::{
    CandidateSettings, Candidates, Descriptors, Initial, Jitter, LazySolid, Pyramid, Settings, Similarity,
    Tables, Usage, UsageSettings, balance_usage, make_candidates, make_descriptors, make_slab,
    similarity_sets,
};

/// The defaults of the nodes `lazy.descriptors` and `lazy.similarity`.
const DIMS: [i64; 2] = [8, 16];
const SPREAD: i32 = 3;

/// Cells in dark gaps, as cobbles or a tissue: `side` pixels a side, one cell for about 12 × 12 pixels.
pub fn cells(side: u32) -> Image {
    let pitch = 12;
    let n = side.div_ceil(pitch) as i32;
    // One point a square of the grid, moved at random.
    let point = |i: i32, j: i32| {
        let hash = hash((i.rem_euclid(n) * n + j.rem_euclid(n)) as u32);
        let moved =
            |cell: i32, bits: u32| (f64::from(cell) + f64::from(bits & 255) / 256.0) * f64::from(pitch);
        (moved(i, hash), moved(j, hash >> 8), hash >> 16)
    };
    Image::from_fn(side, side, |x, y| {
        let (px, py) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
        let (ci, cj) = ((x / pitch) as i32, (y / pitch) as i32);
        // The two nearest points: their distances are equal at the border of a cell.
        let (mut first, mut second, mut tone) = (f64::MAX, f64::MAX, 0);
        for i in ci - 2..=ci + 2 {
            for j in cj - 2..=cj + 2 {
                let (qx, qy, hash) = point(i, j);
                let distance = ((px - qx).powi(2) + (py - qy).powi(2)).sqrt();
                if distance < first {
                    (second, first, tone) = (first, distance, hash);
                } else {
                    second = second.min(distance);
                }
            }
        }
        let inside = ((second - first) / 4.0).min(1.0);
        let grain = f64::from(hash(x * 65_536 + y) & 31);
        let base = [110.0, 100.0, 90.0].map(|c| c + f64::from(tone & 63) + grain);
        base.map(|c| (20.0 + (c - 20.0) * inside) as u8)
    })
}

fn hash(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// What the stages before a synthesis make, with the defaults of the nodes.
pub struct Stages {
    pub exemplar: Exemplar,
    pub pyramid: Pyramid,
    pub descriptors: Descriptors,
    pub similarity: Similarity,
    pub candidates: Candidates,
    pub initial: Initial,
}

impl Stages {
    /// All stages but the usage weights, for an exemplar of `side` pixels a side.
    pub fn new(side: u32) -> Self {
        let exemplar = exemplar(side);
        let pyramid = pyramid(&exemplar);
        let descriptors = descriptors(&pyramid);
        let similarity = similarity(&pyramid, &descriptors);
        let candidates = candidates(&pyramid);
        let initial = initial(&pyramid, &candidates);
        Self { exemplar, pyramid, descriptors, similarity, candidates, initial }
    }

    /// The tables of a correction.
    pub fn tables(&self, usage: Option<&Usage>) -> Tables {
        let Self { exemplar, pyramid, descriptors, similarity, candidates, .. } = self;
        Tables::new(exemplar, pyramid, descriptors, similarity, candidates, usage)
            .expect("stages of one exemplar")
    }

    /// The usage weights; test volumes have `size` voxels along an edge.
    pub fn usage(&self, size: u32) -> Usage {
        let usage = UsageSettings { size, ..UsageSettings::default() };
        balance_usage(&self.pyramid, self.tables(None), &self.initial, &Settings::default(), &usage, &())
            .expect("nobody cancels")
    }
}

pub fn exemplar(side: u32) -> Exemplar {
    make_exemplar(&cells(side), None, None, &[], &MakeSettings::default()).expect("a usable picture")
}

pub fn pyramid(exemplar: &Exemplar) -> Pyramid {
    Pyramid::new(exemplar, 0).expect("a usable exemplar")
}

pub fn descriptors(pyramid: &Pyramid) -> Descriptors {
    make_descriptors(pyramid, &DIMS)
}

pub fn similarity(pyramid: &Pyramid, descriptors: &Descriptors) -> Similarity {
    similarity_sets(pyramid, descriptors, SPREAD, &()).expect("nobody cancels")
}

pub fn candidates(pyramid: &Pyramid) -> Candidates {
    make_candidates(pyramid, &CandidateSettings::default(), &()).expect("nobody cancels")
}

pub fn initial(pyramid: &Pyramid, candidates: &Candidates) -> Initial {
    let jitter = Jitter { amount: 0.2, sigma_min: 0.3, sigma_max: 1.2, density: 3.0 };
    Initial { jitter: Some(jitter), ..make_slab(pyramid, candidates) }
}

/// A material that is ready to be synthesised.
#[derive(Clone)]
pub struct Material {
    tables: Arc<Tables>,
    initial: Initial,
}

impl Material {
    /// The material of an exemplar of `side` pixels a side; precomputed once in a process.
    pub fn of_side(side: u32) -> Self {
        static MADE: Mutex<BTreeMap<u32, Material>> = Mutex::new(BTreeMap::new());
        let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
        let make = || {
            let stages = Stages::new(side);
            let usage = stages.usage(side.min(64));
            Self { tables: Arc::new(stages.tables(Some(&usage))), initial: stages.initial }
        };
        made.entry(side).or_insert_with(make).clone()
    }

    /// A solid that has computed nothing yet.
    pub fn solid(&self, period: Option<[u32; 3]>) -> LazySolid {
        let settings = Settings { period, ..Settings::default() };
        LazySolid::new(Arc::clone(&self.tables), self.initial.clone(), settings, Digest([0; 32]))
    }
}
