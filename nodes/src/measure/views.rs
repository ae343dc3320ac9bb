//! Pixels of an exemplar and of the planes through a box of voxels.

use crate::data::{Image, Map, Volume};

/// The ways of pairing four quadrants, which count along rows.
pub(super) const PAIRS: [[[usize; 2]; 2]; 3] = [[[0, 3], [1, 2]], [[0, 1], [2, 3]], [[0, 2], [1, 3]]];

/// A plain RGB picture.
pub(super) struct Pixels {
    pub width: usize,
    pub height: usize,
    pub data: Vec<[u8; 3]>,
}

impl Pixels {
    pub fn of(image: &Image) -> Self {
        let (width, height) = (image.width(), image.height());
        let data = (0..height).flat_map(|y| (0..width).map(move |x| image.rgb8(x, y))).collect();
        Self { width: width as usize, height: height as usize, data }
    }

    pub fn get(&self, x: usize, y: usize) -> [u8; 3] {
        self.data[y * self.width + x]
    }

    /// A part, which must be inside.
    pub fn cut(&self, [x, y]: [usize; 2], [width, height]: [usize; 2]) -> Self {
        let rows = (y..y + height).flat_map(|row| &self.data[row * self.width + x..][..width]);
        Self { width, height, data: rows.copied().collect() }
    }

    /// The quadrants in two disjoint halves, in all three ways, opposite quadrants first.
    pub fn splits(&self) -> [[[Self; 2]; 2]; 3] {
        let size = [self.width / 2, self.height / 2];
        let quadrant = |i: usize| self.cut([i % 2 * size[0], i / 2 * size[1]], size);
        PAIRS.map(|split| split.map(|half| half.map(quadrant)))
    }

    /// Squares of this edge in the corners.
    pub fn corners(&self, edge: usize) -> [Self; 4] {
        let (w, h) = (self.width - edge, self.height - edge);
        [[0, 0], [w, 0], [0, h], [w, h]].map(|at| self.cut(at, [edge; 2]))
    }
}

/// A box of RGB voxels.
pub(super) struct Voxels {
    pub size: [usize; 3],
    pub data: Vec<[u8; 3]>,
}

impl Voxels {
    /// The colours of a volume; `None` if the map does not fit it.
    pub fn of(volume: &Volume, color: &Map) -> Option<Self> {
        let (n, count) = (color.channels, volume.voxels());
        if n == 0 || color.samples.len() != count.checked_mul(n)? {
            return None;
        }
        let channel = |i: usize, c: usize| color.samples.get_u8(i * n + if n < 3 { 0 } else { c });
        let data = (0..count).map(|i| [channel(i, 0), channel(i, 1), channel(i, 2)]).collect();
        Some(Self { size: volume.size, data })
    }

    pub fn get(&self, [x, y, z]: [usize; 3]) -> [u8; 3] {
        self.data[(z * self.size[1] + y) * self.size[0] + x]
    }

    /// The slice across an axis: columns along x (or y for axis 0), rows along z (or y for axis 2).
    pub fn slice(&self, axis: usize, at: usize) -> Pixels {
        let (columns, rows) = in_plane(axis);
        let (width, height) = (self.size[columns], self.size[rows]);
        let mut data = Vec::with_capacity(width * height);
        for row in 0..height {
            for column in 0..width {
                let mut voxel = [at; 3];
                (voxel[columns], voxel[rows]) = (column, row);
                data.push(self.get(voxel));
            }
        }
        Pixels { width, height, data }
    }
}

/// The axes of columns and rows of a slice across `axis`.
pub(super) fn in_plane(axis: usize) -> (usize, usize) {
    match axis {
        0 => (1, 2),
        1 => (0, 2),
        _ => (0, 1),
    }
}

/// The luminance of a pixel in sRGB encoding (Rec. 601 weights), 0 to 255.
pub(super) fn luminance([r, g, b]: [u8; 3]) -> f64 {
    f64::from(77 * u32::from(r) + 150 * u32::from(g) + 29 * u32::from(b)) / 256.0
}
