//! The camera that turns about an object. What is shown lies within a ball of radius 1 around the origin.

use eframe::egui::{Pos2, Rect, Vec2, pos2};

use super::vector::{Vec3, add, cross, dot, product, scale, sub};

/// Half the vertical opening in degrees: a long lens, as for a picture of a thing.
const HALF_OPENING: f32 = 15.0;
/// The distance at which the ball of radius 1 just fits.
const HOME: f32 = 4.0;

/// A camera on a sphere around a target. World axes: x to the right, y up, z towards a viewer at azimuth 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// What it looks at.
    pub target: Vec3,
    /// Degrees to the right.
    pub azimuth: f32,
    /// Degrees upwards.
    pub elevation: f32,
    /// From the target.
    pub distance: f32,
}

impl Default for Orbit {
    fn default() -> Self {
        Self { target: [0.0; 3], azimuth: 35.0, elevation: 20.0, distance: HOME }
    }
}

impl Orbit {
    /// From the target to the eye, length 1.
    pub fn back(&self) -> Vec3 {
        let ((sin_az, cos_az), (sin_el, cos_el)) =
            (self.azimuth.to_radians().sin_cos(), self.elevation.to_radians().sin_cos());
        [sin_az * cos_el, sin_el, cos_az * cos_el]
    }

    /// To the right of the picture, length 1.
    pub fn right(&self) -> Vec3 {
        let (sin, cos) = self.azimuth.to_radians().sin_cos();
        [cos, 0.0, -sin]
    }

    /// Upwards in the picture, length 1.
    pub fn up(&self) -> Vec3 {
        cross(self.back(), self.right())
    }

    /// Where the eye is.
    pub fn eye(&self) -> Vec3 {
        add(self.target, scale(self.back(), self.distance))
    }

    /// Half the picture's height and width at distance 1.
    fn slopes(&self, size: Vec2) -> [f32; 2] {
        // A narrow picture keeps the whole ball in view.
        let tan = HALF_OPENING.to_radians().tan();
        let (width, height) = (size.x.max(1.0), size.y.max(1.0));
        let narrow = (width / height).min(1.0);
        [tan / narrow * width / height, tan / narrow]
    }

    /// World to clip space, by columns; depths from 0 to 1.
    pub fn view_projection(&self, size: Vec2) -> [[f32; 4]; 4] {
        let (right, up, back, eye) = (self.right(), self.up(), self.back(), self.eye());
        let row = |v: Vec3| [v[0], v[1], v[2], -dot(v, eye)];
        let (r, u, b) = (row(right), row(up), row(back));
        let view = std::array::from_fn(|c| [r[c], u[c], b[c], if c == 3 { 1.0 } else { 0.0 }]);
        let [slope_x, slope_y] = self.slopes(size);
        let (near, far) = ((self.distance * 0.02).max(0.005), self.distance + 40.0);
        let depth = far / (near - far);
        let projection = [
            [1.0 / slope_x, 0.0, 0.0, 0.0],
            [0.0, 1.0 / slope_y, 0.0, 0.0],
            [0.0, 0.0, depth, -1.0],
            [0.0, 0.0, near * depth, 0.0],
        ];
        product(projection, view)
    }

    /// Where a point appears; `None` behind the eye.
    pub fn project(&self, point: Vec3, rect: Rect) -> Option<Pos2> {
        let v = sub(point, self.eye());
        let depth = -dot(v, self.back());
        if depth <= 1e-4 {
            return None;
        }
        let [slope_x, slope_y] = self.slopes(rect.size());
        let x = dot(v, self.right()) / depth / slope_x;
        let y = dot(v, self.up()) / depth / slope_y;
        Some(pos2(rect.center().x + x * rect.width() / 2.0, rect.center().y - y * rect.height() / 2.0))
    }

    /// The direction in which a place of the picture looks; its component straight ahead is 1.
    #[cfg(test)]
    pub fn ray(&self, at: Pos2, rect: Rect) -> Vec3 {
        let [slope_x, slope_y] = self.slopes(rect.size());
        let x = (at.x - rect.center().x) / (rect.width() / 2.0).max(0.5) * slope_x;
        let y = (rect.center().y - at.y) / (rect.height() / 2.0).max(0.5) * slope_y;
        sub(add(scale(self.right(), x), scale(self.up(), y)), self.back())
    }

    /// Turns by a drag of so many points.
    pub fn turn(&mut self, delta: Vec2) {
        self.azimuth = (self.azimuth - delta.x * 0.4).rem_euclid(360.0);
        self.elevation = (self.elevation + delta.y * 0.4).clamp(-89.0, 89.0);
    }

    /// Moves the target so that it follows a drag.
    pub fn pan(&mut self, delta: Vec2, rect: Rect) {
        let [_, slope_y] = self.slopes(rect.size());
        let unit = 2.0 * self.distance * slope_y / rect.height().max(1.0);
        let by = add(scale(self.right(), -delta.x * unit), scale(self.up(), delta.y * unit));
        self.target = add(self.target, by).map(|c| c.clamp(-3.0, 3.0));
    }

    /// Comes closer by a factor.
    pub fn zoom(&mut self, factor: f32) {
        if factor.is_finite() && factor > 0.0 {
            self.distance = (self.distance / factor).clamp(0.3, 40.0);
        }
    }

    /// How much larger than at first the object appears.
    pub fn magnification(&self) -> f32 {
        HOME / self.distance
    }
}

#[cfg(test)]
mod tests {
    use eframe::egui::vec2;
    use proptest::prelude::*;

    use super::*;

    fn any_orbit() -> impl Strategy<Value = Orbit> {
        (-360f32..360.0, -89f32..89.0, 1f32..20.0, prop::array::uniform3(-1f32..1.0))
            .prop_map(|(azimuth, elevation, distance, target)| Orbit { target, azimuth, elevation, distance })
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(200) })]

        #[test]
        fn the_ray_of_a_projected_point_meets_the_point(orbit in any_orbit(), p in prop::array::uniform3(-1f32..1.0)) {
            let rect = Rect::from_min_size(pos2(30.0, 40.0), vec2(640.0, 400.0));
            if let Some(at) = orbit.project(p, rect) {
                let depth = -dot(sub(p, orbit.eye()), orbit.back());
                let met = add(orbit.eye(), scale(orbit.ray(at, rect), depth));
                prop_assert!(sub(met, p).iter().all(|c| c.abs() < 1e-3), "{met:?} {p:?}");
            }
        }

        #[test]
        fn the_matrix_projects_as_the_camera_does(orbit in any_orbit(), p in prop::array::uniform3(-1f32..1.0)) {
            let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(300.0, 500.0));
            let m = orbit.view_projection(rect.size());
            let clip: [f32; 4] = std::array::from_fn(|r| m[0][r] * p[0] + m[1][r] * p[1] + m[2][r] * p[2] + m[3][r]);
            if let Some(at) = orbit.project(p, rect) {
                let (x, y) = ((clip[0] / clip[3] + 1.0) * 150.0, (1.0 - clip[1] / clip[3]) * 250.0);
                let gap = (x - at.x).abs() + (y - at.y).abs();
                prop_assert!(gap < 0.05 * (1.0 + at.x.abs() + at.y.abs()) / 10.0, "{x} {y} {at:?}");
            }
        }

        #[test]
        fn the_frame_stays_orthonormal(orbit in any_orbit()) {
            let (r, u, b) = (orbit.right(), orbit.up(), orbit.back());
            for (a, c, expected) in [(r, r, 1.0), (u, u, 1.0), (b, b, 1.0), (r, u, 0.0), (u, b, 0.0), (r, b, 0.0)] {
                prop_assert!((dot(a, c) - expected).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn a_drag_that_pans_takes_the_target_along() {
        let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(400.0, 300.0));
        let mut orbit = Orbit::default();
        let before = orbit.project([0.0; 3], rect).unwrap();
        orbit.pan(vec2(30.0, -20.0), rect);
        let after = orbit.project([0.0; 3], rect).unwrap();
        assert!((after - before - vec2(30.0, -20.0)).length() < 1.0, "{before:?} {after:?}");
    }
}
