//! Measures of how structures lie: correlation, orientation, flat regions.

use super::compare::Random;
use super::correlation::Correlation;
use super::flat::largest_flat;
use super::orientation::Orientations;
use super::views::{Pixels, Voxels};
use crate::control::{Cancelled, Control, check};

/// How the structures of a volume's axis-aligned slices lie, against its exemplar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Structure {
    /// Root mean square difference of the autocorrelations of luminance over all lags to a quarter of the size (Urs et
    /// al. 2014, section VI), over that between disjoint halves of the exemplar. From 0; up to about 1 is good. Misses
    /// colour and contrast, and lines that break without moving.
    pub autocorrelation: f64,
    /// The most by which the autocorrelation exceeds the exemplar's at a lag of 4 pixels or more, 0 to 1; small is good.
    /// Up to 0.2 is chance in a small exemplar, more is stripes, tiles or diagonal bands. Misses what repeats after more
    /// than a quarter of the size.
    pub repetition: f64,
    /// Kullback-Leibler divergence of local orientations by structure tensor (Urs et al. 2014, section VI) in nats, from
    /// 0; small is good. Misses scale.
    pub orientation_kl: f64,
    /// The share of a slice that its largest flat region takes, over that in the exemplar; up to about 1 is good, more is
    /// collapse. Misses collapse to a region with texture of its own.
    pub flat: f64,
}

/// Added to both sides of the ratios of correlations and of shares.
const FLOOR: [f64; 2] = [0.02, 0.01];
/// The shortest lag of a repetition.
const LEAST: i64 = 4;

/// Measures slices across the axes; of each axis, unturned and transposed, the one that is more like the exemplar.
pub(super) fn measure_structure(
    voxels: &Voxels,
    truth: &Pixels,
    slices: usize,
    random: Random,
    control: &dyn Control,
) -> Result<Structure, Cancelled> {
    let edges = [truth.width, truth.height].into_iter().chain(voxels.size);
    let shortest = edges.min().unwrap_or(0);
    let reach = (shortest / 4).max(1);
    let (w, h) = (truth.width / 2, truth.height / 2);
    let quadrants = |places: [[usize; 2]; 2]| {
        Correlation::of(&places.map(|[x, y]| cut(truth, [x * w, y * h], [w, h])), reach)
    };
    let own = quadrants([[0, 0], [1, 1]]).distance(&quadrants([[1, 0], [0, 1]]));
    let expected = Correlation::of(&[cut(truth, [0, 0], [truth.width, truth.height])], reach);
    let mut directions = Orientations::default();
    directions.add(truth);

    let (mut squares, mut repetition, mut orientation_kl, mut flat) = (0.0, 0.0f64, 0.0, 0.0);
    for axis in 0..3 {
        check(control)?;
        let pick = |slice: usize| {
            voxels.slice(axis, random.below(voxels.size[axis], [11, axis as u64, slice as u64]))
        };
        let pictures: Vec<Pixels> = (0..slices).map(pick).collect();
        let found = Correlation::of(&pictures, reach);
        let turned = found.transposed();
        let found = if turned.distance(&expected) < found.distance(&expected) { turned } else { found };
        squares += found.distance(&expected).powi(2) / 3.0;
        repetition = repetition.max(found.excess(&expected, LEAST));
        let mut found = Orientations::default();
        pictures.iter().for_each(|picture| found.add(picture));
        let turned = found.transposed();
        orientation_kl += directions.divergence(&found).min(directions.divergence(&turned)) / 3.0;
        for picture in &pictures {
            // A share depends on the size: equal sizes are compared.
            let side = [shortest; 2];
            flat += largest_flat(&cut(picture, [0, 0], side)) / (3 * slices) as f64;
        }
    }
    // The exemplar's largest region in any corner, since one picture tells less than many slices.
    let corners = [0, truth.width - shortest].map(|x| [0, truth.height - shortest].map(|y| [x, y]));
    let own_flat = corners.into_iter().flatten().map(|at| largest_flat(&cut(truth, at, [shortest; 2])));
    let own_flat = own_flat.fold(0.0, f64::max);
    let ratio = |a: f64, b: f64, floor: f64| (a + floor) / (b + floor);
    Ok(Structure {
        autocorrelation: ratio(libm::sqrt(squares), own, FLOOR[0]),
        repetition,
        orientation_kl,
        flat: ratio(flat, own_flat, FLOOR[1]),
    })
}

/// A part of a picture.
fn cut(picture: &Pixels, [x, y]: [usize; 2], [width, height]: [usize; 2]) -> Pixels {
    let rows = (y..y + height).flat_map(|row| &picture.data[row * picture.width + x..][..width]);
    Pixels { width, height, data: rows.copied().collect() }
}
