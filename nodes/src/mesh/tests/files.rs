//! Files: round trips, what readers accept, and what they refuse without ever panicking.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use breccia_engine::{Data, Sink, Value};

use super::*;
use crate::data::Image;
use crate::mesh::{MeshError, decode_mesh, encode_glb};

fn colored_torus() -> Mesh {
    let mesh = torus(6, 5);
    let colors = (0..mesh.positions.len()).map(|i| [i as u8 * 5, 255 - i as u8, 99, 255]).collect();
    Mesh { colors, ..mesh }
}

/// What the exporter for `extension` writes to its main file, and the names of all files.
fn export(mesh: &Mesh, extension: &str) -> (Vec<u8>, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join(format!("a b.{extension}"));
    let exporter = crate::mesh::exporters().into_iter().find(|e| e.extensions.contains(&extension)).unwrap();
    let mut sink = Sink::new(&target).unwrap();
    (exporter.write)(&Value::new(mesh.clone()), &mut sink).unwrap();
    let names = sink.commit().unwrap();
    let mut names: Vec<_> =
        names.iter().map(|p| p.file_name().unwrap().to_string_lossy().into_owned()).collect();
    names.sort();
    (std::fs::read(target).unwrap(), names)
}

fn read(text: &str, extension: &str) -> Result<Mesh, MeshError> {
    decode_mesh(text.as_bytes(), extension)
}

#[test]
fn what_is_written_is_read_back() {
    for extension in ["glb", "obj", "ply"] {
        let mesh = colored_torus();
        let back = decode_mesh(&export(&mesh, extension).0, extension).unwrap();
        let corners = |mesh: &Mesh| -> Vec<_> {
            let corner = |i: u32| {
                let i = i as usize;
                (
                    mesh.positions[i],
                    mesh.colors[i],
                    mesh.uvs[i].map(|c| (c * 1e5).round()),
                    mesh.normals[i].map(|c| (c * 1e5).round()),
                )
            };
            mesh.triangles.iter().map(|t| t.map(corner)).collect()
        };
        assert_eq!(corners(&back), corners(&mesh), "{extension}");
    }
}

#[test]
fn textures_are_embedded_or_lie_beside_under_safe_names() {
    let mut mesh = torus(4, 4);
    for name in ["color", "normal", "roughness", "metallic", "../height"] {
        let image = if matches!(name, "color" | "normal") {
            Image::from_fn(4, 4, |x, y| [x as u8, y as u8, 255])
        } else {
            Image::from_fn(4, 4, |x, _| [x as u8 * 60])
        };
        mesh.textures.push((name.to_owned(), image));
    }
    let (_, names) = export(&mesh, "obj");
    let expected = [
        "a b.obj",
        "a_b.mtl",
        "a_b_.._height.png",
        "a_b_color.png",
        "a_b_metallic.png",
        "a_b_normal.png",
        "a_b_roughness.png",
    ];
    assert_eq!(names, expected);
    let glb = encode_glb(&mesh).unwrap();
    let document = gltf::Gltf::from_slice(&glb).unwrap();
    let material = document.materials().next().unwrap();
    let pbr = material.pbr_metallic_roughness();
    assert!(pbr.base_color_texture().is_some() && pbr.metallic_roughness_texture().is_some());
    assert!(material.normal_texture().is_some());
    let names: Vec<_> = document.images().filter_map(|image| image.name().map(str::to_owned)).collect();
    assert_eq!(names, ["color", "normal", ".._height", "metallic_roughness"]);
}

#[test]
fn the_cache_keeps_all_of_a_mesh() {
    let mut mesh = colored_torus();
    mesh.space_bounds = Some(([0.0; 3], [1.0; 3]));
    mesh.notes.push("kept".to_owned());
    mesh.textures.push(("color".to_owned(), Image::from_fn(2, 2, |x, y| [x as u8, y as u8, 3])));
    let bytes = mesh.encode().unwrap();
    assert_eq!(Mesh::decode(&bytes), Ok(mesh));
    for end in 0..bytes.len() {
        assert!(Mesh::decode(&bytes[..end]).is_err());
    }
}

#[test]
fn obj_reads_polygons_negative_indices_and_flips_v() {
    let mesh =
        read("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0.25\nf -4/1 2/2 3/2 4/1\n", "OBJ").unwrap();
    assert_eq!(mesh.triangles.len(), 2);
    assert_eq!(mesh.uvs[0], [0.0, 1.0]);
    assert_eq!(mesh.uvs[1], [1.0, 0.75]);
    assert_eq!(mesh.normals[0], [0.0, 0.0, 1.0]);
}

#[test]
fn obj_errors_name_the_line() {
    let cases = [
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "line 4: `4` names vertex 4, but there are 3"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 2 0\n", "line 5: `0` names vertex 0"),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/7 2 3\n",
            "line 4: `1/7` names texture coordinate 7, but there are 0",
        ),
        ("v 0 0 0\nv 1 0 x\nv 0 1 0\nf 1 2 3\n", "line 2: "),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -9223372036854775808\n", "line 4: "),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf a b c\n", "line 4: `a` in `a` is not a whole number"),
        ("v 0 0 0\nv 1 0 0\n", "no triangles"),
        ("v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", "position of vertex 1 is not finite"),
        ("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "all 1 are degenerate"),
        ("v 0 0 0\nv 1 0 0\nf 1 2\n", "no triangles"),
    ];
    for (text, expected) in cases {
        let found = read(text, "obj").unwrap_err().to_string();
        assert!(found.contains(expected), "`{found}` for {text:?}");
    }
}

#[test]
fn degenerate_triangles_are_dropped_and_counted() {
    let mesh = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 1 2\nf 1 2 4\n", "obj").unwrap();
    assert_eq!(mesh.triangles.len(), 1);
    assert!(mesh.summary().contains("dropped 2 degenerate triangles"));
}

#[test]
fn ply_reads_ascii_and_big_endian() {
    let header = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\ncomment x\nelement extra 1\nproperty list uchar short q\nelement vertex 4\n\
             property double x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\n\
             property uchar blue\nproperty float u\nproperty float v\nelement face 1\n\
             property list uchar uint vertex_index\nend_header\n"
        )
    };
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut text = header("ascii") + "2 5 -6\n";
    let mut bytes = header("binary_big_endian").into_bytes();
    bytes.extend([2, 0, 5, 0xff, 0xfa]);
    for [x, y] in corners {
        text += &format!("{x} {y} 0 255 128 {} {x} {y}\n", x * 10.0);
        bytes.extend(f64::from(x).to_be_bytes());
        bytes.extend([y, 0.0f32].iter().flat_map(|c| c.to_be_bytes()));
        bytes.extend([255, 128, (x * 10.0) as u8]);
        bytes.extend([x, y].iter().flat_map(|c| c.to_be_bytes()));
    }
    text += "4 0 1 2 3\n";
    bytes.push(4);
    bytes.extend((0..4u32).flat_map(u32::to_be_bytes));
    let ascii = read(&text, "ply").unwrap();
    assert_eq!(ascii, decode_mesh(&bytes, "ply").unwrap());
    assert_eq!(ascii.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(ascii.uvs[2], [1.0, 0.0]);
    assert_eq!(ascii.colors[1], [255, 128, 10, 255]);
}

#[test]
fn ply_refuses_counts_that_cannot_fit_before_allocating() {
    for format in ["ascii", "binary_little_endian"] {
        let text = format!(
            "ply\nformat {format} 1.0\nelement vertex 99999999999999\nproperty float x\nend_header\n0 0 0\n"
        );
        let error = read(&text, "ply").unwrap_err().to_string();
        assert!(error.contains("99999999999999 rows cannot fit"), "{error}");
    }
    let text = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
                element face 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n99999999 0 0\n";
    assert!(read(text, "ply").unwrap_err().to_string().contains("element `face`, row 0: a list of 99999999"));
}

#[test]
fn gltf_with_external_buffers_asks_for_glb() {
    let text = r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"a%FFb.bin"}]}"#;
    let error = read(text, "gltf").unwrap_err().to_string();
    assert!(error.contains("save as GLB"), "{error}");
}

#[test]
fn gltf_attributes_without_accessor_are_refused() {
    let text = r#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[{"attributes":{"POSITION":3}}]}]}"#;
    let error = read(text, "gltf").unwrap_err().to_string();
    assert!(error.contains("mesh 0: an attribute names accessor 3, but there are 0"), "{error}");
}

#[test]
fn gltf_applies_node_transforms_and_turns_mirrored_triangles() {
    let glb = encode_glb(&cube()).unwrap();
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let json = String::from_utf8(glb[20..20 + length].to_vec()).unwrap();
    let json = json
        .trim_end()
        .replace(r#""nodes":[{"mesh":0"#, r#""nodes":[{"scale":[-2,1,1],"translation":[5,0,0],"mesh":0"#);
    assert!(json.contains("scale"), "{json}");
    let json = format!("{json}{}", " ".repeat(json.len().next_multiple_of(4) - json.len()));
    let mut bytes = glb[..8].to_vec();
    let rest = &glb[20 + length..];
    bytes.extend((20 + json.len() as u32 + rest.len() as u32).to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json.as_bytes());
    bytes.extend(rest);
    let mesh = decode_mesh(&bytes, "glb").unwrap();
    assert_eq!(mesh.bounds(), Some(([3.0, -1.0, -1.0], [7.0, 1.0, 1.0])));
    assert!((volume(&mesh) - 16.0).abs() < 1e-5, "outside stays outside");
}

#[test]
fn no_prefix_of_a_file_panics() {
    let mesh = colored_torus();
    for extension in ["glb", "obj", "ply"] {
        let bytes = export(&mesh, extension).0;
        for end in 0..bytes.len() {
            let read = decode_mesh(&bytes[..end], extension);
            assert!(extension == "obj" || end + 4 > bytes.len() || read.is_err(), "{extension} cut at {end}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: None, rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default() })]

    #[test]
    fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..200), kind in 0usize..4) {
        let _ = decode_mesh(&bytes, ["obj", "glb", "gltf", "ply"][kind]);
    }

    #[test]
    fn no_damaged_file_panics(kind in 0usize..3, hits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)) {
        let extension = ["glb", "obj", "ply"][kind];
        let mut bytes = FILES.with(|files| files[kind].clone());
        for (at, byte) in hits {
            let at = at.index(bytes.len().min(1500));
            bytes[at] = byte;
        }
        let _ = decode_mesh(&bytes, extension);
    }

    #[test]
    fn no_words_of_obj_panic(words in prop::collection::vec("(v|vt|vn|f|l|p|o|g|s|usemtl|mtllib|#|-?[0-9]{1,3}(/-?[0-9]{0,2}){0,3}|\\n|1 2 3)", 0..40)) {
        let _ = read(&words.join(" ").replace("\\n", "\n"), "obj");
    }
}

thread_local! {
    static FILES: [Vec<u8>; 3] = ["glb", "obj", "ply"].map(|extension| export(&colored_torus(), extension).0);
}
