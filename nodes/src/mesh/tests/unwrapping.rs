//! Atlases: no overlap, all inside, the surface unchanged.

use super::*;
use crate::mesh::{UnwrapSettings, make_atlas, uv_problem};

fn settings() -> UnwrapSettings {
    UnwrapSettings { texture_size: 512, ..UnwrapSettings::default() }
}

/// Counts texel centres that lie strictly inside more than one triangle.
fn overlaps(mesh: &Mesh, size: usize) -> usize {
    let mut count = vec![0u8; size * size];
    for t in &mesh.triangles {
        let corners = t.map(|i| mesh.uvs[i as usize].map(|c| f64::from(c) * size as f64));
        let fold =
            |i: usize, pick: fn(f64, f64) -> f64| pick(pick(corners[0][i], corners[1][i]), corners[2][i]);
        for y in fold(1, f64::min) as usize..=(fold(1, f64::max) as usize).min(size - 1) {
            for x in fold(0, f64::min) as usize..=(fold(0, f64::max) as usize).min(size - 1) {
                let p = [x as f64 + 0.5, y as f64 + 0.5];
                let side =
                    |a: [f64; 2], b: [f64; 2]| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
                let [a, b, c] = corners;
                let sides = [side(a, b), side(b, c), side(c, a)];
                if sides.iter().all(|&s| s > 1e-3) || sides.iter().all(|&s| s < -1e-3) {
                    count[y * size + x] += 1;
                }
            }
        }
    }
    count.iter().filter(|&&n| n > 1).count()
}

#[test]
fn charts_do_not_overlap_and_keep_the_surface() {
    for mesh in [cube(), sphere(10), torus(24, 12)] {
        let atlas = make_atlas(&mesh, settings()).unwrap();
        assert_eq!(uv_problem(&atlas), None, "{}", mesh.name);
        assert_eq!(overlaps(&atlas, 512), 0, "{}", mesh.name);
        let corners = |mesh: &Mesh| -> Vec<_> {
            mesh.triangles.iter().map(|t| t.map(|i| mesh.positions[i as usize])).collect()
        };
        assert_eq!(corners(&mesh), corners(&atlas), "{}", mesh.name);
    }
}

#[test]
fn the_atlas_is_the_same_for_any_number_of_threads() {
    let mesh = sphere(10);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| make_atlas(&mesh, settings()).unwrap())
    };
    assert_eq!(with(1), with(4));
}

#[test]
fn damaged_and_degenerate_meshes_do_no_harm() {
    let mut mesh = cube();
    // A fin on an edge that two faces share already, a triangle without area, and one of one point.
    mesh.positions.push([3.0, 3.0, 3.0]);
    mesh.triangles.extend([[0, 1, 8], [0, 1, 1], [4, 4, 4]]);
    let atlas = make_atlas(&mesh, settings()).unwrap();
    assert_eq!(overlaps(&atlas, 512), 0);
    assert_eq!(uv_problem(&atlas), None);
    let nothing = Mesh { positions: vec![[1.0; 3]; 3], triangles: vec![[0, 1, 2]], ..Mesh::default() };
    assert!(make_atlas(&nothing, settings()).is_ok());
    let broken = Mesh { triangles: vec![[0, 1, 9]], ..nothing };
    assert!(make_atlas(&broken, settings()).is_err());
    assert!(make_atlas(&Mesh::default(), settings()).is_err());
}
