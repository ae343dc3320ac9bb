//! Three faces and an oblique cut of a solid side by side, for judging it by eye.

use super::RenderError;
use super::error::check_picture;
use crate::control::Control;
use crate::data::{Image, Solid};
use crate::solid::{Filter, Plane, slice};

/// Pixels between the panels and around them.
const GAP: u32 = 6;

/// The grey around the panels.
const GREY: [u8; 3] = [232; 3];

/// The edge of the oblique panel, as a fraction of the box's: a square of this size fits into the
/// hexagon that the plane cuts out of a cube.
const OBLIQUE: f64 = 0.86;

/// The cube of `size` voxels from `origin` on: its first layers across z, y and x (rows and columns as in
/// [`Plane::new`]), and the cut through its centre across (1, 1, 1); each voxel `enlarge` pixels wide,
/// nothing filtered.
///
/// # Errors
/// [`RenderError`]: an impossible size, or no answer from the solid.
pub fn contact_sheet(
    solid: &dyn Solid,
    origin: [i32; 3],
    size: u32,
    enlarge: u32,
    control: &dyn Control,
) -> Result<Image, RenderError> {
    let oblique = (f64::from(size) * OBLIQUE) as u32;
    let panel = |voxels: u32| voxels.saturating_mul(enlarge);
    let width = panel(size).saturating_mul(3).saturating_add(panel(oblique.max(1))).saturating_add(5 * GAP);
    let picture = [width, panel(size).saturating_add(2 * GAP)];
    check_picture(picture)?;
    check_picture([size, enlarge])?;
    let corner = origin.map(f64::from);
    let half = f64::from(size) / 2.0;
    let mut panels = Vec::new();
    for axis in [2, 1, 0] {
        let normal = std::array::from_fn(|i| if i == axis { 1.0 } else { 0.0 });
        let center = std::array::from_fn(|i| corner[i] + if i == axis { 0.5 } else { half });
        let plane = Plane::new(center, normal, 0.0, 1.0)?;
        panels.push(slice(solid, &plane, [size; 2], Filter::Nearest, "color", control)?);
    }
    let plane = Plane::new(corner.map(|c| c + half), [1.0; 3], 0.0, 1.0)?;
    panels.push(slice(solid, &plane, [oblique.max(1); 2], Filter::Nearest, "color", control)?);

    Ok(Image::from_fn(picture[0], picture[1], |x, y| {
        let mut left = GAP;
        for image in &panels {
            let wide = image.width() * enlarge;
            let top = (picture[1] - image.height() * enlarge) / 2;
            if (left..left + wide).contains(&x) && (top..top + image.height() * enlarge).contains(&y) {
                return image.rgb8((x - left) / enlarge, (y - top) / enlarge);
            }
            left += wide + GAP;
        }
        GREY
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::CheckerSolid;

    #[test]
    fn panels_show_the_first_layers() {
        let solid = CheckerSolid { colors: [[30, 60, 90], [200, 160, 120]], cell: 3, noise: 30, seed: 4 };
        let (origin, size, zoom) = ([4, -9, 2], 8u32, 2);
        let image = contact_sheet(&solid, origin, size, zoom, &()).unwrap();
        for (row, column) in (0..size).flat_map(|r| (0..size).map(move |c| (r, c))) {
            let (r, c) = (row as i32, column as i32);
            let [x, y, z] = origin;
            let expected = [[x + c, y + r, z], [x + c, y, z + r], [x, y + c, z + r]].map(|v| solid.color(v));
            let shown = [0, 1, 2].map(|panel| {
                let left = GAP + panel * (size * zoom + GAP);
                image.rgb8(left + column * zoom + 1, GAP + row * zoom)
            });
            assert_eq!(shown, expected, "row {row} column {column}");
        }
    }

    #[test]
    fn impossible_sizes_are_refused() {
        let solid = CheckerSolid { colors: [[0; 3]; 2], cell: 1, noise: 0, seed: 0 };
        assert!(contact_sheet(&solid, [0; 3], 0, 2, &()).is_err());
        assert!(contact_sheet(&solid, [0; 3], u32::MAX, 2, &()).is_err());
        assert!(contact_sheet(&solid, [0; 3], 4, 0, &()).is_err());
    }
}
