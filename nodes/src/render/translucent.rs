//! A box of a solid, seen through: what a mask marks is opaque and shaded, the rest as translucent as wanted.

use super::error::{RenderError, check_picture};
use super::march::Scene;
use super::studio::Background;
use crate::control::Control;
use crate::data::{Image, Solid};
use crate::solid::{available_memory, box_volume};

/// A plane that cuts a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Points to what is cut off: x to the right, y down, z away; of any length.
    pub normal: [f64; 3],
    /// Where it cuts: 0 at the first of the box's corners along the normal, 1 at the last.
    pub at: f64,
}

/// How the box is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TranslucentSettings {
    /// Width and height of the picture in pixels.
    pub picture: [u32; 2],
    /// How much a voxel that is not marked hides of what lies behind it, by its key: 0 leaves it out, 1 makes it opaque.
    pub opacities: [f64; 256],
    /// Planes that cut parts off.
    pub cuts: [Option<Cut>; 3],
    /// Degrees to the right and upwards.
    pub view: [f64; 2],
    /// What lies behind.
    pub background: Background,
}

/// What a voxel's opacity is looked up by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Key {
    /// The luminance of its colour, 0 to 255.
    Luminance,
    /// The low eight bits of the map `label`.
    Label,
}

impl Key {
    /// Opacities of all keys from those at even distances (luminance) or of the first ones (labels; the last is that of all others).
    /// `otherwise` where none are given.
    pub fn opacities(self, given: &[f64], otherwise: f64) -> [f64; 256] {
        let Some(last) = given.len().checked_sub(1) else { return [otherwise; 256] };
        std::array::from_fn(|key| match self {
            Self::Label => given[key.min(last)],
            Self::Luminance => {
                let at = key as f64 * last as f64 / 255.0;
                let low = at.floor();
                let next = given[(low as usize + 1).min(last)];
                given[low as usize] + (at - low) * (next - given[low as usize])
            }
        })
    }
}

/// A picture of a box, given by its first voxel and its size. `marked` is white where voxels are opaque whatever the opacity; `inside`, if
/// given, is white where there is anything at all. Axes lie as in [`super::cutaway`].
///
/// # Errors
/// [`RenderError`]: an impossible size of box or picture, no labels, or no answer from a solid.
pub fn translucent(
    solid: &dyn Solid,
    marked: Option<&dyn Solid>,
    inside: Option<&dyn Solid>,
    place: ([i32; 3], [u32; 3]),
    key: Key,
    settings: &TranslucentSettings,
    control: &dyn Control,
) -> Result<Image, RenderError> {
    check_picture(settings.picture)?;
    translucent_scene(solid, marked, inside, place, key, control)?.picture(settings, control)
}

/// What [`translucent`] shows, for pictures from several sides.
///
/// # Errors
/// As there.
pub fn translucent_scene(
    solid: &dyn Solid,
    marked: Option<&dyn Solid>,
    inside: Option<&dyn Solid>,
    (origin, size): ([i32; 3], [u32; 3]),
    key: Key,
    control: &dyn Control,
) -> Result<Scene, RenderError> {
    let [x, y, z] = size;
    if !size.iter().all(|n| (1..=1024).contains(n))
        || (0..3).any(|i| origin[i].checked_add_unsigned(size[i]).is_none())
    {
        return Err(RenderError::Box(x, y, z));
    }
    let voxels = |solid: &dyn Solid| box_volume(solid, origin, size, available_memory(), control);
    let white = |solid: &dyn Solid| -> Result<Vec<bool>, RenderError> {
        let volume = voxels(solid)?;
        let map = volume.maps.first();
        Ok(map.map_or_else(Vec::new, |map| {
            (0..volume.voxels()).map(|i| map.samples.get_u8(i * map.channels) > 127).collect()
        }))
    };
    let (marked, inside) = (marked.map(white).transpose()?, inside.map(white).transpose()?);
    Scene::new(&voxels(solid)?, marked.as_deref(), inside.as_deref(), key == Key::Label)
}
