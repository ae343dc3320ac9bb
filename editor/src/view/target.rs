//! The texture that frames are drawn into, and how its pixels come back.

use std::sync::mpsc::channel;
use std::time::Duration;

use eframe::wgpu;

use super::renderer::{DEPTH, FORMAT};

/// How long a picture may take to come back before the device counts as stuck.
const PATIENCE: Duration = Duration::from_secs(10);

/// A colour target with depths, of one size.
pub struct Target {
    size: [u32; 2],
    color: wgpu::Texture,
    view: wgpu::TextureView,
    /// The antialiased target that is resolved into `color`, where there is one.
    samples: Option<wgpu::TextureView>,
    depth: wgpu::TextureView,
}

impl Target {
    /// A target of at most the size that the device takes.
    pub fn new(device: &wgpu::Device, size: [u32; 2], samples: u32) -> Self {
        let limit = device.limits().max_texture_dimension_2d.min(8192);
        let size = size.map(|n| n.clamp(1, limit));
        let make = |format, sample_count, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some("viewport target"),
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let seen = attachment | wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let color = make(FORMAT, 1, seen);
        Self {
            size,
            view: view(&color),
            samples: (samples > 1).then(|| view(&make(FORMAT, samples, attachment))),
            depth: view(&make(DEPTH, samples, attachment)),
            color,
        }
    }

    /// Width and height.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// What egui shows.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// Begins drawing.
    pub fn begin<'a>(&self, encoder: &'a mut wgpu::CommandEncoder) -> wgpu::RenderPass<'a> {
        let (view, resolve_target) = match &self.samples {
            Some(samples) => (samples, Some(&self.view)),
            None => (&self.view, None),
        };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("viewport"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                resolve_target,
                depth_slice: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        })
    }

    /// The pixels, row by row, as RGBA with colours not multiplied by alpha.
    ///
    /// # Errors
    /// What the device says.
    pub fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Vec<u8>, String> {
        let [width, height] = self.size;
        let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("viewport picture"),
            size: u64::from(row) * u64::from(height),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_texture_to_buffer(
            self.color.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row),
                    rows_per_image: None,
                },
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        let submission = queue.submit([encoder.finish()]);
        let (sender, receiver) = channel();
        buffer.slice(..).map_async(wgpu::MapMode::Read, move |mapped| {
            let _ = sender.send(mapped);
        });
        let wait = wgpu::PollType::Wait { submission_index: Some(submission), timeout: Some(PATIENCE) };
        device.poll(wait).map_err(|error| error.to_string())?;
        let mapped = receiver.recv().map_err(|error| error.to_string())?;
        mapped.map_err(|error| error.to_string())?;
        let bytes = buffer.slice(..).get_mapped_range().map_err(|error| error.to_string())?;
        let mut out = Vec::with_capacity(4 * width as usize * height as usize);
        for line in bytes.chunks_exact(row as usize) {
            out.extend_from_slice(line.get(..4 * width as usize).unwrap_or_default());
        }
        for pixel in out.chunks_exact_mut(4) {
            if let [color @ .., alpha] = pixel
                && *alpha > 0
                && *alpha < 255
            {
                for c in color {
                    *c = (u32::from(*c) * 255 / u32::from(*alpha)).min(255) as u8;
                }
            }
        }
        Ok(out)
    }
}
