//! The lights of the studio: a large soft key, a fill, a rim from behind, and a bright room around.

use super::shadow::Shadows;
use super::vector::{Vec3, add, dot, scale, unit_or};
use crate::control::{Cancelled, Control};

/// Directions of the room, all around.
const ROOM: usize = 80;
/// Directions over the face of the key light.
const KEY: usize = 18;
/// Half the angle that the key light fills, as a slope.
const KEY_SPREAD: f64 = 0.17;
/// Irradiance of the key light on a surface that faces it.
const KEY_POWER: f64 = 0.92;
/// Texels along the edge of depth maps.
const MAP_SIZES: [usize; 2] = [144, 448];

/// The lights, with what stands in their way.
pub(super) struct Lights {
    /// Each direction with the irradiance it gives to a surface that faces it.
    beams: Vec<(Vec3, f64)>,
    shadows: Shadows,
    key: Vec3,
    frame: [Vec3; 3],
}

impl Lights {
    /// Lights for a viewer at that azimuth in degrees, around triangles within a sphere.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(
        azimuth: f64,
        corners: &[[Vec3; 3]],
        sphere: (Vec3, f64),
        control: &dyn Control,
    ) -> Result<Self, Cancelled> {
        let (sin, cos) = libm::sincos(azimuth.to_radians());
        // Right, up, and towards the viewer on the ground.
        let frame = [[cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos]];
        let key = from_frame(&frame, [-0.52, 0.68, 0.52]);
        let mut directions = Vec::new();
        let mut beams = Vec::new();
        for i in 0..ROOM {
            let direction = fibonacci_sphere(i, ROOM);
            directions.push((direction, MAP_SIZES[0]));
            beams.push((direction, 4.0 / ROOM as f64 * room(&frame, direction)));
        }
        for i in 0..KEY {
            let [x, y] = vogel_disc(i, KEY);
            let (u, v) = ([key[2], 0.0, -key[0]], [0.0, 1.0, 0.0]);
            let shifted = add(key, add(scale(u, x * KEY_SPREAD), scale(v, y * KEY_SPREAD)));
            let direction = unit_or(shifted, key);
            directions.push((direction, MAP_SIZES[1]));
            beams.push((direction, KEY_POWER / KEY as f64));
        }
        let shadows = Shadows::new(&directions, corners, sphere, control)?;
        Ok(Self { beams, shadows, key, frame })
    }

    /// How much of each beam reaches a point with that geometric normal.
    pub fn reaching(&self, point: Vec3, normal: Vec3) -> Reaching {
        let mut light = Vec::new();
        self.shadows.light(point, normal, &mut light);
        Reaching(light)
    }

    /// The diffuse irradiance on a surface with that normal.
    pub fn irradiance(&self, reaching: &Reaching, normal: Vec3) -> f64 {
        let beams = self.beams.iter().zip(&reaching.0);
        beams.map(|(&(d, power), &lit)| power * f64::from(lit) * dot(d, normal).max(0.0)).sum()
    }

    /// The fraction of the key light that arrives.
    pub fn key_fraction(&self, reaching: &Reaching) -> f64 {
        reaching.0.iter().skip(ROOM).map(|&lit| f64::from(lit)).sum::<f64>() / KEY as f64
    }

    /// The fraction of the room's light that arrives, compared with an open surface.
    pub fn openness(&self, reaching: &Reaching, normal: Vec3) -> f64 {
        let (mut some, mut all) = (0.0, 1e-9);
        for (&(d, power), &lit) in self.beams.iter().zip(&reaching.0).take(ROOM) {
            let share = power * dot(d, normal).max(0.0);
            some += share * f64::from(lit);
            all += share;
        }
        (some / all).min(1.0)
    }

    /// The parts of the light that the object keeps from a point of the ground: the room's and the key
    /// light's, both of all the light there would be.
    pub fn kept_away(&self, point: Vec3) -> [f64; 2] {
        let reaching = self.reaching(point, [0.0, 1.0, 0.0]);
        let (mut open, mut kept) = (1e-9, [0.0; 2]);
        for (i, (&(d, power), &lit)) in self.beams.iter().zip(&reaching.0).enumerate() {
            let share = power * d[1].max(0.0);
            open += share;
            kept[usize::from(i >= ROOM)] += share * (1.0 - f64::from(lit));
        }
        kept.map(|part| part / open)
    }

    /// Towards the middle of the key light.
    pub fn key(&self) -> Vec3 {
        self.key
    }

    /// The irradiance of the key light on a surface that faces it.
    pub fn key_power(&self) -> f64 {
        KEY_POWER
    }

    /// What a mirror sees in a direction: the room, and the key light blurred by the roughness.
    pub fn reflected(&self, direction: Vec3, roughness: f64) -> f64 {
        let sharpness = 2.0 + 60.0 * (1.0 - roughness) * (1.0 - roughness);
        let lobe = libm::pow(dot(direction, self.key).max(0.0), sharpness) * (0.3 + 0.03 * sharpness);
        room(&self.frame, direction) + lobe
    }
}

/// See [`Lights::reaching`].
pub(super) struct Reaching(Vec<f32>);

/// The radiance of the room: brighter above, a fill at the right, a rim light behind, light from the floor.
fn room(frame: &[Vec3; 3], direction: Vec3) -> f64 {
    let height = direction[1];
    let sky = if height > 0.0 { 0.25 + 0.22 * height } else { 0.25 + 0.10 * height };
    let fill = dot(direction, from_frame(frame, [0.85, 0.25, 0.45])).max(0.0);
    let rim = dot(direction, from_frame(frame, [0.45, 0.5, -0.8])).max(0.0);
    sky + 0.22 * fill * fill + 0.9 * libm::pow(rim, 6.0)
}

fn from_frame(frame: &[Vec3; 3], [x, y, z]: Vec3) -> Vec3 {
    let sum = add(add(scale(frame[0], x), scale(frame[1], y)), scale(frame[2], z));
    unit_or(sum, [0.0, 1.0, 0.0])
}

/// Evenly spread directions, by the golden angle.
fn fibonacci_sphere(i: usize, count: usize) -> Vec3 {
    let y = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
    let (sin, cos) = libm::sincos(i as f64 * GOLDEN_ANGLE);
    let r = (1.0 - y * y).max(0.0).sqrt();
    [r * cos, y, r * sin]
}

/// Evenly spread points of the unit disc, by the golden angle.
fn vogel_disc(i: usize, count: usize) -> [f64; 2] {
    let r = ((i as f64 + 0.5) / count as f64).sqrt();
    let (sin, cos) = libm::sincos(i as f64 * GOLDEN_ANGLE);
    [r * cos, r * sin]
}

const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
