//! Slices of a solid by a plane at any position, orientation and resolution.

use super::sample;
use crate::control::{Control, check};
use crate::data::{Filter, Image, Samples, Solid, SolidError, Tap};

/// A grid of pixels in space.
///
/// Pixel (column c, row r) of a picture of w × h pixels looks at the point
/// `center + (c + ½ − w/2) · right + (r + ½ − h/2) · down`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// The point in the middle of the picture, in voxel coordinates.
    pub center: [f64; 3],
    /// The step from one column to the next, in voxels.
    pub right: [f64; 3],
    /// The step from one row to the next, in voxels.
    pub down: [f64; 3],
}

/// Why there is no slice.
#[derive(Clone, Debug, thiserror::Error)]
pub enum PlaneError {
    /// The normal has no direction.
    #[error("the normal {0:?} has no direction")]
    NoNormal([f64; 3]),
    /// The plane leaves the lattice.
    #[error("the picture reaches {0:?}, voxel coordinates end at ±{FAR:e}")]
    OutOfRange([f64; 3]),
    /// The picture has no pixels, or too many.
    #[error("a picture of {0} × {1} pixels cannot be made")]
    Size(u32, u32),
    /// The solid lacks the map.
    #[error("the solid has no map `{found}`, only {maps}")]
    NoMap {
        /// The name asked for.
        found: String,
        /// The names there are.
        maps: String,
    },
    /// The map has more channels than a picture.
    #[error("map `{0}` has {1} channels, a picture takes 1 to 4")]
    Channels(String, usize),
    /// The solid gave no answer.
    #[error(transparent)]
    Solid(#[from] SolidError),
}

impl From<PlaneError> for breccia_engine::NodeError {
    fn from(error: PlaneError) -> Self {
        match error {
            PlaneError::Solid(error) => error.into(),
            other => Self::failed(other),
        }
    }
}

/// How far from the origin a picture may reach, in voxels.
const FAR: f64 = 1e9;

/// Pixels along the edge of the portions in which the solid is asked.
const TILE: u32 = 512;

impl Plane {
    /// A plane through `center` across `normal`, with pixels of `scale` voxels.
    ///
    /// Rows run along z projected into the plane, or along y where the normal is closest to z; columns run
    /// across, towards the positive end of the axis that they are most parallel to. So the picture across
    /// z, y or x is `volume[z]`, `volume[:, y]` or `volume[:, :, x]` of an array in Z, Y, X order, unturned,
    /// and the sign of the normal makes no difference. `rotation` then turns the grid about the normal by
    /// that many degrees, rows towards columns; multiples of 90 are exact.
    ///
    /// # Errors
    /// If the normal is zero or not finite.
    pub fn new(center: [f64; 3], normal: [f64; 3], rotation: f64, scale: f64) -> Result<Self, PlaneError> {
        let n = unit(normal).ok_or(PlaneError::NoNormal(normal))?;
        let size = n.map(f64::abs);
        let reference = if size[2] > size[0].max(size[1]) { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] };
        let along = dot(reference, n);
        let projected = std::array::from_fn(|i| reference[i] - along * n[i]);
        let down = unit(projected).ok_or(PlaneError::NoNormal(normal))?;
        let across = [
            down[1] * n[2] - down[2] * n[1],
            down[2] * n[0] - down[0] * n[2],
            down[0] * n[1] - down[1] * n[0],
        ];
        let main = across.into_iter().fold(0.0, |best: f64, c| if c.abs() > best.abs() { c } else { best });
        let right = if main < 0.0 { across.map(|c| -c) } else { across };
        let (sin, cos) = sin_cos_degrees(rotation);
        Ok(Self {
            center,
            right: std::array::from_fn(|i| scale * (cos * right[i] - sin * down[i])),
            down: std::array::from_fn(|i| scale * (sin * right[i] + cos * down[i])),
        })
    }

    /// The point a pixel looks at.
    pub fn point(&self, size: [u32; 2], column: u32, row: u32) -> [f64; 3] {
        let c = f64::from(column) + 0.5 - f64::from(size[0]) / 2.0;
        let r = f64::from(row) + 0.5 - f64::from(size[1]) / 2.0;
        std::array::from_fn(|i| self.center[i] + (c * self.right[i] + r * self.down[i]))
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector at length 1; exact for vectors along an axis.
fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let largest = v.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    if !largest.is_finite() || largest == 0.0 || v.iter().any(|c| c.is_nan()) {
        return None;
    }
    let v = v.map(|c| c / largest);
    let length = dot(v, v).sqrt();
    Some(v.map(|c| c / length))
}

fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    let turned = libm::fmod(degrees, 360.0);
    let quarters = turned / 90.0;
    if quarters.fract() == 0.0 {
        return [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][(quarters as i32).rem_euclid(4) as usize];
    }
    libm::sincos(turned.to_radians())
}

/// A slice of one map of the solid, `size` pixels wide and high, in the map's own number type.
///
/// # Errors
/// [`PlaneError`]: no such map, no such picture, a plane out of range, or no answer from the solid.
pub fn slice(
    solid: &dyn Solid,
    plane: &Plane,
    size: [u32; 2],
    filter: Filter,
    map: &str,
    control: &dyn Control,
) -> Result<Image, PlaneError> {
    let infos = solid.maps();
    let names = || infos.iter().map(|info| info.name.as_str()).collect::<Vec<_>>().join(", ");
    let Some(info) = infos.iter().find(|info| info.name == map) else {
        return Err(PlaneError::NoMap { found: map.to_owned(), maps: names() });
    };
    if !(1..=4).contains(&info.channels) {
        return Err(PlaneError::Channels(map.to_owned(), info.channels));
    }
    let [width, height] = size;
    let pixels = (width as usize).checked_mul(height as usize).filter(|&n| n > 0 && n <= 1 << 30);
    let pixels = pixels.ok_or(PlaneError::Size(width, height))?;
    for (column, row) in [(0, 0), (width - 1, 0), (0, height - 1), (width - 1, height - 1)] {
        let corner = plane.point(size, column, row);
        // Written so that NaN is out of range too.
        if !corner.iter().all(|c| c.abs() <= FAR) {
            return Err(PlaneError::OutOfRange(corner));
        }
    }
    let n = info.channels;
    let mut samples = Samples::zeros(info.ty, pixels * n);
    for top in (0..height).step_by(TILE as usize) {
        for left in (0..width).step_by(TILE as usize) {
            check(control).map_err(SolidError::from)?;
            let (rows, columns) =
                (top..height.min(top.saturating_add(TILE)), left..width.min(left.saturating_add(TILE)));
            let span = columns.len();
            let mut taps = Vec::with_capacity(rows.len() * span);
            for row in rows.clone() {
                for column in columns.clone() {
                    let point = plane.point(size, column, row);
                    taps.push(Tap::new(point, filter).ok_or(PlaneError::OutOfRange(point))?);
                }
            }
            let tile = sample(solid, std::slice::from_ref(info), &taps, control)?;
            let Some(tile) = tile.first() else { continue };
            for (i, row) in rows.enumerate() {
                let to = (row as usize * width as usize + left as usize) * n;
                samples.copy_from(to, &tile.samples, i * span * n, span * n);
            }
        }
        control.progress(f64::from(top + TILE.min(height - top)) as f32 / height as f32);
    }
    Image::new(width, height, n, samples).map_err(|_| PlaneError::Size(width, height))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::CheckerSolid;

    const SOLID: CheckerSolid =
        CheckerSolid { colors: [[40, 90, 160], [220, 180, 120]], cell: 3, noise: 25, seed: 9 };

    /// What the voxel of a pixel is for each axis, written out by hand.
    type VoxelOf = fn(i32, i32, i32) -> [i32; 3];
    const AXES: [([f64; 3], VoxelOf); 3] = [
        ([0.0, 0.0, 1.0], |at, column, row| [column, row, at]),
        ([0.0, 1.0, 0.0], |at, column, row| [column, at, row]),
        ([1.0, 0.0, 0.0], |at, column, row| [at, column, row]),
    ];

    #[test]
    fn slices_across_an_axis_are_the_voxels_exactly() {
        for (normal, voxel) in AXES {
            for (sign, position, size) in [(1.0, 5, [16, 12]), (-2.5, -7, [9, 16]), (1.0, 0, [7, 5])] {
                let [w, h] = size.map(|n| n as i32);
                let center = normal.map(|c| if c == 0.0 { 0.0 } else { f64::from(position) });
                let plane = Plane::new(center, normal.map(|c| c * sign), 0.0, 1.0).unwrap();
                let image = slice(&SOLID, &plane, size, Filter::Nearest, "color", &()).unwrap();
                for row in 0..h {
                    for column in 0..w {
                        // floor(½ + c − w/2): for an odd width the middle pixel's centre is the corner.
                        let (x, y) = ((2 * column + 1 - w).div_euclid(2), (2 * row + 1 - h).div_euclid(2));
                        let expected = SOLID.color(voxel(position, x, y));
                        assert_eq!(
                            image.rgb8(column as u32, row as u32),
                            expected,
                            "{normal:?} {column} {row}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn trilinear_at_voxel_centres_is_nearest() {
        for (normal, _) in AXES {
            let plane = Plane::new(normal.map(|c| c * 4.5), normal, 0.0, 1.0).unwrap();
            let image = |filter| slice(&SOLID, &plane, [10, 10], filter, "color", &()).unwrap();
            assert_eq!(image(Filter::Trilinear), image(Filter::Nearest));
        }
    }

    #[test]
    fn trilinear_between_two_layers_is_their_mean() {
        let plane = |z: f64| Plane::new([0.0, 0.0, z], [0.0, 0.0, 1.0], 0.0, 1.0).unwrap();
        let image = |z, filter| slice(&SOLID, &plane(z), [8, 8], filter, "color", &()).unwrap();
        let (low, high) = (image(3.5, Filter::Nearest), image(4.5, Filter::Nearest));
        let mean = image(4.0, Filter::Trilinear);
        for (x, y) in (0..8).flat_map(|y| (0..8).map(move |x| (x, y))) {
            let (a, b) = (low.rgb8(x, y), high.rgb8(x, y));
            let expected: [u8; 3] =
                std::array::from_fn(|c| (u16::from(a[c]) + u16::from(b[c])).div_ceil(2) as u8);
            assert_eq!(mean.rgb8(x, y), expected);
        }
    }

    #[test]
    fn a_quarter_turn_permutes_the_pixels() {
        let turned = |rotation| {
            let plane = Plane::new([0.0; 3], [0.0, 0.0, 1.0], rotation, 1.0).unwrap();
            slice(&SOLID, &plane, [8, 8], Filter::Nearest, "color", &()).unwrap()
        };
        let (plain, quarter) = (turned(0.0), turned(90.0));
        for (x, y) in (0..8).flat_map(|y| (0..8).map(move |x| (x, y))) {
            assert_eq!(quarter.rgb8(x, y), plain.rgb8(y, 7 - x));
        }
        assert_eq!(turned(-270.0), quarter);
        assert_eq!(turned(720.0), plain);
    }

    #[test]
    fn the_grid_of_an_oblique_plane_is_orthonormal_in_the_plane() {
        for normal in [[1.0, 1.0, 1.0], [-3.0, 0.2, 0.1], [0.0, -1.0, 1.0], [1e-3, 1e-3, 1.0]] {
            let plane = Plane::new([0.0; 3], normal, 33.0, 2.0).unwrap();
            for (a, b, expected) in [
                (plane.right, plane.right, 4.0),
                (plane.down, plane.down, 4.0),
                (plane.right, plane.down, 0.0),
                (plane.right, normal, 0.0),
                (plane.down, normal, 0.0),
            ] {
                assert!((dot(a, b) - expected).abs() < 1e-12, "{normal:?}");
            }
        }
    }

    #[test]
    fn what_cannot_be_sliced_is_refused() {
        assert!(matches!(Plane::new([0.0; 3], [0.0; 3], 0.0, 1.0), Err(PlaneError::NoNormal(_))));
        assert!(matches!(Plane::new([0.0; 3], [f64::NAN; 3], 0.0, 1.0), Err(PlaneError::NoNormal(_))));
        let plane = |center| Plane::new(center, [1.0, 0.0, 0.0], 0.0, 1.0).unwrap();
        let slice = |center, size, map| slice(&SOLID, &plane(center), size, Filter::Nearest, map, &());
        assert!(matches!(slice([f64::NAN; 3], [4, 4], "color"), Err(PlaneError::OutOfRange(_))));
        assert!(matches!(slice([3e9; 3], [4, 4], "color"), Err(PlaneError::OutOfRange(_))));
        assert!(matches!(slice([0.0; 3], [0, 4], "color"), Err(PlaneError::Size(0, 4))));
        assert!(matches!(slice([0.0; 3], [4, 4], "colour"), Err(PlaneError::NoMap { .. })));
    }
}
