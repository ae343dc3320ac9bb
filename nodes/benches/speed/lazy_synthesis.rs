//! Whole cubes, for each instruction set that this machine has.

use std::fmt;

use breccia_nodes::data::{Solid, VoxelSet};
use breccia_nodes::lazy::{Isa, available_instruction_sets};
use divan::Bencher;
use divan::counter::ItemsCount;

use crate::material::Material;
use crate::sizes;

struct Case {
    isa: Isa,
    size: u32,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}³ {:?}", self.size, self.isa)
    }
}

/// Every instruction set at the smaller size, at the larger one those that people would wait for.
fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (i, size) in sizes(&[64, 128], 16).into_iter().enumerate() {
        let sets = available_instruction_sets().into_iter().filter(|&isa| i == 0 || isa != Isa::Portable);
        cases.extend(sets.map(|isa| Case { isa, size }));
    }
    cases
}

/// A periodic cube from an exemplar of as many pixels a side; items are voxels.
#[divan::bench(args = cases(), sample_count = 5, sample_size = 1)]
fn cube(bencher: Bencher, case: &Case) {
    let material = Material::of_side(case.size);
    let all = VoxelSet::from_box([0; 3], [case.size; 3]);
    bencher
        .counter(ItemsCount::new(all.len()))
        .with_inputs(|| material.solid(Some([case.size; 3])).with_isa(case.isa))
        .bench_refs(|solid| solid.evaluate(&all, &()).expect("voxels"));
}
