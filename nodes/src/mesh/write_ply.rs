//! PLY, binary little-endian.

use std::io::{self, Write};

use super::write::unit_normal;
use crate::data::Mesh;

/// Writes positions, and normals, UVs and colours where there are some.
pub(super) fn write(mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "ply\nformat binary_little_endian 1.0\ncomment breccia")?;
    writeln!(out, "element vertex {}", mesh.positions.len())?;
    let mut declare = |present: bool, ty: &str, names: &[&str]| {
        names.iter().filter(|_| present).try_for_each(|name| writeln!(out, "property {ty} {name}"))
    };
    declare(true, "float", &["x", "y", "z"])?;
    declare(!mesh.normals.is_empty(), "float", &["nx", "ny", "nz"])?;
    declare(!mesh.uvs.is_empty(), "float", &["s", "t"])?;
    declare(!mesh.colors.is_empty(), "uchar", &["red", "green", "blue", "alpha"])?;
    writeln!(
        out,
        "element face {}\nproperty list uchar int vertex_indices\nend_header",
        mesh.triangles.len()
    )?;
    for (i, position) in mesh.positions.iter().enumerate() {
        out.write_all(&floats(position))?;
        if let Some(&normal) = mesh.normals.get(i) {
            out.write_all(&floats(&unit_normal(normal)))?;
        }
        if let Some([u, v]) = mesh.uvs.get(i) {
            out.write_all(&floats(&[*u, 1.0 - v]))?;
        }
        if let Some(color) = mesh.colors.get(i) {
            out.write_all(color)?;
        }
    }
    for triangle in &mesh.triangles {
        out.write_all(&[3])?;
        triangle.iter().try_for_each(|corner| out.write_all(&corner.to_le_bytes()))?;
    }
    out.flush()
}

fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}
