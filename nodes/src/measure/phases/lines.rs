//! Statistics along lines: two-point correlation, lineal path, chords, crossings.

use super::grid::Grid;

/// The two-point correlation S₂(r) of a phase along an axis, the share of pairs of voxels `r` apart that are both of it, for r = 0
/// to `reach`: the volume fraction φ at 0, about φ² where nothing is correlated. 0 to 1. Torquato 2002, section 2.1.
///
/// Lags that no pair has are left out.
pub fn two_point(grid: &Grid, axis: usize, reach: usize) -> Vec<f64> {
    let n = grid.size[axis];
    let value = |lag: usize| {
        let (lines, stride) = grid.lines(axis);
        let (mut both, mut pairs) = (0u64, 0u64);
        for start in lines {
            let at = |i: usize| grid.data[start + i * stride];
            both += (0..n - lag).filter(|&i| at(i) && at(i + lag)).count() as u64;
            pairs += (n - lag) as u64;
        }
        both as f64 / pairs.max(1) as f64
    };
    (0..=reach.min(n.saturating_sub(1))).map(value).collect()
}

/// What lines along the axes of a grid meet.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Chords {
    /// How many runs of the phase have each length, whether the border cuts them or not.
    runs: Vec<u64>,
    /// How many lines have each length.
    lines: Vec<u64>,
    /// How many runs of each length the border does not cut.
    whole: Vec<u64>,
    /// Changes of phase between neighbours, and pairs of neighbours.
    crossings: [u64; 2],
}

impl Chords {
    /// Of all lines along all axes.
    pub fn of(grid: &Grid) -> Self {
        let longest = grid.size.into_iter().max().unwrap_or(0);
        let zeros = || vec![0; longest + 1];
        let mut chords = Self { runs: zeros(), lines: zeros(), whole: zeros(), crossings: [0; 2] };
        for axis in grid.axes() {
            let n = grid.size[axis];
            let (lines, stride) = grid.lines(axis);
            for start in lines {
                chords.lines[n] += 1;
                let line: Vec<bool> = (0..n).map(|i| grid.data[start + i * stride]).collect();
                let mut at = 0;
                for run in line.chunk_by(|a, b| a == b) {
                    if run.first() == Some(&true) {
                        chords.runs[run.len()] += 1;
                        if at > 0 && at + run.len() < n {
                            chords.whole[run.len()] += 1;
                        }
                    }
                    at += run.len();
                    chords.crossings[0] += u64::from(at < n);
                }
                chords.crossings[1] += n as u64 - 1;
            }
        }
        chords
    }

    /// The lineal path function L(r), the share of segments of `r` steps that lie in the phase, for r = 0 to `reach`: the volume
    /// fraction at 0, falling. 0 to 1. Lu & Torquato 1992.
    pub fn lineal_path(&self, reach: usize) -> Vec<f64> {
        let places = |lengths: &[u64], steps: usize| {
            let places = lengths.iter().enumerate().skip(steps + 1);
            places.map(|(length, count)| count * (length - steps) as u64).sum::<u64>()
        };
        let share = |steps| places(&self.runs, steps) as f64 / places(&self.lines, steps).max(1) as f64;
        (0..=reach).map(share).collect()
    }

    /// The chord length distribution p(z), the share of chords of the phase of each length from 0 voxels on, without those that the
    /// border cuts. Torquato & Lu 1993.
    pub fn distribution(&self) -> Vec<f64> {
        let sum = self.whole.iter().sum::<u64>().max(1) as f64;
        self.whole.iter().map(|&count| count as f64 / sum).collect()
    }

    /// The mean of [`Self::distribution`] in voxels; 0 if there are no chords.
    pub fn mean(&self) -> f64 {
        self.distribution().iter().enumerate().map(|(length, share)| length as f64 * share).sum()
    }

    /// The specific surface S_V in 1/voxel: twice the crossings per length of line, `S_V = 2 P_L` (Underwood 1970), of lines along
    /// the axes. Exact for isotropic media and for balls, whichever way they were cut.
    pub fn surface(&self) -> f64 {
        2.0 * self.crossings[0] as f64 / self.crossings[1].max(1) as f64
    }
}
