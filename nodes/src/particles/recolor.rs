//! Particles and matrix in the colours of other solids (Du et al. 2013, section 4.2, Fig. 15).

use std::sync::Arc;

use breccia_engine::{Data, Digest};
use rayon::prelude::*;

use super::index::Index;
use super::packing::Packing;
use super::particle::{NOTHING, Particle};
use crate::control::{Cancelled, Control, check};
use crate::data::{
    BRICK_VOXELS, Extent, MapInfo, Samples, Solid, SolidError, VoxelMap, VoxelSet, indices, voxel_at,
};
use crate::exemplar::luminance;

/// How colours are taken over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecolorSettings {
    /// Whether a particle takes the one colour at its centre; else every voxel its own.
    pub whole: bool,
    /// How much of the new colour shows, 0 to 1.
    pub strength: f64,
    /// How much of a particle's own light and dark stays on the new colour, 0 to 1.
    pub detail: f64,
}

/// A solid whose colours come from others, particles and matrix apart.
pub struct RecolorSolid {
    packing: Arc<Packing>,
    index: Index,
    base: Arc<dyn Solid>,
    particles: Option<Arc<dyn Solid>>,
    matrix: Option<Arc<dyn Solid>>,
    settings: RecolorSettings,
    /// For each placed particle, the colour at its centre.
    centers: Vec<[u8; 3]>,
    /// For each particle of the set, its mean luminance.
    means: Vec<f64>,
    digest: Digest,
}

impl RecolorSolid {
    /// `base` in the colours of `particles` where particles are, and of `matrix` elsewhere.
    ///
    /// # Errors
    /// As [`Solid::evaluate`], of the colours at the centres.
    pub fn new(
        packing: Arc<Packing>,
        base: Arc<dyn Solid>,
        particles: Option<Arc<dyn Solid>>,
        matrix: Option<Arc<dyn Solid>>,
        settings: RecolorSettings,
        control: &dyn Control,
    ) -> Result<Self, SolidError> {
        let centers = match &particles {
            Some(solid) if settings.whole => {
                let set: VoxelSet = packing.placed.iter().map(|p| p.center).collect();
                let found = solid.evaluate(&set, control)?;
                packing.placed.iter().map(|p| color_at(&found, p.center)).collect()
            }
            _ => vec![[0; 3]; packing.placed.len()],
        };
        let set = &packing.set;
        let mean = |p: &Particle| {
            let shown = p.source.iter().filter(|&&s| s != NOTHING);
            shown.clone().map(|&s| f64::from(luminance(set.color(s)))).sum::<f64>()
                / shown.count().max(1) as f64
        };
        let means = set.particles.par_iter().map(mean).collect();
        let mut hasher = blake3::Hasher::new();
        hasher.update(b"recolor").update(&packing.digest().0).update(&base.digest().0);
        for solid in [&particles, &matrix] {
            hasher.update(&solid.as_ref().map_or([0; 32], |solid| solid.digest().0));
        }
        hasher.update(format!("{settings:?}").as_bytes());
        let (index, digest) = (Index::new(&packing), hasher.finalize().into());
        Ok(Self { packing, index, base, particles, matrix, settings, centers, means, digest })
    }
}

/// The colour of a voxel of an answer.
fn color_at(answer: &VoxelMap, voxel: [i32; 3]) -> [u8; 3] {
    match (answer.index(voxel), answer.maps.first()) {
        (Some(at), Some(map)) => {
            std::array::from_fn(|c| map.samples.get_u8(at * map.channels + c.min(map.channels - 1)))
        }
        _ => [0; 3],
    }
}

impl Solid for RecolorSolid {
    fn maps(&self) -> Vec<MapInfo> {
        self.base.maps()
    }

    fn extent(&self) -> Extent {
        let all = [Some(&self.base), self.particles.as_ref(), self.matrix.as_ref()];
        let mut extents = all.into_iter().flatten().map(|solid| solid.extent());
        let first = extents.next().unwrap_or(Extent::Unbounded);
        let same = extents.all(|extent| extent == first);
        if same || matches!(first, Extent::Bounded(..)) { first } else { Extent::Unbounded }
    }

    fn evaluate(&self, voxels: &VoxelSet, control: &dyn Control) -> Result<VoxelMap, SolidError> {
        let mut answer = self.base.evaluate(voxels, control)?;
        let bricks = voxels.bricks();
        let labels: Vec<Vec<(u32, [i32; 3])>> = bricks
            .par_iter()
            .map(|&brick| {
                check(control)?;
                Ok(self.index.label_brick(&self.packing, brick))
            })
            .collect::<Result<_, Cancelled>>()?;
        // Each solid is asked only where its colours are wanted.
        let wanted = |of_particles: bool| {
            let mut set = VoxelSet::new();
            for (&brick, labels) in bricks.iter().zip(&labels) {
                let mut mask = [0u64; 8];
                for (at, (label, _)) in labels.iter().enumerate() {
                    mask[at >> 6] |= u64::from((*label != 0) == of_particles) << (at & 63);
                }
                let asked = voxels.mask(brick).copied().unwrap_or_default();
                set.insert_mask(brick, &std::array::from_fn(|z| mask[z] & asked[z]));
            }
            set
        };
        let in_particles = match &self.particles {
            Some(solid) if !self.settings.whole => Some(solid.evaluate(&wanted(true), control)?),
            _ => None,
        };
        let in_matrix = match &self.matrix {
            Some(solid) => Some(solid.evaluate(&wanted(false), control)?),
            None => None,
        };
        let slots: Vec<Option<usize>> = bricks.iter().map(|&brick| answer.slot(brick)).collect();
        let Some(map) = answer.maps.first_mut() else { return Ok(answer) };
        let (n, Samples::U8(samples)) = (map.channels, &mut map.samples) else { return Ok(answer) };
        let RecolorSettings { strength, detail, .. } = self.settings;
        for ((&brick, labels), slot) in bricks.iter().zip(&labels).zip(slots) {
            let Some(slot) = slot else { continue };
            let asked = voxels.mask(brick).copied().unwrap_or_default();
            for at in indices(&asked) {
                let (label, _) = labels[at];
                let voxel = voxel_at(brick, at);
                let place = (slot * BRICK_VOXELS + at) * n;
                let Some(old) = samples.get(place..place + 3).map(|c| [c[0], c[1], c[2]]) else { continue };
                let (new, shade) = if label == 0 {
                    let Some(found) = &in_matrix else { continue };
                    (color_at(found, voxel), 0.0)
                } else {
                    let index = label as usize - 1;
                    let new = match (&in_particles, &self.particles) {
                        (Some(found), _) => color_at(found, voxel),
                        (None, Some(_)) => self.centers[index],
                        (None, None) => continue,
                    };
                    let mean = self.means[self.packing.placed[index].particle as usize];
                    (new, detail * (f64::from(luminance(old)) - mean))
                };
                for c in 0..3 {
                    let shaded = f64::from(new[c]) + shade;
                    let mixed = f64::from(old[c]) * (1.0 - strength) + shaded * strength;
                    samples[place + c] = (mixed + 0.5).clamp(0.0, 255.0) as u8;
                }
            }
        }
        Ok(answer)
    }

    fn digest(&self) -> Digest {
        self.digest
    }

    fn summary(&self) -> String {
        format!("{}, recoloured", self.base.summary())
    }

    fn byte_size(&self) -> u64 {
        self.base.byte_size() + self.index.byte_size() + 11 * self.centers.len() as u64
    }
}
