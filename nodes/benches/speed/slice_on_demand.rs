//! Slices of an unbounded solid: the first, and the next ones, which share bricks with it.

use breccia_nodes::data::Image;
use breccia_nodes::lazy::LazySolid;
use breccia_nodes::solid::{Filter, Plane, slice};
use divan::Bencher;

use crate::material::Material;
use crate::sizes;

const FLAT: [f64; 3] = [0.0, 0.0, 1.0];
const OBLIQUE: [f64; 3] = [1.0, 1.0, 1.0];

/// Pixels along a side of the slice.
fn sides() -> Vec<u32> {
    sizes(&[256], 16)
}

/// The solid, from an exemplar half as large as the slice.
fn solid(side: u32) -> LazySolid {
    Material::of_side((side / 2).clamp(16, 64)).solid(None)
}

/// The slice `depth` voxels along the normal, somewhere far from the origin.
fn cut(solid: &LazySolid, side: u32, normal: [f64; 3], depth: f64) -> Image {
    let length = normal.iter().map(|c| c * c).sum::<f64>().sqrt();
    let center = normal.map(|c| 10_000.5 + depth * c / length);
    let plane = Plane::new(center, normal, 0.0, 1.0).expect("a plane");
    slice(solid, &plane, [side; 2], Filter::Nearest, "color", &()).expect("a slice")
}

/// Nothing is known beforehand.
#[divan::bench(args = sides(), sample_count = 5, sample_size = 1)]
fn cold_flat(bencher: Bencher, side: u32) {
    let inputs = || solid(side);
    bencher.with_inputs(inputs).bench_refs(|solid| cut(solid, side, FLAT, 0.0));
}

/// Nothing is known beforehand.
#[divan::bench(args = sides(), sample_count = 5, sample_size = 1)]
fn cold_oblique(bencher: Bencher, side: u32) {
    let inputs = || solid(side);
    bencher.with_inputs(inputs).bench_refs(|solid| cut(solid, side, OBLIQUE, 0.0));
}

/// The slice one voxel before is known.
#[divan::bench(args = sides(), sample_count = 5, sample_size = 1)]
fn next_flat(bencher: Bencher, side: u32) {
    bencher.with_inputs(|| known(side, FLAT)).bench_refs(|solid| cut(solid, side, FLAT, 1.0));
}

/// The slice one voxel before is known.
#[divan::bench(args = sides(), sample_count = 5, sample_size = 1)]
fn next_oblique(bencher: Bencher, side: u32) {
    bencher.with_inputs(|| known(side, OBLIQUE)).bench_refs(|solid| cut(solid, side, OBLIQUE, 1.0));
}

/// The same slice is known.
#[divan::bench(args = sides(), sample_count = 5, sample_size = 1)]
fn again_oblique(bencher: Bencher, side: u32) {
    bencher.with_inputs(|| known(side, OBLIQUE)).bench_refs(|solid| cut(solid, side, OBLIQUE, 0.0));
}

fn known(side: u32, normal: [f64; 3]) -> LazySolid {
    let solid = solid(side);
    cut(&solid, side, normal, 0.0);
    solid
}
