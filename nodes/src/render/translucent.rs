//! A box of a solid, seen through: what a mask marks is opaque and shaded, the rest as translucent as wanted.

use super::Camera;
use super::cutaway::to_world;
use super::error::{RenderError, check_picture};
use super::studio::{Background, Seen, compose};
use super::vector::{Vec3, add, dot, scale, unit_or};
use crate::control::Control;
use crate::data::{Image, Solid, Volume, srgb_to_linear};
use crate::solid::{available_memory, box_volume};

/// How the box is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TranslucentSettings {
    /// Width and height of the picture in pixels.
    pub picture: [u32; 2],
    /// How much a voxel of the rest hides of what lies behind it: 0 leaves it out, 1 makes it opaque.
    pub opacity: f64,
    /// Degrees to the right and upwards.
    pub view: [f64; 2],
    /// What lies behind.
    pub background: Background,
}

/// Samples along each side of a pixel.
const GRID: u32 = 2;
/// Where light comes from: above, left, the viewer.
const LIGHT: Vec3 = [-0.45, 0.75, 0.5];

/// A picture of the box from `origin` of `size` voxels. `marked` is white where voxels are opaque whatever the opacity; `inside`, if
/// given, is white where there is anything at all. Axes lie as in [`super::cutaway`].
///
/// # Errors
/// [`RenderError`]: an impossible size of box or picture, or no answer from a solid.
pub fn translucent(
    solid: &dyn Solid,
    marked: Option<&dyn Solid>,
    inside: Option<&dyn Solid>,
    origin: [i32; 3],
    size: [u32; 3],
    settings: &TranslucentSettings,
    control: &dyn Control,
) -> Result<Image, RenderError> {
    check_picture(settings.picture)?;
    let [x, y, z] = size;
    if !size.iter().all(|n| (1..=1024).contains(n))
        || (0..3).any(|i| origin[i].checked_add_unsigned(size[i]).is_none())
    {
        return Err(RenderError::Box(x, y, z));
    }
    let voxels = |solid: &dyn Solid| box_volume(solid, origin, size, available_memory(), control);
    let white = |solid: &dyn Solid| -> Result<Vec<bool>, RenderError> {
        let volume = voxels(solid)?;
        let map = volume.maps.first();
        Ok(map.map_or_else(Vec::new, |map| {
            (0..volume.voxels()).map(|i| map.samples.get_u8(i * map.channels) > 127).collect()
        }))
    };
    let scene = Scene {
        size: size.map(f64::from),
        marked: marked.map(white).transpose()?,
        inside: inside.map(white).transpose()?,
        colors: voxels(solid)?,
        opacity: settings.opacity.clamp(0.0, 1.0),
        linear: std::array::from_fn(|byte| f64::from(srgb_to_linear(byte as u8))),
    };
    let corners =
        (0..8).map(|i| to_world(std::array::from_fn(|a| if i >> a & 1 == 1 { scene.size[a] } else { 0.0 })));
    let camera = Camera::framing(corners, settings.view, 1.0, 0.86, settings.picture);
    let weight = 1.0 / f64::from(GRID * GRID);
    compose(settings.picture, settings.background, control, |column, row| {
        let mut pixel = Seen::default();
        for sample in 0..GRID * GRID {
            let step = |n: u32| (f64::from(n) + 0.5) / f64::from(GRID);
            let at = [f64::from(column) + step(sample % GRID), f64::from(row) + step(sample / GRID)];
            let (color, cover) = scene.look(to_world(camera.eye()), to_world(camera.ray(at[0], at[1])));
            pixel += Seen { color: color.map(|c| c * weight), object: cover * weight, shadow: 0.0 };
        }
        pixel
    })
}

struct Scene {
    size: Vec3,
    marked: Option<Vec<bool>>,
    inside: Option<Vec<bool>>,
    colors: Volume,
    opacity: f64,
    linear: [f64; 256],
}

impl Scene {
    fn index(&self, voxel: [i64; 3]) -> Option<usize> {
        let inside = (0..3).all(|a| voxel[a] >= 0 && (voxel[a] as f64) < self.size[a]);
        let [x, y, z] = voxel.map(|c| c as usize);
        inside.then(|| self.colors.index(x, y, z))
    }

    fn is_there(&self, at: usize) -> bool {
        self.inside.as_ref().is_none_or(|inside| inside[at])
    }

    /// Whether a voxel stops a ray.
    fn is_solid(&self, voxel: [i64; 3]) -> bool {
        self.index(voxel).is_some_and(|at| {
            self.is_there(at)
                && (self.opacity >= 1.0 || self.marked.as_ref().is_some_and(|marked| marked[at]))
        })
    }

    fn color(&self, at: usize) -> Vec3 {
        let Some(map) = self.colors.maps.first() else { return [0.0; 3] };
        let n = map.channels;
        std::array::from_fn(|c| self.linear[usize::from(map.samples.get_u8(at * n + c.min(n - 1)))])
    }

    /// Light and coverage along a ray, voxel by voxel (Amanatides & Woo 1987).
    fn look(&self, eye: Vec3, ray: Vec3) -> (Vec3, f64) {
        let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
        for i in 0..3 {
            let (a, b) = (-eye[i] / ray[i], (self.size[i] - eye[i]) / ray[i]);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        if enter >= leave || !enter.is_finite() {
            return ([0.0; 3], 0.0);
        }
        let start = add(eye, scale(ray, enter + 1e-9));
        let mut voxel: [i64; 3] =
            std::array::from_fn(|a| start[a].floor().clamp(0.0, self.size[a] - 1.0) as i64);
        let step = ray.map(|r| if r < 0.0 { -1i64 } else { 1 });
        let mut next: Vec3 =
            std::array::from_fn(|a| ((voxel[a] + i64::from(step[a] > 0)) as f64 - eye[a]) / ray[a]);
        let (mut light, mut cover, mut t) = ([0.0; 3], 0.0f64, enter);
        let length = dot(ray, ray).sqrt();
        while let Some(at) = self.index(voxel) {
            let axis = if next[0] <= next[1] && next[0] <= next[2] {
                0
            } else if next[1] <= next[2] {
                1
            } else {
                2
            };
            let part = if !self.is_there(at) {
                0.0
            } else if self.is_solid(voxel) {
                1.0
            } else {
                1.0 - libm::pow(1.0 - self.opacity, (next[axis] - t) * length)
            };
            if part > 0.0 {
                let shade = if part == 1.0 { self.shade(voxel) } else { 0.8 };
                let color = self.color(at);
                (0..3).for_each(|c| light[c] += (1.0 - cover) * part * shade * color[c]);
                cover += (1.0 - cover) * part;
                if cover > 0.995 {
                    break;
                }
            }
            t = next[axis];
            voxel[axis] += step[axis];
            next[axis] += (1.0 / ray[axis]).abs();
        }
        (light, cover)
    }

    /// How light a voxel is, from the way in which solid voxels around it lie.
    fn shade(&self, voxel: [i64; 3]) -> f64 {
        let mut normal = [0.0; 3];
        for dz in -2i64..=2 {
            for dy in -2i64..=2 {
                for dx in -2i64..=2 {
                    let d = [dx, dy, dz];
                    if !self.is_solid(std::array::from_fn(|a| voxel[a] + d[a])) {
                        (0..3).for_each(|a| normal[a] += d[a] as f64);
                    }
                }
            }
        }
        let light = unit_or(LIGHT, [0.0, 1.0, 0.0]);
        let normal = unit_or(to_world(normal), light);
        0.42 + 0.68 * dot(normal, light).max(0.0)
    }
}
