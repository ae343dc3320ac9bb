//! Baking: what texels hold, gutters, independence of blocks and threads.

use super::*;
use crate::control::Cancelled;
use crate::mesh::texels::{NONE, cover, nearest_covered, position};
use crate::mesh::{BakeError, BakeSettings, Filter, Space, bake_solid, bake_vertices, surface_voxels};

fn settings() -> BakeSettings {
    BakeSettings {
        resolution: 40,
        texture_size: 128,
        gutter: 3,
        origin: [-7, 100, 3],
        ..BakeSettings::default()
    }
}

#[test]
fn each_texel_holds_the_voxel_at_its_place() {
    let mesh = torus(24, 12);
    let settings = BakeSettings { filter: Filter::Nearest, ..settings() };
    let baked = bake_solid(&mesh, &Noise, settings, &()).unwrap();
    let image = baked.texture("color").unwrap();
    let space = Space::of_mesh(&mesh, 40, settings.origin).unwrap();
    let owner = cover(&mesh.uvs, &mesh.triangles, 128);
    assert!(owner.iter().all(|&t| t != NONE), "the torus fills its whole texture");
    for (texel, &triangle) in owner.iter().enumerate() {
        let voxel = space.to_voxels(position(&mesh, triangle, texel, 128)).map(|c| c.floor() as i32);
        assert_eq!(image.rgb8((texel % 128) as u32, (texel / 128) as u32), Noise::color(voxel));
    }
    assert!(baked.texture("label").is_none(), "labels cannot be filtered");
    assert_eq!(baked.texture("normal").unwrap().rgb8(5, 5), [128, 128, 255]);
    assert_eq!(baked.texture("roughness").unwrap().get(9, 9, 0), image.get(9, 9, 0));
}

#[test]
fn texel_positions_lie_on_the_surface_they_are_mapped_to() {
    // On the torus's uv grid positions follow from the coordinates alone.
    let mesh = torus(256, 128);
    let owner = cover(&mesh.uvs, &mesh.triangles, 64);
    for (texel, &triangle) in owner.iter().enumerate() {
        let [u, v] = [texel % 64, texel / 64].map(|c| (c as f64 + 0.5) / 64.0 * std::f64::consts::TAU);
        let ring = 1.0 + 0.4 * v.cos();
        let expected = [ring * u.cos(), 0.4 * v.sin(), ring * u.sin()];
        let found = position(&mesh, triangle, texel, 64);
        for i in 0..3 {
            assert!((found[i] - expected[i]).abs() < 2e-3, "{texel}: {found:?} for {expected:?}");
        }
    }
}

#[test]
fn the_result_depends_neither_on_blocks_nor_on_threads() {
    let mesh = torus(24, 12);
    let bake = |block, threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| bake_solid(&mesh, &Noise, BakeSettings { block, ..settings() }, &()).unwrap())
    };
    let reference = bake(256, 1);
    assert_eq!(reference, bake(8, 3));
    assert_eq!(reference, bake(16, 2));
}

#[test]
fn trilinear_samples_at_voxel_centres_are_the_voxels() {
    let at = |i: usize| [i as f64 + 0.5, -3.5, 7.5];
    let sampled = crate::mesh::sample_solid(&Noise, 20, &at, Filter::Trilinear, 8, &()).unwrap();
    let Samples::U8(color) = &sampled.maps[0].samples else { panic!("bytes") };
    for i in 0..20 {
        let rank = sampled.rank[i] as usize;
        assert_eq!(color[rank * 3..rank * 3 + 3], Noise::color([i as i32, -4, 7]));
    }
}

#[test]
fn trilinear_samples_between_two_voxels_are_their_mean() {
    let at = |_: usize| [8.0, 0.5, 0.5];
    let sampled = crate::mesh::sample_solid(&Noise, 1, &at, Filter::Trilinear, 8, &()).unwrap();
    let (a, b) = (Noise::color([7, 0, 0])[1], Noise::color([8, 0, 0])[1]);
    assert_eq!(sampled.maps[0].samples.get_u8(1), ((f32::from(a) + f32::from(b)) / 2.0 + 0.5) as u8);
}

#[test]
fn gutters_hold_the_nearest_covered_texel() {
    let mesh = Mesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        uvs: vec![[0.3, 0.3], [0.7, 0.3], [0.3, 0.7]],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let (size, reach) = (32usize, 4);
    let owner = cover(&mesh.uvs, &mesh.triangles, size);
    let covered: Vec<usize> = (0..size * size).filter(|&i| owner[i] != NONE).collect();
    assert!(covered.len() > 60 && covered.len() < 110);
    let nearest = nearest_covered(&owner, size, reach);
    let distance =
        |a: usize, b: usize| (a % size).abs_diff(b % size).pow(2) + (a / size).abs_diff(b / size).pow(2);
    for (texel, &found) in nearest.iter().enumerate() {
        let best = covered.iter().map(|&c| distance(texel, c)).min().unwrap();
        if best <= (reach * reach) as usize {
            assert_eq!(distance(texel, found as usize), best);
        } else {
            assert_eq!(found, NONE);
        }
    }
}

#[test]
fn a_triangle_smaller_than_a_texel_still_gets_one() {
    let uvs = [[0.501, 0.501], [0.502, 0.501], [0.501, 0.502]];
    let owner = cover(&uvs, &[[0, 1, 2]], 16);
    assert_eq!(owner.iter().filter(|&&t| t == 0).count(), 1);
}

#[test]
fn meshes_without_usable_uvs_get_an_atlas() {
    let mut mesh = sphere(6);
    assert!(!bake_solid(&mesh, &Noise, settings(), &()).unwrap().notes.is_empty());
    mesh.uvs = vec![[1.5, 0.0]; mesh.positions.len()];
    let baked = bake_solid(&mesh, &Noise, settings(), &()).unwrap();
    assert!(baked.notes[0].contains("outside 0 to 1"), "{:?}", baked.notes);
}

#[test]
fn vertices_take_the_colours_at_their_positions() {
    let mesh = cube();
    let settings = BakeSettings { filter: Filter::Nearest, resolution: 10, origin: [0; 3], ..settings() };
    let baked = bake_vertices(&mesh, &Noise, settings, &()).unwrap();
    let [r, g, b] = Noise::color([10, 0, 0]);
    assert_eq!(baked.colors[1], [r, g, b, 255]);
}

#[test]
fn surface_voxels_are_those_whose_cubes_meet_a_triangle() {
    let mesh = sphere(8);
    let space = Space::of_mesh(&mesh, 24, [-3, 0, 5]).unwrap();
    let set = surface_voxels(&mesh, &space, 0.0, &()).unwrap();
    // Any voxel with a point of the surface in it must be there.
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize].map(f64::from));
        for k in 0..64 {
            let (u, v) = (f64::from(k % 8) / 8.0, f64::from(k / 8) / 8.0);
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let p = std::array::from_fn(|i| a[i] + (b[i] - a[i]) * u + (c[i] - a[i]) * v);
            assert!(set.contains(space.to_voxels(p).map(|c| c.floor() as i32)));
        }
    }
    // None may be farther from the sphere than its own diagonal and the flatness of the triangles.
    for voxel in set.voxels() {
        let center = space.to_world(voxel.map(|c| f64::from(c) + 0.5));
        let radius = center.iter().map(|c| c * c).sum::<f64>().sqrt();
        assert!((radius - 1.0).abs() * space.voxels_per_unit < 1.4, "{voxel:?} at {radius}");
    }
    let thick = surface_voxels(&mesh, &space, 1.0, &()).unwrap();
    assert!(thick.len() > 2 * set.len() && set.voxels().all(|v| thick.contains(v)));
}

#[test]
fn impossible_bakes_are_refused() {
    let too_large = BakeSettings { texture_size: 1 << 20, ..settings() };
    assert!(matches!(bake_solid(&cube(), &Noise, too_large, &()), Err(BakeError::TextureSize(_))));
    assert!(matches!(bake_solid(&Mesh::default(), &Noise, settings(), &()), Err(BakeError::Space(_))));
    struct Cancel;
    impl Control for Cancel {
        fn is_cancelled(&self) -> bool {
            true
        }
    }
    assert!(matches!(bake_solid(&torus(8, 8), &Noise, settings(), &Cancel), Err(BakeError::Cancelled)));
    assert_eq!(
        surface_voxels(&cube(), &Space::of_mesh(&cube(), 9, [0; 3]).unwrap(), 0.0, &Cancel),
        Err(Cancelled.into())
    );
}
