//! Usage weights: a static balance of how often each exemplar pixel is used, against collapse to a few of them.
//!
//! Chen & Wang 2010 count usage while they optimise; a lazy synthesis cannot, since a voxel must not depend on
//! all others. So usage is measured beforehand on small test volumes of other seeds, and pixels used too often
//! get a higher cost once and for all.

use std::sync::Arc;

use breccia_engine::{Data, Digest};

use super::color::Contrast;
use super::initial::Initial;
use super::pyramid::{LevelView, Pyramid};
use super::schedule::Settings;
use super::solid::{Counted, LazySolid};
use super::tables::{Tables, ViewTables};
use crate::control::{Cancelled, Control};
use crate::data::{Reader, VoxelSet, Writer};

/// Costs added to each exemplar pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Usage {
    /// For each level (finest first) and view, the weight of every pixel, in descriptor distance units, from 0.
    pub levels: Vec<Vec<Vec<i32>>>,
    /// For each level, how much contrast is restored where the three colours of a voxel become one, in 256ths.
    pub stretch: Vec<u32>,
}

/// How usage is balanced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UsageSettings {
    /// Test volumes synthesised one after the other; 0 leaves all weights at 0.
    pub rounds: usize,
    /// Voxels along an edge of a test volume.
    pub size: u32,
    /// How far a weight moves in a round, as a fraction of a third of the mean cost for each factor of two in use.
    pub rate: f64,
    /// The wanted contrast as a fraction of the exemplar's; 0 leaves it as it comes.
    pub contrast: f64,
}

impl Default for UsageSettings {
    fn default() -> Self {
        Self { rounds: 3, size: 64, rate: 0.3, contrast: 0.95 }
    }
}

/// Measures usage on test volumes and balances it.
///
/// After each round every weight moves by `rate · D · clamp(log2(use / mean use), −2, 3)`, with D a third of the
/// level's mean cost and use averaged over 5 × 5 pixels, and stays between 0 and 3 D. The contrast that is missing
/// is made up for by stretching the choice among the three colours of a voxel.
///
/// # Errors
/// [`Cancelled`].
pub fn balance_usage(
    pyramid: &Pyramid,
    tables: Tables,
    initial: &Initial,
    settings: &Settings,
    usage: &UsageSettings,
    control: &dyn Control,
) -> Result<Usage, Cancelled> {
    let mut tables = tables;
    let size = [usage.size; 3];
    for round in 0..usage.rounds {
        let settings =
            Settings { seed: settings.seed_of_round(round), period: Some(size), ..settings.clone() };
        // Every level is measured on its own field: the finest of a stack that starts at this level.
        let shared = Arc::new(tables);
        let solid = LazySolid::new(Arc::clone(&shared), initial.clone(), settings, Digest([0; 32]));
        let (mut moves, mut stretches) = (Vec::new(), Vec::new());
        for level in 0..pyramid.levels.len() {
            let n = usage.size.div_ceil(1 << level);
            let wanted = VoxelSet::from_box([0; 3], [n; 3]);
            let Counted { counts, contrast, cost } = solid.count_usage(level, &wanted, control)?;
            let ratio = contrast.deviation() / own_contrast(&pyramid.levels[level]).max(1e-9);
            let missing = if usage.contrast > 0.0 { usage.contrast - ratio } else { 0.0 };
            stretches.push(libm::round(STRETCH * missing) as i32);
            let unit = (cost / 3).max(1);
            moves.push(
                counts
                    .iter()
                    .zip(&pyramid.levels[level])
                    .map(|(counts, view)| step(counts, view, unit, usage.rate))
                    .collect::<Vec<_>>(),
            );
            control.progress(
                (round * pyramid.levels.len() + level + 1) as f32
                    / (usage.rounds * pyramid.levels.len()) as f32,
            );
        }
        drop(solid);
        tables = Arc::into_inner(shared).ok_or(Cancelled)?;
        for ((level, moves), stretch) in tables.levels.iter_mut().zip(&moves).zip(stretches) {
            level.stretch = level.stretch.saturating_add_signed(stretch).min(MOST_STRETCH);
            for (view, (moves, most)) in level.views.iter_mut().zip(moves) {
                for (record, m) in view.records.iter_mut().zip(moves) {
                    record.usage = (record.usage + m).clamp(0, *most);
                }
            }
        }
    }
    Ok(Usage {
        stretch: tables.levels.iter().map(|l| l.stretch).collect(),
        levels: tables.levels.iter().map(|l| l.views.iter().map(weights).collect()).collect(),
    })
}

/// 256ths of stretch in a round for all of the contrast. Measured, a tenth of stretch gains 0.07 of contrast at its
/// own level; steps are smaller, since coarser levels hand theirs on.
const STRETCH: f64 = 256.0 * 0.5;
const MOST_STRETCH: u32 = 128;

/// The mean contrast of some views.
fn own_contrast(views: &[LevelView]) -> f64 {
    let deviation = |view: &LevelView| {
        let mut contrast = Contrast::default();
        view.texels.iter().for_each(|&texel| contrast.add(texel));
        contrast.deviation()
    };
    views.iter().map(deviation).sum::<f64>() / views.len().max(1) as f64
}

fn weights(view: &ViewTables) -> Vec<i32> {
    view.records.iter().map(|record| record.usage).collect()
}

/// By how much the weights of one view move, and the largest weight allowed.
fn step(counts: &[u32], view: &LevelView, unit: i64, rate: f64) -> (Vec<i32>, i32) {
    let centres = view.centres();
    let total: u64 = centres.iter().map(|&p| u64::from(counts[view.index(p)])).sum();
    let expected = total as f64 / centres.len().max(1) as f64;
    let mut moves = vec![0; counts.len()];
    for &pixel in &centres {
        let (x, y) = (i32::from(pixel & 255), i32::from(pixel >> 8));
        let (mut sum, mut n) = (0u64, 0u64);
        let m = view.margin();
        for dy in -2..=2 {
            for dx in -2..=2 {
                let (u, v) = (x + dx, y + dy);
                let inside = u >= m && v >= m && u < view.width - m && v < view.height - m;
                if inside || view.tileable {
                    sum += u64::from(counts[view.index(view.pixel(u, v))]);
                    n += 1;
                }
            }
        }
        let ratio = sum as f64 / n as f64 / expected.max(1e-9);
        let doublings = libm::log2(ratio + 0.02).clamp(-2.0, 3.0);
        moves[view.index(pixel)] = libm::round(rate * unit as f64 * doublings) as i32;
    }
    (moves, (3 * unit).min(1 << 24) as i32)
}

impl Data for Usage {
    const TYPE: &'static str = "usage";
    const DOCS: &'static str = "A cost for each exemplar pixel that balances how often it is used.";

    fn byte_size(&self) -> u64 {
        self.levels.iter().flatten().map(|weights| weights.len() as u64 * 4).sum()
    }

    fn summary(&self) -> String {
        format!("{} levels", self.levels.len())
    }

    fn digest(&self) -> Digest {
        Digest::of(&self.encode().unwrap_or_default())
    }

    fn encode(&self) -> Option<Vec<u8>> {
        let mut out = Writer::new();
        out.u64(self.levels.len() as u64).u64(self.levels.first().map_or(0, Vec::len) as u64);
        self.levels.iter().flatten().for_each(|weights| {
            out.array(weights);
        });
        out.array(&self.stretch);
        Some(out.finish())
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = Reader::new(bytes);
        let (levels, views) = (reader.u64()?, reader.u64()?);
        let level =
            |reader: &mut Reader<'_>| (0..views).map(|_| reader.array()).collect::<Result<Vec<_>, _>>();
        let levels = (0..levels).map(|_| level(&mut reader)).collect::<Result<_, _>>()?;
        let stretch = reader.array()?;
        reader.end()?;
        Ok(Self { levels, stretch })
    }
}
