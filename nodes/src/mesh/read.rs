//! Meshes from files: the choice of format, and what holds for all of them.

use rustc_hash::FxHashMap;

use super::vector::{Vec3, cross, dot, sub, unit};
use super::{read_gltf, read_obj, read_ply};
use crate::data::Mesh;

/// Extensions that can be read, in lower case.
pub const EXTENSIONS: &[&str] = &["obj", "glb", "gltf", "ply"];

/// Why a file holds no usable mesh. The text names line, face, element or accessor.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshError {
    /// The format is not known.
    #[error("cannot read a mesh with extension `{0}`, expected one of obj, glb, gltf, ply")]
    Extension(String),
    /// The file's syntax is broken.
    #[error("{format}, {place}: {problem}")]
    Syntax {
        /// The format.
        format: &'static str,
        /// The line, element or object.
        place: String,
        /// What is wrong there.
        problem: String,
    },
    /// There is nothing to show.
    #[error("the file holds no triangles{0}")]
    NoFaces(String),
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names vertex {vertex}, but there are {vertices}")]
    Index {
        /// The triangle, counted from 0.
        triangle: usize,
        /// The vertex it names, counted from 0.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
    /// A number is NaN or infinite.
    #[error("the {what} of vertex {vertex} is not finite: {value}")]
    NotFinite {
        /// `position` or `UV`.
        what: &'static str,
        /// The vertex, counted from 0.
        vertex: usize,
        /// What was found.
        value: String,
    },
    /// A vertex attribute has another length than there are vertices.
    #[error("{found} {what}s for {vertices} vertices")]
    Length {
        /// `UV`, `normal` or `colour`.
        what: &'static str,
        /// How many were found.
        found: usize,
        /// How many vertices there are.
        vertices: usize,
    },
}

impl MeshError {
    pub(super) fn syntax(format: &'static str, place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Syntax { format, place: place.into(), problem: problem.into() }
    }
}

/// A mesh from the bytes of a file: OBJ, GLB, glTF with embedded buffers, or PLY by extension.
///
/// Polygons are triangulated as fans, glTF's node transforms applied and all objects merged; materials and
/// textures are left out. Texture coordinates are turned to glTF's top-left origin. Degenerate triangles
/// are dropped, with a note in [`Mesh::notes`]. Missing normals are computed. Meshes that are not manifold
/// or not closed are accepted.
///
/// # Errors
/// See [`MeshError`].
pub fn decode_mesh(bytes: &[u8], extension: &str) -> Result<Mesh, MeshError> {
    let mesh = match extension.to_lowercase().as_str() {
        "obj" => read_obj::read(bytes)?,
        "glb" | "gltf" => read_gltf::read(bytes)?,
        "ply" => read_ply::read(bytes)?,
        other => return Err(MeshError::Extension(other.to_owned())),
    };
    finish(mesh)
}

/// Checks what readers deliver, drops degenerate triangles, computes missing normals.
fn finish(mut mesh: Mesh) -> Result<Mesh, MeshError> {
    let vertices = mesh.positions.len();
    let not_finite = |what, vertex: usize, value: &[f32]| {
        Err(MeshError::NotFinite { what, vertex, value: format!("{value:?}") })
    };
    if let Some((i, p)) = mesh.positions.iter().enumerate().find(|(_, p)| !p.iter().all(|c| c.is_finite())) {
        return not_finite("position", i, p);
    }
    for (what, found) in
        [("UV", mesh.uvs.len()), ("normal", mesh.normals.len()), ("colour", mesh.colors.len())]
    {
        if found != 0 && found != vertices {
            return Err(MeshError::Length { what, found, vertices });
        }
    }
    if let Some((i, uv)) = mesh.uvs.iter().enumerate().find(|(_, uv)| !uv.iter().all(|c| c.is_finite())) {
        return not_finite("UV", i, uv);
    }
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices) {
            return Err(MeshError::Index { triangle, vertex, vertices });
        }
    }
    let before = mesh.triangles.len();
    let positions = &mesh.positions;
    mesh.triangles.retain(|t| !is_degenerate(t.map(|v| positions[v as usize])));
    let dropped = before - mesh.triangles.len();
    if mesh.triangles.is_empty() {
        let cause = if dropped > 0 { format!(": all {dropped} are degenerate") } else { String::new() };
        return Err(MeshError::NoFaces(cause));
    }
    if dropped > 0 {
        mesh.notes.push(format!("dropped {dropped} degenerate triangles"));
    }
    complete_normals(&mut mesh);
    Ok(mesh)
}

/// Whether a triangle has no area to speak of (an angle whose sine is below 10⁻⁹, or a side of no length).
fn is_degenerate(corners: [[f32; 3]; 3]) -> bool {
    let [a, b, c] = corners.map(|p| p.map(f64::from));
    let (u, v) = (sub(b, a), sub(c, a));
    let n = cross(u, v);
    dot(n, n) <= 1e-18 * dot(u, u) * dot(v, v)
}

fn unit32(v: Vec3) -> Option<[f32; 3]> {
    Some(unit(v)?.map(|c| c as f32))
}

/// Gives normals unit length, and vertices without a usable one that of the surface.
fn complete_normals(mesh: &mut Mesh) {
    let given: Vec<Option<[f32; 3]>> = mesh.normals.iter().map(|n| unit32(n.map(f64::from))).collect();
    if !given.is_empty() && given.iter().all(Option::is_some) {
        mesh.normals = given.into_iter().flatten().collect();
        return;
    }
    let computed = smooth_normals(&mesh.positions, &mesh.triangles);
    let pick = |(i, normal)| given.get(i).copied().flatten().unwrap_or(normal);
    mesh.normals = computed.into_iter().enumerate().map(pick).collect();
}

/// Vertex normals weighted by the triangles' angles; vertices at one position share theirs.
pub fn smooth_normals(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut groups = FxHashMap::default();
    let mut group_of = Vec::with_capacity(positions.len());
    for position in positions {
        let next = groups.len();
        // Adding zero makes minus zero plus zero.
        group_of.push(*groups.entry(position.map(|c| (c + 0.0).to_bits())).or_insert(next));
    }
    let mut sums = vec![[0.0; 3]; groups.len()];
    for triangle in triangles {
        let Some(corners) = corners(positions, triangle) else { continue };
        for k in 0..3 {
            let (at, next, last) = (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
            let (u, v) = (sub(next, at), sub(last, at));
            let lengths = (dot(u, u) * dot(v, v)).sqrt();
            let (Some(normal), true) = (unit32(cross(u, v)), lengths > 0.0) else { continue };
            let angle = libm::acos((dot(u, v) / lengths).clamp(-1.0, 1.0));
            let sum = &mut sums[group_of[triangle[k] as usize]];
            (0..3).for_each(|i| sum[i] += f64::from(normal[i]) * angle);
        }
    }
    group_of.iter().map(|&group| unit32(sums[group]).unwrap_or([0.0, 1.0, 0.0])).collect()
}

fn corners(positions: &[[f32; 3]], triangle: &[u32; 3]) -> Option<[[f64; 3]; 3]> {
    let mut out = [[0.0; 3]; 3];
    for (out, &i) in out.iter_mut().zip(triangle) {
        *out = positions.get(i as usize)?.map(f64::from);
    }
    Some(out)
}
