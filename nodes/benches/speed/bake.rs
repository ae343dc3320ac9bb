//! Baking an unbounded lazy solid into the texture of a torus: work grows with the surface, so by four where
//! the resolution doubles.

use std::f32::consts::TAU;

use breccia_nodes::data::Mesh;
use breccia_nodes::mesh::{BakeSettings, bake_solid};
use divan::Bencher;

use crate::material::Material;
use crate::sizes;

/// A torus with its own UVs. Its box is 1 wide; the tube's radius is a third of the ring's.
fn torus() -> Mesh {
    const AROUND: u32 = 64;
    const TUBE: u32 = 24;
    let mut mesh = Mesh { name: "torus".to_owned(), ..Mesh::default() };
    // The last column and row repeat the first ones at the other end of the texture.
    for i in 0..=AROUND {
        for j in 0..=TUBE {
            let (u, v) = (i as f32 / AROUND as f32, j as f32 / TUBE as f32);
            let ((sin_u, cos_u), (sin_v, cos_v)) = ((TAU * u).sin_cos(), (TAU * v).sin_cos());
            let ring = 0.375 + 0.125 * cos_v;
            mesh.positions.push([ring * cos_u, 0.125 * sin_v, ring * sin_u]);
            mesh.normals.push([cos_v * cos_u, sin_v, cos_v * sin_u]);
            mesh.uvs.push([u, v]);
        }
    }
    for i in 0..AROUND {
        for j in 0..TUBE {
            let a = i * (TUBE + 1) + j;
            let b = a + TUBE + 1;
            mesh.triangles.extend([[a, a + 1, b], [b, a + 1, b + 1]]);
        }
    }
    mesh
}

/// Voxels along the torus; its texture has as many texels a side.
fn resolutions() -> Vec<u32> {
    sizes(&[256, 512, 1024], 24)
}

#[divan::bench(args = resolutions(), sample_count = 3, sample_size = 1)]
fn torus_of_cells(bencher: Bencher, resolution: u32) {
    let mesh = torus();
    let material = Material::of_side((resolution / 2).clamp(16, 64));
    let settings = BakeSettings { resolution, texture_size: resolution, ..BakeSettings::default() };
    bencher
        .with_inputs(|| material.solid(None))
        .bench_refs(|solid| bake_solid(&mesh, solid, settings, &()).expect("a baked mesh"));
}
