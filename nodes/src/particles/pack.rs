//! Packing particles by the neighbourhoods of their cross-sections (Du et al. 2013, section 3.2, Algorithm 1).

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::Arc;

use super::axes::AXES;
use super::bits::{Bits, Occupancy};
use super::neighbours::{Neighbours, center_offset};
use super::packing::{Packing, Placed};
use super::particle::{Particle, ParticleSet};
use super::quota::Quota;
use crate::control::{Cancelled, Control, check};
use crate::lazy::random::{hash, unit};

/// In which order candidates are tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Those nearest to the middle of the domain first.
    Isotropic,
    /// Those that continue a layer across this axis first, then those that begin a new one.
    Layered(usize),
}

/// Which of the particles of a cross-section are tried first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// Any, drawn for each place.
    Random,
    /// The largest.
    Large,
}

/// How particles are packed.
#[derive(Clone, Debug)]
pub struct PackSettings {
    /// Edges of the domain along x, y and z in voxels.
    pub size: [u32; 3],
    /// Whether what leaves the domain comes in again on the other side; else the domain cuts it.
    pub wrap: bool,
    /// The order of candidates.
    pub order: Order,
    /// The fraction of a particle that others may already have taken.
    pub tolerance: f64,
    /// Voxels that must stay free around a particle.
    pub gap: f64,
    /// Particles to start from: the first in the middle, others at random.
    pub starts: usize,
    /// Particles of a cross-section that are tried in one place.
    pub tries: usize,
    /// Which are tried first.
    pub choice: Choice,
    /// By what fraction a class of size may exceed its share of the particles, which cross-sections tell; infinity for no shares.
    pub slack: f64,
    /// Seed of every random choice.
    pub seed: u64,
}

impl Default for PackSettings {
    fn default() -> Self {
        Self {
            size: [128; 3],
            wrap: true,
            order: Order::Isotropic,
            tolerance: 0.05,
            gap: 0.0,
            starts: 1,
            tries: 8,
            choice: Choice::Large,
            slack: 0.1,
            seed: 1,
        }
    }
}

/// Why there is no packing.
#[derive(Clone, Debug, thiserror::Error)]
pub enum PackError {
    /// The computation was cancelled.
    #[error("cancelled")]
    Cancelled,
    /// No particle is small enough.
    #[error(
        "the smallest particle has {0} × {1} × {2} voxels and does not fit into a domain of {3} × {4} × {5}; \
         expected a larger domain or smaller particles"
    )]
    TooSmall(u32, u32, u32, u32, u32, u32),
    /// There is nothing to place.
    #[error("there are no particles to place")]
    Empty,
    /// The region has no room.
    #[error("no particle may be placed: the region is black wherever a start was tried ({0} places)")]
    NoRoom(usize),
}

impl From<Cancelled> for PackError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

const START: u32 = 111;
const PLACE: u32 = 112;
const CHOOSE: u32 = 113;
const DENSITY: u32 = 114;
const THIN: u32 = 115;

/// A cross-section near a placed particle's, where a particle may go.
type Candidate = (u8, u64, u32, u8, u8, u32);

/// Packs a domain: particles are placed next to those that are there, where the pictures show neighbours, until none fits any
/// more. `region` gives for a voxel of the domain the probability (0 to 255) that a particle whose centre lies there is placed.
///
/// # Errors
/// [`PackError`].
pub fn pack(
    set: &Arc<ParticleSet>,
    neighbours: &Neighbours,
    region: Option<&(dyn Fn([i32; 3]) -> u8 + Sync)>,
    settings: &PackSettings,
    control: &dyn Control,
) -> Result<Packing, PackError> {
    let (size, wrap) = (settings.size, settings.wrap);
    let smallest = set.particles.iter().min_by_key(|p| p.size.iter().map(|&n| u64::from(n)).product::<u64>());
    let smallest = smallest.ok_or(PackError::Empty)?;
    if wrap && !set.particles.iter().any(|p| (0..3).all(|a| p.size[a] <= size[a])) {
        let [a, b, c] = smallest.size;
        return Err(PackError::TooSmall(a, b, c, size[0], size[1], size[2]));
    }
    let bare: Vec<Bits> = set.particles.iter().map(Particle::bits).collect();
    let mut packer = Packer {
        settings,
        set,
        neighbours,
        region,
        shapes: bare.iter().map(|bits| bits.grown(settings.gap)).collect(),
        bare,
        taken: Occupancy::new(size, wrap),
        exact: Vec::new(),
        placed: Vec::new(),
        queue: BinaryHeap::new(),
        waiting: Vec::new(),
        quota: Quota::new(set, size.iter().map(|&n| f64::from(n)).product(), settings.slack),
        next: 0,
    };
    let middle = size.map(|n| f64::from(n / 2));
    let mut tried = 0;
    for start in 0..settings.starts.max(1) as i32 {
        // The first goes into the middle if the region lets it; places for the others are drawn.
        for attempt in 0..64 {
            let draw = |purpose: u32, k: i32| unit(hash(settings.seed, purpose, [start, attempt, k]));
            let particle = (draw(START, 0) * set.particles.len() as f64) as u32;
            let place = if start == 0 && attempt == 0 {
                middle
            } else {
                std::array::from_fn(|a| libm::floor(draw(PLACE, a as i32) * f64::from(size[a])))
            };
            tried += 1;
            if packer.try_place(particle, place) {
                break;
            }
        }
    }
    if packer.placed.is_empty() {
        return Err(PackError::NoRoom(tried));
    }
    packer.run(control)?;
    // Where particles lie far apart in the pictures, next to each other there is room for more than there should be: the surplus goes
    // evenly, wherever it is.
    let lots: Vec<(u32, u32)> =
        packer.placed.iter().map(|p| (p.particle, hash(settings.seed, THIN, p.center))).collect();
    let mut stays = packer.quota.stays(&lots).into_iter();
    packer.placed.retain(|_| stays.next().unwrap_or(true));
    Ok(Packing { set: Arc::clone(set), size, wrap, placed: packer.placed })
}

/// What became of a candidate.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Outcome {
    Placed,
    /// Nothing fits.
    Never,
    /// Something might fit that has had its share.
    Wait,
}

struct Packer<'a> {
    settings: &'a PackSettings,
    set: &'a Arc<ParticleSet>,
    neighbours: &'a Neighbours,
    region: Option<&'a (dyn Fn([i32; 3]) -> u8 + Sync)>,
    /// The particles with the gap around them, and without.
    shapes: Vec<Bits>,
    bare: Vec<Bits>,
    taken: Occupancy,
    /// The centres of placed particles before rounding.
    exact: Vec<[f64; 3]>,
    placed: Vec<Placed>,
    queue: BinaryHeap<Reverse<Candidate>>,
    /// Candidates whose particles have had their share.
    waiting: Vec<Reverse<Candidate>>,
    quota: Quota,
    next: u32,
}

impl Packer<'_> {
    /// Tries candidates until none is left.
    fn run(&mut self, control: &dyn Control) -> Result<(), Cancelled> {
        let domain: f64 = self.settings.size.iter().map(|&n| f64::from(n)).product();
        let mut filled = 0.0;
        let mut counted = 0;
        let mut pops = 0u64;
        let mut last = usize::MAX;
        loop {
            let Some(Reverse(candidate)) = self.queue.pop() else {
                // What had to wait is tried again as long as that helps.
                if self.waiting.is_empty() || last == self.placed.len() {
                    break;
                }
                last = self.placed.len();
                self.queue.extend(self.waiting.drain(..));
                continue;
            };
            let (_, _, sequence, view, near, parent) = candidate;
            pops += 1;
            if pops.is_multiple_of(512) {
                check(control)?;
                for one in &self.placed[counted..] {
                    filled += f64::from(self.set.particles[one.particle as usize].volume);
                }
                counted = self.placed.len();
                control.progress((filled / domain / self.set.fraction().max(0.05)).min(0.99) as f32);
            }
            if self.try_candidate(sequence, view.into(), near.into(), parent) == Outcome::Wait {
                self.waiting.push(Reverse(candidate));
            }
        }
        Ok(())
    }

    /// Tries the particles of a candidate's cross-section, in an order drawn for it, until one fits.
    fn try_candidate(&mut self, sequence: u32, view: usize, near: usize, parent: u32) -> Outcome {
        let from = self.placed[parent as usize].particle;
        let section = self.set.particles[from as usize].sections[view] as usize;
        let near = self.neighbours.near[view][section][near];
        let made = &self.neighbours.made[view][near.section as usize];
        let count = made.len();
        let mut outcome = Outcome::Never;
        if count == 0 {
            return outcome;
        }
        let first = match self.settings.choice {
            Choice::Random => hash(self.settings.seed, CHOOSE, [sequence as i32, 0, 0]) as usize % count,
            Choice::Large => 0,
        };
        for k in 0..count.min(self.settings.tries) {
            let other = made[(first + k) % count];
            if !self.quota.wants(other) {
                outcome = Outcome::Wait;
                continue;
            }
            let offset = center_offset(self.set, view, from, other, &near);
            let start = self.exact[parent as usize];
            if self.try_place(other, std::array::from_fn(|a| start[a] + f64::from(offset[a]))) {
                return Outcome::Placed;
            }
        }
        outcome
    }

    /// Places a particle if it fits; then its neighbours become candidates.
    fn try_place(&mut self, particle: u32, place: [f64; 3]) -> bool {
        let settings = self.settings;
        let size = settings.size.map(f64::from);
        let place: [f64; 3] = std::array::from_fn(|a| {
            if settings.wrap { place[a] - size[a] * libm::floor(place[a] / size[a]) } else { place[a] }
        });
        if (0..3).any(|a| !(0.0..size[a]).contains(&place[a])) {
            return false;
        }
        let center: [i32; 3] =
            std::array::from_fn(|a| (libm::round(place[a]) as i32).min(settings.size[a] as i32 - 1));
        let volume = self.set.particles[particle as usize].volume;
        let most = (settings.tolerance * f64::from(volume)) as u64;
        // A particle that covers another's centre is no neighbour of it, however much overlap is allowed.
        if self.taken.holds(center) {
            return false;
        }
        let edges = self.set.particles[particle as usize].size;
        if settings.wrap && (0..3).any(|a| edges[a] > settings.size[a]) {
            return false;
        }
        if !self.taken.fits(&self.shapes[particle as usize], center, most) {
            return false;
        }
        if let Some(region) = self.region {
            let chance = f64::from(region(center)) / 255.0;
            if unit(hash(settings.seed, DENSITY, center)) >= chance {
                return false;
            }
        }
        self.quota.count(particle);
        self.taken.take(&self.bare[particle as usize], center);
        let index = self.placed.len() as u32;
        self.placed.push(Placed { particle, center, shape: None });
        self.exact.push(place);
        for view in 0..3 {
            let section = self.set.particles[particle as usize].sections[view] as usize;
            for (k, near) in self.neighbours.near[view][section].iter().enumerate() {
                let (priority, key) = self.key(view, place, near.offset);
                self.queue.push(Reverse((priority, key, self.next, view as u8, k as u8, index)));
                self.next = self.next.wrapping_add(1);
            }
        }
        true
    }

    /// Where a candidate comes in the order: smaller first.
    fn key(&self, view: usize, place: [f64; 3], offset: [f32; 2]) -> (u8, u64) {
        let size = self.settings.size.map(f64::from);
        let mut at = place;
        (0..2).for_each(|i| at[AXES[view][i]] += f64::from(offset[i]));
        let from_middle = |a: usize| {
            let d = at[a] - libm::floor(size[a] / 2.0);
            if self.settings.wrap { d - size[a] * libm::round(d / size[a]) } else { d }
        };
        let squared = |axes: &[usize]| {
            // Sixteenths of a voxel, squared: whole numbers have one order on every machine.
            axes.iter()
                .map(|&a| libm::round(from_middle(a) * 16.0) as i64)
                .map(|d| (d * d) as u64)
                .sum::<u64>()
        };
        match self.settings.order {
            Order::Isotropic => (0, squared(&[0, 1, 2])),
            Order::Layered(axis) if axis == view => (0, squared(&AXES[view])),
            Order::Layered(_) => (1, squared(&[0, 1, 2])),
        }
    }
}
