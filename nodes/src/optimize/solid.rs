//! An optimised field as a volume, with every map that the exemplar carries (the sources of the voxels are known, so that normal,
//! roughness and other maps follow the colour).

use crate::data::{Map, Samples, Volume};
use crate::exemplar::Exemplar;
use crate::lazy::Pyramid;

use super::field::Field;

/// What becomes of a field.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidSettings {
    /// Voxels cut off on each side.
    pub margin: usize,
    /// Whether colours are those of the field, as the mean solver makes them, rather than looked up at the sources.
    pub mixed: bool,
    /// Whether a map `source` is added: column, row and view of the exemplar.
    pub sources: bool,
}

/// The voxels of a field with all maps of the exemplar. A field of a coarse level has its colours only.
pub fn field_volume(
    field: &Field,
    exemplar: &Exemplar,
    pyramid: &Pyramid,
    settings: &SolidSettings,
) -> Volume {
    let margin = settings.margin;
    let size = field.size.map(|n| n.saturating_sub(2 * margin).max(1));
    let [width, height, depth] = size;
    let mut voxels = Vec::with_capacity(width * height * depth);
    for z in 0..depth {
        for y in 0..height {
            let row = ((z + margin).min(field.size[2] - 1) * field.size[1]
                + (y + margin).min(field.size[1] - 1))
                * field.size[0];
            voxels.extend((0..width).map(|x| row + (x + margin).min(field.size[0] - 1)));
        }
    }
    let mut volume = Volume { size, origin: [0; 3], spacing: [1.0; 3], maps: Vec::new() };
    let views = pyramid.levels.get(field.level).map_or(&[][..], Vec::as_slice);
    let finest = field.level == 0 && exemplar.views.len() == views.len();
    if settings.mixed || !finest {
        let colors =
            voxels.iter().flat_map(|&i| [field.colors[i][0], field.colors[i][1], field.colors[i][2]]);
        volume.maps.push(Map { name: "color".into(), channels: 3, samples: Samples::U8(colors.collect()) });
    }
    let infos = if finest { exemplar.view(0).map_infos() } else { Vec::new() };
    for (m, info) in infos.iter().enumerate() {
        if info.name == "color" && settings.mixed {
            continue;
        }
        let mut map = Map::zeros(info, voxels.len());
        for (to, &i) in voxels.iter().enumerate() {
            let view = field.view_of(i);
            let Some((_, image)) = exemplar.views[view].carried.get(m) else { continue };
            let from = views[view].index(field.sources[view][i]);
            map.samples.copy_from(to * info.channels, image.samples(), from * info.channels, info.channels);
        }
        volume.maps.push(map);
    }
    if settings.sources {
        let sources = voxels.iter().flat_map(|&i| {
            let view = field.view_of(i);
            let source = u32::from(field.sources[view][i]);
            [source & 255, source >> 8, view as u32]
        });
        volume.maps.push(Map {
            name: "source".into(),
            channels: 3,
            samples: Samples::U32(sources.collect()),
        });
    }
    volume
}
