//! Measures of a volume against its exemplar, to be read together.

use super::color_divergence;
use super::contrast::Variation;
use super::copies::{Places, mean_copy};
use super::curves::{LikenessCurves, histogram};
use super::cuts::{Cuts, oblique_edge, turned_squares};
use super::likeness::{Likeness, Quality};
use super::matches::Matches;
use super::nearest::{Found, Sampler};
use super::random::Random;
use super::structure::{Structure, axis_structure, mean_structure, oblique_structure};
use super::views::{Pixels, Voxels};
use super::wasserstein::{Vector, areas, levels, pyramids, scales, sliced, vectors};
use crate::control::{Cancelled, Control, check};
use crate::data::{Image, Samples, Volume};

/// How much is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QualitySettings {
    /// Patches taken across the axes, and as many again from oblique planes.
    pub samples: usize,
    /// Slices across each axis, and three times as many oblique cuts.
    pub slices: usize,
    /// Selects patches and slices.
    pub seed: u64,
}

impl Default for QualitySettings {
    fn default() -> Self {
        Self { samples: 2048, slices: 8, seed: 1 }
    }
}

/// Why nothing was measured.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeasureError {
    /// The exemplar is too small to be split into halves.
    #[error("an exemplar of {0} × {1} pixels is too small: measuring needs at least {SMALLEST} × {SMALLEST}")]
    Exemplar(usize, usize),
    /// The exemplar has nothing to compare with.
    #[error(
        "all pixels of the exemplar have the colour ({0}, {1}, {2}): there is no texture to compare with"
    )]
    Constant(u8, u8, u8),
    /// The volume is too small for slices and patches.
    #[error(
        "a box of {0} × {1} × {2} voxels is too small: measuring needs at least {SMALLEST} along each axis"
    )]
    Volume(usize, usize, usize),
    /// The volume has no colours.
    #[error("the volume has no map `color` (or `value`, if it is grey) that fits its size, only {0}")]
    NoColor(String),
    /// A sample is no number.
    #[error("{0} holds a sample that is not finite")]
    NotFinite(&'static str),
    /// The computation was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<MeasureError> for breccia_engine::NodeError {
    fn from(error: MeasureError) -> Self {
        match error {
            MeasureError::Cancelled(cancelled) => cancelled.into(),
            other => Self::input(other),
        }
    }
}

/// The smallest exemplar, so that each quadrant holds some patches, and the shortest edge of a box.
const SMALLEST: usize = 16;

/// The largest square that is looked for in copies.
const LONGEST_COPY: usize = 32;

/// Turned squares of an exemplar that oblique cuts are held to.
const TURNS: usize = 32;

/// Added to both sides of ratios of Wasserstein distances, which are in standard deviations.
const WASSERSTEIN_FLOOR: f64 = 0.02;

/// Measures a volume against its exemplar. See [`measure_views`].
///
/// # Errors
/// As [`measure_views`].
pub fn measure_quality(
    volume: &Volume,
    exemplar: &Image,
    settings: &QualitySettings,
    control: &dyn Control,
) -> Result<Quality, MeasureError> {
    measure_views(volume, &[exemplar], settings, control)
}

/// Measures a volume against the exemplars of its slices across x, y and z, or one exemplar for all. Oblique cuts are held to
/// the nearest of the exemplars, and to the mean of their curves.
///
/// # Errors
/// [`MeasureError`]: too small an exemplar (16 pixels) or volume (16 voxels), an exemplar of one colour, no colours, samples
/// that are not finite, or cancelled.
pub fn measure_views(
    volume: &Volume,
    exemplars: &[&Image],
    settings: &QualitySettings,
    control: &dyn Control,
) -> Result<Quality, MeasureError> {
    let views = read_views(exemplars)?;
    let voxels = read_voxels(volume)?;
    let random = Random(settings.seed);
    let samples = settings.samples.clamp(64, 1 << 20);
    let cuts = Cuts::new(&voxels, settings.slices.clamp(1, 4096), random, control)?;
    let scene = Scene { views: &views, voxels: &voxels, cuts: &cuts, samples, random, control };
    let mut quality = Quality::default();

    scene.colors(&mut quality);
    scene.variation(&mut quality);
    control.progress(0.05);
    let [axis, oblique] = scene.structure()?;
    fill_structure(&mut quality, &axis, &oblique);
    control.progress(0.2);
    scene.wasserstein(&mut quality)?;
    control.progress(0.3);
    scene.copies(&mut quality)?;
    control.progress(0.4);
    scene.patches(&mut quality)?;
    quality.curves = LikenessCurves {
        luminance: [histogram(cuts.axis.iter().flatten()), histogram(&cuts.oblique), histogram(&views)],
        autocorrelation: [axis.radial[0].clone(), oblique.radial[0].clone(), axis.radial[1].clone()],
        orientation: axis.shares,
    };
    Ok(quality)
}

fn read_views(exemplars: &[&Image]) -> Result<Vec<Pixels>, MeasureError> {
    let mut views = Vec::new();
    for exemplar in exemplars {
        let (width, height) = (exemplar.width() as usize, exemplar.height() as usize);
        if width < SMALLEST || height < SMALLEST {
            return Err(MeasureError::Exemplar(width, height));
        }
        if not_finite(exemplar.samples()) {
            return Err(MeasureError::NotFinite("the exemplar"));
        }
        let view = Pixels::of(exemplar);
        let [r, g, b] = view.get(0, 0);
        if view.data.iter().all(|&pixel| pixel == [r, g, b]) {
            return Err(MeasureError::Constant(r, g, b));
        }
        views.push(view);
    }
    if views.is_empty() { Err(MeasureError::Exemplar(0, 0)) } else { Ok(views) }
}

pub(super) fn read_voxels(volume: &Volume) -> Result<Voxels, MeasureError> {
    let [x, y, z] = volume.size;
    if volume.size.iter().any(|&n| n < SMALLEST) {
        return Err(MeasureError::Volume(x, y, z));
    }
    // A grey volume has its levels in `value`.
    let color = volume.map("color").or_else(|| volume.map("value").filter(|map| map.channels == 1));
    let voxels = color.and_then(|color| Voxels::of(volume, color));
    if color.is_some_and(|color| not_finite(&color.samples)) {
        return Err(MeasureError::NotFinite("the map `color`"));
    }
    voxels.ok_or_else(|| {
        let names: Vec<_> = volume.maps.iter().map(|map| format!("`{}`", map.name)).collect();
        MeasureError::NoColor(if names.is_empty() { "nothing".to_owned() } else { names.join(", ") })
    })
}

pub(super) fn not_finite(samples: &Samples) -> bool {
    matches!(samples, Samples::F32(values) if values.iter().any(|v| !v.is_finite()))
}

/// The larger of a ratio and its reciprocal.
fn away_from_one(ratio: f64) -> f64 {
    ratio.max(1.0 / ratio.max(1e-9))
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
    sum / f64::max(count, 1.0)
}

fn fill_structure(quality: &mut Quality, axis: &Structure, oblique: &Structure) {
    let fill = |of: &Structure, found: &mut Likeness, own: &mut Likeness| {
        found.autocorrelation = of.autocorrelation;
        [found.repetition, own.repetition] = of.repetition;
        [found.orientation_kl, own.orientation_kl] = of.orientation_kl;
        found.flat = of.flat;
        (own.autocorrelation, own.flat) = (1.0, 1.0);
    };
    fill(axis, &mut quality.axis, &mut quality.axis_own);
    fill(oblique, &mut quality.oblique, &mut quality.oblique_own);
}

/// What is compared, and how.
struct Scene<'a> {
    views: &'a [Pixels],
    voxels: &'a Voxels,
    cuts: &'a Cuts,
    samples: usize,
    random: Random,
    control: &'a dyn Control,
}

impl Scene<'_> {
    /// The exemplar of slices across an axis.
    fn view(&self, axis: usize) -> &Pixels {
        &self.views[axis.min(self.views.len() - 1)]
    }

    /// The shortest edge of box and exemplars.
    fn shortest(&self) -> usize {
        let edges = self.views.iter().flat_map(|view| [view.width, view.height]);
        edges.chain(self.voxels.size).min().unwrap_or(0)
    }

    /// The edge of the part of oblique cuts that fits into all exemplars.
    fn oblique_edge(&self) -> usize {
        oblique_edge(self.voxels.size.into_iter().min().unwrap_or(0)).min(self.shortest())
    }

    fn colors(&self, quality: &mut Quality) {
        let pixels = |pictures: &[Pixels]| pictures.iter().flat_map(|p| &p.data).copied().collect::<Vec<_>>();
        let own = mean(self.views.iter().map(|view| {
            mean(view.splits().into_iter().map(|split| {
                let [a, b] = split.map(|half| pixels(&half));
                (color_divergence(&a, &b) + color_divergence(&b, &a)) / 2.0
            }))
        }));
        // All slices across an axis together are all voxels.
        let axis = |view: &Pixels| color_divergence(&view.data, &self.voxels.data);
        quality.axis.color_kl = mean(self.views.iter().map(axis));
        quality.oblique.color_kl = color_divergence(&pixels(self.views), &pixels(&self.cuts.oblique));
        (quality.axis_own.color_kl, quality.oblique_own.color_kl) = (own, own);
    }

    fn variation(&self, quality: &mut Quality) {
        let fill = |to: &mut Likeness, [contrast, fine, sharpness]: [f64; 3]| {
            (to.contrast, to.fine_contrast, to.sharpness) = (contrast, fine, sharpness);
        };
        let average = |ratios: &[[f64; 3]]| [0, 1, 2].map(|i| mean(ratios.iter().map(|r| r[i])));
        let axis =
            |axis: usize| Variation::of(&self.cuts.axis[axis]).ratios(&Variation::of([self.view(axis)]));
        let own = |split: [[Pixels; 2]; 2]| {
            let [a, b] = split.map(|half| Variation::of(&half));
            a.ratios(&b).map(away_from_one)
        };
        let own = average(&self.views.iter().flat_map(Pixels::splits).map(own).collect::<Vec<_>>());
        fill(&mut quality.axis, average(&[0, 1, 2].map(axis)));
        // Nearest voxels of turned cuts are sharper at edges and less sharp within: so is the exemplar when turned.
        let turned = self.views.iter().enumerate().flat_map(|(i, view)| {
            let whole = [0, 0, view.width, view.height];
            let edge = oblique_edge(view.width.min(view.height));
            turned_squares(view, &[whole], edge, TURNS, (self.random, 10 + i as u64))
        });
        let turned = Variation::of(&turned.collect::<Vec<_>>());
        fill(&mut quality.oblique, Variation::of(&self.cuts.oblique).ratios(&turned));
        fill(&mut quality.axis_own, own);
        fill(&mut quality.oblique_own, own);
    }

    fn structure(&self) -> Result<[Structure; 2], Cancelled> {
        let shortest = self.shortest();
        let across =
            |axis: usize| axis_structure(&self.cuts.axis[axis], self.view(axis), shortest, self.control);
        let axis = [across(0)?, across(1)?, across(2)?];
        let edge = self.oblique_edge();
        let against = |view| oblique_structure(&self.cuts.oblique, view, edge, self.control);
        let oblique = self.views.iter().map(against).collect::<Result<Vec<_>, Cancelled>>()?;
        Ok([mean_structure(&axis), mean_structure(&oblique)])
    }

    fn wasserstein(&self, quality: &mut Quality) -> Result<(), Cancelled> {
        let count = levels(self.oblique_edge().min(self.shortest() / 2));
        let truth = pyramids(self.views, count);
        let axis = [0, 1, 2].map(|a| pyramids(&self.cuts.axis[a], count));
        let oblique = pyramids(&self.cuts.oblique, count);
        check(self.control)?;
        let samples = self.samples.min(4096);
        // Sums over levels: across the axes, oblique, and between the halves.
        let mut sums = [0.0; 3];
        for level in 0..count {
            let scales = scales(truth.iter().map(|pyramid| &pyramid[level]));
            let draw = |areas: &_, transposed, key: u64| -> Vec<Vector> {
                vectors(areas, &scales, transposed, samples, (self.random, key + 16 * level as u64))
            };
            let distance = |a: &[Vector], b: &[Vector]| sliced(a, b, self.random);
            for (a, pyramids) in axis.iter().enumerate() {
                check(self.control)?;
                let view = truth.get(a).map_or(&truth[..1], std::slice::from_ref);
                let expected = draw(&areas::whole(view, level), false, 0);
                let found = [false, true].map(|t| draw(&areas::whole(pyramids, level), t, 1 + a as u64));
                let [plain, turned] = found.map(|found| distance(&found, &expected));
                sums[0] += plain.min(turned) / 3.0;
            }
            check(self.control)?;
            let expected = draw(&areas::whole(&truth, level), false, 0);
            sums[1] += distance(&draw(&areas::whole(&oblique, level), false, 4), &expected);
            let own = truth.iter().flat_map(|pyramid| areas::splits(&pyramid[level]));
            let own = own.map(|[a, b]| distance(&draw(&a, false, 5), &draw(&b, false, 6)));
            sums[2] += mean(own);
        }
        let [axis, oblique, own] = sums.map(|sum| sum / count as f64 + WASSERSTEIN_FLOOR);
        (quality.axis.wasserstein, quality.oblique.wasserstein) = (axis / own, oblique / own);
        (quality.axis_own.wasserstein, quality.oblique_own.wasserstein) = (1.0, 1.0);
        Ok(())
    }

    fn copies(&self, quality: &mut Quality) -> Result<(), Cancelled> {
        let samples = (self.samples / 4).max(64);
        let limits = [self.shortest(), self.oblique_edge()].map(|edge| (edge / 4).clamp(4, LONGEST_COPY));
        let copy = |pictures: &[Pixels], places: &Places<'_>, limit: usize, key: u64| {
            mean_copy(pictures, places, limit, samples, (self.random, key), self.control)
        };
        for axis in 0..3 {
            let view = self.views.get(axis).map_or(&self.views[..1], std::slice::from_ref);
            let found = copy(&self.cuts.axis[axis], &Places::of(view), limits[0], axis as u64)?;
            quality.axis.copy = quality.axis.copy.max(found);
        }
        quality.oblique.copy = copy(&self.cuts.oblique, &Places::of(self.views), limits[1], 3)?;
        for view in self.views {
            let [[a, b], ..] = view.splits();
            for (limit, own) in
                limits.into_iter().zip([&mut quality.axis_own.copy, &mut quality.oblique_own.copy])
            {
                let both = copy(&a, &Places::of(&b), limit, 4)? + copy(&b, &Places::of(&a), limit, 5)?;
                *own = own.max(both / 2.0);
            }
        }
        quality.copy_limits = limits;
        Ok(())
    }

    fn patches(&self, quality: &mut Quality) -> Result<(), Cancelled> {
        let sampler = Sampler::new(self.views, self.voxels, self.samples, self.random, self.control)?;
        let mut all = Found::default();
        for axis in 0..3 {
            let found = sampler.axis(axis)?;
            quality.distances[axis] = found.distance(sampler.own_of(axis));
            quality.completeness[axis] = found.completeness(sampler.own_of(axis));
            all.add(&found);
            self.control.progress(0.6 + 0.1 * axis as f32);
        }
        let fill = |to: &mut Likeness, found: &Found, own: &Matches| {
            to.distance = found.distance(own);
            to.completeness = found.completeness(sampler.own());
            [to.coverage, to.source_entropy] = sampler.sources(found, own);
        };
        fill(&mut quality.axis, &all, sampler.own());
        fill(&mut quality.oblique, &sampler.oblique()?, sampler.own_turned());
        for to in [&mut quality.axis_own, &mut quality.oblique_own] {
            (to.distance, to.completeness) = (sampler.worst, sampler.worst);
            (to.coverage, to.source_entropy) = (1.0, 1.0);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
