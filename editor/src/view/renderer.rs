//! The viewport's renderer: frames into a texture of its own, antialiased where the adapter can.

use bytemuck::{Pod, Zeroable};
use eframe::wgpu;

use super::geometry::Vertex;
use super::gpu_parts::{Finish, Material, Shape, line_buffer};
use super::pixels::Pixels;
use super::target::Target;
use super::vector::Vec3;

/// What egui takes.
pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Depths.
pub const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// `Globals` of the shader.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
struct Globals {
    view_projection: [[f32; 4]; 4],
    eye: [f32; 4],
    key: [f32; 4],
    around: [f32; 4],
    clip: [f32; 4],
    inside: [f32; 4],
    top: [f32; 4],
    bottom: [f32; 4],
}

/// How a frame is lit, and what lies behind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Towards the key light, unit length.
    pub key: Vec3,
    /// Strength of all light; 1 as in a studio.
    pub brightness: f32,
    /// Colours as they are, without light.
    pub flat: bool,
    /// The background at the top and at the bottom, sRGB and alpha as fractions, colours times alpha.
    pub behind: [[f32; 4]; 2],
}

/// A frame to be drawn.
#[derive(Clone)]
pub struct Frame {
    /// World to clip space.
    pub view_projection: [[f32; 4]; 4],
    /// Where the eye is.
    pub eye: Vec3,
    /// Light and background.
    pub light: Light,
    /// What lies beyond `dot(normal, p) = distance` is clipped from materials that are.
    pub clip: Option<(Vec3, f32)>,
    /// sRGB of the inside of what is clipped.
    pub inside: [u8; 3],
    /// What is drawn; what is not opaque last.
    pub parts: Vec<(Shape, Material)>,
    /// Ends of lines.
    pub lines: Vec<Vertex>,
}

impl Frame {
    fn globals(&self) -> Globals {
        let b = self.light.brightness;
        let [x, y, z] = self.light.key;
        let (normal, distance) = self.clip.unwrap_or(([0.0, 1.0, 0.0], f32::MAX));
        let inside = self.inside.map(breccia_nodes::data::srgb_to_linear);
        Globals {
            view_projection: self.view_projection,
            eye: [self.eye[0], self.eye[1], self.eye[2], 1.0],
            key: [x, y, z, 0.72 * b],
            around: [0.52 * b, 0.20 * b, f32::from(u8::from(self.light.flat)), 0.0],
            clip: [normal[0], normal[1], normal[2], distance],
            inside: [inside[0], inside[1], inside[2], 1.0],
            top: self.light.behind[0],
            bottom: self.light.behind[1],
        }
    }

    /// Whether another frame looks the same.
    pub fn same(&self, other: &Self) -> bool {
        let ids = |frame: &Self| frame.parts.iter().map(|(s, m)| (s.id, m.id)).collect::<Vec<_>>();
        self.globals() == other.globals() && self.lines == other.lines && ids(self) == ids(other)
    }
}

/// Pipelines and the device they run on.
pub struct Renderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    samples: u32,
    material_layout: wgpu::BindGroupLayout,
    globals: wgpu::Buffer,
    globals_group: wgpu::BindGroup,
    solid: wgpu::RenderPipeline,
    glass: wgpu::RenderPipeline,
    lines: wgpu::RenderPipeline,
    behind: wgpu::RenderPipeline,
}

impl Renderer {
    /// Makes the pipelines.
    pub fn new(adapter: &wgpu::Adapter, device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let can = |format: wgpu::TextureFormat| {
            adapter.get_texture_format_features(format).flags.sample_count_supported(4)
        };
        let samples = if can(FORMAT) && can(DEPTH) { 4 } else { 1 };
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("viewport"),
            source: wgpu::ShaderSource::Wgsl(include_str!("shader.wgsl").into()),
        });
        let [globals_layout, material_layout] = layouts(&device);
        let globals = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("viewport globals"),
            size: size_of::<Globals>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let globals_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("viewport globals"),
            layout: &globals_layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: globals.as_entire_binding() }],
        });
        let with_material = pipeline_layout(&device, &[Some(&globals_layout), Some(&material_layout)]);
        let without = pipeline_layout(&device, &[Some(&globals_layout)]);
        let triangles = wgpu::PrimitiveTopology::TriangleList;
        let make = |layout, entries: [&str; 2], topology, depth: Depth| {
            pipeline(&device, &module, layout, entries, topology, depth, samples)
        };
        Self {
            samples,
            solid: make(&with_material, ["corner", "surface"], triangles, Depth::Solid),
            glass: make(&with_material, ["corner", "surface"], triangles, Depth::Glass),
            lines: make(&without, ["corner", "plain"], wgpu::PrimitiveTopology::LineList, Depth::Glass),
            behind: make(&without, ["behind", "background"], triangles, Depth::Behind),
            device,
            queue,
            material_layout,
            globals,
            globals_group,
        }
    }

    /// The device.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The queue.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Samples a pixel.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Copies a texture to the device.
    pub fn material(&self, pixels: &Pixels, finish: Finish) -> Material {
        Material::new(&self.device, &self.queue, &self.material_layout, pixels, finish)
    }

    /// Draws a frame.
    pub fn draw(&self, frame: &Frame, target: &Target) {
        self.queue.write_buffer(&self.globals, 0, bytemuck::bytes_of(&frame.globals()));
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let lines = (!frame.lines.is_empty()).then(|| line_buffer(&self.device, &frame.lines));
        {
            let mut pass = target.begin(&mut encoder);
            pass.set_bind_group(0, &self.globals_group, &[]);
            pass.set_pipeline(&self.behind);
            pass.draw(0..3, 0..1);
            for (pipeline, wanted) in [(&self.solid, true), (&self.glass, false)] {
                pass.set_pipeline(pipeline);
                for (shape, material) in
                    frame.parts.iter().filter(|(_, material)| material.is_opaque() == wanted)
                {
                    pass.set_bind_group(1, &*material.bind_group, &[]);
                    pass.set_vertex_buffer(0, shape.vertices.slice(..));
                    pass.set_index_buffer(shape.indices.slice(..), wgpu::IndexFormat::Uint32);
                    pass.draw_indexed(0..shape.count, 0, 0..1);
                }
            }
            if let Some(lines) = &lines {
                pass.set_pipeline(&self.lines);
                pass.set_vertex_buffer(0, lines.slice(..));
                pass.draw(0..u32::try_from(frame.lines.len()).unwrap_or(0), 0..1);
            }
        }
        self.queue.submit([encoder.finish()]);
    }
}

fn layouts(device: &wgpu::Device) -> [wgpu::BindGroupLayout; 2] {
    let uniform = |binding| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let fragment = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty,
        count: None,
    };
    let texture = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    let make = |entries: &[wgpu::BindGroupLayoutEntry]| {
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("viewport"), entries })
    };
    [make(&[uniform(0)]), make(&[fragment(0, texture), fragment(1, sampler), uniform(2)])]
}

fn pipeline_layout(
    device: &wgpu::Device,
    layouts: &[Option<&wgpu::BindGroupLayout>],
) -> wgpu::PipelineLayout {
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("viewport"),
        bind_group_layouts: layouts,
        immediate_size: 0,
    })
}

/// What a pipeline does with depths.
#[derive(Clone, Copy, PartialEq)]
enum Depth {
    Solid,
    Glass,
    Behind,
}

fn pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    [vertex, fragment]: [&str; 2],
    topology: wgpu::PrimitiveTopology,
    depth: Depth,
    samples: u32,
) -> wgpu::RenderPipeline {
    let corner = wgpu::VertexBufferLayout {
        array_stride: size_of::<Vertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Unorm8x4],
    };
    let buffers = [Some(corner)];
    let compare =
        if depth == Depth::Behind { wgpu::CompareFunction::Always } else { wgpu::CompareFunction::LessEqual };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("viewport"),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(vertex),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: if depth == Depth::Behind { &[] } else { &buffers },
        },
        primitive: wgpu::PrimitiveState { topology, ..wgpu::PrimitiveState::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(depth == Depth::Solid),
            depth_compare: Some(compare),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState { count: samples, ..wgpu::MultisampleState::default() },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(fragment),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: FORMAT,
                blend: (depth == Depth::Glass).then_some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}
