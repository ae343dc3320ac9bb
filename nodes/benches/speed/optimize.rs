//! Texture optimisation: what an iteration of search and solve costs, how that grows with the box, and what is
//! precomputed of an exemplar.

use breccia_nodes::exemplar::{MakeSettings, make_exemplar};
use breccia_nodes::lazy::{LevelView, Pyramid};
use breccia_nodes::optimize::{
    Field, Method, SearchSettings, SolveSettings, Solver, WeightSettings, search, solve, start,
};
use breccia_nodes::search::{Keep, Patches, SimilarSets, Window, patch_basis, patches, similar_sets};
use divan::Bencher;

use crate::material::cells;
use crate::sizes;

/// An exemplar's neighbourhoods.
struct Known {
    views: Vec<LevelView>,
    patches: Patches,
    sets: SimilarSets,
}

fn pyramid(side: u32) -> Pyramid {
    let settings = MakeSettings { max_size: 256, ..MakeSettings::default() };
    let exemplar = make_exemplar(&cells(side), None, None, &[], &settings).expect("a usable picture");
    Pyramid::new(&exemplar, 1).expect("a usable exemplar")
}

fn known(side: u32, window: i32) -> Known {
    let pyramid = pyramid(side);
    let (patches, sets) = precomputed(&pyramid, window);
    Known { views: pyramid.levels[0].clone(), patches, sets }
}

fn precomputed(pyramid: &Pyramid, window: i32) -> (Patches, SimilarSets) {
    let keep = Keep { dims: 16, variance: 1.0 };
    let basis = patch_basis(pyramid, 0, Window { size: window }, keep, &()).expect("the window fits");
    let patches = patches(pyramid, &basis, &()).expect("nobody cancels");
    let sets = similar_sets(&patches, 5, 1, &()).expect("nobody cancels");
    (patches, sets)
}

fn iteration(known: &Known, field: &Field, sweep: u32) -> Field {
    let settings = SearchSettings {
        method: Method::Coherent,
        reach: 1,
        index: 8.0,
        directions: [true; 3],
        seed: 1,
        sweep,
    };
    let matches =
        search(field, &known.patches, Some(&known.sets), None, &settings, &()).expect("nobody cancels");
    let weights = WeightSettings { position: 300.0, smoothing: 0, color: 5000.0 };
    let settings = SolveSettings { solver: Solver::Discrete, gamma: 0.3, weights, seed: 1, sweep };
    solve(&matches, &known.views, Some(field), None, &settings, &()).expect("nobody cancels")
}

/// One iteration at the finest level of the fast schedule, 4 × 4 neighbourhoods of a 128² exemplar.
#[divan::bench(args = sizes(&[32, 64, 128], 16), max_time = 30)]
fn optimize_iteration(bencher: Bencher<'_, '_>, size: u32) {
    let known = known(if size < 32 { 32 } else { 128 }, 4);
    let first = start([size as usize; 3], 0, &known.views, 1);
    // Coherent pieces, as later iterations find them.
    let field = iteration(&known, &first, 0);
    bencher.bench(|| iteration(&known, &field, 1));
}

/// The same with the slow schedule's 6 × 6 neighbourhoods.
#[divan::bench(args = sizes(&[64], 16), max_time = 20)]
fn optimize_iteration_wide(bencher: Bencher<'_, '_>, size: u32) {
    let known = known(if size < 32 { 32 } else { 128 }, 6);
    let field = iteration(&known, &start([size as usize; 3], 0, &known.views, 1), 0);
    bencher.bench(|| iteration(&known, &field, 1));
}

/// Basis, coefficients and similarity sets of the finest level.
#[divan::bench(args = sizes(&[64, 128, 256], 32), max_time = 20)]
fn optimize_precompute(bencher: Bencher<'_, '_>, side: u32) {
    let pyramid = pyramid(side);
    bencher.bench(|| precomputed(&pyramid, 8));
}
