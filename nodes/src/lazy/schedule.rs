//! The settings of a synthesis: passes, sub-passes, candidates a level, and the weights of the cost.

use super::per_level;

/// How a pass is divided: voxels of one sub-pass do not see each other's new values, those of later ones do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Schedule {
    /// One sub-pass: every voxel sees the state before the pass. The shortest chain of dependencies.
    Jacobi,
    /// Two sub-passes: voxels of even, then of odd coordinate sum.
    Parity,
    /// Four sub-passes of two complementary octants each, the same bit for bit as the paper's eight, since
    /// octants that differ in all three coordinates do not see each other.
    Octants,
}

impl Schedule {
    /// Number of sub-passes.
    pub fn steps(self) -> usize {
        match self {
            Self::Jacobi => 1,
            Self::Parity => 2,
            Self::Octants => 4,
        }
    }

    /// The voxels of a brick that sub-pass `step` changes, as a mask: bits x + 8 y of word z. Bricks start at
    /// multiples of 8, so every brick has the same.
    pub fn subset(self, step: usize) -> [u64; 8] {
        // Octants by the parities of x (bit 0), y (bit 1), z (bit 2), each with its complement.
        const PAIRS: [[usize; 2]; 4] = [[0, 7], [3, 4], [5, 2], [6, 1]];
        let mut mask = [0u64; 8];
        for i in 0..512usize {
            let (x, y, z) = (i & 7, i >> 3 & 7, i >> 6);
            let octant = (x & 1) | (y & 1) << 1 | (z & 1) << 2;
            let chosen = match self {
                Self::Jacobi => true,
                Self::Parity => (x + y + z) & 1 == step,
                Self::Octants => PAIRS[step].contains(&octant),
            };
            if chosen {
                mask[z] |= 1 << (i & 63);
            }
        }
        mask
    }
}

/// How three colours become one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColorRule {
    /// The colour nearest to the mean of the three, which keeps the exemplar's contrast.
    Nearest,
    /// The mean, as in the paper.
    Mean,
}

/// The settings of a synthesis. Lists go by level, finest first; their last entry serves all coarser levels.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Seed of every random choice.
    pub seed: u64,
    /// The period in voxels along x, y and z, or unbounded.
    pub period: Option<[u32; 3]>,
    /// Correction passes.
    pub passes: Vec<i64>,
    /// Division of a pass, by level.
    pub schedule: Vec<Schedule>,
    /// 2D candidates a pixel, 1 to 4.
    pub similar: Vec<i64>,
    /// 3D candidates a pixel, 0 to 12.
    pub triples: Vec<i64>,
    /// Raises the distance of a pixel that continues none of its neighbours by this fraction (κ).
    pub coherence: f64,
    /// Weight of a triple's crossbar error against the neighbourhood distances (λ).
    pub crossbar: f64,
    /// How three colours become one.
    pub color: ColorRule,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            seed: 1,
            period: None,
            passes: vec![2],
            schedule: vec![Schedule::Jacobi],
            similar: vec![2, 4],
            triples: vec![2, 12],
            coherence: 0.4,
            crossbar: 3.0,
            color: ColorRule::Nearest,
        }
    }
}

impl Settings {
    /// The division of passes of a level.
    pub fn schedule_at(&self, level: usize) -> Schedule {
        self.schedule.get(level).or(self.schedule.last()).copied().unwrap_or(Schedule::Jacobi)
    }

    /// The seed of a test volume, apart from those that people choose.
    pub(super) fn seed_of_round(&self, round: usize) -> u64 {
        0x7e57_0000_0000_0000 | round as u64
    }

    /// The masks of a level's sub-passes in the order of time, over all its passes.
    pub(super) fn steps(&self, level: usize) -> Vec<[u64; 8]> {
        let schedule = self.schedule_at(level);
        let pass = (0..schedule.steps()).map(|step| schedule.subset(step));
        let passes = per_level(&self.passes, level).clamp(0, 64) as usize;
        pass.cycle().take(passes * schedule.steps()).collect()
    }
}
