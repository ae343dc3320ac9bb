//! GLB: one mesh, one material, textures embedded as PNG.

use std::collections::BTreeMap;

use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::buffer::{Target, View};
use gltf_json::image::MimeType;
use gltf_json::material::{
    NormalTexture, OcclusionTexture, PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor,
};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::texture::{Info, MagFilter, MinFilter, Sampler, WrappingMode};
use gltf_json::validation::Checked::Valid;
use gltf_json::validation::USize64;
use gltf_json::{
    Accessor, Asset, Buffer, Image as GltfImage, Index, Material, Mesh as GltfMesh, Node, Root, Scene,
    Texture,
};
use serde_json::json;

use super::write::{check, encode_png, png, sanitize, unit_normal};
use crate::data::{Image, Mesh, srgb_to_linear};

/// The bytes of a GLB file. `color`, `normal`, `roughness`, `metallic` and `occlusion` join the material;
/// other textures are embedded as images of their name.
///
/// # Errors
/// If the mesh's arrays do not fit together, or the file would exceed the format's 4 GiB.
pub fn encode(mesh: &Mesh) -> Result<Vec<u8>, String> {
    check(mesh)?;
    let mut file = File::default();
    file.root.asset = Asset { generator: Some("breccia".to_owned()), ..Asset::default() };
    let mut attributes = BTreeMap::new();
    let (lo, hi) = mesh.bounds().unwrap_or_default();
    let positions = file.accessor(
        bytemuck::cast_slice(&mesh.positions),
        mesh.positions.len(),
        ComponentType::F32,
        Type::Vec3,
        Some(Target::ArrayBuffer),
    );
    if let Some(accessor) = file.root.accessors.get_mut(positions.value()) {
        accessor.min = Some(json!(lo));
        accessor.max = Some(json!(hi));
    }
    attributes.insert(Valid(Semantic::Positions), positions);
    if !mesh.normals.is_empty() {
        let normals: Vec<[f32; 3]> = mesh.normals.iter().map(|&n| unit_normal(n)).collect();
        let index = file.accessor(
            bytemuck::cast_slice(&normals),
            normals.len(),
            ComponentType::F32,
            Type::Vec3,
            Some(Target::ArrayBuffer),
        );
        attributes.insert(Valid(Semantic::Normals), index);
    }
    if !mesh.uvs.is_empty() {
        let index = file.accessor(
            bytemuck::cast_slice(&mesh.uvs),
            mesh.uvs.len(),
            ComponentType::F32,
            Type::Vec2,
            Some(Target::ArrayBuffer),
        );
        attributes.insert(Valid(Semantic::TexCoords(0)), index);
    }
    if !mesh.colors.is_empty() {
        // Linear in glTF; sixteen bits keep the dark shades apart.
        let wide = |fraction: f32| (fraction * 65535.0 + 0.5) as u16;
        let linear = |&[r, g, b, a]: &[u8; 4]| {
            [wide(srgb_to_linear(r)), wide(srgb_to_linear(g)), wide(srgb_to_linear(b)), u16::from(a) * 257]
        };
        let colors: Vec<[u16; 4]> = mesh.colors.iter().map(linear).collect();
        let index = file.accessor(
            bytemuck::cast_slice(&colors),
            colors.len(),
            ComponentType::U16,
            Type::Vec4,
            Some(Target::ArrayBuffer),
        );
        if let Some(accessor) = file.root.accessors.get_mut(index.value()) {
            accessor.normalized = true;
        }
        attributes.insert(Valid(Semantic::Colors(0)), index);
    }
    let indices = file.accessor(
        bytemuck::cast_slice(&mesh.triangles),
        mesh.triangles.len() * 3,
        ComponentType::U32,
        Type::Scalar,
        Some(Target::ElementArrayBuffer),
    );
    let material = file.material(mesh)?;
    let material = file.root.push(material);
    let primitive = Primitive {
        attributes,
        extensions: None,
        extras: Default::default(),
        indices: Some(indices),
        material: Some(material),
        mode: Valid(Mode::Triangles),
        targets: None,
    };
    let name = Some(sanitize(&mesh.name));
    let index = file.root.push(GltfMesh {
        extensions: None,
        extras: Default::default(),
        name: name.clone(),
        primitives: vec![primitive],
        weights: None,
    });
    let node = file.root.push(Node { mesh: Some(index), name, ..Node::default() });
    let scene =
        file.root.push(Scene { extensions: None, extras: Default::default(), name: None, nodes: vec![node] });
    file.root.scene = Some(scene);
    file.finish()
}

/// The document and its binary chunk while they are written.
#[derive(Default)]
struct File {
    root: Root,
    bin: Vec<u8>,
}

impl File {
    fn view(&mut self, bytes: &[u8], target: Option<Target>) -> Index<View> {
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        self.root.push(View {
            buffer: Index::new(0),
            byte_length: USize64::from(bytes.len()),
            byte_offset: Some(USize64::from(offset)),
            byte_stride: None,
            name: None,
            target: target.map(Valid),
            extensions: None,
            extras: Default::default(),
        })
    }

    fn accessor(
        &mut self,
        bytes: &[u8],
        count: usize,
        ty: ComponentType,
        shape: Type,
        target: Option<Target>,
    ) -> Index<Accessor> {
        let view = self.view(bytes, target);
        self.root.push(Accessor {
            buffer_view: Some(view),
            byte_offset: None,
            count: USize64::from(count),
            component_type: Valid(GenericComponentType(ty)),
            extensions: None,
            extras: Default::default(),
            type_: Valid(shape),
            min: None,
            max: None,
            name: None,
            normalized: false,
            sparse: None,
        })
    }

    fn image(&mut self, name: &str, png: &[u8]) -> Index<GltfImage> {
        let view = self.view(png, None);
        self.root.push(GltfImage {
            buffer_view: Some(view),
            mime_type: Some(MimeType("image/png".to_owned())),
            name: Some(name.to_owned()),
            uri: None,
            extensions: None,
            extras: Default::default(),
        })
    }

    fn texture(&mut self, name: &str, png: &[u8]) -> Index<Texture> {
        let source = self.image(name, png);
        if self.root.samplers.is_empty() {
            self.root.samplers.push(Sampler {
                mag_filter: Some(Valid(MagFilter::Linear)),
                min_filter: Some(Valid(MinFilter::LinearMipmapLinear)),
                wrap_s: Valid(WrappingMode::ClampToEdge),
                wrap_t: Valid(WrappingMode::ClampToEdge),
                ..Sampler::default()
            });
        }
        self.root.push(Texture {
            name: Some(name.to_owned()),
            sampler: Some(Index::new(0)),
            source,
            extensions: None,
            extras: Default::default(),
        })
    }

    fn material(&mut self, mesh: &Mesh) -> Result<Material, String> {
        let info = |index| Info { index, tex_coord: 0, extensions: None, extras: Default::default() };
        let mut material = Material { name: Some("solid".to_owned()), ..Material::default() };
        let mut pbr = PbrMetallicRoughness {
            base_color_factor: PbrBaseColorFactor([1.0; 4]),
            metallic_factor: StrengthFactor(0.0),
            roughness_factor: StrengthFactor(1.0),
            ..PbrMetallicRoughness::default()
        };
        // Without UVs there is no place for a texture.
        let textures = if mesh.uvs.is_empty() { &[][..] } else { &mesh.textures[..] };
        for (name, image) in textures {
            match name.as_str() {
                "roughness" | "metallic" => continue,
                "color" => {
                    pbr.base_color_texture = Some(info(self.texture(name, &encode_png(name, image)?)));
                }
                "normal" if image.channels() >= 3 => {
                    material.normal_texture = Some(NormalTexture {
                        index: self.texture(name, &encode_png(name, image)?),
                        scale: 1.0,
                        tex_coord: 0,
                        extensions: None,
                        extras: Default::default(),
                    });
                }
                "occlusion" => {
                    material.occlusion_texture = Some(OcclusionTexture {
                        index: self.texture(name, &encode_png(name, image)?),
                        strength: StrengthFactor(1.0),
                        tex_coord: 0,
                        extensions: None,
                        extras: Default::default(),
                    });
                }
                _ => {
                    self.image(&sanitize(name), &encode_png(name, image)?);
                }
            }
        }
        let find = |name: &str| textures.iter().find(|(n, _)| n == name).map(|(_, image)| image);
        let (roughness, metallic) = (find("roughness"), find("metallic"));
        if let Some(first) = roughness.or(metallic) {
            let bytes = metallic_roughness(first, roughness, metallic);
            let png = png(&bytes, first.width(), first.height(), 3)?;
            pbr.metallic_roughness_texture = Some(info(self.texture("metallic_roughness", &png)));
            pbr.metallic_factor = StrengthFactor(if metallic.is_some() { 1.0 } else { 0.0 });
        }
        material.pbr_metallic_roughness = pbr;
        Ok(material)
    }

    /// Header, JSON chunk, binary chunk.
    fn finish(mut self) -> Result<Vec<u8>, String> {
        self.root.buffers.push(Buffer {
            byte_length: USize64::from(self.bin.len()),
            name: None,
            uri: None,
            extensions: None,
            extras: Default::default(),
        });
        let mut json = serde_json::to_vec(&self.root).map_err(|error| error.to_string())?;
        json.resize(json.len().next_multiple_of(4), b' ');
        let total = 12 + 8 + json.len() + 8 + self.bin.len();
        let length =
            |n: usize| u32::try_from(n).map_err(|_| format!("{n} bytes exceed the 4 GiB of a GLB file"));
        let mut out = Vec::with_capacity(total);
        out.extend_from_slice(b"glTF");
        out.extend_from_slice(&2u32.to_le_bytes());
        out.extend_from_slice(&length(total)?.to_le_bytes());
        for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &self.bin)] {
            out.extend_from_slice(&length(chunk.len())?.to_le_bytes());
            out.extend_from_slice(kind);
            out.extend_from_slice(chunk);
        }
        Ok(out)
    }
}

/// One picture of the first one's size with roughness in green and metallic in blue.
fn metallic_roughness(first: &Image, roughness: Option<&Image>, metallic: Option<&Image>) -> Vec<u8> {
    let (width, height) = (first.width(), first.height());
    let at = |image: Option<&Image>, x: u32, y: u32, otherwise: u8| {
        let Some(image) = image else { return otherwise };
        let scale = |i: u32, from: u32, to: u32| (u64::from(i) * u64::from(to) / u64::from(from)) as u32;
        let (x, y) = (scale(x, width, image.width()), scale(y, height, image.height()));
        let pixel = y as usize * image.width() as usize + x as usize;
        image.samples().get_u8(pixel * image.channels())
    };
    let mut out = Vec::with_capacity(first.pixels() * 3);
    for y in 0..height {
        for x in 0..width {
            out.extend([255, at(roughness, x, y, 255), at(metallic, x, y, 0)]);
        }
    }
    out
}
