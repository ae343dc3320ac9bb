//! Against closed forms.

use super::*;
use crate::data::{Image, Map, Report, Samples, Volume};
use crate::measure::random::Random;

const ALL: Neighbours = Neighbours::All;
const FACES: Neighbours = Neighbours::Faces;

/// Distance from the middle of a box of 32³.
fn radius([x, y, z]: [usize; 3]) -> f64 {
    let [x, y, z] = [x, y, z].map(|c| c as f64 - 16.0);
    (x * x + y * y + z * z).sqrt()
}

#[test]
fn euler_numbers_of_solids_are_known() {
    let both = |phase: &dyn Fn([usize; 3]) -> bool| {
        let grid = Grid::from_fn([32; 3], phase);
        [ALL, FACES].map(|neighbours| euler_number(&grid, neighbours))
    };
    let ball = |v: [usize; 3]| radius(v) < 10.0;
    let torus = |[x, y, z]: [usize; 3]| {
        let ring = radius([x, y, 16]) - 9.0;
        let z = z as f64 - 16.0;
        ring * ring + z * z < 12.0
    };
    assert_eq!(both(&ball), [1, 1]);
    assert_eq!(both(&torus), [0, 0]);
    assert_eq!(both(&|v| (6.0..11.0).contains(&radius(v))), [2, 2]);
    // Two voxels that share a corner are one object or two.
    assert_eq!(both(&|v| v == [4, 4, 4] || v == [5, 5, 5]), [1, 2]);
    assert_eq!(both(&|v| v == [4, 4, 4] || v == [5, 5, 4]), [1, 2]);
    assert_eq!(both(&|_| false), [0, 0]);
}

#[test]
fn euler_numbers_of_pictures_are_known() {
    let both = |phase: &dyn Fn(usize, usize) -> bool| {
        let grid = Grid::from_fn([32, 32, 1], |[x, y, _]| phase(x, y));
        [ALL, FACES].map(|neighbours| euler_number(&grid, neighbours))
    };
    assert_eq!(both(&|x, y| (4..9).contains(&x) && (4..9).contains(&y)), [1, 1]);
    assert_eq!(both(&|x, y| (4..9).contains(&x) && (4..9).contains(&y) && (x, y) != (6, 6)), [0, 0]);
    assert_eq!(both(&|x, y| (x, y) == (4, 4) || (x, y) == (5, 5)), [1, 2]);
    // A ring of four pixels that touch at corners has a hole for eight neighbours alone.
    assert_eq!(both(&|x, y| matches!((x, y), (5, 4) | (4, 5) | (6, 5) | (5, 6))), [0, 4]);
}

#[test]
fn lines_of_a_small_pattern_are_counted() {
    let row = [true, true, false, true, true, true, false, true];
    let grid = Grid::from_fn([8, 1, 1], |[x, ..]| row[x]);
    assert_eq!(two_point(&grid, 0, 2), [6.0 / 8.0, 3.0 / 7.0, 3.0 / 6.0]);
    let chords = Chords::of(&grid);
    // Runs of 2, 3 and 1.
    assert_eq!(chords.lineal_path(3), [6.0 / 8.0, 3.0 / 7.0, 1.0 / 6.0, 0.0]);
    assert_eq!(chords.mean(), 3.0);
    assert_eq!(chords.surface(), 2.0 * 4.0 / 7.0);
}

#[test]
fn components_join_through_faces() {
    let grid = Grid::from_fn([4, 4, 4], |[x, y, z]| (x, y) == (0, 0) || (x, y, z) == (1, 1, 0));
    assert_eq!(connectivity(&grid), 0.8);
    assert_eq!(connectivity(&Grid::from_fn([4, 4, 1], |_| false)), 0.0);
    assert_eq!(connectivity(&Grid::from_fn([4, 1, 4], |_| true)), 1.0);
}

/// Overlapping balls: centres are a Poisson process, in cells of 8³ with voxels of 1.
fn boolean_model(n: usize, radius: f64, per_voxel: f64, seed: u64) -> Grid {
    let random = Random(seed);
    let wide = n + 2 * radius as usize + 2;
    let count = (per_voxel * (wide * wide * wide) as f64).round() as u64;
    let mut data = vec![false; n * n * n];
    for i in 0..count {
        let center = [0, 1, 2].map(|c| random.fraction([1, i, c]) * wide as f64 - radius - 1.0);
        let range = center.map(|c| {
            let from = (c - radius).max(0.0) as usize;
            from..((c + radius + 1.0).max(0.0) as usize).min(n)
        });
        let [xs, ys, zs] = range;
        for (z, y) in zs.flat_map(|z| ys.clone().map(move |y| (z, y))) {
            for x in xs.clone() {
                let squares = [x, y, z].into_iter().zip(center).map(|(v, c)| (v as f64 - c) * (v as f64 - c));
                data[(z * n + y) * n + x] |= squares.sum::<f64>() < radius * radius;
            }
        }
    }
    Grid { size: [n; 3], data }
}

#[test]
fn overlapping_balls_have_their_closed_forms() {
    let (n, radius, density) = (96, 6.0, 0.0008);
    let balls = boolean_model(n, radius, density, 5);
    let void = Grid { size: balls.size, data: balls.data.iter().map(|p| !p).collect() };
    let pi = std::f64::consts::PI;
    let ball = 4.0 / 3.0 * pi * radius * radius * radius;
    let fraction = (-density * ball).exp();
    let chords = Chords::of(&void);
    let near = |found: f64, expected: f64, share: f64| {
        assert!((found - expected).abs() < share * expected, "{found} {expected}");
    };
    let two = two_point(&void, 0, 20);
    let path = chords.lineal_path(20);
    for r in 0..=20 {
        let s = (r as f64 / radius).min(2.0);
        let union = ball * (1.0 + 0.75 * s - s * s * s / 16.0);
        near(two[r], (-density * union).exp(), 0.06);
        near(path[r], fraction * (-density * pi * radius * radius * r as f64).exp(), 0.12);
    }
    near(chords.surface(), density * 4.0 * pi * radius * radius * fraction, 0.06);
    // The mean chord of the void is the reciprocal of centres seen per length.
    near(chords.mean(), 1.0 / (density * pi * radius * radius), 0.12);
}

#[test]
fn a_telegraph_has_the_exponential_correlation_of_a_debye_medium() {
    // A change with probability 0.1 at each step: S₂(r) − φ² = φ (1 − φ) exp(−r / a), a = −1 / ln 0.8.
    let (w, h) = (4096, 48);
    let mut data = Vec::new();
    for y in 0..h {
        let mut phase = Random(1).fraction([2, y, 0]) < 0.5;
        for x in 0..w {
            phase ^= Random(1).fraction([3, y, x]) < 0.1;
            data.push(phase);
        }
    }
    let found = two_point(&Grid { size: [w as usize, h as usize, 1], data }, 0, 12);
    for (r, value) in found.iter().enumerate() {
        let expected = 0.25 + 0.25 * libm::pow(0.8, r as f64);
        assert!((value - expected).abs() < 0.015, "{r}: {value} {expected}");
    }
}

fn labelled(grid: &Grid) -> Volume {
    let samples = Samples::U32(grid.data.iter().map(|&p| u32::from(p)).collect());
    let maps = vec![Map { name: "label".into(), channels: 1, samples }];
    Volume { size: grid.size, origin: [0; 3], spacing: [1.0; 3], maps }
}

fn mask(grid: &Grid, z: usize) -> Image {
    Image::from_fn(grid.size[0] as u32, grid.size[1] as u32, |x, y| {
        [if grid.get([x as usize, y as usize, z]) { 255u8 } else { 0 }]
    })
}

fn measured(solid: &Grid, exemplar: &Image, truth: &Grid) -> Report {
    let settings = PhaseSettings::default();
    compare_phases(&labelled(solid), exemplar, Some(&labelled(truth)), &settings, &()).unwrap().0
}

fn flags(report: &Report) -> Vec<&str> {
    report.rows.iter().filter(|row| row.flagged()).map(|row| row.name.as_str()).collect()
}

#[test]
fn a_true_medium_is_flagged_by_none_and_each_fault_by_its_own() {
    let model = |seed| boolean_model(48, 4.0, 0.0015, seed);
    let truth = model(1);
    let exemplar = mask(&truth, 20);
    for seed in 1..5 {
        let report = measured(&model(seed), &exemplar, &truth);
        assert_eq!(flags(&report), [""; 0], "{report:#?}");
    }
    let flagged = |solid: &Grid, names: &[&str]| {
        let report = measured(solid, &exemplar, &truth);
        let flags = flags(&report);
        assert!(names.iter().all(|name| flags.contains(name)), "{flags:?} {report:#?}");
    };
    let other = model(2);
    let inverted = Grid { size: other.size, data: other.data.iter().map(|p| !p).collect() };
    flagged(&inverted, &["slice_fraction", "solid_fraction"]);
    // Noise of single voxels.
    let noisy = other.data.iter().enumerate().map(|(i, &p)| p ^ (Random(2).below(40, [i as u64, 0, 0]) == 0));
    let noisy = Grid { size: other.size, data: noisy.collect() };
    flagged(&noisy, &["slice_chord", "solid_surface", "solid_euler_26", "solid_chord"]);
    // The exemplar pulled along z.
    let pulled = Grid::from_fn([48; 3], |[x, y, _]| truth.get([x, y, 20]));
    flagged(&pulled, &["solid_two_point", "solid_lineal_path"]);
    // Smaller and more balls of the same fraction.
    flagged(
        &boolean_model(48, 2.0, 0.012, 3),
        &["slice_surface", "slice_chord", "solid_surface", "solid_euler_6"],
    );
}

#[test]
fn phases_are_read_from_labels_two_values_and_colours() {
    let grid = boolean_model(32, 4.0, 0.0015, 1);
    let exemplar = mask(&grid, 9);
    let report = |map: Map| {
        let volume = Volume { maps: vec![map], ..labelled(&grid) };
        compare_phases(&volume, &exemplar, None, &PhaseSettings::default(), &()).unwrap().0
    };
    let samples = |f: &dyn Fn(bool) -> Vec<u8>| Samples::U8(grid.data.iter().flat_map(|&p| f(p)).collect());
    let expected = report(labelled(&grid).maps[0].clone());
    let two = report(Map { name: "value".into(), channels: 1, samples: samples(&|p| vec![u8::from(p)]) });
    let colors = samples(&|p| if p { vec![220, 210, 190] } else { vec![40, 50, 30] });
    assert_eq!(two, expected);
    assert_eq!(report(Map { name: "color".into(), channels: 3, samples: colors }), expected);
}

#[test]
fn what_has_no_two_phases_is_refused() {
    let grid = boolean_model(32, 4.0, 0.0015, 1);
    let (good, exemplar) = (labelled(&grid), mask(&grid, 9));
    let refused = |volume: &Volume, exemplar: &Image, truth: Option<&Volume>| {
        compare_phases(volume, exemplar, truth, &PhaseSettings::default(), &()).unwrap_err()
    };
    let grey = Image::from_fn(32, 32, |_, _| [90u8]);
    assert!(matches!(refused(&good, &grey, None), PhaseError::OnePhase("the exemplar", _)));
    assert_eq!(refused(&good, &Image::from_fn(8, 32, |x, _| [x as u8]), None), PhaseError::Exemplar(8, 32));
    let empty = labelled(&Grid::from_fn([32; 3], |_| false));
    assert!(matches!(refused(&good, &exemplar, Some(&empty)), PhaseError::OnePhase("the truth", _)));
    let larger = labelled(&boolean_model(40, 4.0, 0.0015, 1));
    let error = refused(&good, &exemplar, Some(&larger));
    assert_eq!(error, PhaseError::Size { found: [40; 3], expected: [32; 3] });
    let mut other = good.clone();
    other.maps[0].name = "height".into();
    assert_eq!(refused(&other, &exemplar, None), PhaseError::NoMap("the volume", "`height`".into()));
    let nan = Map { name: "value".into(), channels: 1, samples: Samples::F32(vec![f32::NAN; 32 * 32 * 32]) };
    let nan = Volume { maps: vec![nan], ..good.clone() };
    assert_eq!(refused(&nan, &exemplar, None), PhaseError::NotFinite("the volume"));
    let thin = labelled(&Grid::from_fn([32, 32, 8], |[x, ..]| x > 9));
    assert_eq!(refused(&thin, &exemplar, None), PhaseError::Volume(32, 32, 8));
}
