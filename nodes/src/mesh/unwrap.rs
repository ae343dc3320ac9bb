//! Texture coordinates: the mesh's own where they can be baked into, else an atlas.
//!
//! The atlas is made by the crate `uvunwrap` (charts grown by normal, conformal and then as-rigid-as-possible
//! parameterisation, packing by shape). It is used without its SIMD solver, so that the atlas has the same
//! bits on every machine. Should it fail, every triangle becomes a chart of its own in a plain grid.

use std::panic::{AssertUnwindSafe, catch_unwind};

use uvunwrap::{Density, MeshInput, Options, generate};

use crate::data::Mesh;

/// How an atlas is laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnwrapSettings {
    /// Texels along a side of the texture the atlas is made for, 16 to 16384.
    pub texture_size: u32,
    /// Empty texels around each chart; two charts are at least twice as far apart.
    pub padding: u32,
    /// Largest angle in degrees between a triangle and its chart's mean, above 0 and below 90.
    pub max_angle: f32,
}

impl Default for UnwrapSettings {
    fn default() -> Self {
        Self { texture_size: 2048, padding: 4, max_angle: 70.0 }
    }
}

/// A mesh could not be unwrapped.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum UnwrapError {
    /// There is nothing to unwrap.
    #[error("the mesh has no triangles to unwrap")]
    Empty,
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names vertex {vertex} of {vertices}")]
    Index {
        /// The triangle.
        triangle: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
    /// The texture is too small for so many charts.
    #[error("a texture of {size} texels a side has no room for {triangles} triangles")]
    NoRoom {
        /// The texture's size.
        size: u32,
        /// How many triangles.
        triangles: usize,
    },
}

/// Why a mesh's own texture coordinates cannot be baked into; `None` if they can.
pub fn uv_problem(mesh: &Mesh) -> Option<&'static str> {
    if mesh.uvs.is_empty() {
        return Some("the mesh has no UVs");
    }
    if mesh.uvs.len() != mesh.positions.len() {
        return Some("the UVs are not as many as the vertices");
    }
    // Exporters round: a hair outside is as good as inside.
    if !mesh.uvs.iter().flatten().all(|c| (-1e-5..=1.0 + 1e-5).contains(c)) {
        return Some("UVs lie outside 0 to 1");
    }
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| mesh.uvs.get(i as usize).copied().unwrap_or_default());
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    mesh.triangles.iter().all(|t| area(t) == 0.0).then_some("the UVs of all triangles have no area")
}

/// The mesh with texture coordinates that can be baked into: its own, else an atlas, with a note saying so.
///
/// # Errors
/// As [`make_atlas`].
pub fn ensure_uvs(mesh: &Mesh, settings: UnwrapSettings) -> Result<Mesh, UnwrapError> {
    let Some(problem) = uv_problem(mesh) else { return Ok(mesh.clone()) };
    let mut unwrapped = make_atlas(mesh, settings)?;
    unwrapped.notes.push(format!("made a new atlas, since {problem}"));
    Ok(unwrapped)
}

/// The mesh with a new atlas: vertices at chart borders are doubled, textures laid out by the old
/// coordinates are dropped. No two triangles overlap.
///
/// # Errors
/// If there are no triangles, a triangle names a missing vertex, or the texture is too small.
pub fn make_atlas(mesh: &Mesh, settings: UnwrapSettings) -> Result<Mesh, UnwrapError> {
    if mesh.triangles.is_empty() {
        return Err(UnwrapError::Empty);
    }
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= mesh.positions.len()) {
            return Err(UnwrapError::Index { triangle, vertex, vertices: mesh.positions.len() });
        }
    }
    match charts(mesh, settings) {
        Some((sources, uvs, triangles)) => Ok(with_vertices(mesh, &sources, uvs, triangles)),
        None => grid(mesh, settings),
    }
}

type Layout = (Vec<u32>, Vec<[f32; 2]>, Vec<[u32; 3]>);

/// The atlas of `uvunwrap`, or `None` if it fails.
fn charts(mesh: &Mesh, settings: UnwrapSettings) -> Option<Layout> {
    let page_size = settings.texture_size.clamp(16, 1 << 14);
    let options = Options {
        density: Density::Auto { page_size },
        padding: settings.padding.min(page_size / 16),
        max_chart_angle: settings.max_angle.clamp(1.0, 89.0),
        ..Options::default()
    };
    let indices: &[u32] = bytemuck::cast_slice(&mesh.triangles);
    // The crate is young, and what it is given comes from files.
    let run = || generate(&[MeshInput::new(&mesh.positions, indices)], &options);
    let atlas = catch_unwind(AssertUnwindSafe(run)).ok()?.ok()?;
    let output = atlas.meshes.first()?;
    // A page is cropped to the rows in use; several pages become squares of one texture.
    let side = (1u32..).find(|s| s * s >= atlas.page_count)?;
    let scale =
        [atlas.width, atlas.height].map(|n| n as f32 / page_size.max(atlas.width).max(atlas.height) as f32);
    let uv = |vertex: &uvunwrap::OutputVertex| {
        let page = vertex.page.unwrap_or(0);
        let cell = [page % side, page / side];
        std::array::from_fn(|i| (vertex.uv[i] * scale[i] + cell[i] as f32) / side as f32)
    };
    let uvs: Vec<[f32; 2]> = output.vertices.iter().map(uv).collect();
    let sources: Vec<u32> = output.vertices.iter().map(|vertex| vertex.xref).collect();
    let triangles: Vec<[u32; 3]> = output.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    let sound = triangles.len() == mesh.triangles.len()
        && triangles.iter().flatten().all(|&i| (i as usize) < uvs.len())
        && sources.iter().all(|&i| (i as usize) < mesh.positions.len())
        && uvs.iter().flatten().all(|c| (0.0..=1.0).contains(c));
    sound.then_some((sources, uvs, triangles))
}

/// Every triangle as a chart of its own, two to a cell of a plain grid.
fn grid(mesh: &Mesh, settings: UnwrapSettings) -> Result<Mesh, UnwrapError> {
    let count = mesh.triangles.len();
    let size = settings.texture_size.clamp(16, 1 << 14);
    let side = (1u32..).find(|s| *s as usize * *s as usize * 2 >= count).unwrap_or(u32::MAX);
    let cell = 1.0 / side as f32;
    let texel = 1.0 / size as f32;
    if cell < 4.0 * texel {
        return Err(UnwrapError::NoRoom { size, triangles: count });
    }
    let margin = (settings.padding as f32 * texel).min(cell / 8.0);
    let (near, far, gap) = (margin, cell - margin, 2.0 * margin);
    let mut uvs = Vec::new();
    for i in 0..count as u32 {
        let origin = [(i / 2 % side) as f32 * cell, (i / 2 / side) as f32 * cell];
        let corners = if i % 2 == 0 {
            [[near, near], [far - gap, near], [near, far - gap]]
        } else {
            [[far, far], [near + gap, far], [far, near + gap]]
        };
        uvs.extend(corners.map(|c| [origin[0] + c[0], origin[1] + c[1]]));
    }
    let sources: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
    let triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mut out = with_vertices(mesh, &sources, uvs, triangles);
    out.notes
        .push("every triangle became a chart of its own, since no larger charts could be made".to_owned());
    Ok(out)
}

/// The mesh with new triangles over copies of its vertices.
fn with_vertices(mesh: &Mesh, sources: &[u32], uvs: Vec<[f32; 2]>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh {
        name: mesh.name.clone(),
        positions: pick(&mesh.positions, sources),
        normals: pick(&mesh.normals, sources),
        colors: pick(&mesh.colors, sources),
        uvs,
        triangles,
        textures: Vec::new(),
        space_bounds: mesh.space_bounds,
        notes: mesh.notes.clone(),
    }
}

/// The picked entries, or nothing if one is missing.
fn pick<T: Copy>(items: &[T], sources: &[u32]) -> Vec<T> {
    sources.iter().map(|&i| items.get(i as usize).copied()).collect::<Option<_>>().unwrap_or_default()
}
