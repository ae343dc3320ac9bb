//! Which triangle is seen at each sample of a tile.

use super::camera::Camera;
use super::vector::Vec3;

/// Samples of coverage in each shaded place.
pub(super) const SUB: usize = 4;

/// Where they lie: a square turned so that no two share a row or column.
const PATTERN: [[f64; 2]; SUB] = [[0.375, 0.125], [0.875, 0.375], [0.125, 0.625], [0.625, 0.875]];

/// Marks samples where nothing is seen.
const NOTHING: u32 = u32::MAX;

/// A triangle in the picture.
pub(super) struct Triangle {
    /// Columns and rows of the corners.
    places: [[f64; 2]; 3],
    /// One over the depths of the corners.
    inverse: Vec3,
    /// Twice the area, with the sign of the orientation.
    area: f64,
}

impl Triangle {
    /// The triangle as the camera sees it.
    pub fn new(corners: &[Vec3; 3], camera: &Camera) -> Self {
        let [a, b, c] = corners.map(|corner| camera.project(corner));
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        Self { places: [a, b, c].map(|[x, y, _]| [x, y]), inverse: [a, b, c].map(|p| 1.0 / p[2]), area }
    }

    /// The smallest and largest column and row, if the triangle can be seen at all.
    fn bounds(&self) -> Option<[[f64; 2]; 2]> {
        let [a, b, c] = self.places;
        let low = std::array::from_fn(|i| a[i].min(b[i]).min(c[i]));
        let high: [f64; 2] = std::array::from_fn(|i| a[i].max(b[i]).max(c[i]));
        let finite = low.iter().chain(&high).chain(&self.inverse).all(|n| n.is_finite());
        (finite && self.area != 0.0 && self.inverse.iter().all(|&n| n > 0.0)).then_some([low, high])
    }

    /// Weights of the corners in the picture; each is negative beyond the opposite edge.
    fn flat_weights(&self, [x, y]: [f64; 2]) -> Vec3 {
        let [a, b, c] = self.places;
        let edge = |p: [f64; 2], q: [f64; 2]| (q[0] - p[0]) * (y - p[1]) - (x - p[0]) * (q[1] - p[1]);
        [edge(b, c) / self.area, edge(c, a) / self.area, edge(a, b) / self.area]
    }

    /// Weights of the corners in space at a place of the picture, also outside the triangle.
    pub fn open_weights(&self, place: [f64; 2]) -> Vec3 {
        let flat = self.flat_weights(place);
        let w: Vec3 = std::array::from_fn(|i| flat[i] * self.inverse[i]);
        let sum = w[0] + w[1] + w[2];
        if sum.abs() > 1e-300 { w.map(|w| w / sum) } else { [1.0 / 3.0; 3] }
    }

    /// Weights of the corners in space, moved into the triangle where the place lies outside.
    pub fn weights(&self, place: [f64; 2]) -> Vec3 {
        let w = self.open_weights(place).map(|w| if w > 0.0 { w } else { 0.0 });
        let sum = w[0] + w[1] + w[2];
        if sum > 0.0 { w.map(|w| w / sum) } else { [1.0 / 3.0; 3] }
    }
}

/// The triangles that may be seen in each tile of `tile` pixels, tiles in rows; triangles are given in half pixels.
pub(super) fn bin(triangles: &[Triangle], picture: [u32; 2], tile: u32) -> Vec<Vec<u32>> {
    let [columns, rows] = picture.map(|n| n.div_ceil(tile) as usize);
    let mut bins = vec![Vec::new(); columns * rows];
    for (i, triangle) in triangles.iter().enumerate() {
        let Some([low, high]) = triangle.bounds() else { continue };
        let size = f64::from(tile) * 2.0;
        let range = |axis: usize, count: usize| {
            let first = (low[axis] / size).floor().max(0.0) as usize;
            let last = (high[axis] / size).floor();
            if last < 0.0 { 0..0 } else { first..(last as usize + 1).min(count) }
        };
        for row in range(1, rows) {
            for column in range(0, columns) {
                bins[row * columns + column].push(i as u32);
            }
        }
    }
    bins
}

/// The samples of one tile, in half pixels.
pub(super) struct Tile {
    origin: [u32; 2],
    size: [usize; 2],
    /// One over the depth of what is seen.
    nearest: Vec<f64>,
    triangle: Vec<u32>,
}

impl Tile {
    /// A tile where nothing is seen.
    pub fn new(origin: [u32; 2], size: [usize; 2]) -> Self {
        let samples = size[0] * size[1] * SUB;
        Self { origin, size, nearest: vec![0.0; samples], triangle: vec![NOTHING; samples] }
    }

    /// Draws a triangle where it is nearer than what was drawn before.
    pub fn draw(&mut self, id: u32, triangle: &Triangle) {
        let Some([low, high]) = triangle.bounds() else { return };
        let range = |axis: usize| {
            let origin = f64::from(self.origin[axis]);
            let first = (low[axis] - origin).floor().max(0.0) as usize;
            let last = (high[axis] - origin).ceil().max(0.0) as usize;
            first..last.min(self.size[axis])
        };
        let columns = range(0);
        for row in range(1) {
            for column in columns.clone() {
                for (s, [dx, dy]) in PATTERN.into_iter().enumerate() {
                    let place = [
                        f64::from(self.origin[0]) + column as f64 + dx,
                        f64::from(self.origin[1]) + row as f64 + dy,
                    ];
                    let w = triangle.flat_weights(place);
                    if w[0] < 0.0 || w[1] < 0.0 || w[2] < 0.0 {
                        continue;
                    }
                    let inverse =
                        w[0] * triangle.inverse[0] + w[1] * triangle.inverse[1] + w[2] * triangle.inverse[2];
                    let at = (row * self.size[0] + column) * SUB + s;
                    if inverse > self.nearest[at] {
                        self.nearest[at] = inverse;
                        self.triangle[at] = id;
                    }
                }
            }
        }
    }

    /// What covers a place: each triangle once, with the mean place of its samples in the picture and their
    /// number.
    pub fn covers(&self, column: usize, row: usize) -> impl Iterator<Item = (u32, [f64; 2], f64)> + '_ {
        let at = (row * self.size[0] + column) * SUB;
        let ids = self.triangle.get(at..at + SUB).unwrap_or(&[]);
        let first = move |s: usize, id: u32| id != NOTHING && !ids[..s].contains(&id);
        let corner = [f64::from(self.origin[0]) + column as f64, f64::from(self.origin[1]) + row as f64];
        ids.iter().enumerate().filter(move |&(s, &id)| first(s, id)).map(move |(_, &id)| {
            let (mut sum, mut count) = ([0.0; 2], 0.0);
            for (&other, place) in ids.iter().zip(PATTERN) {
                if other == id {
                    sum = [sum[0] + place[0], sum[1] + place[1]];
                    count += 1.0;
                }
            }
            (id, [corner[0] + sum[0] / count, corner[1] + sum[1] / count], count)
        })
    }
}
