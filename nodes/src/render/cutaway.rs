//! A box of a solid with one corner cut out, so that the inside is seen.

use super::error::RenderError;
use super::studio::{Background, Seen, compose};
use super::vector::{Vec3, add, scale};
use super::{Camera, error::check_picture};
use crate::control::Control;
use crate::data::{Image, Solid, VoxelMap, VoxelSet, srgb_to_linear};

/// How the box is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutawaySettings {
    /// Width and height of the picture in pixels.
    pub picture: [u32; 2],
    /// The fraction of each edge that is cut off at the nearest corner, 0 to 0.9.
    pub corner: f64,
    /// What lies behind.
    pub background: Background,
}

/// Samples along each side of a pixel.
const GRID: u32 = 4;

/// How light the faces across x, y and z are: light falls from above and slightly from the left.
const FACE_LIGHT: Vec3 = [0.66, 1.0, 0.83];

/// The longest edge of a box; its faces alone are 16 million voxels.
const LONGEST: u32 = 2048;

/// A picture of the box from `origin` of `size` voxels, seen from the corner where x is largest and y and
/// z are smallest: the front face is `volume[0]` of an array in Z, Y, X order as an image viewer shows it,
/// x to the right and y down; z leads away from the viewer. The solid is asked only for voxels that are seen.
///
/// # Errors
/// [`RenderError`]: an impossible size of box or picture, or no answer from the solid.
pub fn cutaway(
    solid: &dyn Solid,
    origin: [i32; 3],
    size: [u32; 3],
    settings: &CutawaySettings,
    control: &dyn Control,
) -> Result<Image, RenderError> {
    check_picture(settings.picture)?;
    let [x, y, z] = size;
    let coordinates = (0..3).all(|i| origin[i].checked_add_unsigned(size[i]).is_some());
    if !size.iter().all(|n| (1..=LONGEST).contains(n)) || !coordinates {
        return Err(RenderError::Box(x, y, z));
    }
    let corner = if settings.corner.is_finite() { settings.corner.clamp(0.0, 0.9) } else { 0.0 };
    let cut = size.map(|n| ((f64::from(n) * corner + 0.5) as u32).min(n - 1));
    // A notch needs all three edges.
    let cut = if cut.contains(&0) { [0; 3] } else { cut };
    let block = Block { origin, size, cut };
    let answer = solid.evaluate(&block.visible(), control)?;
    let view = View::new(block, settings.picture, &answer);
    let weight = 1.0 / f64::from(GRID * GRID);
    compose(settings.picture, settings.background, control, |column, row| {
        let mut pixel = Seen::default();
        for sample in 0..GRID * GRID {
            let step = |n: u32| (f64::from(n) + 0.5) / f64::from(GRID);
            let (x, y) = (f64::from(column) + step(sample % GRID), f64::from(row) + step(sample / GRID));
            if let Some(color) = view.surface(x, y) {
                pixel += Seen { color: color.map(|c| c * weight), object: weight, shadow: 0.0 };
            }
        }
        if pixel.object < 1.0 {
            // The ground is smooth: one look at it serves for the whole pixel.
            let shadow = view.ground_shadow(f64::from(column) + 0.5, f64::from(row) + 0.5);
            pixel.shadow = shadow * (1.0 - pixel.object);
        }
        pixel
    })
}

/// A box with a notch of `cut` voxels at the corner (largest x, smallest y, smallest z).
#[derive(Clone, Copy)]
struct Block {
    origin: [i32; 3],
    size: [u32; 3],
    cut: [u32; 3],
}

impl Block {
    /// The voxels whose faces are seen.
    fn visible(&self) -> VoxelSet {
        let ([sx, sy, sz], [cx, cy, cz]) = (self.size, self.cut);
        let boxes = [
            // The outer faces across z, y and x, each in two parts around the notch.
            ([0, cy, 0], [sx, sy - cy, 1]),
            ([0, 0, 0], [sx - cx, cy, 1]),
            ([0, 0, cz], [sx, 1, sz - cz]),
            ([0, 0, 0], [sx - cx, 1, cz]),
            ([sx - 1, 0, cz], [1, sy, sz - cz]),
            ([sx - 1, cy, 0], [1, sy - cy, cz]),
            // The inner faces.
            ([sx - cx, 0, cz], [cx, cy, 1]),
            ([sx - cx, cy, 0], [cx, 1, cz]),
            ([sx - cx - 1, 0, 0], [1, cy, cz]),
        ];
        let mut seen = VoxelSet::new();
        for (from, size) in boxes {
            let from = std::array::from_fn(|i| self.origin[i].saturating_add_unsigned(from[i]));
            seen.union(&VoxelSet::from_box(from, size));
        }
        seen
    }

    /// Where a ray meets the surface: the point, the axis across the face, and the voxel behind the face.
    fn hit(&self, eye: Vec3, ray: Vec3) -> Option<(Vec3, usize, [u32; 3], bool)> {
        let size = self.size.map(f64::from);
        let (mut enter, mut leave, mut axis) = (f64::NEG_INFINITY, f64::INFINITY, 0);
        for i in 0..3 {
            let (a, b) = (-eye[i] / ray[i], (size[i] - eye[i]) / ray[i]);
            if a.min(b) > enter {
                (enter, axis) = (a.min(b), i);
            }
            leave = leave.min(a.max(b));
        }
        // Also a miss if a ray in a face's plane makes NaN.
        if !(enter < leave && enter > 0.0) {
            return None;
        }
        let mut point = add(eye, scale(ray, enter));
        let cut = self.cut.map(f64::from);
        let walls = [size[0] - cut[0], cut[1], cut[2]];
        let inside = |p: Vec3| p[0] > walls[0] && p[1] < walls[1] && p[2] < walls[2];
        let notch = self.cut[0] > 0
            && inside(std::array::from_fn(|i| if i == axis { point[i] + ray[i] * 1e-9 } else { point[i] }));
        if notch {
            // The ray goes towards smaller x, larger y and larger z; the nearest wall stops it.
            let mut stop = f64::INFINITY;
            for i in 0..3 {
                let t = (walls[i] - eye[i]) / ray[i];
                if t > enter && t < stop {
                    (stop, axis) = (t, i);
                }
            }
            if !stop.is_finite() {
                return None;
            }
            point = add(eye, scale(ray, stop));
        }
        let voxel = std::array::from_fn(|i| {
            let at = if i != axis {
                point[i].floor()
            } else if notch {
                [walls[0] - 1.0, walls[1], walls[2]][i]
            } else {
                [size[0] - 1.0, 0.0, 0.0][i]
            };
            at.clamp(0.0, size[i] - 1.0) as u32
        });
        Some((point, axis, voxel, notch))
    }
}

/// Everything needed to look through a place of the picture.
struct View<'a> {
    block: Block,
    camera: Camera,
    eye: Vec3,
    answer: &'a VoxelMap,
    linear: [f64; 256],
    longest: f64,
}

impl<'a> View<'a> {
    fn new(block: Block, picture: [u32; 2], answer: &'a VoxelMap) -> Self {
        let [x, y, z] = block.size.map(f64::from);
        let corners = (0..8).map(|i| {
            let pick = |bit: u32, n: f64| if i >> bit & 1 == 1 { n } else { 0.0 };
            to_world([pick(0, x), pick(1, y), pick(2, z)])
        });
        let camera = Camera::framing(corners, [36.0, 27.0], 1.0, 0.84, picture);
        let linear = std::array::from_fn(|byte| f64::from(srgb_to_linear(byte as u8)));
        Self { block, eye: to_voxels(camera.eye()), camera, answer, linear, longest: x.max(y).max(z) }
    }

    /// The light from the box through a place of the picture; `None` beside it.
    fn surface(&self, x: f64, y: f64) -> Option<Vec3> {
        let (point, axis, voxel, notch) = self.block.hit(self.eye, to_voxels(self.camera.ray(x, y)))?;
        let light = FACE_LIGHT[axis] * if notch { self.crease(point, axis) } else { 1.0 };
        Some(self.color(voxel).map(|c| c * light))
    }

    /// The linear colour of a voxel of the box.
    fn color(&self, voxel: [u32; 3]) -> Vec3 {
        let voxel = std::array::from_fn(|i| self.block.origin[i].saturating_add_unsigned(voxel[i]));
        let (Some(at), Some(map)) = (self.answer.index(voxel), self.answer.maps.first()) else {
            return [0.0; 3];
        };
        let n = map.channels;
        std::array::from_fn(|c| self.linear[usize::from(map.samples.get_u8(at * n + c.min(n - 1)))])
    }

    /// How much light reaches a point of the notch: less towards its creases.
    fn crease(&self, point: Vec3, axis: usize) -> f64 {
        let cut = self.block.cut.map(f64::from);
        let depth =
            [point[0] - (f64::from(self.block.size[0]) - cut[0]), cut[1] - point[1], cut[2] - point[2]];
        let dark = (0..3).filter(|&i| i != axis).map(|i| {
            let near = depth[i] / (0.45 * self.longest * 0.5);
            1.0 - 0.24 * libm::exp(-3.0 * near.max(0.0))
        });
        dark.product::<f64>() * 0.96
    }

    /// The shadow on the ground that the box stands on: close under it, and wide to the far right.
    fn ground_shadow(&self, x: f64, y: f64) -> f64 {
        let (eye, ray) = (self.eye, to_voxels(self.camera.ray(x, y)));
        let ground = f64::from(self.block.size[1]);
        let t = (ground - eye[1]) / ray[1];
        if !(t > 0.0 && t.is_finite()) {
            return 0.0;
        }
        let point = add(eye, scale(ray, t));
        let blurred = |sigma: f64, shift: [f64; 2]| {
            let along = |at: f64, size: u32, shift: f64| {
                let (at, sigma) = (at - shift * self.longest, sigma * self.longest);
                (libm::erf(at / sigma) - libm::erf((at - f64::from(size)) / sigma)) / 2.0
            };
            along(point[0], self.block.size[0], shift[0]) * along(point[2], self.block.size[2], shift[1])
        };
        0.50 * blurred(0.05, [0.0, 0.0]) + 0.34 * blurred(0.26, [0.10, 0.06])
    }
}

/// Voxel axes (y down, z away) to world axes (y up, z towards the viewer); its own inverse.
pub(super) fn to_world([x, y, z]: Vec3) -> Vec3 {
    [x, -y, -z]
}

fn to_voxels(p: Vec3) -> Vec3 {
    to_world(p)
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use breccia_engine::Digest;

    use super::*;
    use crate::data::{Extent, MapInfo, SolidError};
    use crate::solid::{CheckerSolid, ConstantSolid};

    const SETTINGS: CutawaySettings =
        CutawaySettings { picture: [96, 80], corner: 0.5, background: Background::Transparent };

    /// Remembers what it was asked for.
    struct Spy(Mutex<VoxelSet>);

    impl Solid for Spy {
        fn maps(&self) -> Vec<MapInfo> {
            ConstantSolid { color: [0; 3] }.maps()
        }
        fn extent(&self) -> Extent {
            Extent::Unbounded
        }
        fn evaluate(&self, voxels: &VoxelSet, control: &dyn Control) -> Result<VoxelMap, SolidError> {
            self.0.lock().unwrap().union(voxels);
            ConstantSolid { color: [200; 3] }.evaluate(voxels, control)
        }
        fn digest(&self) -> Digest {
            Digest::of(b"spy")
        }
        fn summary(&self) -> String {
            String::new()
        }
        fn byte_size(&self) -> u64 {
            0
        }
    }

    #[test]
    fn only_visible_voxels_are_asked_for() {
        let spy = Spy(Mutex::default());
        cutaway(&spy, [5, -3, 8], [16, 16, 16], &SETTINGS, &()).unwrap();
        let asked = spy.0.into_inner().unwrap();
        let surface = |v: [i32; 3]| {
            let [x, y, z] = [v[0] - 5, v[1] + 3, v[2] - 8];
            let outside = |x: i32, y: i32, z: i32| x >= 16 || y < 0 || z < 0 || (x >= 8 && y < 8 && z < 8);
            !outside(x, y, z) && (outside(x + 1, y, z) || outside(x, y - 1, z) || outside(x, y, z - 1))
        };
        let all = VoxelSet::from_box([5, -3, 8], [16; 3]);
        let expected: VoxelSet = all.voxels().filter(|&v| surface(v)).collect();
        assert_eq!(asked, expected);
    }

    #[test]
    fn every_visible_voxel_is_where_rays_meet_it() {
        let block = Block { origin: [0; 3], size: [12, 9, 10], cut: [6, 4, 5] };
        let answer = VoxelMap::default();
        let view = View::new(block, [400, 400], &answer);
        let visible = block.visible();
        let mut met = VoxelSet::new();
        for (x, y) in (0..400).flat_map(|y| (0..400).map(move |x| (f64::from(x), f64::from(y)))) {
            let hit = block.hit(to_voxels(view.camera.eye()), to_voxels(view.camera.ray(x, y)));
            if let Some((.., voxel, _)) = hit {
                met.insert(voxel.map(|c| c as i32));
            }
        }
        let missing: Vec<_> = visible.voxels().filter(|&v| !met.contains(v)).collect();
        let foreign: Vec<_> = met.voxels().filter(|&v| !visible.contains(v)).collect();
        assert!(foreign.is_empty(), "{foreign:?}");
        // Voxels in the notch's creases hide behind the wall in front of them.
        assert!(missing.len() * 20 < visible.len(), "{missing:?}");
    }

    #[test]
    fn the_object_is_opaque_and_the_corners_are_clear() {
        let solid = CheckerSolid { colors: [[250; 3], [10; 3]], cell: 4, noise: 0, seed: 0 };
        let image = cutaway(&solid, [0; 3], [16; 3], &SETTINGS, &()).unwrap();
        assert_eq!(image.channels(), 4);
        assert_eq!(image.get(48, 40, 3), 1.0);
        assert!(image.get(0, 0, 3) < 0.01);
    }

    #[test]
    fn impossible_sizes_are_refused() {
        let solid = ConstantSolid { color: [1, 2, 3] };
        let make = |origin, size, picture| {
            cutaway(&solid, origin, size, &CutawaySettings { picture, ..SETTINGS }, &())
        };
        assert!(matches!(make([0; 3], [0, 1, 1], [9, 9]), Err(RenderError::Box(0, 1, 1))));
        assert!(matches!(make([i32::MAX; 3], [2; 3], [9, 9]), Err(RenderError::Box(2, 2, 2))));
        assert!(matches!(make([0; 3], [2; 3], [0, 9]), Err(RenderError::Size(0, 9))));
        assert!(make([0; 3], [1; 3], [1, 1]).is_ok());
    }
}
