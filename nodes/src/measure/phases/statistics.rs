//! All statistics of a phase in one window, with how much they vary.

use rayon::prelude::*;

use super::components::connectivity;
use super::euler::{Neighbours, euler_number};
use super::grid::Grid;
use super::lines::{Chords, two_point};
use crate::control::{Cancelled, Control, check};
use crate::measure::correlation::curve_distance;

/// Single numbers: fraction, surface, Euler numbers by all and by face neighbours per 1000 voxels, connectivity, mean chord.
pub(super) const NUMBERS: usize = 6;

/// What is known of a phase in a window, or on average over several.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Statistics {
    pub numbers: [f64; NUMBERS],
    /// Two-point correlation, the mean over the axes.
    pub two_point: Vec<f64>,
    pub lineal: Vec<f64>,
    /// Shares of chord lengths.
    pub chords: Vec<f64>,
}

/// Statistics with their standard errors, and the distances of the curves of two halves.
#[derive(Clone, Debug, Default)]
pub(super) struct Estimate {
    pub mean: Statistics,
    pub errors: [f64; NUMBERS],
    /// Root mean square distances of two-point correlation and lineal path.
    pub halves: [f64; 2],
}

impl Statistics {
    /// Of one window.
    pub fn of(grid: &Grid, reach: usize) -> Self {
        let voxels = grid.data.len().max(1) as f64;
        // Cells of the lower borders are not counted.
        let inner: f64 = grid.axes().iter().map(|&axis| (grid.size[axis] - 1) as f64).product();
        let chords = Chords::of(grid);
        let euler = |neighbours| euler_number(grid, neighbours) as f64 * 1000.0 / inner.max(1.0);
        let axes = grid.axes();
        let each: Vec<Vec<f64>> = axes.iter().map(|&axis| two_point(grid, axis, reach)).collect();
        let length = each.iter().map(Vec::len).min().unwrap_or(0);
        let mean = |lag: usize| each.iter().map(|values| values[lag]).sum::<f64>() / axes.len().max(1) as f64;
        Self {
            numbers: [
                grid.data.iter().filter(|&&phase| phase).count() as f64 / voxels,
                chords.surface(),
                euler(Neighbours::All),
                euler(Neighbours::Faces),
                connectivity(grid),
                chords.mean(),
            ],
            two_point: (0..length).map(mean).collect(),
            lineal: chords.lineal_path(reach),
            chords: chords.distribution(),
        }
    }

    /// The mean of several, curves as far as the shortest.
    pub fn mean(of: &[Self]) -> Self {
        let n = of.len().max(1) as f64;
        let curve = |get: fn(&Self) -> &Vec<f64>| -> Vec<f64> {
            let length = of.iter().map(|s| get(s).len()).min().unwrap_or(0);
            (0..length).map(|i| of.iter().map(|s| get(s)[i]).sum::<f64>() / n).collect()
        };
        Self {
            numbers: std::array::from_fn(|k| of.iter().map(|s| s.numbers[k]).sum::<f64>() / n),
            two_point: curve(|s| &s.two_point),
            lineal: curve(|s| &s.lineal),
            chords: curve(|s| &s.chords),
        }
    }

    /// Root mean square distances of two-point correlation and lineal path.
    pub fn distances(&self, other: &Self) -> [f64; 2] {
        [curve_distance(&self.two_point, &other.two_point), curve_distance(&self.lineal, &other.lineal)]
    }
}

impl Estimate {
    /// Of one window; quadrants or octants tell how much chance there is.
    pub fn of_window(grid: &Grid, reach: usize, control: &dyn Control) -> Result<Self, Cancelled> {
        check(control)?;
        let parts = of_all(&grid.parts(), reach, control)?;
        let (even, odd) = parts.split_at(parts.len() / 2);
        let halves = Statistics::mean(even).distances(&Statistics::mean(odd));
        Ok(Self { mean: Statistics::of(grid, reach), errors: errors(&parts, parts.len()), halves })
    }

    /// Of several windows, of which about `independent` are.
    pub fn of_windows(
        grids: &[Grid],
        reach: usize,
        independent: usize,
        control: &dyn Control,
    ) -> Result<Self, Cancelled> {
        let all = of_all(grids, reach, control)?;
        Ok(Self { mean: Statistics::mean(&all), errors: errors(&all, independent), halves: [0.0; 2] })
    }
}

fn of_all(grids: &[Grid], reach: usize, control: &dyn Control) -> Result<Vec<Statistics>, Cancelled> {
    let one = |grid| {
        check(control)?;
        Ok(Statistics::of(grid, reach))
    };
    grids.par_iter().map(one).collect()
}

/// Standard errors of the mean.
fn errors(of: &[Statistics], independent: usize) -> [f64; NUMBERS] {
    let mean = Statistics::mean(of).numbers;
    std::array::from_fn(|k| {
        let squares: f64 = of.iter().map(|s| (s.numbers[k] - mean[k]) * (s.numbers[k] - mean[k])).sum();
        libm::sqrt(squares / of.len().saturating_sub(1).max(1) as f64 / independent.max(1) as f64)
    })
}
