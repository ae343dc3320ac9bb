//! Measures of how structures lie: correlation, orientation, flat regions.

use rayon::prelude::*;

use super::correlation::{Correlation, curve_distance};
use super::flat::largest_flat;
use super::orientation::Orientations;
use super::views::Pixels;
use crate::control::{Cancelled, Control, check};

/// How structures lie in slices, and how they lie in the exemplar itself.
#[derive(Clone, Debug, Default)]
pub(super) struct Structure {
    /// The distance of autocorrelations, over that between the halves of the exemplar.
    pub autocorrelation: f64,
    /// The excess of the autocorrelation, found and own.
    pub repetition: [f64; 2],
    /// The divergence of orientations, found and own.
    pub orientation_kl: [f64; 2],
    /// The share of the largest flat region, over the exemplar's.
    pub flat: f64,
    /// The mean autocorrelation over all directions of the slices and of the exemplar, for lags of 0, 1, … pixels.
    pub radial: [Vec<f64>; 2],
    /// The shares of orientations of the slices and of the exemplar.
    pub shares: [Vec<f64>; 2],
}

/// Added to both sides of the ratios of correlations and of shares.
const FLOOR: [f64; 2] = [0.02, 0.01];
/// The shortest lag of a repetition.
const LEAST: i64 = 4;

fn ratio(a: f64, b: f64, floor: f64) -> f64 {
    (a + floor) / (b + floor)
}

fn root_mean_square(values: [f64; 3]) -> f64 {
    libm::sqrt(values.iter().map(|v| v * v).sum::<f64>() / 3.0)
}

fn orientations<'a>(pictures: impl IntoIterator<Item = &'a Pixels>) -> Orientations {
    let mut orientations = Orientations::default();
    pictures.into_iter().for_each(|picture| orientations.add(picture));
    orientations
}

/// The mean largest flat region in squares of `edge` in a corner of each slice, over the largest in any corner of the exemplar,
/// since one picture tells less than many slices. A share depends on the size: equal sizes are compared.
fn flatness(pictures: &[Pixels], view: &Pixels, edge: usize) -> f64 {
    let shares: Vec<f64> =
        pictures.par_iter().map(|picture| largest_flat(&picture.cut([0, 0], [edge; 2]))).collect();
    let own = view.corners(edge).iter().map(largest_flat).fold(0.0, f64::max);
    ratio(shares.iter().sum::<f64>() / shares.len().max(1) as f64, own, FLOOR[1])
}

/// Slices of one axis against its view; unturned or transposed, whatever is more like it.
pub(super) fn axis_structure(
    pictures: &[Pixels],
    view: &Pixels,
    shortest: usize,
    control: &dyn Control,
) -> Result<Structure, Cancelled> {
    let reach = (shortest / 4).max(1);
    let splits = view.splits();
    let own = splits.each_ref().map(|split| split.each_ref().map(|half| Correlation::of(half, reach)));
    let expected = Correlation::of(&[view.cut([0, 0], [view.width, view.height])], reach);
    check(control)?;
    let found = Correlation::of(pictures, reach);
    let turned = found.transposed();
    let found = if turned.distance(&expected) < found.distance(&expected) { turned } else { found };
    check(control)?;

    let directions = orientations([view]);
    let own_kl = splits.map(|split| {
        let [a, b] = split.map(|half| orientations(&half));
        (a.divergence(&b) + b.divergence(&a)) / 2.0
    });
    let seen = orientations(pictures);
    let turned = seen.transposed();
    let kl = directions.divergence(&seen).min(directions.divergence(&turned));
    check(control)?;
    Ok(Structure {
        autocorrelation: ratio(
            found.distance(&expected),
            root_mean_square(own.each_ref().map(|[a, b]| a.distance(b))),
            FLOOR[0],
        ),
        repetition: [
            found.excess(&expected, LEAST),
            root_mean_square(own.map(|[a, b]| a.excess(&b, LEAST).max(b.excess(&a, LEAST)))),
        ],
        orientation_kl: [kl, own_kl.iter().sum::<f64>() / 3.0],
        flat: flatness(pictures, view, shortest),
        radial: [found.radial(), expected.radial()],
        shares: [seen.shares(), directions.shares()],
    })
}

/// Oblique squares against a view by what does not depend on how either is turned: the autocorrelation averaged over all
/// directions, and orientations after the best turn. Single squares are small, so that what chance does to them is told by
/// squares of the same size from the corners of the view.
pub(super) fn oblique_structure(
    pictures: &[Pixels],
    view: &Pixels,
    edge: usize,
    control: &dyn Control,
) -> Result<Structure, Cancelled> {
    let reach = (edge / 4).max(1);
    let corners = view.corners(edge);
    let expected = Correlation::of(&[view.cut([0, 0], [view.width, view.height])], reach);
    let radial = expected.radial();
    let own = view.splits().map(|split| {
        let [a, b] = split.map(|half| Correlation::of(&half, reach).radial());
        curve_distance(&a, &b)
    });
    let isotropic = expected.isotropic();
    let directions = orientations([view]);
    let each = |pictures: &[Pixels]| -> Result<[f64; 2], Cancelled> {
        let measured = pictures.par_iter().map(|picture| {
            check(control)?;
            let square = picture.cut([0, 0], [edge; 2]);
            let directed = directions.divergence_turned(&orientations([&square]));
            Ok([Correlation::of(&[square], reach).excess(&isotropic, LEAST), directed])
        });
        let measured = measured.collect::<Result<Vec<_>, Cancelled>>()?;
        let mean = |i: usize| measured.iter().map(|m| m[i]).sum::<f64>() / measured.len().max(1) as f64;
        Ok([mean(0), mean(1)])
    };
    let ([repetition, kl], [own_repetition, own_kl]) = (each(pictures)?, each(&corners)?);
    let found = Correlation::of(pictures, reach).radial();
    check(control)?;
    Ok(Structure {
        autocorrelation: ratio(curve_distance(&found, &radial), root_mean_square(own), FLOOR[0]),
        repetition: [repetition, own_repetition],
        orientation_kl: [kl, own_kl],
        flat: flatness(pictures, view, edge),
        radial: [found, radial],
        shares: [orientations(pictures).shares(), directions.shares()],
    })
}

/// The mean of several.
pub(super) fn mean_structure(of: &[Structure]) -> Structure {
    let n = of.len().max(1) as f64;
    let mean = |value: fn(&Structure) -> f64| of.iter().map(value).sum::<f64>() / n;
    let most = |value: fn(&Structure) -> f64| of.iter().map(value).fold(0.0, f64::max);
    let curve = |value: fn(&Structure) -> &Vec<f64>| {
        let length = of.iter().map(|s| value(s).len()).min().unwrap_or(0);
        (0..length).map(|i| of.iter().map(|s| value(s)[i]).sum::<f64>() / n).collect::<Vec<f64>>()
    };
    Structure {
        autocorrelation: libm::sqrt(mean(|s| s.autocorrelation * s.autocorrelation)),
        // A period along one axis is not to be averaged away.
        repetition: [most(|s| s.repetition[0]), most(|s| s.repetition[1])],
        orientation_kl: [mean(|s| s.orientation_kl[0]), mean(|s| s.orientation_kl[1])],
        flat: mean(|s| s.flat),
        radial: [curve(|s| &s.radial[0]), curve(|s| &s.radial[1])],
        shares: [curve(|s| &s.shares[0]), curve(|s| &s.shares[1])],
    }
}
