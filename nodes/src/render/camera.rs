//! A perspective camera that frames what it is given.

use super::vector::{Vec3, add, cross, dot, scale, sub};

/// The distance of the eye, in radii of what is looked at: a long lens, as for a picture of a thing.
const DISTANCE: f64 = 4.6;

/// A perspective camera. World axes: x to the right, y up, z towards a viewer at azimuth 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    eye: Vec3,
    right: Vec3,
    up: Vec3,
    forward: Vec3,
    /// Pixels a unit of slope.
    focal: f64,
    /// The pixel that looks straight ahead.
    middle: [f64; 2],
}

impl Camera {
    /// A camera whose picture is filled by `points` up to the fraction `fill` of its narrower side, seen
    /// from `azimuth` (degrees, to the right) and `elevation` (degrees, upwards); `zoom` enlarges further.
    pub fn framing(
        points: impl Iterator<Item = [f64; 3]> + Clone,
        [azimuth, elevation]: [f64; 2],
        zoom: f64,
        fill: f64,
        size: [u32; 2],
    ) -> Self {
        let far = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let (low, high) = points.clone().fold(far, |(low, high): (Vec3, Vec3), p| {
            (std::array::from_fn(|i| low[i].min(p[i])), std::array::from_fn(|i| high[i].max(p[i])))
        });
        let center: Vec3 = std::array::from_fn(|i| (low[i] + high[i]) / 2.0);
        let radius = points.clone().map(|p| dot(sub(p, center), sub(p, center))).fold(0.0, f64::max).sqrt();
        let (sin_az, cos_az) = libm::sincos(azimuth.to_radians());
        let (sin_el, cos_el) = libm::sincos(elevation.to_radians());
        let back = [sin_az * cos_el, sin_el, cos_az * cos_el];
        let right = [cos_az, 0.0, -sin_az];
        let mut camera = Self {
            eye: add(center, scale(back, radius.max(1e-30) * DISTANCE)),
            right,
            up: cross(back, right),
            forward: scale(back, -1.0),
            focal: 1.0,
            middle: [0.0; 2],
        };
        let spread = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        let [x0, y0, x1, y1] = points.fold(spread, |[x0, y0, x1, y1], p| {
            let [x, y, _] = camera.project(p);
            [x0.min(x), y0.min(y), x1.max(x), y1.max(y)]
        });
        let [width, height] = size.map(f64::from);
        let focal = fill * (width / (x1 - x0).max(1e-9)).min(height / (y1 - y0).max(1e-9)) * zoom;
        camera.focal = focal;
        camera.middle = [(width - focal * (x0 + x1)) / 2.0, (height - focal * (y0 + y1)) / 2.0];
        camera
    }

    /// Where a point appears: column and row in pixels (the first pixel covers 0 to 1), and its depth.
    pub fn project(&self, point: [f64; 3]) -> [f64; 3] {
        let v = sub(point, self.eye);
        let depth = dot(v, self.forward);
        let slope = self.focal / depth;
        [self.middle[0] + slope * dot(v, self.right), self.middle[1] - slope * dot(v, self.up), depth]
    }

    /// The direction in which a place of the picture looks; its component straight ahead is 1.
    pub fn ray(&self, x: f64, y: f64) -> [f64; 3] {
        let (a, b) = ((x - self.middle[0]) / self.focal, (self.middle[1] - y) / self.focal);
        std::array::from_fn(|i| self.forward[i] + a * self.right[i] + b * self.up[i])
    }

    /// Where the camera stands.
    pub fn eye(&self) -> [f64; 3] {
        self.eye
    }

    /// The camera of the same picture at `factor` times as many pixels.
    pub fn enlarged(&self, factor: f64) -> Self {
        Self { focal: self.focal * factor, middle: self.middle.map(|m| m * factor), ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ray_of_a_projected_point_meets_the_point() {
        let corners = (0..8).map(|i| [f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2) * 3.0]);
        let camera = Camera::framing(corners.clone(), [40.0, 25.0], 1.0, 0.8, [320, 200]);
        for p in corners {
            let [x, y, depth] = camera.project(p);
            assert!((31.9..288.1).contains(&x) && (19.9..180.1).contains(&y), "{x} {y}");
            let back = add(camera.eye(), scale(camera.ray(x, y), depth));
            assert!(sub(back, p).iter().all(|c| c.abs() < 1e-9), "{back:?} {p:?}");
        }
    }
}
