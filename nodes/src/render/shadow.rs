//! Which directions of light reach a point: an orthographic depth map for each direction.

use rayon::prelude::*;

use super::vector::{Vec3, add, cross, dot, scale, sub, unit_or};
use crate::control::{Cancelled, Control, check};

/// A picture of how far towards the light a surface reaches.
pub(super) struct DepthMap {
    /// Towards the light.
    pub direction: Vec3,
    across: [Vec3; 2],
    center: Vec3,
    radius: f64,
    size: usize,
    depths: Vec<f32>,
}

impl DepthMap {
    /// The map of triangles within the sphere, `size` texels wide.
    fn new(direction: Vec3, corners: &[[Vec3; 3]], center: Vec3, radius: f64, size: usize) -> Self {
        let helper = if direction[1].abs() < 0.9 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] };
        let u = unit_or(cross(helper, direction), [1.0, 0.0, 0.0]);
        let across = [u, cross(direction, u)];
        let depths = vec![f32::NEG_INFINITY; size * size];
        let mut map = Self { direction, across, center, radius, size, depths };
        for triangle in corners {
            map.draw(triangle.map(|p| map.place(p)));
        }
        map
    }

    /// Columns and rows in texels, and depth towards the light.
    fn place(&self, point: Vec3) -> Vec3 {
        let v = sub(point, self.center);
        let texels = |axis: Vec3| (dot(v, axis) / self.radius * 0.5 + 0.5) * self.size as f64;
        [texels(self.across[0]), texels(self.across[1]), dot(v, self.direction)]
    }

    fn draw(&mut self, [a, b, c]: [Vec3; 3]) {
        let range = |i: usize| {
            let (low, high) = (a[i].min(b[i]).min(c[i]), a[i].max(b[i]).max(c[i]));
            // Texels whose centres lie in the range.
            ((low - 0.5).ceil().max(0.0) as usize, ((high + 0.5).floor().max(0.0) as usize).min(self.size))
        };
        let ((x0, x1), (y0, y1)) = (range(0), range(1));
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        if x0 >= x1 || y0 >= y1 || area == 0.0 {
            // Too small to hold a centre: it still stops some light.
            let mean = |i: usize| (a[i] + b[i] + c[i]) / 3.0;
            return self.raise(mean(0).max(0.0) as usize, mean(1).max(0.0) as usize, mean(2));
        }
        for y in y0..y1 {
            for x in x0..x1 {
                let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
                let w1 = ((px - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (py - a[1])) / area;
                let w2 = ((b[0] - a[0]) * (py - a[1]) - (px - a[0]) * (b[1] - a[1])) / area;
                if w1 >= 0.0 && w2 >= 0.0 && w1 + w2 <= 1.0 {
                    self.raise(x, y, a[2] + w1 * (b[2] - a[2]) + w2 * (c[2] - a[2]));
                }
            }
        }
    }

    fn raise(&mut self, x: usize, y: usize, depth: f64) {
        if let Some(texel) = self.depths.get_mut(y.min(self.size - 1) * self.size + x.min(self.size - 1)) {
            *texel = texel.max(depth as f32);
        }
    }

    /// How much light of this direction reaches a point of a surface with that normal, 0 to 1.
    fn light(&self, point: Vec3, normal: Vec3) -> f64 {
        let texel = 2.0 * self.radius / self.size as f64;
        let [x, y, depth] = self.place(add(point, scale(normal, 1.6 * texel)));
        let limit = (depth + 0.4 * texel) as f32;
        let (x, y) = (x - 0.5, y - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let lit = |dx: i64, dy: i64| {
            let (i, j) = (left as i64 + dx, top as i64 + dy);
            let inside = (0..self.size as i64).contains(&i) && (0..self.size as i64).contains(&j);
            let free = !inside || self.depths[j as usize * self.size + i as usize] <= limit;
            f64::from(u8::from(free))
        };
        let (fx, fy) = (x - left, y - top);
        (lit(0, 0) * (1.0 - fx) + lit(1, 0) * fx) * (1.0 - fy)
            + (lit(0, 1) * (1.0 - fx) + lit(1, 1) * fx) * fy
    }
}

/// Depth maps of many directions.
pub(super) struct Shadows {
    maps: Vec<DepthMap>,
}

impl Shadows {
    /// The maps of `directions`, each given with its resolution.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(
        directions: &[(Vec3, usize)],
        corners: &[[Vec3; 3]],
        (center, radius): (Vec3, f64),
        control: &dyn Control,
    ) -> Result<Self, Cancelled> {
        let maps = directions.par_iter().map(|&(direction, size)| {
            check(control)?;
            Ok(DepthMap::new(direction, corners, center, radius, size))
        });
        Ok(Self { maps: maps.collect::<Result<_, Cancelled>>()? })
    }

    /// For each direction, how much of its light reaches a point of a surface with that normal; nothing
    /// from behind the surface.
    pub fn light(&self, point: Vec3, normal: Vec3, to: &mut Vec<f32>) {
        to.clear();
        to.extend(self.maps.iter().map(|map| {
            if dot(map.direction, normal) <= 0.0 { 0.0 } else { map.light(point, normal) as f32 }
        }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_roof_keeps_light_from_above_away() {
        let roof = [[-1.0, 1.0, -1.0], [1.0, 1.0, -1.0], [0.0, 1.0, 1.0]];
        let directions = [([0.0, 1.0, 0.0], 64), ([1.0, 0.0, 0.0], 64), ([0.0, -1.0, 0.0], 64)];
        let shadows = Shadows::new(&directions, &[roof], ([0.0; 3], 2.0), &()).unwrap();
        let mut light = Vec::new();
        shadows.light([0.0; 3], [0.6, 0.8, 0.0], &mut light);
        assert_eq!(light, [0.0, 1.0, 0.0]);
        shadows.light([1.8, 0.0, 0.0], [0.6, 0.8, 0.0], &mut light);
        assert_eq!(light, [1.0, 1.0, 0.0]);
        shadows.light([0.0, 1.0, 0.0], [0.0, 1.0, 0.0], &mut light);
        assert_eq!(light[0], 1.0);
    }
}
