//! A triangle mesh with optional normals, texture coordinates, vertex colours and texture maps.

use breccia_engine::{Data, Digest};

use super::{Image, Reader, Writer};

/// A triangle mesh. Optional per-vertex arrays are either empty or as long as `positions`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// The object's name, for files that keep one.
    pub name: String,
    /// Vertex positions in the units of the file it came from; y is up, as in glTF.
    pub positions: Vec<[f32; 3]>,
    /// Unit vertex normals, or empty.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates with the origin at the top left as in glTF, or empty.
    pub uvs: Vec<[f32; 2]>,
    /// Vertex colours in sRGB encoding and alpha, or empty.
    pub colors: Vec<[u8; 4]>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Texture maps by name (`color`, `normal`, `roughness`, …), laid out by `uvs`.
    pub textures: Vec<(String, Image)>,
    /// The bounding box that voxel space refers to where it is not the mesh's own: a part cut from a mesh
    /// keeps the box of the whole, so that one solid runs through all parts without a break.
    pub space_bounds: Option<([f32; 3], [f32; 3])>,
    /// What was repaired or left undone on the way here, one sentence each, for people to read.
    pub notes: Vec<String>,
}

impl Mesh {
    /// The smallest and the largest corner of the bounding box; `None` without vertices.
    pub fn bounds(&self) -> Option<([f32; 3], [f32; 3])> {
        let first = *self.positions.first()?;
        Some(self.positions.iter().fold((first, first), |(lo, hi), p| {
            (std::array::from_fn(|i| lo[i].min(p[i])), std::array::from_fn(|i| hi[i].max(p[i])))
        }))
    }

    /// The bounding box that voxel space refers to: that of the whole the mesh was cut from, or its own.
    pub fn voxel_bounds(&self) -> Option<([f32; 3], [f32; 3])> {
        self.space_bounds.or_else(|| self.bounds())
    }

    /// The texture of that name.
    pub fn texture(&self, name: &str) -> Option<&Image> {
        self.textures.iter().find(|(n, _)| n == name).map(|(_, image)| image)
    }
}

impl Data for Mesh {
    const TYPE: &'static str = "mesh";
    const DOCS: &'static str = "A triangle mesh with optional normals, UVs, vertex colours and textures.";

    fn byte_size(&self) -> u64 {
        let arrays = size_of_val(&self.positions[..])
            + size_of_val(&self.normals[..])
            + size_of_val(&self.uvs[..])
            + size_of_val(&self.colors[..])
            + size_of_val(&self.triangles[..]);
        arrays as u64 + self.textures.iter().map(|(_, image)| image.byte_size()).sum::<u64>()
    }

    fn summary(&self) -> String {
        let mut text = format!("{} vertices, {} triangles", self.positions.len(), self.triangles.len());
        if !self.uvs.is_empty() {
            text += ", UVs";
        }
        for (name, image) in &self.textures {
            text += &format!(", {name} {}", image.summary());
        }
        for note in &self.notes {
            text += &format!("; {note}");
        }
        text
    }

    fn digest(&self) -> Digest {
        // The encoded form is canonical: it has one byte sequence for one mesh.
        Digest::of(&encode(self))
    }

    fn encode(&self) -> Option<Vec<u8>> {
        Some(encode(self))
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = Reader::new(bytes);
        let mut mesh = Self {
            name: reader.text()?,
            positions: reader.array()?,
            normals: reader.array()?,
            uvs: reader.array()?,
            colors: reader.array()?,
            triangles: reader.array()?,
            ..Self::default()
        };
        for _ in 0..reader.u64()? {
            mesh.textures.push((reader.text()?, Image::decode(reader.bytes()?)?));
        }
        mesh.space_bounds = match reader.array::<[[f32; 3]; 2]>()?[..] {
            [] => None,
            [[lo, hi]] => Some((lo, hi)),
            _ => return Err("a mesh has more than one bounding box".to_owned()),
        };
        for _ in 0..reader.u64()? {
            mesh.notes.push(reader.text()?);
        }
        reader.end()?;
        Ok(mesh)
    }
}

fn encode(mesh: &Mesh) -> Vec<u8> {
    let mut out = Writer::new();
    out.text(&mesh.name).array(&mesh.positions).array(&mesh.normals).array(&mesh.uvs);
    out.array(&mesh.colors).array(&mesh.triangles).u64(mesh.textures.len() as u64);
    for (name, image) in &mesh.textures {
        out.text(name).bytes(&image.encode().unwrap_or_default());
    }
    let bounds: Vec<_> = mesh.space_bounds.iter().map(|&(lo, hi)| [lo, hi]).collect();
    out.array(&bounds).u64(mesh.notes.len() as u64);
    for note in &mesh.notes {
        out.text(note);
    }
    out.finish()
}
