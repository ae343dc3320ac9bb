//! Wavefront OBJ, its material file, and its textures.

use std::io::{self, Write};

use breccia_engine::Sink;

use super::write::{encode_png, invalid, sanitize, unit_normal};
use crate::data::Mesh;

/// Writes NAME.obj, and if there are textures NAME.mtl and a NAME_MAP.png for each of them.
pub(super) fn write(mesh: &Mesh, sink: &mut Sink) -> io::Result<()> {
    let stem = sanitize(&sink.stem());
    let textured = !mesh.textures.is_empty() && !mesh.uvs.is_empty();
    let mut out = sink.main()?;
    writeln!(out, "# breccia")?;
    if textured {
        writeln!(out, "mtllib {stem}.mtl")?;
    }
    writeln!(out, "o {}", sanitize(&mesh.name))?;
    for (i, [x, y, z]) in mesh.positions.iter().enumerate() {
        write!(out, "v {x} {y} {z}")?;
        if let Some(&[r, g, b, _]) = mesh.colors.get(i) {
            let [r, g, b] = [r, g, b].map(|c| f32::from(c) / 255.0);
            write!(out, " {r} {g} {b}")?;
        }
        writeln!(out)?;
    }
    for [u, v] in &mesh.uvs {
        writeln!(out, "vt {u} {}", 1.0 - v)?;
    }
    for [x, y, z] in mesh.normals.iter().map(|&n| unit_normal(n)) {
        writeln!(out, "vn {x} {y} {z}")?;
    }
    if textured {
        writeln!(out, "usemtl solid")?;
    }
    for triangle in &mesh.triangles {
        write!(out, "f")?;
        for &corner in triangle {
            let i = corner + 1;
            match (mesh.uvs.is_empty(), mesh.normals.is_empty()) {
                (true, true) => write!(out, " {i}")?,
                (true, false) => write!(out, " {i}//{i}")?,
                (false, true) => write!(out, " {i}/{i}")?,
                (false, false) => write!(out, " {i}/{i}/{i}")?,
            }
        }
        writeln!(out)?;
    }
    out.flush()?;
    if textured { write_material(mesh, &stem, sink) } else { Ok(()) }
}

fn write_material(mesh: &Mesh, stem: &str, sink: &mut Sink) -> io::Result<()> {
    let mut material = String::from("newmtl solid\nKd 1 1 1\nKs 0 0 0\n");
    let mut names: Vec<String> = Vec::new();
    for (name, image) in &mesh.textures {
        let mut file = format!("{stem}_{}.png", sanitize(name));
        if names.contains(&file) {
            file = format!("{stem}_{}_{}.png", sanitize(name), names.len());
        }
        let statement = match name.as_str() {
            "color" => "map_Kd",
            "normal" => "norm",
            "roughness" => "map_Pr",
            "metallic" => "map_Pm",
            "occlusion" => "map_Ka",
            "height" => "disp",
            _ => "#",
        };
        material += &format!("{statement} {file}\n");
        let mut out = sink.file(&file)?;
        out.write_all(&encode_png(name, image).map_err(invalid)?)?;
        out.flush()?;
        names.push(file);
    }
    let mut out = sink.file(&format!("{stem}.mtl"))?;
    out.write_all(material.as_bytes())?;
    out.flush()
}
