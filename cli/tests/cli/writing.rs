//! Outputs: their names, their formats, and what becomes of them when something fails.

use crate::support::{Place, assign};

const SMALL: [&str; 6] = ["--set", "size=8", "--set", "sheet.size=8", "--set", "quality.size=16"];

#[test]
fn without_options_every_output_is_written() {
    let place = Place::new();
    place.run("lazy_volume", &SMALL).expect(0, &["wrote volume.npy"]);
    assert_eq!(place.files(), ["preview.png", "quality.json", "sheet.png", "statistics.json", "volume.npy"]);
}

#[test]
fn a_folder_takes_every_output_but_those_named() {
    let place = Place::new();
    place
        .run("lazy_volume", &[&SMALL[..], &["--out-dir", "a/b", "--output", "volume=v.nrrd"]].concat())
        .expect(0, &[]);
    assert_eq!(place.files(), ["a", "v.nrrd"]);
    let mut names: Vec<_> =
        std::fs::read_dir(place.path("a/b")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["preview.png", "quality.json", "sheet.png", "statistics.json"]);
}

#[test]
fn the_extension_tells_the_format() {
    let place = Place::new();
    for (file, start) in [
        ("v.npy", &b"\x93NUMPY"[..]),
        ("v.nrrd", b"NRRD"),
        ("v.tif", b"II"),
        ("v.png", b"\x89PNG"),
        ("V.NPY", b"\x93"),
    ] {
        let output = format!("volume={file}");
        place.run("lazy_volume", &["--set", "size=8", "--output", &output]).expect(0, &[]);
        assert!(place.read(file).starts_with(start), "{file}");
    }
    place.run("lazy_volume", &["--set", "size=8", "--output", "volume=slices/"]).expect(0, &[]);
    assert_eq!(std::fs::read_dir(place.path("slices")).unwrap().count(), 9);
}

#[test]
fn files_that_belong_together_are_written_together() {
    let place = Place::new();
    let small = ["--set", "resolution=16", "--set", "texture_size=64"];
    place.run("lazy_mesh", &[&small[..], &["--output", "mesh=m/cow.obj"]].concat()).expect(0, &[]);
    let mut names: Vec<_> =
        std::fs::read_dir(place.path("m")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names.len(), 3, "{names:?}");
    assert!(place.read("m/cow.obj").starts_with(b"#") || place.read("m/cow.obj").starts_with(b"mtllib"));
}

#[test]
fn an_output_of_a_node_can_be_asked_for() {
    let place = Place::new();
    place.run("lazy_volume", &["--output", "photo.image=p.png"]).expect(0, &[]);
    assert_eq!(place.files(), ["p.png"]);
}

#[test]
fn outputs_that_do_not_depend_on_a_failure_are_written() {
    let place = Place::new();
    let args = ["--set", "size=8", "--set", "quality.size=60000", "--set", "sheet.size=8"];
    place.run("lazy_volume", &args).expect(5, &["node `quality`", "not written for that reason: quality"]);
    assert_eq!(place.files(), ["preview.png", "sheet.png", "statistics.json", "volume.npy"]);
}

#[test]
fn files_of_a_replaced_set_are_left_out() {
    let place = Place::new();
    let exemplar = assign("exemplar", &place.picture("photo.png", 32));
    let args = ["--set", "size=8", "--output", "volume=v.npy", "--input", &exemplar];
    place.run("lazy_volume", &args).expect(0, &["note: input `mask` is left out"]);
    // A whole material does not fit another picture either.
    let small = ["--set", "resolution=16", "--set", "texture_size=64", "--output", "mesh=m.glb"];
    let answer = place.run("pbr_mesh", &[&small[..], &["--input", &exemplar]].concat());
    answer.expect(0, &["`height`", "`mask`", "`normal`", "`roughness`"]);
}

#[test]
fn a_graph_of_ones_own_reads_files_beside_it() {
    let place = Place::new();
    std::fs::create_dir(place.path("graphs")).unwrap();
    place.picture("graphs/photo.png", 8);
    place.write(
        "graphs/copy.ron",
        r#"(format: "breccia-graph", version: 1,
            interface: (outputs: {"copy": (node: "read", socket: "image", docs: "")}),
            nodes: {"read": (type: "io.read_image", params: {"path": "photo.png"})})"#,
    );
    place.breccia(&["run", "graphs/copy.ron"]).expect(0, &[]);
    assert_eq!(place.files(), ["copy.png", "graphs"]);
}
