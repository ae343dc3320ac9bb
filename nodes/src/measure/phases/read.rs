//! Phases of pictures and volumes.

use super::grid::Grid;
use super::threshold::otsu;
use crate::control::Cancelled;
use crate::data::{Image, Map, Samples, Volume};
use crate::measure::compare::not_finite;
use crate::measure::views::{Pixels, luminance};

/// Why phases were not measured.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PhaseError {
    /// The picture is too small to tell its own spread.
    #[error("an exemplar of {0} × {1} pixels is too small: phases need at least {SMALLEST} × {SMALLEST}")]
    Exemplar(usize, usize),
    /// The box is too small.
    #[error("a box of {0} × {1} × {2} voxels is too small: phases need at least {SMALLEST} along each axis")]
    Volume(usize, usize, usize),
    /// There is nothing to tell apart.
    #[error("{0} has one phase only, expected two: {1}")]
    OnePhase(&'static str, String),
    /// There is nothing to tell phases by.
    #[error("{0} has no map `label`, `color` or `value` that fits its size, only {1}")]
    NoMap(&'static str, String),
    /// Solid and truth are of different sizes.
    #[error(
        "the truth has {found:?} voxels, expected the volume's {expected:?}: statistics depend on the window"
    )]
    Size {
        /// The truth's size.
        found: [usize; 3],
        /// The volume's size.
        expected: [usize; 3],
    },
    /// A sample is no number.
    #[error("{0} holds a sample that is not finite")]
    NotFinite(&'static str),
    /// The computation was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<PhaseError> for breccia_engine::NodeError {
    fn from(error: PhaseError) -> Self {
        match error {
            PhaseError::Cancelled(cancelled) => cancelled.into(),
            other => Self::input(other),
        }
    }
}

/// The shortest edge of pictures and boxes.
pub(super) const SMALLEST: usize = 16;

/// The bright phase of a picture, and the threshold on luminance that parts it from the dark one.
pub(super) fn picture_phase(picture: &Image, what: &'static str) -> Result<(Grid, f64), PhaseError> {
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    if width < SMALLEST || height < SMALLEST {
        return Err(PhaseError::Exemplar(width, height));
    }
    if not_finite(picture.samples()) {
        return Err(PhaseError::NotFinite(what));
    }
    let levels: Vec<u8> = Pixels::of(picture).data.iter().map(|&pixel| luminance(pixel) as u8).collect();
    let mut histogram = [0; 256];
    levels.iter().for_each(|&level| histogram[usize::from(level)] += 1);
    let one = || PhaseError::OnePhase(what, "all its pixels have one luminance".to_owned());
    let threshold = otsu(&histogram).ok_or_else(one)?;
    let data = levels.into_iter().map(|level| f64::from(level) > threshold).collect();
    Ok((Grid { size: [width, height, 1], data }, threshold))
}

/// The phase of a volume: labels other than 0; of a map with two values the larger; else what is brighter than the threshold.
pub(super) fn volume_phase(volume: &Volume, threshold: f64, what: &'static str) -> Result<Grid, PhaseError> {
    let [x, y, z] = volume.size;
    if volume.size.iter().any(|&n| n < SMALLEST) {
        return Err(PhaseError::Volume(x, y, z));
    }
    let count = volume.voxels();
    let fits = |map: &&Map| map.channels > 0 && Some(map.samples.len()) == count.checked_mul(map.channels);
    let names = || {
        let names: Vec<_> = volume.maps.iter().map(|map| format!("`{}`", map.name)).collect();
        if names.is_empty() { "nothing".to_owned() } else { names.join(", ") }
    };
    let known = ["label", "color", "value"].into_iter();
    let map = known.filter_map(|name| volume.map(name)).find(fits);
    let map = map.ok_or_else(|| PhaseError::NoMap(what, names()))?;
    if not_finite(&map.samples) {
        return Err(PhaseError::NotFinite(what));
    }
    let n = map.channels;
    let data = if map.name == "label" {
        (0..count).map(|i| map.samples.get(i * n) != 0.0).collect()
    } else if let Some(larger) = larger_of_two(map) {
        (0..count).map(|i| map.samples.get(i) == larger).collect()
    } else {
        let channel = |i: usize, c: usize| map.samples.get_u8(i * n + if n < 3 { 0 } else { c });
        let level = |i: usize| luminance([channel(i, 0), channel(i, 1), channel(i, 2)]) as u8;
        (0..count).map(|i| f64::from(level(i)) > threshold).collect()
    };
    Ok(Grid { size: volume.size, data })
}

/// The larger value of a map of one channel and exactly two values.
fn larger_of_two(map: &Map) -> Option<f32> {
    if map.channels != 1 {
        return None;
    }
    let value = |i: usize| map.samples.get(i);
    let first = value(0);
    let second = (0..map.samples.len()).map(value).find(|&v| v != first)?;
    let third = (0..map.samples.len()).map(value).any(|v| v != first && v != second);
    // Two neighbouring floats are two values by chance rather than by meaning.
    let meant = matches!(map.samples, Samples::U8(_) | Samples::U32(_)) || (first - second).abs() > 1e-3;
    (!third && meant).then_some(first.max(second))
}
