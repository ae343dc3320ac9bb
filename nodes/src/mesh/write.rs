//! The exporters of meshes, and what their formats share.

use std::io;
use std::sync::Arc;

use breccia_engine::{Data, Exporter, Sink, Value};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};

use super::{write_glb, write_obj, write_ply};
use crate::data::{Image, Mesh, Samples, linear_to_srgb};

/// GLB, OBJ and PLY.
pub(super) fn exporters() -> Vec<Exporter> {
    vec![
        Exporter {
            ty: Mesh::TYPE,
            extensions: &["glb"],
            docs: "Binary glTF 2.0 with textures embedded as PNG",
            write: |value, sink| {
                let bytes = write_glb::encode(&*mesh(value)?).map_err(invalid)?;
                io::Write::write_all(&mut sink.main()?, &bytes)
            },
        },
        Exporter {
            ty: Mesh::TYPE,
            extensions: &["obj"],
            docs: "Wavefront OBJ, with NAME.mtl and a NAME_MAP.png for each texture beside it",
            write: |value, sink| write_obj::write(&*mesh(value)?, sink),
        },
        Exporter {
            ty: Mesh::TYPE,
            extensions: &["ply"],
            docs: "Binary PLY with normals, UVs and vertex colours, without textures",
            write: |value, sink: &mut Sink| write_ply::write(&*mesh(value)?, &mut sink.main()?),
        },
    ]
}

fn mesh(value: &Value) -> io::Result<Arc<Mesh>> {
    let mesh = value
        .downcast::<Mesh>()
        .ok_or_else(|| invalid(format!("a value of type {} is not a mesh", value.type_name())))?;
    check(&mesh).map_err(invalid)?;
    Ok(mesh)
}

pub(super) fn invalid(problem: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, problem.into())
}

/// Checks that a mesh's arrays fit together and that its numbers are finite.
pub(super) fn check(mesh: &Mesh) -> Result<(), String> {
    let vertices = mesh.positions.len();
    if vertices == 0 || mesh.triangles.is_empty() {
        return Err("the mesh is empty, so there is nothing to write".to_owned());
    }
    if vertices > i32::MAX as usize {
        return Err(format!("{vertices} vertices are more than the format can number"));
    }
    for (what, found) in
        [("normals", mesh.normals.len()), ("UVs", mesh.uvs.len()), ("colours", mesh.colors.len())]
    {
        if found != 0 && found != vertices {
            return Err(format!("the mesh has {found} {what} for {vertices} vertices"));
        }
    }
    if let Some(index) = mesh.triangles.iter().flatten().find(|&&i| i as usize >= vertices) {
        return Err(format!("a triangle names vertex {index} of {vertices}"));
    }
    let numbers = mesh.positions.iter().flatten().chain(mesh.uvs.iter().flatten());
    if numbers.chain(mesh.normals.iter().flatten()).any(|c| !c.is_finite()) {
        return Err("the mesh holds numbers that are not finite".to_owned());
    }
    Ok(())
}

/// A name with nothing in it that a file system or a text format could trip over.
pub(super) fn sanitize(name: &str) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '_' };
    let name: String = name.chars().map(safe).take(100).collect();
    if name.trim_matches(['.', '_']).is_empty() { "mesh".to_owned() } else { name }
}

/// A texture as 8-bit PNG. Float colours are linear and become sRGB; other floats are fractions.
pub(super) fn encode_png(name: &str, image: &Image) -> Result<Vec<u8>, String> {
    let bytes: Vec<u8> = match image.samples() {
        Samples::U8(bytes) => bytes.clone(),
        Samples::F32(linear) if name == "color" => {
            let channels = image.channels();
            let has_alpha = channels.is_multiple_of(2);
            let encode = |(i, &v): (usize, &f32)| {
                if has_alpha && i % channels == channels - 1 {
                    (v * 255.0 + 0.5).clamp(0.0, 255.0) as u8
                } else {
                    linear_to_srgb(v)
                }
            };
            linear.iter().enumerate().map(encode).collect()
        }
        other => (0..other.len()).map(|i| other.get_u8(i)).collect(),
    };
    png(&bytes, image.width(), image.height(), image.channels())
}

/// Bytes as PNG of one to four channels.
pub(super) fn png(bytes: &[u8], width: u32, height: u32, channels: usize) -> Result<Vec<u8>, String> {
    let color = match channels {
        1 => ExtendedColorType::L8,
        2 => ExtendedColorType::La8,
        3 => ExtendedColorType::Rgb8,
        _ => ExtendedColorType::Rgba8,
    };
    let mut out = Vec::new();
    PngEncoder::new(&mut out).write_image(bytes, width, height, color).map_err(|error| error.to_string())?;
    Ok(out)
}

/// A normal at unit length; one without direction points up.
pub(super) fn unit_normal(normal: [f32; 3]) -> [f32; 3] {
    super::vector::unit(normal.map(f64::from)).map_or([0.0, 1.0, 0.0], |n| n.map(|c| c as f32))
}
