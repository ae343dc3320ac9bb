//! `breccia compare`.

use crate::support::Place;

const EXEMPLAR: [&str; 2] = ["--exemplar", "builtin:granite/color_128.png"];

/// The value of a measure.
fn measure(place: &Place, volume: &str, name: &str) -> f64 {
    let args = [&["compare"], &EXEMPLAR[..], &["--json", "--samples", "256", volume]].concat();
    let answer = place.breccia(&args);
    answer.expect(0, &[]);
    let report: serde_json::Value = serde_json::from_str(&answer.stdout).unwrap();
    let rows = report["rows"].as_array().unwrap();
    rows.iter().find(|row| row["name"] == name).unwrap()["value"].as_f64().unwrap()
}

/// 24³ voxels of three bytes as an NPY file.
fn npy(voxel: impl Fn(usize) -> [u8; 3]) -> Vec<u8> {
    let header = "{'descr': '|u1', 'fortran_order': False, 'shape': (24, 24, 24, 3), }";
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(118u16.to_le_bytes());
    bytes.extend(format!("{header:117}\n").bytes());
    bytes.extend((0..24 * 24 * 24).flat_map(voxel));
    bytes
}

#[test]
fn a_synthesised_volume_resembles_its_exemplar_more_than_a_flat_one() {
    let place = Place::new();
    place.write("flat.npy", npy(|_| [120, 110, 110]));
    place.write("striped.npy", npy(|i| [if i % 24 % 4 < 2 { 200 } else { 20 }; 3]));
    let made = "builtin:granite/volume_32.nrrd";
    assert!(measure(&place, made, "axis_color_kl") < 0.1);
    assert!(measure(&place, "flat.npy", "axis_color_kl") > 1.0);
    assert!(measure(&place, "flat.npy", "axis_flat") > 5.0 * measure(&place, made, "axis_flat"));
    assert!(measure(&place, "striped.npy", "axis_repetition") > 0.5);
    assert!(measure(&place, made, "axis_repetition") < 0.3);
    assert!(measure(&place, "striped.npy", "axis_orientation_kl") > 0.5);
}

#[test]
fn the_measures_are_printed_to_be_read() {
    let place = Place::new();
    let answer = place.breccia(&[&["compare"], &EXEMPLAR[..], &["builtin:granite/volume_32.nrrd"]].concat());
    answer.expect(0, &[]);
    assert!(
        answer.stdout.lines().any(|line| line.starts_with("axis_coverage") && line.contains("good from 0.8"))
    );
    assert_eq!(place.files(), [""; 0]);
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let place = Place::new();
    let compare = |volume: &str, code: i32, message: &str| {
        place.breccia(&[&["compare"], &EXEMPLAR[..], &[volume]].concat()).expect(code, &[message]);
    };
    compare("nowhere.npy", 4, "cannot read `nowhere.npy`");
    place.write("cut.npy", &npy(|_| [0; 3])[..500]);
    compare("cut.npy", 4, "cut.npy");
    place.breccia(&["compare", "builtin:granite/volume_32.nrrd"]).expect(2, &["--exemplar"]);
}
