//! glTF 2.0: GLB, and JSON with embedded buffers. Accessors are read with checked arithmetic, since the
//! crate's own readers trust offsets and counts.

use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;
use gltf::{Accessor, Gltf, Semantic};

use super::read::MeshError;
use crate::data::{Mesh, linear_to_srgb};

fn error(place: impl Into<String>, problem: impl Into<String>) -> MeshError {
    MeshError::syntax("glTF", place, problem)
}

/// A mesh of all primitives of the default scene (or of all nodes where there is none).
pub(super) fn read(bytes: &[u8]) -> Result<Mesh, MeshError> {
    // A total length shorter than the header itself would underflow in the crate.
    if bytes.starts_with(b"glTF") && bytes.get(8..12).is_none_or(|n| n[0] < 12 && n[1..] == [0; 3]) {
        return Err(error("header", "the file is cut short"));
    }
    let (document, mut blob) = parse(bytes)?;
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let place = format!("buffer {}", buffer.index());
        if let gltf::buffer::Source::Uri(uri) = buffer.source()
            && !uri.starts_with("data:")
        {
            let shown: String = uri.chars().take(80).collect();
            let problem = format!("its data lies in another file, `{shown}`; save as GLB instead");
            return Err(error(place, problem));
        }
        let data = gltf::buffer::Data::from_source_and_blob(buffer.source(), None, &mut blob)
            .map_err(|e| error(&place, e.to_string()))?;
        if data.len() < buffer.length() {
            return Err(error(place, format!("{} bytes found, {} expected", data.len(), buffer.length())));
        }
        buffers.push(data.0);
    }
    let mut mesh = Mesh::default();
    let mut attributes = Present::default();
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let mut pending: Vec<(gltf::Node<'_>, [[f64; 4]; 4])> = match &scene {
        Some(scene) => scene.nodes().map(|node| (node, IDENTITY)).collect(),
        None => document.nodes().map(|node| (node, IDENTITY)).collect(),
    };
    pending.reverse();
    // A node stands in one place only; this also ends circles.
    let mut seen = vec![false; document.nodes().len()];
    while let Some((node, parent)) = pending.pop() {
        match seen.get_mut(node.index()) {
            Some(seen) if !*seen => *seen = true,
            _ => continue,
        }
        let matrix = multiply(&parent, &node.transform().matrix().map(|column| column.map(f64::from)));
        if let Some(part) = node.mesh() {
            if mesh.name.is_empty() {
                mesh.name = part.name().or(node.name()).unwrap_or_default().to_owned();
            }
            for primitive in part.primitives() {
                add_primitive(&mut mesh, &mut attributes, &primitive, &matrix, &buffers).map_err(
                    |problem| {
                        error(format!("mesh {}, primitive {}", part.index(), primitive.index()), problem)
                    },
                )?;
            }
        }
        let mut children: Vec<_> = node.children().map(|child| (child, matrix)).collect();
        children.reverse();
        pending.append(&mut children);
    }
    attributes.settle(&mut mesh);
    Ok(mesh)
}

/// The validated document and its binary chunk.
fn parse(bytes: &[u8]) -> Result<(gltf::Document, Option<Vec<u8>>), MeshError> {
    let invalid = |e: gltf::Error| error("document", e.to_string());
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(invalid)?;
    let root = document.into_json();
    // The crate's validation looks positions up before it checks that they are there.
    let accessors = root.accessors.len();
    for (number, mesh) in root.meshes.iter().enumerate() {
        let indices = mesh.primitives.iter().flat_map(|primitive| primitive.attributes.values());
        if let Some(index) = indices.map(|index| index.value()).find(|&index| index >= accessors) {
            let problem = format!("an attribute names accessor {index}, but there are {accessors}");
            return Err(error(format!("mesh {number}"), problem));
        }
    }
    Ok((gltf::Document::from_json(root).map_err(invalid)?, blob))
}

const IDENTITY: [[f64; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// The product of two matrices of columns.
fn multiply(a: &[[f64; 4]; 4], b: &[[f64; 4]; 4]) -> [[f64; 4]; 4] {
    std::array::from_fn(|column| std::array::from_fn(|row| (0..4).map(|k| a[k][row] * b[column][k]).sum()))
}

/// How many primitives carry an attribute; attributes that only some have are left out.
#[derive(Default)]
struct Present {
    primitives: usize,
    normals: usize,
    uvs: usize,
    colors: usize,
}

impl Present {
    fn settle(&self, mesh: &mut Mesh) {
        if self.normals < self.primitives {
            mesh.normals.clear();
        }
        if self.uvs < self.primitives {
            mesh.uvs.clear();
        }
        if self.colors < self.primitives {
            mesh.colors.clear();
        }
        if self.uvs > 0 && mesh.uvs.is_empty() {
            mesh.notes.push("left out the UVs, since some parts have none".to_owned());
        }
    }
}

fn add_primitive(
    mesh: &mut Mesh,
    present: &mut Present,
    primitive: &gltf::Primitive<'_>,
    matrix: &[[f64; 4]; 4],
    buffers: &[Vec<u8>],
) -> Result<(), String> {
    if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        return Ok(());
    }
    let attribute = |semantic: &Semantic| primitive.get(semantic);
    let positions = attribute(&Semantic::Positions).ok_or("it has no POSITION")?;
    let positions: Vec<[f32; 3]> = read_accessor(&positions, buffers)?;
    let count = positions.len();
    let first = u32::try_from(mesh.positions.len()).map_err(|_| "too many vertices")?;
    let sized = |what: &str, found: usize| {
        if found == count { Ok(()) } else { Err(format!("{found} {what} for {count} vertices")) }
    };
    present.primitives += 1;
    if let Some(normals) = attribute(&Semantic::Normals) {
        let normals: Vec<[f32; 3]> = read_accessor(&normals, buffers)?;
        sized("normals", normals.len())?;
        mesh.normals.extend(normals.iter().map(|n| transform_normal(matrix, *n)));
        present.normals += 1;
    }
    if let Some(uvs) = attribute(&Semantic::TexCoords(0)) {
        let uvs: Vec<[f32; 2]> = read_accessor(&uvs, buffers)?;
        sized("UVs", uvs.len())?;
        mesh.uvs.extend(uvs);
        present.uvs += 1;
    }
    if let Some(colors) = attribute(&Semantic::Colors(0)) {
        let rgba: Vec<[f32; 4]> = match colors.dimensions() {
            Dimensions::Vec3 => {
                read_accessor::<3>(&colors, buffers)?.iter().map(|c| [c[0], c[1], c[2], 1.0]).collect()
            }
            _ => read_accessor(&colors, buffers)?,
        };
        sized("colours", rgba.len())?;
        mesh.colors.extend(rgba.iter().map(|&[r, g, b, a]| {
            [
                linear_to_srgb(r),
                linear_to_srgb(g),
                linear_to_srgb(b),
                (a * 255.0 + 0.5).clamp(0.0, 255.0) as u8,
            ]
        }));
        present.colors += 1;
    }
    mesh.positions.extend(positions.iter().map(|p| transform_point(matrix, *p)));
    let indices: Vec<u32> = match primitive.indices() {
        Some(accessor) => read_indices(&accessor, buffers)?,
        None => (0..count as u32).collect(),
    };
    if let Some(&index) = indices.iter().find(|&&i| i as usize >= count) {
        return Err(format!("an index names vertex {index} of {count}"));
    }
    let mirrored = determinant(matrix) < 0.0;
    let mut add = |a: u32, b: u32, c: u32| {
        let (b, c) = if mirrored { (c, b) } else { (b, c) };
        mesh.triangles.push([a + first, b + first, c + first]);
    };
    match primitive.mode() {
        Mode::TriangleStrip => indices
            .windows(3)
            .enumerate()
            .for_each(|(i, t)| if i % 2 == 0 { add(t[0], t[1], t[2]) } else { add(t[1], t[0], t[2]) }),
        Mode::TriangleFan => {
            if let Some((&hub, rim)) = indices.split_first() {
                rim.windows(2).for_each(|t| add(hub, t[0], t[1]));
            }
        }
        _ => indices.chunks_exact(3).for_each(|t| add(t[0], t[1], t[2])),
    }
    Ok(())
}

fn transform_point(m: &[[f64; 4]; 4], p: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = p.map(f64::from);
    std::array::from_fn(|i| (m[0][i] * x + m[1][i] * y + m[2][i] * z + m[3][i]) as f32)
}

/// Normals go by the cofactor matrix, the inverse transpose up to a positive or negative factor.
fn transform_normal(m: &[[f64; 4]; 4], n: [f32; 3]) -> [f32; 3] {
    let n = n.map(f64::from);
    let cofactor = |c: usize, r: usize| {
        let (c1, c2, r1, r2) = ((c + 1) % 3, (c + 2) % 3, (r + 1) % 3, (r + 2) % 3);
        m[c1][r1] * m[c2][r2] - m[c1][r2] * m[c2][r1]
    };
    let sign = if determinant(m) < 0.0 { -1.0 } else { 1.0 };
    let out: [f64; 3] = std::array::from_fn(|r| sign * (0..3).map(|c| cofactor(c, r) * n[c]).sum::<f64>());
    let length = (out[0] * out[0] + out[1] * out[1] + out[2] * out[2]).sqrt();
    out.map(|c| (c / length) as f32)
}

fn determinant(m: &[[f64; 4]; 4]) -> f64 {
    m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[1][0] * (m[0][1] * m[2][2] - m[0][2] * m[2][1])
        + m[2][0] * (m[0][1] * m[1][2] - m[0][2] * m[1][1])
}

/// The bytes of each item of an accessor.
fn items<'a>(
    accessor: &Accessor<'_>,
    buffers: &'a [Vec<u8>],
    item: usize,
) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, String> {
    let place = format!("accessor {}", accessor.index());
    if accessor.sparse().is_some() {
        return Err(format!("{place} is sparse, which is not supported"));
    }
    let view = accessor.view().ok_or(format!("{place} has no buffer view"))?;
    let outside = || format!("{place} reaches beyond its buffer");
    let buffer = buffers.get(view.buffer().index()).ok_or_else(outside)?;
    let view_end = view.offset().checked_add(view.length()).ok_or_else(outside)?;
    let data = buffer.get(view.offset()..view_end).ok_or_else(outside)?;
    let data = data.get(accessor.offset()..).ok_or_else(outside)?;
    let stride = view.stride().unwrap_or(item).max(1);
    let count = accessor.count();
    let last = count.saturating_sub(1).checked_mul(stride).and_then(|n| n.checked_add(item));
    if count > 0 && last.is_none_or(|last| last > data.len()) {
        return Err(outside());
    }
    Ok((0..count).filter_map(move |i| data.get(i * stride..i * stride + item)))
}

/// Vectors of `N` numbers; whole numbers count as fractions of their range.
fn read_accessor<const N: usize>(
    accessor: &Accessor<'_>,
    buffers: &[Vec<u8>],
) -> Result<Vec<[f32; N]>, String> {
    if accessor.dimensions().multiplicity() != N {
        return Err(format!(
            "accessor {} holds {:?}, expected {N} numbers",
            accessor.index(),
            accessor.dimensions()
        ));
    }
    let ty = accessor.data_type();
    let size = ty.size();
    let number = |b: &[u8]| match (ty, b) {
        (DataType::F32, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
        (DataType::U32, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]) as f32,
        (DataType::U16, &[a, b]) => f32::from(u16::from_le_bytes([a, b])) / 65535.0,
        (DataType::I16, &[a, b]) => (f32::from(i16::from_le_bytes([a, b])) / 32767.0).max(-1.0),
        (DataType::U8, &[a]) => f32::from(a) / 255.0,
        (DataType::I8, &[a]) => (f32::from(a as i8) / 127.0).max(-1.0),
        _ => 0.0,
    };
    let read =
        |bytes: &[u8]| std::array::from_fn(|i| bytes.get(i * size..(i + 1) * size).map_or(0.0, number));
    Ok(items(accessor, buffers, N * size)?.map(read).collect())
}

fn read_indices(accessor: &Accessor<'_>, buffers: &[Vec<u8>]) -> Result<Vec<u32>, String> {
    if accessor.dimensions() != Dimensions::Scalar {
        return Err(format!("accessor {} of indices is not scalar", accessor.index()));
    }
    let read = |b: &[u8]| match *b {
        [a] => u32::from(a),
        [a, b] => u32::from(u16::from_le_bytes([a, b])),
        [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
        _ => u32::MAX,
    };
    match accessor.data_type() {
        DataType::U8 | DataType::U16 | DataType::U32 => {
            Ok(items(accessor, buffers, accessor.data_type().size())?.map(read).collect())
        }
        other => Err(format!("accessor {} of indices holds {other:?}, not whole numbers", accessor.index())),
    }
}
