//! Removing, thinning out and scaling the particles of a packing (Du et al. 2013, section 4.2).

use std::sync::Arc;

use rayon::prelude::*;

use super::bits::Bits;
use super::factors::Factors;
use super::packing::{Packing, Placed, Shape};
use crate::lazy::random::{hash, unit};

/// Which particles stay, and how large.
#[derive(Clone, Debug)]
pub struct SelectSettings {
    /// The fraction that stays, drawn for each by its place.
    pub keep: f64,
    /// Particles of fewer voxels are removed.
    pub least: u64,
    /// Particles of more voxels are removed.
    pub most: u64,
    /// Numbers of particles that are removed.
    pub remove: Vec<u32>,
    /// How much those that stay are scaled around their centres. What is larger than before may overlap: then voxels belong to the
    /// first.
    pub scale: f64,
    /// Seed of the draw.
    pub seed: u64,
}

const KEEP: u32 = 121;

/// The packing with fewer or other particles; numbers count anew.
pub fn select(packing: &Packing, settings: &SelectSettings) -> Packing {
    let stays = |i: usize, placed: &Placed| {
        let volume = placed.shape.as_ref().map_or(packing.particle(placed).volume.into(), |s| s.bits.count());
        unit(hash(settings.seed, KEEP, placed.center)) < settings.keep
            && (settings.least..=settings.most).contains(&volume)
            && !settings.remove.contains(&Packing::id(i))
    };
    let placed: Vec<Placed> = packing
        .placed
        .par_iter()
        .enumerate()
        .filter(|(i, placed)| stays(*i, placed))
        .map(
            |(_, placed)| {
                if settings.scale == 1.0 { placed.clone() } else { scaled(packing, placed, settings.scale) }
            },
        )
        .collect();
    Packing { placed, set: Arc::clone(&packing.set), size: packing.size, wrap: packing.wrap }
}

/// A placed particle scaled around its centre.
fn scaled(packing: &Packing, placed: &Placed, scale: f64) -> Placed {
    let (low, size) = packing.bounds(placed);
    let high: [i32; 3] = std::array::from_fn(|a| low[a] + size[a] as i32);
    let reach = |c: i32| libm::ceil(f64::from(c.abs()) * scale) as i32 + 1;
    let from = low.map(|c| -reach(c));
    let edges = std::array::from_fn(|a| (reach(high[a]) - from[a] + 1) as u32);
    let bits = Bits::from_fn(from, edges, |v| {
        packing.holds(placed, v.map(|c| libm::round(f64::from(c) / scale) as i32))
    });
    let factors = match &placed.shape {
        Some(shape) => shape.factors.times(scale),
        None => Factors::uniform(scale),
    };
    Placed { shape: Some(Arc::new(Shape { bits, factors })), ..placed.clone() }
}
