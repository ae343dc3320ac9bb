//! The stages before a synthesis, each with the results of those before it.

use divan::Bencher;

use crate::material::{self, Stages};
use crate::sizes;

/// Pixels along a side of the exemplar.
fn sides() -> Vec<u32> {
    sizes(&[64, 128], 16)
}

#[divan::bench(args = sides(), sample_count = 5)]
fn pyramid(bencher: Bencher, side: u32) {
    let exemplar = material::exemplar(side);
    bencher.bench(|| material::pyramid(&exemplar));
}

#[divan::bench(args = sides(), sample_count = 5, sample_size = 1)]
fn descriptors(bencher: Bencher, side: u32) {
    let pyramid = material::pyramid(&material::exemplar(side));
    bencher.bench(|| material::descriptors(&pyramid));
}

#[divan::bench(args = sides(), sample_count = 5, sample_size = 1)]
fn similarity(bencher: Bencher, side: u32) {
    let pyramid = material::pyramid(&material::exemplar(side));
    let descriptors = material::descriptors(&pyramid);
    bencher.bench(|| material::similarity(&pyramid, &descriptors));
}

#[divan::bench(args = sides(), sample_count = 5, sample_size = 1)]
fn candidates(bencher: Bencher, side: u32) {
    let pyramid = material::pyramid(&material::exemplar(side));
    bencher.bench(|| material::candidates(&pyramid));
}

#[divan::bench(args = sides(), sample_count = 5)]
fn slab(bencher: Bencher, side: u32) {
    let pyramid = material::pyramid(&material::exemplar(side));
    let candidates = material::candidates(&pyramid);
    bencher.bench(|| material::initial(&pyramid, &candidates));
}

#[divan::bench(args = sides(), sample_count = 5, sample_size = 1)]
fn usage(bencher: Bencher, side: u32) {
    let stages = Stages::new(side);
    bencher.bench(|| stages.usage(side.min(64)));
}

/// Everything from the picture to the tables.
#[divan::bench(args = sides(), sample_count = 3, sample_size = 1)]
fn whole(bencher: Bencher, side: u32) {
    bencher.bench(|| {
        let stages = Stages::new(side);
        stages.tables(Some(&stages.usage(side.min(64))))
    });
}
