//! Volumes of known virtues and vices.

use super::*;
use crate::data::{Map, Samples};

const N: usize = 32;

/// A homogeneous isotropic medium without end: bytes of a hash, smoothed and stretched to three colours.
fn medium([x, y, z]: [i32; 3], seed: u64) -> [u8; 3] {
    let mut sum = 0;
    for k in 0..27 {
        let at = [x + k % 3, y + k / 3 % 3, z + k / 9].map(|c| c as u64);
        sum += Random(seed).below(256, at) as i32;
    }
    // Mean 27 · 127.5, standard deviation √27 · 74.
    let level = ((sum - 3442) / 9 + 128).clamp(0, 255);
    [level as u8, (level / 2 + 40) as u8, (255 - level) as u8]
}

fn volume(voxel: impl Fn([i32; 3]) -> [u8; 3]) -> Volume {
    let n = N as i32;
    let places = (0..n * n * n).map(|i| [i % n, i / n % n, i / n / n]);
    let samples = Samples::U8(places.flat_map(voxel).collect());
    let maps = vec![Map { name: "color".into(), channels: 3, samples }];
    Volume { size: [N; 3], origin: [0; 3], spacing: [1.0; 3], maps }
}

fn exemplar() -> Image {
    Image::from_fn(48, 48, |x, y| medium([x as i32, y as i32, 500], 77))
}

fn quality(voxel: impl Fn([i32; 3]) -> [u8; 3]) -> Quality {
    measure_quality(&volume(voxel), &exemplar(), &QualitySettings::default(), &()).unwrap()
}

#[test]
fn the_same_medium_elsewhere_is_as_good_as_the_exemplar() {
    let q = quality(|v| medium(v, 5));
    assert!(q.color_kl < 0.05, "{q:?}");
    assert!((0.85..1.3).contains(&q.coverage), "{q:?}");
    assert!((q.contrast - 1.0).abs() < 0.08 && (q.fine_contrast - 1.0).abs() < 0.08, "{q:?}");
    assert!(q.distances.iter().all(|d| (d - 1.0).abs() < 0.06), "{q:?}");
    assert!(q.completeness.iter().all(|d| (0.85..1.05).contains(d)), "{q:?}");
    assert!((0.9..1.15).contains(&q.oblique_distance), "{q:?}");
}

#[test]
fn an_extruded_exemplar_is_seen_across_the_other_axes() {
    let image = exemplar();
    let q = quality(|[x, y, _]| image.rgb8(x as u32, y as u32));
    assert!(q.distances[2] < 0.9 && q.completeness[2] < 0.95, "{q:?}");
    assert!(q.completeness[0] > 1.1 && q.completeness[1] > 1.1, "{q:?}");
}

#[test]
fn shuffled_pixels_have_the_colours_and_nothing_else() {
    let image = exemplar();
    let q = quality(|v| {
        let at = |c| Random(3).below(48, [v[0] as u64 + 64 * v[1] as u64, v[2] as u64, c]) as u32;
        image.rgb8(at(0), at(1))
    });
    assert!(q.color_kl < 0.02 && (q.contrast - 1.0).abs() < 0.05, "{q:?}");
    assert!(q.axis_distance > 1.25 && q.oblique_distance > 1.25 && q.fine_contrast > 1.3, "{q:?}");
}

#[test]
fn a_blurred_volume_lacks_contrast_fine_detail_first() {
    let q = quality(|[x, y, z]| {
        let near: Vec<_> = (0..27).map(|k| medium([x + k % 3, y + k / 3 % 3, z + k / 9], 5)).collect();
        std::array::from_fn(|c| (near.iter().map(|rgb| u32::from(rgb[c])).sum::<u32>() / 27) as u8)
    });
    assert!(q.contrast < 0.8 && q.fine_contrast < q.contrast && q.color_kl > 0.1, "{q:?}");
}

#[test]
fn a_flat_volume_covers_nothing() {
    let q = quality(|_| medium([10, 10, 500], 77));
    assert!(q.color_kl > 1.0 && q.coverage < 0.05 && q.contrast < 0.05 && q.fine_contrast < 0.05, "{q:?}");
}

#[test]
fn partial_collapse_and_repetition_lack_coverage() {
    let flat = quality(|[x, y, z]| medium(if x < 16 { [x, y, z] } else { [10, 10, 500] }, 77));
    assert!(flat.coverage < 0.75, "{flat:?}");
    let image = exemplar();
    let repeated = quality(|[x, y, z]| image.rgb8((x % 8) as u32, ((y + z) % 8) as u32));
    assert!(repeated.coverage < 0.9 && repeated.axis_completeness > 1.15, "{repeated:?}");
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let small = Image::from_fn(15, 40, |_, _| [0u8; 3]);
    let settings = QualitySettings::default();
    let flat = volume(|_| [1, 2, 3]);
    assert_eq!(measure_quality(&flat, &small, &settings, &()), Err(MeasureError::Exemplar(15, 40)));
    let thin = Volume { size: [64, 64, 8 - 1], ..flat.clone() };
    assert_eq!(measure_quality(&thin, &exemplar(), &settings, &()), Err(MeasureError::Volume(64, 64, 7)));
    let bare = Volume { maps: Vec::new(), ..flat.clone() };
    assert_eq!(measure_quality(&bare, &exemplar(), &settings, &()), Err(MeasureError::NoColor));
    // A flat exemplar divides by nothing.
    let q = measure_quality(&flat, &Image::from_fn(20, 20, |_, _| [1u8, 2, 3]), &settings, &()).unwrap();
    assert!((q.contrast, q.fine_contrast, q.axis_distance, q.coverage) == (1.0, 1.0, 1.0, 1.0), "{q:?}");
}

#[test]
fn each_fault_of_structure_is_seen_by_the_measure_made_for_it() {
    let image = exemplar();
    let good = quality(|v| medium(v, 5)).structure;
    assert!(good.autocorrelation < 2.0 && good.repetition < 0.3, "{good:?}");
    assert!(good.orientation_kl < 0.05 && good.flat < 2.0, "{good:?}");
    // Tiles of 6³ voxels.
    let tiled = quality(|v| medium(v.map(|c| c % 6), 5)).structure;
    assert!(tiled.repetition > 0.8 && tiled.autocorrelation > 2.0 * good.autocorrelation, "{tiled:?}");
    // Bands along x + y + z.
    let banded = quality(|[x, y, z]| image.rgb8(((x + y + z) % 48) as u32, 7)).structure;
    assert!(banded.repetition > 0.5 && banded.orientation_kl > 0.5, "{banded:?}");
    // Three quarters of one colour.
    let collapsed = quality(|v| if v[0] < 24 { [128, 104, 127] } else { medium(v, 5) }).structure;
    assert!(collapsed.flat > 3.0 * good.flat, "{collapsed:?}");
    let shuffled = quality(|v| {
        let at = |c| Random(3).below(48, [v[0] as u64 + 64 * v[1] as u64, v[2] as u64, c]) as u32;
        image.rgb8(at(0), at(1))
    });
    assert!(shuffled.structure.autocorrelation > 1.3 * good.autocorrelation, "{:?}", shuffled.structure);
}
