//! A picture of a textured mesh in a small photo studio.

use rayon::prelude::*;

use super::camera::Camera;
use super::error::{RenderError, check_picture};
use super::ground::Ground;
use super::light::Lights;
use super::material::{Material, Point};
use super::raster::{SUB, Tile, Triangle, bin};
use super::studio::{Background, Seen, compose};
use super::surface::{Surface, blend, face_normal};
use super::vector::{Vec3, dot, scale, sub, unit_or};
use crate::control::{Cancelled, Control, check};
use crate::data::{Image, Mesh};

/// How a mesh is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PortraitSettings {
    /// Width and height of the picture in pixels.
    pub picture: [u32; 2],
    /// Where the viewer stands, in degrees around the vertical: 0 looks along −z, 90 along −x.
    pub azimuth: f64,
    /// How far the viewer looks down, in degrees.
    pub elevation: f64,
    /// 1 fits the whole mesh, 2 shows it twice as large.
    pub zoom: f64,
    /// What lies behind.
    pub background: Background,
}

/// A picture of a mesh: its `color`, `normal`, `roughness` and `metallic` maps, else its vertex colours, else
/// grey clay, lit by a soft key light, fill, rim and a bright room, all with shadows, on a ground that
/// takes the shadow. Edges and textures are antialiased.
///
/// # Errors
/// [`RenderError`]: an impossible picture, or a mesh without a triangle that could be shown.
pub fn portrait(
    mesh: &Mesh,
    settings: &PortraitSettings,
    control: &dyn Control,
) -> Result<Image, RenderError> {
    check_picture(settings.picture)?;
    let surface = Surface::new(mesh)?;
    let view = [settings.azimuth, settings.elevation.clamp(-90.0, 90.0)];
    let camera = Camera::framing(surface.points(), view, settings.zoom, 0.80, settings.picture);
    let sphere = bounding_sphere(&surface);
    let lights = Lights::new(settings.azimuth, &surface.corners, sphere, control)?;
    let lowest = surface.points().map(|p| p[1]).fold(f64::INFINITY, f64::min);
    let stage = Stage {
        material: Material::new(mesh, &surface),
        ground: Ground::new(&lights, sphere, lowest, control)?,
        lights,
        ground_strength: ((view[1] - 2.0) / 8.0).clamp(0.0, 1.0) * 0.9,
        triangles: surface
            .corners
            .iter()
            .map(|corners| Triangle::new(corners, &camera.enlarged(2.0)))
            .collect(),
        camera,
        surface,
    };
    control.progress(0.2);
    let [width, height] = settings.picture;
    let columns = width.div_ceil(TILE);
    let bins = bin(&stage.triangles, settings.picture, TILE);
    let tiles: Vec<Vec<Seen>> = bins
        .par_iter()
        .enumerate()
        .map(|(i, bin)| {
            check(control)?;
            let (x, y) = (i as u32 % columns * TILE, i as u32 / columns * TILE);
            stage.tile(x, y, TILE.min(width - x), TILE.min(height - y), bin, control)
        })
        .collect::<Result<_, Cancelled>>()?;
    compose(settings.picture, settings.background, control, |x, y| {
        let tile = tiles.get((y / TILE * columns + x / TILE) as usize);
        let wide = TILE.min(width - x / TILE * TILE);
        let at = (y % TILE * wide + x % TILE) as usize;
        tile.and_then(|tile| tile.get(at)).copied().unwrap_or_default()
    })
}

/// Pixels along the edge of the portions that are drawn at once.
const TILE: u32 = 32;

fn bounding_sphere(surface: &Surface) -> (Vec3, f64) {
    let far = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let (low, high) = surface.points().fold(far, |(low, high): (Vec3, Vec3), p| {
        (std::array::from_fn(|i| low[i].min(p[i])), std::array::from_fn(|i| high[i].max(p[i])))
    });
    let center = std::array::from_fn(|i| (low[i] + high[i]) / 2.0);
    let squares = surface.points().map(|p| dot(sub(p, center), sub(p, center)));
    // A little room, so that no depth map's border texel holds the surface.
    (center, squares.fold(0.0, f64::max).sqrt().max(1e-30) * 1.04)
}

/// Everything that a picture is made from.
struct Stage {
    surface: Surface,
    material: Material,
    lights: Lights,
    camera: Camera,
    triangles: Vec<Triangle>,
    ground: Ground,
    /// 0 where the ground is seen edge-on or from below.
    ground_strength: f64,
}

impl Stage {
    /// The pixels of one tile, rows from top to bottom.
    fn tile(
        &self,
        x: u32,
        y: u32,
        width: u32,
        height: u32,
        bin: &[u32],
        control: &dyn Control,
    ) -> Result<Vec<Seen>, Cancelled> {
        let mut tile = Tile::new([x * 2, y * 2], [width as usize * 2, height as usize * 2]);
        for &triangle in bin {
            if let Some(shape) = self.triangles.get(triangle as usize) {
                tile.draw(triangle, shape);
            }
        }
        let mut pixels = Vec::with_capacity((width * height) as usize);
        for row in 0..height {
            check(control)?;
            for column in 0..width {
                pixels.push(self.pixel(&tile, column as usize, row as usize, [x + column, y + row]));
            }
        }
        Ok(pixels)
    }

    /// One pixel: four places to shade, each with four samples of what covers it.
    fn pixel(&self, tile: &Tile, column: usize, row: usize, [x, y]: [u32; 2]) -> Seen {
        let mut pixel = Seen::default();
        let mut known: Option<Known> = None;
        for quarter in 0..4 {
            let (i, j) = (2 * column + quarter % 2, 2 * row + quarter / 2);
            for (triangle, place, samples) in tile.covers(i, j) {
                let weight = samples / (4.0 * SUB as f64);
                let color = self.shade(triangle as usize, place, &mut known);
                pixel += Seen { color: scale(color, weight), object: weight, shadow: 0.0 };
            }
        }
        if pixel.object < 1.0 && self.ground_strength > 0.0 {
            let shadow = self.ground.seen(&self.camera, f64::from(x) + 0.5, f64::from(y) + 0.5);
            pixel.shadow = shadow * self.ground_strength * (1.0 - pixel.object);
        }
        pixel
    }

    /// The light from a triangle at a place of the picture (in half pixels).
    fn shade(&self, triangle: usize, place: [f64; 2], known: &mut Option<Known>) -> Vec3 {
        let (Some(shape), Some(corners), Some(normals)) = (
            self.triangles.get(triangle),
            self.surface.corners.get(triangle),
            self.surface.normals.get(triangle),
        ) else {
            return [0.0; 3];
        };
        let weights = shape.weights(place);
        let position = blend(corners, weights);
        let view = unit_or(sub(self.camera.eye(), position), [0.0, 0.0, 1.0]);
        // Both sides are shown: the normals of a face seen from behind are turned round.
        let mut face = face_normal(corners);
        let mut normal = unit_or(blend(normals, weights), face);
        if dot(face, view) < 0.0 {
            face = scale(face, -1.0);
        }
        if dot(normal, face) < 0.0 {
            normal = scale(normal, -1.0);
        }
        let steps = match self.surface.uvs.get(triangle) {
            Some(uvs) => {
                let at = |w: Vec3| -> [f64; 2] {
                    std::array::from_fn(|i| uvs[0][i] * w[0] + uvs[1][i] * w[1] + uvs[2][i] * w[2])
                };
                let here = at(weights);
                [[1.0, 0.0], [0.0, 1.0]].map(|[dx, dy]| {
                    let there = at(shape.open_weights([place[0] + dx, place[1] + dy]));
                    [there[0] - here[0], there[1] - here[1]]
                })
            }
            None => [[0.0; 2]; 2],
        };
        let reach = 3.0 * self.pixel_size(position);
        let known = match known {
            Some(known) if known.serves(position, normal, reach) => known,
            other => {
                other.insert(Known { position, normal, reaching: self.lights.reaching(position, normal) })
            }
        };
        let point = Point { triangle, weights, normal, view, steps };
        self.material.shade(&self.surface, &point, &self.lights, &known.reaching)
    }

    /// How wide a pixel is at a point of the surface.
    fn pixel_size(&self, position: Vec3) -> f64 {
        let [x, y, depth] = self.camera.project(position);
        let (a, b) = (self.camera.ray(x, y), self.camera.ray(x + 1.0, y));
        depth * dot(sub(a, b), sub(a, b)).sqrt()
    }
}

/// The light that reaches a point, kept for its neighbours within a pixel.
struct Known {
    position: Vec3,
    normal: Vec3,
    reaching: super::light::Reaching,
}

impl Known {
    fn serves(&self, position: Vec3, normal: Vec3, reach: f64) -> bool {
        let apart = sub(position, self.position);
        dot(apart, apart) < reach * reach && dot(normal, self.normal) > 0.95
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: PortraitSettings = PortraitSettings {
        picture: [64, 48],
        azimuth: 0.0,
        elevation: 0.0,
        zoom: 1.0,
        background: Background::Transparent,
    };

    /// A unit square in the plane z = 0, facing the viewer.
    fn square() -> Mesh {
        Mesh {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
            uvs: vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        }
    }

    #[test]
    fn a_square_fills_its_part_of_the_picture_without_a_seam() {
        let image = portrait(&square(), &SETTINGS, &()).unwrap();
        // 80 % of the height: rows and columns around the middle.
        let alpha = |x: u32, y: u32| image.get(x, y, 3);
        for (x, y) in (0..48).flat_map(|y| (0..64).map(move |x| (x, y))) {
            let inside = (14..50).contains(&x) && (6..42).contains(&y);
            let outside = !(12..52).contains(&x) || !(4..44).contains(&y);
            assert!(!inside || alpha(x, y) == 1.0, "hole at {x} {y}");
            assert!(!outside || alpha(x, y) == 0.0, "stain at {x} {y}");
        }
    }

    #[test]
    fn the_texture_is_upright() {
        let mut mesh = square();
        // Red above, blue on the lower left, green on the lower right.
        let texture = Image::from_fn(8, 8, |x, y| match (x < 4, y < 4) {
            (_, true) => [200u8, 20, 20],
            (true, false) => [20, 20, 200],
            (false, false) => [20, 200, 20],
        });
        mesh.textures.push(("color".into(), texture));
        let image = portrait(&mesh, &SETTINGS, &()).unwrap();
        let strongest = |x: u32, y: u32| {
            let rgb = image.rgb8(x, y);
            (0..3).max_by_key(|&c| rgb[c])
        };
        let found = [strongest(20, 12), strongest(44, 12), strongest(20, 36), strongest(44, 36)];
        assert_eq!(found, [Some(0), Some(0), Some(2), Some(1)]);
    }

    #[test]
    fn the_nearer_of_two_surfaces_is_seen() {
        let mut mesh = square();
        let behind: Vec<_> = mesh.positions.iter().map(|&[x, y, _]| [x, y, -0.5]).collect();
        mesh.positions.extend(behind);
        mesh.triangles.extend([[4, 5, 6], [4, 6, 7]]);
        mesh.uvs.clear();
        mesh.colors = [[[200, 30, 30, 255]; 4], [[30, 30, 200, 255]; 4]].concat();
        let image = portrait(&mesh, &SETTINGS, &()).unwrap();
        let [r, _, b] = image.rgb8(32, 24);
        assert!(r > b + 50, "{r} {b}");
        let back = PortraitSettings { azimuth: 180.0, ..SETTINGS };
        let [r, _, b] = portrait(&mesh, &back, &()).unwrap().rgb8(32, 24);
        assert!(b > r + 50, "{r} {b}");
    }

    #[test]
    fn the_number_of_threads_makes_no_difference() {
        let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        let settings = PortraitSettings { azimuth: 30.0, elevation: 30.0, ..SETTINGS };
        let image = |n| pool(n).install(|| portrait(&square(), &settings, &()).unwrap());
        assert_eq!(image(1), image(3));
    }

    #[test]
    fn strange_meshes_are_drawn_or_refused() {
        assert!(matches!(portrait(&Mesh::default(), &SETTINGS, &()), Err(RenderError::EmptyMesh(0, 0))));
        let mut huge = square();
        huge.positions.iter_mut().flatten().for_each(|c| *c *= 1e17);
        assert!(portrait(&huge, &SETTINGS, &()).is_ok());
        let mut odd = square();
        odd.uvs.iter_mut().flatten().for_each(|c| *c = f32::NAN);
        odd.textures.push(("color".into(), Image::from_fn(1, 1, |_, _| [9u8; 3])));
        assert!(portrait(&odd, &SETTINGS, &()).is_ok());
    }
}
