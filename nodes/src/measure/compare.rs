//! Measures of a volume against its exemplar, to be read together.

use rayon::prelude::*;

use super::color_divergence;
use super::contrast::{Spread, gather};
use super::patches::{EDGE, NUMBERS, Patch, PatchSet, patch};
use super::structure::{Structure, measure_structure};
use super::views::{Pixels, Voxels, in_plane};
use crate::control::{Cancelled, Control, check};
use crate::data::{Image, Volume};
use crate::solid::Plane;

/// How much is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QualitySettings {
    /// Patches taken across the axes, and as many again from oblique planes.
    pub samples: usize,
    /// Slices across each axis for the contrast.
    pub slices: usize,
    /// Selects patches and slices.
    pub seed: u64,
}

impl Default for QualitySettings {
    fn default() -> Self {
        Self { samples: 2048, slices: 8, seed: 1 }
    }
}

/// How well a volume resembles its exemplar. None of these numbers means much alone: a flat volume may have a
/// small distance, and pixel noise with the right colours a small divergence. Look at pictures too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Kullback-Leibler divergence of colour histograms in nats, 0 and up; small is good. See
    /// [`color_divergence`]. Misses all arrangement: shuffled pixels score 0.
    pub color_kl: f64,
    /// Variety of the volume's patches in terms of the exemplar's, 0 and up; 1 is as varied as the exemplar.
    ///
    /// The exemplar is split into two halves (opposite quadrants each). Patches of the volume, half of them
    /// across the axes and half oblique, each look for the nearest patch in either half, and so does each
    /// half in the other. From how often each cell of 2 × 2 pixels was hit follows how many different cells
    /// as many hits as there are cells reach on average, `Σ 1 − (1 − pᵢ)^m`; coverage is this number for the
    /// volume over that for the exemplar. Misses whether what is covered is arranged well.
    pub coverage: f64,
    /// Standard deviation of luminance over that of the exemplar; 1 is good. Misses scale and arrangement.
    pub contrast: f64,
    /// The same of the fine detail, luminance minus its 3 × 3 mean: below 1 is blurred, above 1 noisy.
    pub fine_contrast: f64,
    /// Neighbourhood distance of slices across x, y and z: the root mean square distance of 5 × 5 RGB patches
    /// to the nearest patch in either half of the exemplar, divided by that from each half to the other.
    ///
    /// 1 is as good as the exemplar itself, verbatim copies reach about 0.7, foreign patches go above 1.
    /// Each direction is compared unturned and transposed, and the better counts. Misses collapse: a volume
    /// that repeats one smooth region scores low.
    pub distances: [f64; 3],
    /// The root mean square of [`Quality::distances`].
    pub axis_distance: f64,
    /// The same the other way round, for each of x, y and z: from patches of the exemplar to the nearest of as
    /// many patches of the volume as half the exemplar has, over the distance between the halves. 1 or a
    /// little below is good; above 1 something of the exemplar is not to be found across that axis, as in
    /// streaks, blur and collapse. Misses what is there besides.
    pub completeness: [f64; 3],
    /// The root mean square of [`Quality::completeness`].
    pub axis_completeness: f64,
    /// The neighbourhood distance of oblique planes (four space diagonals and three face diagonals, nearest
    /// voxels). Cuts of a solid through grains differ from its faces a little even where it is perfect.
    pub oblique_distance: f64,
    /// How its structures lie.
    pub structure: Structure,
}

/// Why nothing was measured.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeasureError {
    /// The exemplar is too small to be split into halves.
    #[error("an exemplar of {0} × {1} pixels is too small: measuring needs at least {SMALLEST} × {SMALLEST}")]
    Exemplar(usize, usize),
    /// The volume is too small for oblique patches.
    #[error("a box of {0} × {1} × {2} voxels is too small: measuring needs at least 8 along each axis")]
    Volume(usize, usize, usize),
    /// The volume has no colours.
    #[error("the volume has no map `color` that fits its size")]
    NoColor,
    /// The computation was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<MeasureError> for breccia_engine::NodeError {
    fn from(error: MeasureError) -> Self {
        match error {
            MeasureError::Cancelled(cancelled) => cancelled.into(),
            other => Self::failed(other),
        }
    }
}

/// The smallest exemplar, so that each quadrant holds some patches.
const SMALLEST: usize = 16;

/// The most patches kept of half an exemplar; larger exemplars are sampled on a coarser grid.
const MOST_PATCHES: usize = 16_384;

/// A grey level's fraction added to both sides of ratios, so that flat exemplars divide too.
const FLOOR: f64 = 0.25;

/// Normals of the oblique planes.
const NORMALS: [[f64; 3]; 7] = [
    [1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, -1.0, 1.0],
    [-1.0, 1.0, 1.0],
    [1.0, 1.0, 0.0],
    [1.0, 0.0, 1.0],
    [0.0, 1.0, 1.0],
];

/// Measures a volume against its exemplar.
///
/// # Errors
/// [`MeasureError`]: too small an exemplar (16 pixels) or volume (8 voxels), no colours, or cancelled.
pub fn measure_quality(
    volume: &Volume,
    exemplar: &Image,
    settings: &QualitySettings,
    control: &dyn Control,
) -> Result<Quality, MeasureError> {
    let (width, height) = (exemplar.width() as usize, exemplar.height() as usize);
    if width < SMALLEST || height < SMALLEST {
        return Err(MeasureError::Exemplar(width, height));
    }
    let [x, y, z] = volume.size;
    if volume.size.iter().any(|&n| n < 8) {
        return Err(MeasureError::Volume(x, y, z));
    }
    let color = volume.map("color").ok_or(MeasureError::NoColor)?;
    let voxels = Voxels::of(volume, color).ok_or(MeasureError::NoColor)?;
    let truth = Pixels::of(exemplar);
    let random = Random(settings.seed);

    let color_kl = color_divergence(&truth.data, &voxels.data);
    check(control)?;
    let [contrast, fine_contrast] = contrasts(&voxels, &truth, settings, random, control)?;
    control.progress(0.1);
    let structure = measure_structure(&voxels, &truth, settings.slices.clamp(1, 4096), random, control)?;
    control.progress(0.2);

    let halves = halves(&truth);
    let samples = settings.samples.clamp(64, 1 << 20);
    let reference = Matches::between_halves(&halves, 2 * samples, random, control)?;
    control.progress(0.4);
    let (mut across, mut missing) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        let count = samples / 3 + usize::from(axis < samples % 3);
        let along = |transposed, count| axis_patches(&voxels, axis, transposed, count, random);
        // A part of the patches tells which way round the exemplar is.
        let plain = Matches::of(&halves, &along(false, count / 8), control)?;
        let turned = Matches::of(&halves, &along(true, count / 8), control)?;
        let transposed = turned.squares < plain.squares;
        across.push(Matches::of(&halves, &along(transposed, count), control)?);
        let found = PatchSet::of(along(transposed, halves[0].len()));
        missing.push(Matches::within(&found, &exemplar_patches(&halves, count, random), control)?);
        control.progress(0.4 + 0.15 * (axis + 1) as f32);
    }
    let oblique = Matches::of(&halves, &oblique_patches(&voxels, samples, random), control)?;

    let ratio = |rms: f64| (rms + FLOOR) / (reference.rms() + FLOOR);
    let (distances, mut all) = sum_up(across, ratio);
    let (completeness, missing) = sum_up(missing, ratio);
    let (axis_distance, axis_completeness) = (ratio(all.rms()), ratio(missing.rms()));
    let oblique_distance = ratio(oblique.rms());
    all.add(oblique);
    let draws = halves.iter().map(PatchSet::cell_count).sum::<usize>().min(reference.count / 2);
    let coverage = all.variety(draws) / reference.variety(draws).max(1e-9);
    Ok(Quality {
        color_kl,
        coverage,
        contrast,
        fine_contrast,
        distances,
        axis_distance,
        completeness,
        axis_completeness,
        oblique_distance,
        structure,
    })
}

/// The ratio of each axis, and all together.
fn sum_up(axes: Vec<Matches>, ratio: impl Fn(f64) -> f64) -> ([f64; 3], Matches) {
    let mut all = Matches::default();
    let mut ratios = [0.0; 3];
    for (to, matches) in ratios.iter_mut().zip(axes) {
        *to = ratio(matches.rms());
        all.add(matches);
    }
    (ratios, all)
}

/// Ratios of the deviations of luminance and of its fine detail.
fn contrasts(
    voxels: &Voxels,
    truth: &Pixels,
    settings: &QualitySettings,
    random: Random,
    control: &dyn Control,
) -> Result<[f64; 2], Cancelled> {
    let (mut all, mut fine) = (Spread::default(), Spread::default());
    for axis in 0..3 {
        for slice in 0..settings.slices.clamp(1, 4096) {
            check(control)?;
            let at = random.below(voxels.size[axis], [10, axis as u64, slice as u64]);
            gather(&voxels.slice(axis, at), &mut all, &mut fine);
        }
    }
    let (mut true_all, mut true_fine) = (Spread::default(), Spread::default());
    gather(truth, &mut true_all, &mut true_fine);
    let ratio = |a: Spread, b: Spread| (a.deviation() + FLOOR) / (b.deviation() + FLOOR);
    Ok([ratio(all, true_all), ratio(fine, true_fine)])
}

/// The patches of opposite quadrants: top left with bottom right, and the other two. No patch crosses.
fn halves(truth: &Pixels) -> [PatchSet; 2] {
    let (w, h) = (truth.width, truth.height);
    let (x, y) = (w / 2, h / 2);
    let mut stride = 1;
    while (w / stride) * (h / stride) / 2 > MOST_PATCHES {
        stride += 1;
    }
    let cell = stride.max(2);
    [
        PatchSet::new(truth, &[[0, 0, x, y], [x, y, w - x, h - y]], stride, cell),
        PatchSet::new(truth, &[[x, 0, w - x, y], [0, y, x, h - y]], stride, cell),
    ]
}

/// What patches found in the halves of the exemplar.
#[derive(Default)]
struct Matches {
    /// Sum of squared distances.
    squares: i64,
    /// How many distances.
    count: usize,
    /// Cells hit, once for each hit.
    cells: Vec<u32>,
}

impl Matches {
    /// Each of `patches` in both halves.
    fn of(halves: &[PatchSet; 2], patches: &[Patch], control: &dyn Control) -> Result<Self, Cancelled> {
        let mut matches = Self::default();
        for half in halves {
            matches.add(Self::within(half, patches, control)?);
        }
        Ok(matches)
    }

    /// `count` patches of each half in the other.
    fn between_halves(
        halves: &[PatchSet; 2],
        count: usize,
        random: Random,
        control: &dyn Control,
    ) -> Result<Self, Cancelled> {
        let mut matches = Self::default();
        for (purpose, [to, from]) in [(20, [0, 1]), (21, [1, 0])] {
            let patches = draw(&halves[from], count, purpose, random);
            matches.add(Self::within(&halves[to], &patches, control)?);
        }
        Ok(matches)
    }

    fn within(half: &PatchSet, patches: &[Patch], control: &dyn Control) -> Result<Self, Cancelled> {
        let found: Vec<(i32, u32)> = patches
            .par_chunks(16)
            .map(|patches| {
                check(control)?;
                Ok(patches.iter().map(|patch| half.nearest(patch)).collect::<Vec<_>>())
            })
            .collect::<Result<Vec<_>, Cancelled>>()?
            .concat();
        let squares = found.iter().map(|&(square, _)| i64::from(square)).sum();
        Ok(Self { squares, count: found.len(), cells: found.into_iter().map(|(_, cell)| cell).collect() })
    }

    fn add(&mut self, other: Self) {
        self.squares += other.squares;
        self.count += other.count;
        self.cells.extend(other.cells);
    }

    /// The root mean square difference of a patch's number, in grey levels.
    fn rms(&self) -> f64 {
        (self.squares as f64 / (self.count.max(1) * NUMBERS) as f64).sqrt()
    }

    /// How many different cells that many hits reach on average.
    fn variety(&self, draws: usize) -> f64 {
        let mut cells = self.cells.clone();
        cells.sort_unstable();
        let shares = cells.chunk_by(|a, b| a == b).map(|hits| hits.len() as f64 / self.count.max(1) as f64);
        shares.map(|p| 1.0 - libm::pow(1.0 - p, draws as f64)).sum()
    }
}

/// Patches of a set, drawn with replacement.
fn draw(set: &PatchSet, count: usize, purpose: u64, random: Random) -> Vec<Patch> {
    (0..count).map(|i| *set.get(random.below(set.len(), [purpose, i as u64, 0]))).collect()
}

/// Patches of both halves of the exemplar.
fn exemplar_patches(halves: &[PatchSet; 2], count: usize, random: Random) -> Vec<Patch> {
    let [a, b] = halves;
    [draw(a, count, 22, random), draw(b, count, 23, random)].concat()
}

/// Patches across an axis at random places.
fn axis_patches(voxels: &Voxels, axis: usize, transposed: bool, count: usize, random: Random) -> Vec<Patch> {
    let (columns, rows) = in_plane(axis);
    let (u, v) = if transposed { (rows, columns) } else { (columns, rows) };
    let pick = |i: usize| {
        let corner: [usize; 3] = std::array::from_fn(|c| {
            let room = voxels.size[c] - if c == axis { 0 } else { EDGE - 1 };
            random.below(room, [30 + axis as u64, i as u64, c as u64])
        });
        patch(|column, row| {
            let mut voxel = corner;
            voxel[u] += column;
            voxel[v] += row;
            voxels.get(voxel)
        })
    };
    (0..count).map(pick).collect()
}

/// Patches of oblique planes at random places, from the nearest voxels.
fn oblique_patches(voxels: &Voxels, count: usize, random: Random) -> Vec<Patch> {
    // The corner of a patch is 2 √2 from its centre.
    const MARGIN: usize = 3;
    let planes: Vec<Plane> =
        NORMALS.iter().filter_map(|&normal| Plane::new([0.0; 3], normal, 0.0, 1.0).ok()).collect();
    let pick = |i: usize| {
        let plane = planes.get(i % planes.len().max(1))?;
        let center: [f64; 3] = std::array::from_fn(|c| {
            let room = voxels.size[c] - 2 * MARGIN;
            (MARGIN + random.below(room, [40, i as u64, c as u64])) as f64 + 0.5
        });
        let plane = Plane { center, ..*plane };
        Some(patch(|column, row| {
            let point = plane.point([EDGE as u32; 2], column as u32, row as u32);
            voxels.get(std::array::from_fn(|c| (point[c].max(0.0) as usize).min(voxels.size[c] - 1)))
        }))
    };
    (0..count).filter_map(pick).collect()
}

/// Random numbers by key.
#[derive(Clone, Copy)]
pub(super) struct Random(pub u64);

impl Random {
    /// A number below `n`, which must not be 0 (SplitMix64 over the key).
    pub fn below(self, n: usize, key: [u64; 3]) -> usize {
        let hash = key.iter().fold(self.0, |state, &k| {
            let mut h = (state ^ k).wrapping_add(0x9e37_79b9_7f4a_7c15);
            h = (h ^ h >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            h = (h ^ h >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
            h ^ h >> 31
        });
        ((u128::from(hash) * n as u128) >> 64) as usize
    }
}

#[cfg(test)]
mod tests;
