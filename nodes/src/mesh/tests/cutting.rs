//! Cutting: closed halves, volumes that add up, caps with holes, charts beside the old ones.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::*;
use crate::mesh::{CutError, Halves, Plane, cut_mesh, uv_problem};

fn cut(mesh: &Mesh, point: [f64; 3], normal: [f64; 3]) -> Halves {
    cut_mesh(mesh, Plane { point, normal }).unwrap()
}

fn check(mesh: &Mesh, halves: &Halves, name: &str) {
    assert_eq!(open_edges(mesh), 0, "{name}: the whole is closed");
    for (half, side) in [(&halves.above, "above"), (&halves.below, "below")] {
        assert_eq!(open_edges(half), 0, "{name} {side}");
        assert!(volume(half) > 0.0, "{name} {side}");
        assert_eq!(half.space_bounds, mesh.bounds());
        assert_eq!(half.normals.len(), if mesh.normals.is_empty() { 0 } else { half.positions.len() });
        if !mesh.uvs.is_empty() {
            assert_eq!(uv_problem(half), None);
        }
    }
    let (whole, parts) = (volume(mesh), volume(&halves.above) + volume(&halves.below));
    assert!((whole - parts).abs() < 1e-5 * whole, "{name}: {whole} is not {parts}");
}

#[test]
fn halves_of_a_cube_are_boxes() {
    let halves = cut(&cube(), [0.5, 0.0, 0.0], [2.0, 0.0, 0.0]);
    check(&cube(), &halves, "cube");
    assert!((volume(&halves.above) - 2.0).abs() < 1e-6);
    assert!((volume(&halves.below) - 6.0).abs() < 1e-6);
}

#[test]
fn a_plane_through_corners_and_edges_leaves_closed_halves() {
    for normal in [[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [1.0, -1.0, 0.0], [0.0, 1.0, -1.0]] {
        check(&cube(), &cut(&cube(), [0.0; 3], normal), "cube by its corners");
    }
    check(&sphere(8), &cut(&sphere(8), [0.0; 3], [0.0, 0.0, 1.0]), "sphere by its vertices");
}

#[test]
fn a_torus_cut_through_its_hole_has_two_caps() {
    let mesh = torus(32, 16);
    let halves = cut(&mesh, [0.01, 0.0, 0.02], [1.0, 0.0, 0.1]);
    check(&mesh, &halves, "torus across");
    // The caps' area is that of two discs of radius 0.4 (of polygons with sixteen sides).
    let area: f64 = cap_area(&halves.below, [1.0, 0.0, 0.1]);
    assert!((area - 2.0 * std::f64::consts::PI * 0.16).abs() < 0.05, "{area}");
}

#[test]
fn a_torus_cut_along_its_plane_has_a_cap_with_a_hole() {
    let mesh = torus(32, 16);
    let halves = cut(&mesh, [0.0, 0.013, 0.0], [0.0, 1.0, 0.0]);
    check(&mesh, &halves, "torus along");
    let area: f64 = cap_area(&halves.below, [0.0, 1.0, 0.0]);
    assert!((area - std::f64::consts::PI * (1.4 * 1.4 - 0.6 * 0.6)).abs() < 0.1, "{area}");
}

/// The area of the triangles whose three normals are the plane's.
fn cap_area(mesh: &Mesh, normal: [f64; 3]) -> f64 {
    let length = normal.iter().map(|c| c * c).sum::<f64>().sqrt();
    let is_cap =
        |i: u32| (0..3).all(|k| (f64::from(mesh.normals[i as usize][k]) - normal[k] / length).abs() < 1e-6);
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize].map(f64::from));
        let n = crate::mesh::vector::cross(crate::mesh::vector::sub(b, a), crate::mesh::vector::sub(c, a));
        0.5 * n.iter().map(|c| c * c).sum::<f64>().sqrt()
    };
    mesh.triangles.iter().filter(|t| t.iter().all(|&i| is_cap(i))).map(area).sum()
}

#[test]
fn the_caps_chart_lies_beside_the_old_atlas() {
    let mesh = torus(32, 16);
    let below = cut(&mesh, [0.0; 3], [0.0, 0.2, 1.0]).below;
    let old: Vec<_> = below.uvs.iter().filter(|uv| uv[0] < 0.9).collect();
    let scale = old.iter().map(|uv| uv[1]).fold(0.0, f32::max);
    assert!(scale > 0.4, "the old atlas keeps {scale} of its size");
    let is_beside = |t: &&[u32; 3]| t.iter().all(|&i| below.uvs[i as usize][0] > scale);
    assert!(below.triangles.iter().filter(is_beside).count() > 20);
}

#[test]
fn vertex_colours_run_on_into_the_cap() {
    let colors = (0..8).map(|i| [i * 30, 255 - i * 30, 7, 255]).collect();
    let mesh = Mesh { colors, ..cube() };
    let above = cut(&mesh, [0.0; 3], [0.0, 0.0, 1.0]).above;
    assert_eq!(above.colors.len(), above.positions.len());
    assert!(above.colors.iter().all(|c| c[2] == 7));
}

#[test]
fn an_open_mesh_is_closed_by_straight_edges_with_a_note() {
    let mut mesh = sphere(8);
    mesh.triangles.retain(|t| t.iter().any(|&i| mesh.positions[i as usize][0] < 0.7));
    let halves = cut(&mesh, [0.0; 3], [0.0, 1.0, 0.0]);
    assert!(halves.above.notes[0].contains("gaps"), "{:?}", halves.above.notes);
}

#[test]
fn planes_that_miss_and_broken_planes_are_refused() {
    let plane = |point, normal| cut_mesh(&cube(), Plane { point, normal });
    assert_eq!(plane([5.0, 0.0, 0.0], [1.0, 0.0, 0.0]), Err(CutError::Misses("below it")));
    assert_eq!(plane([-5.0, 0.0, 0.0], [1.0, 0.0, 0.0]), Err(CutError::Misses("above it")));
    assert!(matches!(plane([0.0; 3], [0.0; 3]), Err(CutError::Normal(_))));
    assert!(plane([f64::NAN; 3], [1.0, 0.0, 0.0]).is_err());
    assert!(cut_mesh(&Mesh::default(), Plane { point: [0.0; 3], normal: [1.0, 0.0, 0.0] }).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default() })]
    #[test]
    fn halves_are_closed_and_add_up_for_any_plane(
        point in prop::array::uniform3(-0.3f64..0.3),
        normal in prop::array::uniform3(-1.0f64..1.0),
    ) {
        prop_assume!(normal.iter().map(|c| c * c).sum::<f64>() > 0.01);
        for mesh in [cube(), sphere(7), torus(20, 11)] {
            check(&mesh, &cut(&mesh, point, normal), &mesh.name);
        }
    }
}
