//! What the renderer draws, in the device's memory.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use eframe::wgpu;
use eframe::wgpu::util::DeviceExt;

use super::geometry::{Geometry, Vertex};
use super::pixels::Pixels;

static NEXT: AtomicU64 = AtomicU64::new(1);

/// A number for a part, so that a frame that shows the same parts is known to look the same.
fn number() -> u64 {
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// Triangles in the device's memory. Cloning copies a pointer.
#[derive(Clone)]
pub struct Shape {
    pub(super) id: u64,
    pub(super) vertices: Arc<wgpu::Buffer>,
    pub(super) indices: Arc<wgpu::Buffer>,
    pub(super) count: u32,
}

impl Shape {
    /// Copies triangles to the device; `None` if there are none, or more than it takes.
    pub fn new(device: &wgpu::Device, geometry: &Geometry) -> Option<Self> {
        let limit = device.limits().max_buffer_size;
        let bytes = size_of_val(&geometry.vertices[..]).max(size_of_val(&geometry.indices[..])) as u64;
        if geometry.indices.is_empty() || bytes > limit {
            return None;
        }
        let buffer = |contents: &[u8], usage| {
            Arc::new(device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("viewport shape"),
                contents,
                usage,
            }))
        };
        Some(Self {
            id: number(),
            vertices: buffer(bytemuck::cast_slice(&geometry.vertices), wgpu::BufferUsages::VERTEX),
            indices: buffer(bytemuck::cast_slice(&geometry.indices), wgpu::BufferUsages::INDEX),
            count: u32::try_from(geometry.indices.len()).ok()?,
        })
    }
}

/// What the clipping plane does to a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clip {
    /// Nothing.
    Whole,
    /// What lies beyond it is not drawn.
    Kept,
    /// Only what lies beyond it is drawn.
    Removed,
}

/// How a surface is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finish {
    /// What the clipping plane does to it.
    pub clip: Clip,
    /// 1 hides what lies behind.
    pub opacity: f32,
    /// Whether single texels are shown as squares when they are large.
    pub sharp: bool,
}

/// Opaque, smooth, whole.
pub const PLAIN: Finish = Finish { clip: Clip::Whole, opacity: 1.0, sharp: false };

/// A texture and how it is drawn, in the device's memory. Cloning copies a pointer.
#[derive(Clone)]
pub struct Material {
    pub(super) id: u64,
    pub(super) bind_group: Arc<wgpu::BindGroup>,
    pub(super) finish: Finish,
}

impl Material {
    /// Copies a texture to the device. Larger ones than it takes begin at a coarser level.
    pub(super) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        layout: &wgpu::BindGroupLayout,
        pixels: &Pixels,
        finish: Finish,
    ) -> Self {
        let limit = device.limits().max_texture_dimension_2d;
        let skip = (0..32).find(|skip| pixels.size.iter().all(|n| n >> skip <= limit)).unwrap_or(0) as usize;
        let levels: Vec<(usize, &Vec<u8>)> = pixels.levels.iter().enumerate().skip(skip).collect();
        let size_at = |level: usize| pixels.size.map(|n| (n >> level).max(1));
        let extent = |[width, height]: [u32; 2]| wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("viewport texture"),
            size: extent(size_at(skip)),
            mip_level_count: levels.len().max(1) as u32,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8UnormSrgb,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        for (to, (level, bytes)) in levels.iter().enumerate() {
            let [width, height] = size_at(*level);
            if bytes.len() as u64 != 4 * u64::from(width) * u64::from(height) {
                continue;
            }
            queue.write_texture(
                wgpu::TexelCopyTextureInfo { mip_level: to as u32, ..texture.as_image_copy() },
                bytes,
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(4 * width),
                    rows_per_image: None,
                },
                extent([width, height]),
            );
        }
        let magnify = if finish.sharp { wgpu::FilterMode::Nearest } else { wgpu::FilterMode::Linear };
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: magnify,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            anisotropy_clamp: if finish.sharp { 1 } else { 8 },
            ..wgpu::SamplerDescriptor::default()
        });
        let clip = match finish.clip {
            Clip::Whole => 0.0,
            Clip::Kept => 1.0,
            Clip::Removed => 2.0,
        };
        let flags = [clip, finish.opacity, 0.0, 0.0];
        let uniform = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("viewport material"),
            contents: bytemuck::cast_slice(&flags),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("viewport material"),
            layout,
            entries: &[
                entry(0, wgpu::BindingResource::TextureView(&view)),
                entry(1, wgpu::BindingResource::Sampler(&sampler)),
                entry(2, uniform.as_entire_binding()),
            ],
        });
        Self { id: number(), bind_group: Arc::new(bind_group), finish }
    }
}

impl Material {
    /// Whether it hides what lies behind.
    pub fn is_opaque(&self) -> bool {
        self.finish.opacity >= 1.0
    }
}

/// Lines in the device's memory.
pub(super) fn line_buffer(device: &wgpu::Device, lines: &[Vertex]) -> wgpu::Buffer {
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("viewport lines"),
        contents: bytemuck::cast_slice(lines),
        usage: wgpu::BufferUsages::VERTEX,
    })
}
