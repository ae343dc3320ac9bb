//! Rays through a box of voxels: what is opaque is shaded, the rest lets light through as a table says, planes cut parts off.

use super::Camera;
use super::cutaway::to_world;
use super::error::RenderError;
use super::studio::{Seen, compose};
use super::translucent::{Cut, TranslucentSettings};
use super::vector::{Vec3, add, dot, scale, unit_or};
use crate::control::Control;
use crate::data::{Image, Samples, Volume, srgb_to_linear};

/// Samples along each side of a pixel.
pub(super) const GRID: u32 = 2;
/// Where light comes from: above, left, the viewer.
const LIGHT: Vec3 = [-0.45, 0.75, 0.5];

/// A box of voxels as rays meet them.
pub struct Scene {
    pub(super) size: [u32; 3],
    /// sRGB colours, and above them the key by which opacities are looked up: luminance, or the label.
    pub(super) voxels: Vec<u32>,
    /// Two bits a voxel: whether there is anything, and whether it is opaque whatever the table says.
    pub(super) flags: Vec<u32>,
}

/// How a scene is looked at.
pub(super) struct View {
    pub camera: Camera,
    pub light: Vec3,
    /// Normals of length 1 and distances of planes in voxels from the box's corner; what lies beyond is not there.
    pub cuts: Vec<(Vec3, f64)>,
    pub opacities: [f64; 256],
    pub linear: [f64; 256],
}

impl Scene {
    /// A box from its colours; `marked` says which voxels are opaque, `inside` where there is anything at all (everywhere, if it is not
    /// given). Keys are the low eight bits of the map `label` if they are to come from there.
    ///
    /// # Errors
    /// [`RenderError::NoLabels`].
    pub(super) fn new(
        colors: &Volume,
        marked: Option<&[bool]>,
        inside: Option<&[bool]>,
        by_label: bool,
    ) -> Result<Self, RenderError> {
        let labels = match colors.map("label").map(|map| (&map.samples, map.channels)) {
            Some((Samples::U32(labels), channels)) => Some((labels, channels)),
            _ => None,
        };
        if by_label && labels.is_none() {
            return Err(RenderError::NoLabels);
        }
        let count = colors.voxels();
        let mut scene = Self {
            size: colors.size.map(|n| n as u32),
            voxels: vec![0; count],
            flags: vec![0; count.div_ceil(16)],
        };
        for (at, voxel) in scene.voxels.iter_mut().enumerate() {
            let [r, g, b] = match colors.maps.first() {
                Some(map) => {
                    [0, 1, 2].map(|c| map.samples.get_u8(at * map.channels + usize::min(c, map.channels - 1)))
                }
                None => [0; 3],
            };
            let luminance = (54 * u32::from(r) + 183 * u32::from(g) + 19 * u32::from(b)) >> 8;
            let label = labels.filter(|_| by_label).map(|(labels, channels)| labels[at * channels] & 255);
            *voxel = u32::from_le_bytes([r, g, b, label.unwrap_or(luminance) as u8]);
            let is = |set: Option<&[bool]>| set.and_then(|set| set.get(at).copied());
            let flag = u32::from(is(inside).unwrap_or(true)) | u32::from(is(marked).unwrap_or(false)) << 1;
            scene.flags[at >> 4] |= flag << (2 * (at & 15));
        }
        Ok(scene)
    }

    /// How the scene is looked at.
    pub(super) fn view(&self, settings: &TranslucentSettings) -> View {
        let size = self.size.map(f64::from);
        let corners: [Vec3; 8] =
            std::array::from_fn(|i| std::array::from_fn(|a| if i >> a & 1 == 1 { size[a] } else { 0.0 }));
        let cut = |&Cut { normal, at }: &Cut| {
            let normal = unit_or(normal, [0.0; 3]);
            let reach = corners.iter().map(|&corner| dot(normal, corner));
            let (low, high) =
                reach.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| (low.min(c), high.max(c)));
            (normal, low + at.clamp(0.0, 1.0) * (high - low))
        };
        View {
            camera: Camera::framing(
                corners.into_iter().map(to_world),
                settings.view,
                1.0,
                0.86,
                settings.picture,
            ),
            light: to_world(unit_or(LIGHT, [0.0, 1.0, 0.0])),
            cuts: settings.cuts.iter().flatten().map(cut).collect(),
            opacities: settings.opacities.map(|opacity| opacity.clamp(0.0, 1.0)),
            linear: std::array::from_fn(|byte| f64::from(srgb_to_linear(byte as u8))),
        }
    }

    /// The picture, found on the processor.
    ///
    /// # Errors
    /// [`RenderError`]: an impossible size, or cancelled.
    pub fn picture(
        &self,
        settings: &TranslucentSettings,
        control: &dyn Control,
    ) -> Result<Image, RenderError> {
        let view = self.view(settings);
        let camera = &view.camera;
        let weight = 1.0 / f64::from(GRID * GRID);
        compose(settings.picture, settings.background, control, |column, row| {
            let mut pixel = Seen::default();
            for sample in 0..GRID * GRID {
                let step = |n: u32| (f64::from(n) + 0.5) / f64::from(GRID);
                let at = [f64::from(column) + step(sample % GRID), f64::from(row) + step(sample / GRID)];
                let (color, cover) =
                    self.look(&view, to_world(camera.eye()), to_world(camera.ray(at[0], at[1])));
                pixel += Seen { color: color.map(|c| c * weight), object: cover * weight, shadow: 0.0 };
            }
            pixel
        })
    }

    fn index(&self, voxel: [i64; 3]) -> Option<usize> {
        let inside = (0..3).all(|a| voxel[a] >= 0 && voxel[a] < i64::from(self.size[a]));
        let ([x, y, z], [w, h, _]) = (voxel.map(|c| c as usize), self.size.map(|n| n as usize));
        inside.then(|| (z * h + y) * w + x)
    }

    /// What a voxel hides of what lies behind it.
    fn opacity(&self, view: &View, at: usize) -> f64 {
        match self.flags[at >> 4] >> (2 * (at & 15)) & 3 {
            3 => 1.0,
            1 => view.opacities[(self.voxels[at] >> 24) as usize],
            _ => 0.0,
        }
    }

    fn color(&self, view: &View, at: usize) -> Vec3 {
        let [r, g, b, _] = self.voxels[at].to_le_bytes();
        [r, g, b].map(|byte| view.linear[usize::from(byte)])
    }

    /// Light and coverage along a ray, voxel by voxel (Amanatides & Woo 1987).
    fn look(&self, view: &View, eye: Vec3, ray: Vec3) -> (Vec3, f64) {
        const NOTHING: (Vec3, f64) = ([0.0; 3], 0.0);
        let size = self.size.map(f64::from);
        let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
        for i in 0..3 {
            let (a, b) = (-eye[i] / ray[i], (size[i] - eye[i]) / ray[i]);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        // Where the last cut ends the ray, and the cut through which it enters.
        let (mut end, mut face) = (f64::INFINITY, None);
        for &(normal, distance) in &view.cuts {
            let (above, slope) = (dot(normal, eye) - distance, dot(normal, ray));
            let t = -above / slope;
            if slope.abs() < 1e-12 {
                if above > 0.0 {
                    return NOTHING;
                }
            } else if slope > 0.0 {
                end = end.min(t);
            } else if t > enter {
                (enter, face) = (t, Some(normal));
            }
        }
        if enter >= leave.min(end) || !enter.is_finite() {
            return NOTHING;
        }
        let start = add(eye, scale(ray, enter + 1e-9));
        let mut voxel: [i64; 3] = std::array::from_fn(|a| start[a].floor().clamp(0.0, size[a] - 1.0) as i64);
        let step = ray.map(|r| if r < 0.0 { -1i64 } else { 1 });
        let mut next: Vec3 =
            std::array::from_fn(|a| ((voxel[a] + i64::from(step[a] > 0)) as f64 - eye[a]) / ray[a]);
        let (mut light, mut cover, mut t) = ([0.0; 3], 0.0f64, enter);
        let length = dot(ray, ray).sqrt();
        while let Some(at) = self.index(voxel).filter(|_| t < end) {
            let axis = if next[0] <= next[1] && next[0] <= next[2] {
                0
            } else if next[1] <= next[2] {
                1
            } else {
                2
            };
            let opacity = self.opacity(view, at);
            let part = if opacity == 0.0 || opacity >= 1.0 {
                opacity
            } else {
                1.0 - libm::pow(1.0 - opacity, (next[axis].min(end) - t) * length)
            };
            if part > 0.0 {
                let shade = match face.filter(|_| t == enter) {
                    _ if part < 1.0 => 0.8,
                    Some(normal) => lit(view, normal),
                    None => self.shade(view, voxel),
                };
                let color = self.color(view, at);
                (0..3).for_each(|c| light[c] += (1.0 - cover) * part * shade * color[c]);
                cover += (1.0 - cover) * part;
                if cover > 0.995 {
                    break;
                }
            }
            t = next[axis];
            voxel[axis] += step[axis];
            next[axis] += (1.0 / ray[axis]).abs();
        }
        (light, cover)
    }

    /// How light a voxel is, from the way in which opaque voxels around it lie.
    fn shade(&self, view: &View, voxel: [i64; 3]) -> f64 {
        let mut normal = [0.0; 3];
        for dz in -2i64..=2 {
            for dy in -2i64..=2 {
                for dx in -2i64..=2 {
                    let d = [dx, dy, dz];
                    let near = self.index(std::array::from_fn(|a| voxel[a] + d[a]));
                    if near.is_none_or(|at| self.opacity(view, at) < 1.0) {
                        (0..3).for_each(|a| normal[a] += d[a] as f64);
                    }
                }
            }
        }
        lit(view, unit_or(normal, view.light))
    }
}

/// How light a face with this normal is.
fn lit(view: &View, normal: Vec3) -> f64 {
    0.42 + 0.68 * dot(normal, view.light).max(0.0)
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::translucent::{Key, translucent, translucent_scene};
    use super::super::{Background, RenderError};
    use super::*;
    use crate::data::Map;
    use crate::solid::{ConstantSolid, Repeat, VolumeSolid};

    pub const SETTINGS: TranslucentSettings = TranslucentSettings {
        picture: [41, 37],
        opacities: [1.0; 256],
        cuts: [None; 3],
        view: [0.0, 0.0],
        background: Background::Transparent,
    };

    /// A cube of 12 voxels whose nearer half is red with label 1, and whose further half is blue with label 2.
    pub fn halves() -> VolumeSolid {
        let count = 12 * 12 * 12;
        let further = |at: usize| at >= count / 2;
        let color =
            (0..count).flat_map(|at| if further(at) { [20, 30, 220] } else { [220, 30, 20] }).collect();
        let label = (0..count).map(|at| 1 + u32::from(further(at))).collect();
        let map = |name: &str, channels, samples| Map { name: name.to_owned(), channels, samples };
        let maps = vec![map("color", 3, Samples::U8(color)), map("label", 1, Samples::U32(label))];
        let volume = Volume { size: [12; 3], origin: [0; 3], spacing: [1.0; 3], maps };
        VolumeSolid::new(std::sync::Arc::new(volume), Repeat::Clamp).unwrap()
    }

    fn picture(key: Key, settings: &TranslucentSettings) -> Image {
        translucent(&halves(), None, None, ([0; 3], [12; 3]), key, settings, &()).unwrap()
    }

    fn middle(image: &Image) -> [u8; 3] {
        image.rgb8(20, 18)
    }

    #[test]
    fn a_plane_cuts_the_nearer_half_off() {
        let whole = picture(Key::Luminance, &SETTINGS);
        assert!(middle(&whole)[0] > 150 && middle(&whole)[2] < 60, "{:?}", middle(&whole));
        // Away from the viewer is +z.
        let cut =
            |normal, at| TranslucentSettings { cuts: [None, Some(Cut { normal, at }), None], ..SETTINGS };
        let further = picture(Key::Luminance, &cut([0.0, 0.0, -3.0], 0.5));
        assert!(middle(&further)[2] > 150 && middle(&further)[0] < 60, "{:?}", middle(&further));
        assert_eq!(picture(Key::Luminance, &cut([0.0, 0.0, 1.0], 0.5)), whole);
        let nothing = picture(Key::Luminance, &cut([1.0, 2.0, 0.5], 0.0));
        assert!((0..41).all(|x| (0..37).all(|y| nothing.get(x, y, 3) == 0.0)));
    }

    #[test]
    fn a_table_by_label_shows_one_label_alone() {
        let by_label =
            TranslucentSettings { opacities: Key::Label.opacities(&[0.0, 0.0, 1.0], 0.5), ..SETTINGS };
        let blue = picture(Key::Label, &by_label);
        assert!(middle(&blue)[2] > 150 && middle(&blue)[0] < 60, "{:?}", middle(&blue));
        let constant = ConstantSolid { color: [9; 3] };
        let missing = translucent_scene(&constant, None, None, ([0; 3], [2; 3]), Key::Label, &());
        assert!(matches!(missing.err(), Some(RenderError::NoLabels)));
    }

    #[test]
    fn a_table_by_luminance_hides_bright_voxels() {
        let count = 12 * 12 * 12;
        let grey = (0..count).flat_map(|at| if at < count / 2 { [250; 3] } else { [10; 3] }).collect();
        let map = Map { name: "color".to_owned(), channels: 3, samples: Samples::U8(grey) };
        let volume = Volume { size: [12; 3], origin: [0; 3], spacing: [1.0; 3], maps: vec![map] };
        let scene = Scene::new(&volume, None, None, false).unwrap();
        let opacities = Key::Luminance.opacities(&[1.0, 1.0, 0.0, 0.0], 0.0);
        let image = scene.picture(&TranslucentSettings { opacities, ..SETTINGS }, &()).unwrap();
        assert!(middle(&image)[0] < 40 && image.get(20, 18, 3) == 1.0, "{:?}", middle(&image));
    }

    #[test]
    fn half_as_opaque_hides_as_much_over_twice_the_depth() {
        let cover = |opacity: f64, depth: u32| {
            let solid = ConstantSolid { color: [90; 3] };
            let scene = translucent_scene(&solid, None, None, ([0; 3], [64, 64, depth]), Key::Luminance, &())
                .unwrap();
            let settings = TranslucentSettings { opacities: [opacity; 256], ..SETTINGS };
            scene.picture(&settings, &()).unwrap().get(20, 18, 3)
        };
        let (thin, thick) = (cover(0.19, 8), cover(0.1, 16));
        assert!((thin - thick).abs() <= 1.5 / 255.0 && (0.7..0.95).contains(&thin), "{thin} {thick}");
    }

    #[test]
    fn opacities_between_those_given_are_linear() {
        let table = Key::Luminance.opacities(&[0.0, 1.0, 0.5, 0.0], 0.3);
        assert_eq!([table[0], table[85], table[170], table[255]], [0.0, 1.0, 0.5, 0.0]);
        assert!((table[17] - 0.2).abs() < 1e-12);
        assert_eq!(Key::Luminance.opacities(&[], 0.3), [0.3; 256]);
        assert_eq!(Key::Label.opacities(&[0.1, 0.2], 0.3)[7], 0.2);
    }

    #[test]
    fn voxels_that_are_not_there_are_not_seen_even_if_marked() {
        let white = ConstantSolid { color: [255; 3] };
        let black = ConstantSolid { color: [0; 3] };
        let see = |inside: &dyn crate::data::Solid| {
            let place = ([0; 3], [12; 3]);
            translucent(&halves(), Some(&white), Some(inside), place, Key::Luminance, &SETTINGS, &()).unwrap()
        };
        assert_eq!(see(&white).get(20, 18, 3), 1.0);
        assert_eq!(see(&black).get(20, 18, 3), 0.0);
    }
}
