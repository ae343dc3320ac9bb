//! Flat pieces of a solid as textures, found coarse to fine behind the window.

use std::sync::Arc;

use breccia_nodes::data::{Filter, Solid};
use breccia_nodes::solid::{Plane, slice};
use breccia_shaders::Gpu;
use eframe::egui;

use super::geometry::{Geometry, Placement, WHITE};
use super::gpu_parts::{Clip, Finish, Material, Shape};
use super::pixels::{Channel, Pixels, rgba_of};
use super::renderer::Renderer;
use super::vector::{Vec3, sub};
use super::worker::{Job, Worker};

/// Surfaces whose single voxels are to be seen.
const VOXELS: Finish = Finish { clip: Clip::Whole, opacity: 1.0, sharp: true };

/// Where a point of voxel space comes to lie: x to the right, y down, z away from the viewer.
pub fn world(placement: &Placement, [x, y, z]: [f64; 3]) -> Vec3 {
    placement.place([x, -y, -z])
}

/// How a box of voxels is laid into the ball.
pub fn placement((origin, size): ([i32; 3], [u32; 3])) -> Placement {
    let low = origin.map(f64::from);
    let high: [f64; 3] = std::array::from_fn(|i| low[i] + f64::from(size[i]));
    Placement::of_box([low[0], -high[1], -high[2]], [high[0], -low[1], -low[2]])
}

/// The axes along which columns and rows run on a face across an axis, as in slices.
pub fn columns_and_rows(axis: usize) -> [usize; 2] {
    match axis {
        0 => [1, 2],
        1 => [0, 2],
        _ => [0, 1],
    }
}

/// A rectangle across an axis, in voxel coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// The axis that it lies across.
    pub axis: usize,
    /// Where on that axis.
    pub at: f64,
    /// Its corner of smallest coordinates along columns and rows, and the opposite one.
    pub from: [f64; 2],
    /// See `from`.
    pub to: [f64; 2],
}

impl Face {
    /// A point of it.
    pub fn point(&self, column: f64, row: f64) -> [f64; 3] {
        let [c, r] = columns_and_rows(self.axis);
        let mut point = [self.at; 3];
        if let Some(to) = point.get_mut(c) {
            *to = column;
        }
        if let Some(to) = point.get_mut(r) {
            *to = row;
        }
        point
    }

    /// Adds part of it to some triangles; the texture is that of the whole.
    pub fn add(&self, geometry: &mut Geometry, placement: &Placement, from: [f64; 2], to: [f64; 2]) {
        let at = |column, row| world(placement, self.point(column, row));
        let corner = at(from[0], from[1]);
        let uv = |p: [f64; 2]| -> [f32; 2] {
            std::array::from_fn(|i| ((p[i] - self.from[i]) / (self.to[i] - self.from[i]).max(1e-9)) as f32)
        };
        if to[0] - from[0] > 1e-6 && to[1] - from[1] > 1e-6 {
            let (right, down) = (sub(at(to[0], from[1]), corner), sub(at(from[0], to[1]), corner));
            geometry.quad(corner, right, down, [uv(from), uv(to)], WHITE);
        }
    }

    /// The plane whose pixels of about `step` voxels fill it, and how many there are.
    fn plane(&self, step: f64, inside: [f64; 2]) -> (Plane, [u32; 2]) {
        let extent: [f64; 2] = std::array::from_fn(|i| (self.to[i] - self.from[i]).max(1e-6));
        let size = extent.map(|e| (e / step).round().clamp(1.0, 2048.0));
        let axes = columns_and_rows(self.axis);
        let along = |i: usize| -> [f64; 3] {
            std::array::from_fn(|axis| if axes.get(i) == Some(&axis) { extent[i] / size[i] } else { 0.0 })
        };
        let mut center = self.point((self.from[0] + self.to[0]) / 2.0, (self.from[1] + self.to[1]) / 2.0);
        if let Some(c) = center.get_mut(self.axis) {
            // The layer of voxels that lies there, and of the last face the last.
            *c = (self.at.floor() + 0.5).clamp(inside[0] + 0.5, (inside[1] - 0.5).max(inside[0] + 0.5));
        }
        (Plane { center, right: along(0), down: along(1) }, size.map(|n| n as u32))
    }
}

/// What a face's texture is made of.
#[derive(Clone)]
pub struct Source {
    /// Of which version of the subject.
    pub version: u64,
    /// The solid.
    pub solid: Arc<dyn Solid>,
    /// Which of its maps.
    pub map: String,
    /// The box that is looked at.
    pub shown: ([i32; 3], [u32; 3]),
}

type Key = (u64, String, Vec<Face>);

/// Faces with one worker, each with the finest texture so far.
pub struct Faces {
    worker: Worker<Key, (usize, Pixels)>,
    materials: Vec<Option<Material>>,
}

impl Faces {
    /// None yet.
    pub fn new(gpu: Option<Arc<Gpu>>) -> Self {
        Self { worker: Worker::new("faces", gpu), materials: Vec::new() }
    }

    /// Asks for faces, unless these are known or on their way; takes in what has come.
    pub fn update(&mut self, ctx: &egui::Context, renderer: &Renderer, source: &Source, faces: &[Face]) {
        let key = (source.version, source.map.clone(), faces.to_vec());
        let (source, wanted) = (source.clone(), faces.to_vec());
        self.worker.want(ctx, key, move |job| sample(&source, &wanted, job));
        self.materials.resize(faces.len(), None);
        for (at, pixels) in self.worker.poll() {
            if let Some(to) = self.materials.get_mut(at) {
                *to = Some(renderer.material(&pixels, VOXELS));
            }
        }
    }

    /// The texture of a face, if there is one.
    pub fn material(&self, at: usize) -> Option<&Material> {
        self.materials.get(at)?.as_ref()
    }

    /// Gives up what is on its way.
    pub fn rest(&mut self) {
        self.worker.rest();
    }

    /// Whether finer textures are on their way.
    pub fn is_running(&self) -> bool {
        self.worker.is_running()
    }

    /// What went wrong.
    pub fn error(&self) -> Option<&str> {
        self.worker.error()
    }
}

/// Slices coarse to fine: all faces at each step before the next.
fn sample(source: &Source, faces: &[Face], job: &Job<(usize, Pixels)>) -> Result<(), String> {
    let (origin, size) = source.shown;
    let longest = size.into_iter().max().unwrap_or(1);
    for step in [8u32, 4, 1].into_iter().filter(|&step| step == 1 || longest / step >= 12) {
        for (at, face) in faces.iter().enumerate() {
            let low = origin.get(face.axis).copied().unwrap_or(0);
            let high = f64::from(low) + f64::from(size.get(face.axis).copied().unwrap_or(1));
            let (plane, pixels) = face.plane(f64::from(step), [f64::from(low), high]);
            let image = slice(&*source.solid, &plane, pixels, Filter::Nearest, &source.map, job)
                .map_err(|error| error.to_string())?;
            job.send((at, Pixels::new(pixels, rgba_of(&image, Channel::Color))));
        }
    }
    Ok(())
}

/// Grey, for faces that have no texture yet.
pub fn blank(renderer: &Renderer) -> Material {
    renderer.material(&Pixels::flat([120, 120, 122]), VOXELS)
}

/// Triangles on the device, with the texture of a face or grey.
pub fn part(renderer: &Renderer, geometry: &Geometry, material: &Material) -> Option<(Shape, Material)> {
    Some((Shape::new(renderer.device(), geometry)?, material.clone()))
}

#[cfg(test)]
mod tests {
    use breccia_nodes::solid::CheckerSolid;

    use super::*;

    /// Whatever the step, a face's pixels show the voxels at their places.
    #[test]
    fn a_face_shows_the_voxels_of_its_layer() {
        let solid = CheckerSolid { colors: [[200, 30, 20], [10, 60, 220]], cell: 3, noise: 20, seed: 5 };
        for axis in 0..3 {
            let face = Face { axis, at: 12.0, from: [4.0, 2.0], to: [10.0, 9.0] };
            // The box ends at 12: the face is its last.
            let (plane, size) = face.plane(1.0, [0.0, 12.0]);
            assert_eq!(size, [6, 7]);
            let image = slice(&solid, &plane, size, Filter::Nearest, "color", &()).unwrap();
            for (c, r) in [(0, 0), (5, 6), (3, 1)] {
                let mut voxel = face.point(4.0 + f64::from(c), 2.0 + f64::from(r)).map(|v| v as i32);
                voxel[axis] = 11;
                assert_eq!(image.rgb8(c, r), solid.color(voxel), "axis {axis}, pixel {c} {r}");
            }
        }
    }
}
