//! Meshes and solids that the tests of this family share, and tests that cross its files.

mod baking;
mod cutting;
mod files;
mod unwrapping;

use breccia_engine::Digest;

use super::smooth_normals;
use crate::control::Control;
use crate::data::{Extent, Map, MapInfo, Mesh, SampleType, Samples, Solid, SolidError, VoxelMap, VoxelSet};

/// A cube from -1 to 1 of twelve triangles over eight shared vertices.
pub fn cube() -> Mesh {
    let positions = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|c| c as f32 * 2.0 - 1.0)).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { name: "cube".to_owned(), positions, triangles, ..Mesh::default() }
}

/// A grid of quads over two angles, joined to a ring in both (torus) with UVs on doubled seam vertices.
pub fn torus(around: u32, across: u32) -> Mesh {
    let mut mesh = Mesh { name: "torus".to_owned(), ..Mesh::default() };
    let angle = |i: u32, n: u32| f64::from(i % n) / f64::from(n) * std::f64::consts::TAU;
    for i in 0..=around {
        for j in 0..=across {
            let (a, b) = (angle(i, around), angle(j, across));
            let ring = 1.0 + 0.4 * libm::cos(b);
            mesh.positions
                .push([ring * libm::cos(a), 0.4 * libm::sin(b), ring * libm::sin(a)].map(|c| c as f32));
            mesh.uvs.push([i as f32 / around as f32, j as f32 / across as f32]);
        }
    }
    let at = |i: u32, j: u32| i * (across + 1) + j;
    for i in 0..around {
        for j in 0..across {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh.normals = smooth_normals(&mesh.positions, &mesh.triangles);
    mesh
}

/// A sphere of radius 1: the faces of a subdivided cube pushed out.
pub fn sphere(steps: u32) -> Mesh {
    let mut mesh = Mesh { name: "sphere".to_owned(), ..Mesh::default() };
    for face in 0..6u32 {
        let first = mesh.positions.len() as u32;
        for j in 0..=steps {
            for i in 0..=steps {
                // Symmetric, so that points on shared edges have the same bits in both faces.
                let [u, v] = [i, j].map(|k| (2.0 * f64::from(k) - f64::from(steps)) / f64::from(steps));
                let side = if face < 3 { 1.0 } else { -1.0 };
                let mut p = [0.0; 3];
                p[face as usize % 3] = side;
                p[(face as usize + 1) % 3] = u;
                p[(face as usize + 2) % 3] = v * side;
                let length = {
                    let mut squares = p.map(|c| c * c);
                    squares.sort_by(f64::total_cmp);
                    (squares[0] + squares[1] + squares[2]).sqrt()
                };
                mesh.positions.push(p.map(|c| (c / length) as f32));
            }
        }
        let at = |i: u32, j: u32| first + j * (steps + 1) + i;
        for j in 0..steps {
            for i in 0..steps {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    mesh
}

/// The enclosed volume by the divergence theorem.
pub fn volume(mesh: &Mesh) -> f64 {
    let signed = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize].map(f64::from));
        (a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0]))
            / 6.0
    };
    mesh.triangles.iter().map(signed).sum()
}

/// How many directed edges (by position) have no partner that runs the other way.
pub fn open_edges(mesh: &Mesh) -> usize {
    let key = |i: u32| mesh.positions[i as usize].map(|c| (c + 0.0).to_bits());
    let mut balance = std::collections::BTreeMap::new();
    for t in &mesh.triangles {
        for k in 0..3 {
            let (a, b) = (key(t[k]), key(t[(k + 1) % 3]));
            let (edge, step) = if a < b { ((a, b), 1i64) } else { ((b, a), -1) };
            *balance.entry(edge).or_insert(0) += step;
        }
    }
    balance.values().filter(|&&n| n != 0).count()
}

/// A solid whose samples are a hash of the voxel: colour, normal, roughness and labels.
pub struct Noise;

impl Noise {
    pub fn hash(voxel: [i32; 3]) -> u32 {
        voxel.iter().fold(0x9e37_79b9u32, |h, &c| {
            let h = (h ^ c as u32).wrapping_mul(0x85eb_ca6b);
            h ^ h >> 15
        })
    }
    pub fn color(voxel: [i32; 3]) -> [u8; 3] {
        let [r, g, b, _] = Self::hash(voxel).to_le_bytes();
        [r, g, b]
    }
}

impl Solid for Noise {
    fn maps(&self) -> Vec<MapInfo> {
        let map = |name: &str, channels, ty| MapInfo { name: name.to_owned(), channels, ty };
        vec![
            map("color", 3, SampleType::U8),
            map("normal", 3, SampleType::U8),
            map("roughness", 1, SampleType::F32),
            map("label", 1, SampleType::U32),
        ]
    }
    fn extent(&self) -> Extent {
        Extent::Unbounded
    }
    fn evaluate(&self, voxels: &VoxelSet, _: &dyn Control) -> Result<VoxelMap, SolidError> {
        let mut answer = VoxelMap::new(&voxels.bricks(), &self.maps());
        for voxel in voxels.voxels() {
            let Some(at) = answer.index(voxel) else { continue };
            let color = Self::color(voxel);
            for Map { name, channels, samples } in &mut answer.maps {
                match samples {
                    Samples::U8(v) => {
                        let pixel = if name == "color" { color } else { [128, 128, 255] };
                        v[at * *channels..(at + 1) * *channels].copy_from_slice(&pixel);
                    }
                    Samples::F32(v) => v[at] = f32::from(color[0]) / 255.0,
                    Samples::U32(v) => v[at] = 1,
                }
            }
        }
        Ok(answer)
    }
    fn digest(&self) -> Digest {
        Digest::of(b"noise")
    }
    fn summary(&self) -> String {
        "noise".to_owned()
    }
    fn byte_size(&self) -> u64 {
        0
    }
}
