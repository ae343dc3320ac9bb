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

const MADE: &str = "builtin:granite/volume_32.nrrd";

#[test]
fn a_report_is_one_page_that_needs_nothing_else() {
    let place = Place::new();
    let args = ["--phases", "--samples", "128", "--seed", "7", "--report", "out/a b", MADE];
    place.breccia(&[&["compare"], &EXEMPLAR[..], &args].concat()).expect(0, &[]);
    assert_eq!(std::fs::read_dir(place.path("out/a b")).unwrap().count(), 1);
    let page = String::from_utf8(place.read("out/a b/report.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && page.trim_end().ends_with("</html>"));
    // Exemplar, three slices and three cuts; three curves of each kind.
    assert_eq!((page.matches("data:image/png;base64,").count(), page.matches("<svg").count()), (7, 6));
    for foreign in ["<script", "<link", "src=\"http", "url(", "@import"] {
        assert!(!page.contains(foreign), "{foreign}");
    }
    for part in [
        "oblique_",
        "color_kl",
        "euler_8",
        "seed 7",
        "&#39;out/a b&#39;",
        "breccia-graph",
        "&quot;seed&quot;: 7",
    ] {
        assert!(page.contains(part), "{part}");
    }
}

#[test]
fn a_report_that_cannot_be_written_is_said_before_anything_is_measured() {
    let place = Place::new();
    place.write("file", b"");
    let args = [&["compare"], &EXEMPLAR[..], &["--report", "file", "nowhere.npy"]].concat();
    place.breccia(&args).expect(6, &["cannot write `file/report.html`"]);
    // A failure afterwards leaves nothing.
    let args = [&["compare"], &EXEMPLAR[..], &["--report", "out", "nowhere.npy"]].concat();
    place.breccia(&args).expect(4, &["nowhere.npy"]);
    assert_eq!(place.files(), ["file"]);
}

#[test]
fn phases_are_compared_with_a_true_volume() {
    let place = Place::new();
    let stones = |dark: u8| {
        npy(move |i| {
            let [x, y, z] = [i % 24, i / 24 % 24, i / 576].map(|c| c as f64 * 0.9);
            if x.sin() + y.sin() + z.sin() > 0.0 { [200, 190, 180] } else { [dark, 30, 50] }
        })
    };
    place.write("solid.npy", stones(40));
    place.write("truth.npy", stones(20));
    place.write("flat.npy", npy(|_| [9; 3]));
    let compare = |truth: &str| {
        let args = ["--json", "--samples", "64", "--truth", truth, "solid.npy"];
        place.breccia(&[&["compare"], &EXEMPLAR[..], &args].concat())
    };
    let answer = compare("truth.npy");
    answer.expect(0, &[]);
    let report: serde_json::Value = serde_json::from_str(&answer.stdout).unwrap();
    let row = |name: &str| {
        report["rows"].as_array().unwrap().iter().find(|row| row["name"] == name).unwrap().clone()
    };
    assert_eq!(row("solid_fraction")["flagged"], false);
    assert_eq!(row("solid_two_point")["flagged"], false);
    assert_eq!(row("axis_color_kl")["flagged"], true);
    compare("flat.npy").expect(4, &["the truth has one phase only"]);
    compare(MADE).expect(4, &["the truth has [32, 32, 32] voxels, expected the volume's [24, 24, 24]"]);
}

#[test]
fn exemplars_of_other_axes_are_taken() {
    let place = Place::new();
    let exemplars =
        ["--exemplar-y", "builtin:granite/color_128.png", "--exemplar-z", "builtin:cobbles/color_64.png"];
    let args = [&["compare"], &EXEMPLAR[..], &exemplars, &["--samples", "64", MADE]].concat();
    let answer = place.breccia(&args);
    answer.expect(0, &[]);
    assert!(answer.stdout.contains('!'), "{}", answer.stdout);
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

    // An exemplar that is too small, or of one colour, and volumes too small or without colour.
    let pictures = [("small.png", 12, 3), ("flat.png", 32, 0)];
    for (name, edge, step) in pictures {
        let picture = image::RgbImage::from_fn(edge, edge, |x, _| image::Rgb([(x * step) as u8; 3]));
        picture.save(place.path(name)).unwrap();
    }
    let with = |exemplar: &str, volume: &str, message: &str| {
        place.breccia(&["compare", "--exemplar", exemplar, volume]).expect(4, &[message]);
    };
    with("small.png", MADE, "an exemplar of 12 × 12 pixels is too small");
    with("flat.png", MADE, "all pixels of the exemplar have the colour (0, 0, 0)");
    let shaped = |shape: &str, descr: &str, bytes: Vec<u8>| {
        let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({shape}), }}");
        let mut file = b"\x93NUMPY\x01\x00".to_vec();
        file.extend(118u16.to_le_bytes());
        file.extend(format!("{header:117}\n").bytes());
        file.extend(bytes);
        file
    };
    place.write("thin.npy", shaped("24, 24, 8, 3", "|u1", vec![7; 24 * 24 * 8 * 3]));
    compare("thin.npy", 4, "a box of 8 × 24 × 24 voxels is too small");
    place.write("labels.npy", shaped("16, 16, 16", "<u4", vec![1; 4 * 4096]));
    compare("labels.npy", 4, "no map `color`");
    let nan = f32::NAN.to_le_bytes().repeat(3 * 4096);
    place.write("nan.npy", shaped("16, 16, 16, 3", "<f4", nan));
    compare("nan.npy", 4, "nan.npy");
}

#[test]
fn what_a_preset_makes_is_compared_without_a_file_of_it() {
    let place = Place::new();
    let small = ["--set", "size=24", "--set", "exemplar.max_size=48", "--samples", "128"];
    let args = [&["compare"], &EXEMPLAR[..], &["lazy_volume", "--json"], &small].concat();
    let json: serde_json::Value = serde_json::from_str(&place.breccia(&args).stdout).unwrap();
    assert!(json["rows"].as_array().unwrap().len() > 10, "{json}");
    // A report has the graph with it.
    place.breccia(&[&args[..], &["--report", "out"]].concat()).expect(0, &[]);
    let page = std::fs::read_to_string(place.path("out/report.html")).unwrap();
    assert!(page.contains("The graph that made the volume") && page.contains("lazy.synthesis"), "{page}");
    // Files have no parameters, and some graphs make no volume.
    let file =
        [&["compare"], &EXEMPLAR[..], &["builtin:granite/volume_32.nrrd", "--set", "size=24"]].concat();
    place.breccia(&file).expect(2, &["`size=…` is for a graph or a preset"]);
    place.breccia(&[&["compare"], &EXEMPLAR[..], &["lazy_mesh"]].concat()).expect(2, &["no output `volume`"]);
}
