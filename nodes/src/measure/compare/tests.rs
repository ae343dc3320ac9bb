//! Volumes of known virtues and vices.

use super::*;
use crate::data::{Map, Report};
use crate::measure::quality_report;

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

/// Overlapping bright balls in a dark matrix, with some noise: a random medium with edges.
fn balls(v: [i32; 3], seed: u64) -> [u8; 3] {
    let random = Random(seed);
    let cell = v.map(|c| c.div_euclid(6));
    let inside = (0..27).any(|k| {
        let c = [cell[0] + k % 3 - 1, cell[1] + k / 3 % 3 - 1, cell[2] + k / 9 - 1];
        let center: [i32; 3] = std::array::from_fn(|i| {
            let key = [c[0] as u64, (c[1] as u64) << 32 | u64::from(c[2] as u32), 5 + i as u64];
            60 * c[i] + random.below(60, key) as i32
        });
        (0..3).map(|i| (10 * v[i] + 5 - center[i]).pow(2)).sum::<i32>() < 33 * 33
    });
    let noise = random.below(24, v.map(|c| c as u64)) as u8;
    if inside { [200 + noise, 180 + noise, 120 + noise] } else { [50 + noise, 40 + noise, 60 + noise] }
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

fn report(voxel: impl Fn([i32; 3]) -> [u8; 3], exemplar: &Image) -> Report {
    quality_report(&measure_quality(&volume(voxel), exemplar, &QualitySettings::default(), &()).unwrap())
}

/// The names of the measures that flag a volume.
fn flags(report: &Report) -> Vec<&str> {
    report.rows.iter().filter(|row| row.flagged()).map(|row| row.name.as_str()).collect()
}

fn flags_all(report: &Report, names: &[&str]) {
    let flags = flags(report);
    assert!(names.iter().all(|name| flags.contains(name)), "{flags:?}\n{report:#?}");
}

#[test]
fn a_true_medium_against_its_own_slice_is_flagged_by_none() {
    // Elsewhere, around the slice itself, and other realisations.
    for (seed, z) in [(77, 0), (77, 484), (5, 0), (6, 0)] {
        let report = report(|v| medium([v[0], v[1], v[2] + z], seed), &exemplar());
        assert_eq!(flags(&report), [""; 0], "{report:#?}");
    }
    for seed in 10..14 {
        let image = Image::from_fn(64, 64, |x, y| balls([x as i32, y as i32, 500], seed));
        let report = report(|v| balls(v, seed), &image);
        assert_eq!(flags(&report), [""; 0], "{report:#?}");
    }
}

#[test]
fn what_is_a_fraction_of_the_exemplars_own_is_about_one() {
    let q =
        measure_quality(&volume(|v| medium(v, 5)), &exemplar(), &QualitySettings::default(), &()).unwrap();
    let near = |value: f64, tolerance: f64| assert!((value - 1.0).abs() < tolerance, "{value} {q:#?}");
    for likeness in [q.axis, q.oblique] {
        near(likeness.contrast, 0.08);
        near(likeness.distance, 0.1);
        near(likeness.completeness, 0.1);
        near(likeness.coverage, 0.2);
        near(likeness.source_entropy, 0.35);
        near(likeness.autocorrelation, 0.4);
        near(likeness.wasserstein, 0.4);
        near(likeness.flat, 0.2);
    }
    q.distances.into_iter().chain(q.completeness).for_each(|ratio| near(ratio, 0.06));
}

#[test]
fn an_extruded_exemplar_is_a_copy_across_one_axis_and_stripes_across_the_others() {
    let image = exemplar();
    let report = report(|[x, y, _]| image.rgb8(x as u32, y as u32), &image);
    flags_all(&report, &["axis_copy", "axis_repetition", "axis_orientation_kl", "oblique_orientation_kl"]);
    let get = |name| report.get(name).unwrap();
    assert!(get("axis_copy") == 8.0 && get("distance_z") < 0.9 && get("completeness_x") > 1.1, "{report:#?}");
}

#[test]
fn shuffled_pixels_have_the_colours_and_nothing_else() {
    let image = exemplar();
    let shuffled = |v: [i32; 3]| {
        let at = |c| Random(3).below(48, [v[0] as u64 + 64 * v[1] as u64, v[2] as u64, c]) as u32;
        image.rgb8(at(0), at(1))
    };
    let report = report(shuffled, &image);
    let structure = ["distance", "completeness", "sharpness", "fine_contrast"];
    let names = structure.iter().flat_map(|name| [format!("axis_{name}"), format!("oblique_{name}")]);
    flags_all(&report, &names.collect::<Vec<_>>().iter().map(String::as_str).collect::<Vec<_>>());
    flags_all(&report, &["axis_wasserstein", "oblique_autocorrelation"]);
    assert!(
        !flags(&report)
            .iter()
            .any(|name| name.ends_with("color_kl") || name.ends_with("_contrast") && !name.contains("fine"))
    );
}

#[test]
fn a_blurred_volume_lacks_sharpness_fine_detail_and_contrast() {
    let blurred = |[x, y, z]: [i32; 3]| {
        let near: Vec<_> = (0..27).map(|k| medium([x + k % 3, y + k / 3 % 3, z + k / 9], 5)).collect();
        std::array::from_fn(|c| (near.iter().map(|rgb| u32::from(rgb[c])).sum::<u32>() / 27) as u8)
    };
    let report = report(blurred, &exemplar());
    flags_all(&report, &["axis_sharpness", "axis_fine_contrast", "axis_contrast", "axis_wasserstein"]);
    assert!(report.get("axis_sharpness") < Some(0.75));
}

#[test]
fn tiles_repeat() {
    for edge in [6, 8] {
        let report = report(|v| medium(v.map(|c| c % edge), 5), &exemplar());
        flags_all(&report, &["axis_repetition", "axis_autocorrelation"]);
        assert!(report.get("axis_repetition") > Some(0.9));
    }
}

#[test]
fn bands_along_a_diagonal_repeat_and_are_directed() {
    let image = exemplar();
    let report = report(|[x, y, z]| image.rgb8(((x + y + z) % 48) as u32, 7), &image);
    flags_all(&report, &["axis_repetition", "axis_orientation_kl", "oblique_orientation_kl"]);
}

#[test]
fn a_volume_that_collapsed_is_flat_and_covers_little() {
    let collapsed = |v: [i32; 3]| if v[0] < 24 { [128, 104, 127] } else { medium(v, 5) };
    let report = report(collapsed, &exemplar());
    let names = ["flat", "coverage", "source_entropy"];
    let names = names.iter().flat_map(|name| [format!("axis_{name}"), format!("oblique_{name}")]);
    flags_all(&report, &names.collect::<Vec<_>>().iter().map(String::as_str).collect::<Vec<_>>());
}

#[test]
fn other_colours_are_another_histogram() {
    let recoloured = |v: [i32; 3]| medium(v, 5).map(|c| c - c / 4);
    flags_all(&report(recoloured, &exemplar()), &["axis_color_kl", "oblique_color_kl"]);
}

#[test]
fn a_directed_medium_needs_an_exemplar_for_each_axis() {
    // Grains four times as long along z.
    let fibres = |[x, y, z]: [i32; 3]| medium([x, y, z.div_euclid(4)], 9);
    let at = |x: u32, y: u32| [x as i32, y as i32];
    let views = [
        Image::from_fn(48, 48, |y, z| fibres([300, at(y, z)[0], at(y, z)[1]])),
        Image::from_fn(48, 48, |x, z| fibres([at(x, z)[0], 300, at(x, z)[1]])),
        Image::from_fn(48, 48, |x, y| fibres([at(x, y)[0], at(x, y)[1], 300])),
    ];
    let settings = QualitySettings::default();
    let measured =
        |views: &[&Image]| quality_report(&measure_views(&volume(fibres), views, &settings, &()).unwrap());
    let [x, y, z] = &views;
    let three = measured(&[x, y, z]);
    assert!(flags(&three).iter().all(|name| name.starts_with("oblique")), "{:?}", flags(&three));
    let one = measured(&[z]);
    assert!(flags(&one).contains(&"axis_orientation_kl"), "{:?} {:?}", flags(&one), flags(&three));
}

#[test]
fn threads_make_no_difference() {
    let settings = QualitySettings { samples: 128, slices: 2, seed: 4 };
    let solid = volume(|v| balls(v, 3));
    let image = Image::from_fn(40, 32, |x, y| balls([x as i32, y as i32, 90], 3));
    let measured = || measure_quality(&solid, &image, &settings, &()).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(pool.install(measured), measured());
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let settings = QualitySettings::default();
    let refused =
        |volume: &Volume, exemplar: &Image| measure_quality(volume, exemplar, &settings, &()).unwrap_err();
    let good = volume(|v| medium(v, 5));
    let small = Image::from_fn(15, 40, |x, _| [x as u8; 3]);
    assert_eq!(refused(&good, &small), MeasureError::Exemplar(15, 40));
    assert_eq!(refused(&good, &Image::from_fn(20, 20, |_, _| [1u8, 2, 3])), MeasureError::Constant(1, 2, 3));
    let nan = Image::new(16, 16, 3, Samples::F32(vec![f32::NAN; 768])).unwrap();
    assert_eq!(refused(&good, &nan), MeasureError::NotFinite("the exemplar"));
    let thin = Volume { size: [64, 64, 8], ..good.clone() };
    assert_eq!(refused(&thin, &exemplar()), MeasureError::Volume(64, 64, 8));
    let bare = Volume { maps: Vec::new(), ..good.clone() };
    assert_eq!(refused(&bare, &exemplar()), MeasureError::NoColor("nothing".into()));
    let mut other = good.clone();
    other.maps[0].name = "label".into();
    assert_eq!(refused(&other, &exemplar()), MeasureError::NoColor("`label`".into()));
    let mut misfit = good.clone();
    misfit.size = [16, 16, 64];
    assert_eq!(refused(&misfit, &exemplar()), MeasureError::NoColor("`color`".into()));
    let mut nan = good;
    nan.maps[0].samples = Samples::F32(vec![f32::NAN; 3 * N * N * N]);
    assert_eq!(refused(&nan, &exemplar()), MeasureError::NotFinite("the map `color`"));
}
