//! Phases of a volume against those of its exemplar, and of a true volume.

use super::grid::Grid;
use super::read::{PhaseError, SMALLEST, picture_phase, volume_phase};
use super::statistics::{Estimate, NUMBERS, Statistics};
use crate::control::Control;
use crate::data::{Curves, Image, Plot, Report, Row, Series, Volume};

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PhaseSettings {
    /// Slices across each axis.
    pub slices: usize,
}

impl Default for PhaseSettings {
    fn default() -> Self {
        Self { slices: 8 }
    }
}

/// Added to both sides of ratios of distances of curves, which are probabilities.
const FLOOR: f64 = 0.005;

/// The largest good ratio of distances of curves.
const FARTHEST: f64 = 2.5;

/// Standard errors that a number may be off.
const ERRORS: f64 = 4.0;

/// Names, units, and what a number may be off besides its standard errors: of the reference, and at all.
const ROWS: [[(&str, &str, f64, f64); NUMBERS]; 2] = [
    [
        ("fraction", "of the area", 0.05, 0.0),
        ("surface", "per voxel", 0.05, 0.0),
        ("euler_8", "per 1000 pixels", 0.1, 0.1),
        ("euler_4", "per 1000 pixels", 0.1, 0.1),
        ("connectivity", "of the phase", 0.0, 0.1),
        ("chord", "voxels", 0.05, 0.0),
    ],
    [
        ("fraction", "of the volume", 0.05, 0.0),
        ("surface", "per voxel", 0.05, 0.0),
        ("euler_26", "per 1000 voxels", 0.1, 0.01),
        ("euler_6", "per 1000 voxels", 0.1, 0.01),
        ("connectivity", "of the phase", 0.0, 0.1),
        ("chord", "voxels", 0.05, 0.0),
    ],
];

/// Measures the phases of a volume on slices across the axes against a picture, and in 3D against a true volume where there is one.
///
/// The phase is the bright one: the exemplar's luminance above its threshold of Otsu 1979 (a mask of two values is parted between
/// them). The same threshold parts the volume and the truth, unless they hold labels, of which 0 is the dark phase, or one channel
/// with two values, of which the smaller is.
///
/// # Errors
/// [`PhaseError`]: too small an exemplar or volume (16 along each axis), no map to tell phases by, an exemplar or a truth of one
/// phase, a truth of another size, samples that are not finite, or cancelled.
pub fn compare_phases(
    volume: &Volume,
    exemplar: &Image,
    truth: Option<&Volume>,
    settings: &PhaseSettings,
    control: &dyn Control,
) -> Result<(Report, Curves), PhaseError> {
    let (picture, threshold) = picture_phase(exemplar, "the exemplar")?;
    let solid = volume_phase(volume, threshold, "the volume")?;
    let truth = truth.map(|truth| true_phase(truth, volume.size, threshold)).transpose()?;
    // Connectivity depends on the window, so equal windows are compared.
    let edge = volume.size.into_iter().chain([picture.size[0], picture.size[1]]).min().unwrap_or(SMALLEST);
    let reach = edge / 4;

    let window = picture.part([0; 3], [edge, edge, 1]);
    let mut own = Estimate::of_window(&picture, reach, control)?;
    own.mean.numbers[4] = Statistics::of(&window, reach).numbers[4];
    let slices = slices(&solid, edge, settings.slices.max(1));
    let found = Estimate::of_windows(&slices, reach, slices.len() / 3, control)?;
    control.progress(0.4);

    let mut report = Report::new("phases");
    report.row("threshold", threshold, "grey levels of luminance; brighter is the phase");
    fill(&mut report, "slice", &found, &own, &ROWS[0]);
    let mut plotted = vec![("slices", found.mean), ("exemplar", own.mean)];
    if let Some(truth) = truth {
        let found = Estimate::of_window(&solid, reach, control)?;
        control.progress(0.7);
        let own = Estimate::of_window(&truth, reach, control)?;
        fill(&mut report, "solid", &found, &own, &ROWS[1]);
        plotted.extend([("solid", found.mean), ("truth", own.mean)]);
    }
    Ok((report, curves(&plotted, reach)))
}

fn true_phase(truth: &Volume, expected: [usize; 3], threshold: f64) -> Result<Grid, PhaseError> {
    if truth.size != expected {
        return Err(PhaseError::Size { found: truth.size, expected });
    }
    let phase = volume_phase(truth, threshold, "the truth")?;
    if phase.data.iter().all(|&p| p) || phase.data.iter().all(|&p| !p) {
        let side = if phase.data.first() == Some(&true) { "above" } else { "not above" };
        let why = format!("all its voxels are {side} the exemplar's threshold of {threshold} grey levels");
        return Err(PhaseError::OnePhase("the truth", why));
    }
    Ok(phase)
}

/// Squares of `edge` in slices spread over each axis.
fn slices(solid: &Grid, edge: usize, count: usize) -> Vec<Grid> {
    let slice = |axis: usize, at: usize| {
        let (u, v) = crate::measure::views::in_plane(axis);
        Grid::from_fn([edge, edge, 1], |[column, row, _]| {
            let mut voxel = [at; 3];
            (voxel[u], voxel[v]) = (column, row);
            solid.get(voxel)
        })
    };
    let places = (0..3).flat_map(|axis| {
        let count = count.min(solid.size[axis]);
        (0..count).map(move |i| (axis, (2 * i + 1) * solid.size[axis] / (2 * count)))
    });
    places.map(|(axis, at)| slice(axis, at)).collect()
}

fn fill(
    report: &mut Report,
    family: &str,
    found: &Estimate,
    own: &Estimate,
    rows: &[(&str, &str, f64, f64); NUMBERS],
) {
    for (k, &(name, unit, relative, absolute)) in rows.iter().enumerate() {
        let (value, reference) = (found.mean.numbers[k], own.mean.numbers[k]);
        let error = libm::sqrt(found.errors[k] * found.errors[k] + own.errors[k] * own.errors[k]);
        let slack = ERRORS * error + relative * reference.abs() + absolute;
        // Euler numbers alone have no least value.
        let least = if name.starts_with("euler") { f64::NEG_INFINITY } else { 0.0 };
        report.rows.push(Row {
            name: format!("{family}_{name}"),
            value,
            unit: unit.to_owned(),
            reference: Some(reference),
            good: Some([(reference - slack).max(least), reference + slack]),
        });
    }
    let distances = found.mean.distances(&own.mean);
    for ((name, distance), half) in ["two_point", "lineal_path"].into_iter().zip(distances).zip(own.halves) {
        report.rows.push(Row {
            name: format!("{family}_{name}"),
            value: (distance + FLOOR) / (half + FLOOR),
            unit: "distance, of that between halves".to_owned(),
            reference: Some(1.0),
            good: Some([0.0, FARTHEST]),
        });
    }
}

fn curves(of: &[(&str, Statistics)], reach: usize) -> Curves {
    let plot = |title: &str, x: &str, y: &str, get: &dyn Fn(&Statistics) -> Vec<f64>| {
        let series = of.iter().map(|(name, statistics)| Series {
            name: (*name).to_owned(),
            points: get(statistics).into_iter().enumerate().map(|(i, v)| [i as f64, v]).collect(),
        });
        Plot::new(title, x, y, series.collect())
    };
    let mut curves = Curves::new("phases");
    curves.plots = vec![
        plot("two-point correlation", "lag in voxels", "both in the phase", &|s| s.two_point.clone()),
        plot("lineal path", "length in voxels", "segment in the phase", &|s| s.lineal.clone()),
        plot("chord lengths", "length in voxels", "share of chords", &|s| {
            s.chords.iter().take(2 * reach + 1).copied().collect()
        }),
    ];
    curves
}
