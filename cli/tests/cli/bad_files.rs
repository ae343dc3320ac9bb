//! Bad files: a clear message, the right exit code, and nothing written.

use crate::support::{Place, assign};

fn refused(file: &str, contents: impl AsRef<[u8]>, input: &str, messages: &[&str]) {
    let place = Place::new();
    let given = assign(input, &place.write(file, contents));
    place.run("lazy_mesh", &["--input", &given, "--set", "resolution=16"]).expect(4, messages);
    assert_eq!(place.files(), [file]);
}

#[test]
fn a_picture_cut_short_is_refused() {
    let place = Place::new();
    place.picture("whole.png", 32);
    let bytes = place.read("whole.png");
    refused("cut.png", &bytes[..bytes.len() / 2], "exemplar", &["node `photo`", "cut.png"]);
}

#[test]
fn something_else_than_a_picture_is_refused() {
    refused("notes.png", "these are notes", "exemplar", &["node `photo`", "notes.png"]);
}

#[test]
fn an_empty_file_is_refused() {
    refused("empty.png", "", "exemplar", &["node `photo`", "empty.png"]);
}

#[test]
fn a_picture_that_claims_to_be_huge_is_refused() {
    let place = Place::new();
    place.picture("whole.png", 32);
    let mut bytes = place.read("whole.png");
    // Width and height of the header chunk, and its checksum.
    bytes[16..24].copy_from_slice(&[0, 0, 0x4e, 0x20, 0, 0, 0x4e, 0x20]);
    let checksum = crc(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&checksum.to_be_bytes());
    refused("huge.png", bytes, "exemplar", &["huge.png", "20000"]);
}

fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| if c & 1 == 1 { 0xEDB8_8320 ^ (c >> 1) } else { c >> 1 })
    })
}

#[test]
fn pictures_that_are_too_small_are_refused() {
    for (side, found) in [(1, "1 × 1"), (7, "7 × 7")] {
        let place = Place::new();
        let given = assign("exemplar", &place.picture("small.png", side));
        place.run("lazy_volume", &["--input", &given]).expect(4, &[found, "at least"]);
        assert_eq!(place.files(), ["small.png"]);
    }
}

#[test]
fn a_mask_of_another_size_is_refused() {
    let place = Place::new();
    let exemplar = assign("exemplar", &place.picture("photo.png", 32));
    let mask = assign("mask", &place.mask("mask.png", 24));
    let answer = place.run("lazy_volume", &["--input", &exemplar, "--input", &mask]);
    answer.expect(4, &["the mask is 24 × 24 pixels, the colour is 32 × 32"]);
}

#[test]
fn a_picture_with_a_pixel_that_is_no_number_is_refused() {
    let place = Place::new();
    let pixel = |x: usize, y: usize| (0.5f32, if (x, y) == (7, 9) { f32::NAN } else { 0.25 }, 0.125f32);
    exr::prelude::write_rgb_file(place.path("photo.exr"), 32, 32, pixel).unwrap();
    let given = assign("exemplar", &place.path("photo.exr"));
    place.run("lazy_volume", &["--input", &given]).expect(4, &["photo.exr", "x 7, y 9", "NaN"]);
    assert_eq!(place.files(), ["photo.exr"]);
}

/// Bakes a mesh and draws it.
fn accepted(obj: &str) {
    let place = Place::new();
    let given = assign("mesh", &place.write("mesh.obj", obj));
    let size = ["--set", "resolution=16", "--set", "texture_size=32"];
    let args =
        [&["--input", given.as_str()], &size[..], &["--output", "mesh=m.glb", "--output", "preview=p.png"]];
    place.run("lazy_mesh", &args.concat()).expect(0, &[]);
    assert_eq!(place.files(), ["m.glb", "mesh.obj", "p.png"]);
}

#[test]
fn faces_without_an_area_are_no_obstacle() {
    accepted("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\nf 1 1 2\n");
}

#[test]
fn a_mesh_of_nothing_but_faces_without_an_area_is_refused() {
    let obj = "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n";
    refused("line.obj", obj, "mesh", &["node `shape`", "line.obj"]);
}

#[test]
fn three_faces_at_one_edge_are_no_obstacle() {
    accepted("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 -1\nf 1 2 3\nf 1 2 4\nf 1 2 5\n");
}

#[test]
fn texture_coordinates_outside_the_unit_square_are_no_obstacle() {
    accepted("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt -3 0.5\nvt 7 0.5\nvt 0 2\nf 1/1 2/2 3/3\n");
}

#[test]
fn an_obj_with_bad_indices_is_refused() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n";
    refused("bad.obj", obj, "mesh", &["node `shape`", "bad.obj"]);
}

#[test]
fn an_obj_without_faces_is_refused() {
    refused("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "mesh", &["node `shape`", "points.obj"]);
}

#[test]
fn a_missing_file_is_named() {
    let answer = Place::new().run("lazy_mesh", &["--input", "exemplar=nowhere.png"]);
    answer.expect(4, &["node `photo`", "cannot read `nowhere.png`"]);
}

#[test]
fn a_missing_built_in_file_gets_a_suggestion() {
    let answer = Place::new().run("lazy_mesh", &["--input", "mesh=builtin:spot/sport.glb"]);
    answer.expect(4, &["did you mean `spot/spot.glb`?"]);
}

#[test]
fn a_view_that_is_not_given_is_missed() {
    let place = Place::new();
    let given = assign("exemplar_x", &place.picture("x.png", 32));
    let answer = place.breccia(&["run", "wood_views", "--input", &given, "--output", "volume=v.npy"]);
    answer.expect(4, &["input `exemplar_y` is left out", "is not given"]);
}
