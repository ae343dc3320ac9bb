//! Nearest neighbourhoods both ways: from slices to the exemplar, and from the exemplar to slices.

use super::cuts::{oblique_plane, turned_squares};
use super::matches::{Matches, draw, halves};
use super::patches::{EDGE, Patch, PatchSet, patch};
use super::random::Random;
use super::views::{PAIRS, Pixels, Voxels, in_plane};
use crate::control::{Cancelled, Control};

/// A grey level's fraction added to both sides of ratios, so that exemplars without detail divide too.
const FLOOR: f64 = 0.25;

/// Matches of slices in the exemplar, and of the exemplar in slices.
#[derive(Default)]
pub(super) struct Found {
    there: Matches,
    back: Matches,
}

impl Found {
    pub fn add(&mut self, other: &Self) {
        self.there.add(&other.there);
        self.back.add(&other.back);
    }

    /// The root mean square distance to the exemplar, over that between its halves.
    pub fn distance(&self, own: &Matches) -> f64 {
        (self.there.rms() + FLOOR) / (own.rms() + FLOOR)
    }

    /// The root mean square distance from the exemplar, over that between its halves.
    pub fn completeness(&self, own: &Matches) -> f64 {
        (self.back.rms() + FLOOR) / (own.rms() + FLOOR)
    }
}

/// Takes patches of a volume and of its exemplars, and looks for them in each other.
pub(super) struct Sampler<'a> {
    voxels: &'a Voxels,
    /// Both halves of each exemplar.
    halves: Vec<[PatchSet; 2]>,
    /// For each exemplar, what its halves find in each other.
    own: Vec<Matches>,
    all_own: Matches,
    /// What the halves find in each other when one is turned, nearest pixels: the same that is done to oblique cuts.
    turned: Matches,
    /// The larger of the distances that the halves have to each other, over that of all.
    pub worst: f64,
    samples: usize,
    random: Random,
    control: &'a dyn Control,
}

impl<'a> Sampler<'a> {
    /// Compares the halves of the exemplars, one for all axes or one for each.
    pub fn new(
        views: &[Pixels],
        voxels: &'a Voxels,
        samples: usize,
        random: Random,
        control: &'a dyn Control,
    ) -> Result<Self, Cancelled> {
        let all: Vec<_> = views.iter().map(halves).collect();
        let (mut own, mut all_own, mut turned) = (Vec::new(), Matches::default(), Matches::default());
        let mut worst = 0.0f64;
        for (view, halves) in all.iter().enumerate() {
            // As many hits in all as slices have, so that what chance does to shares is the same.
            let count = samples / views.len();
            let mut matches = Matches::default();
            for (to, from) in [(0, 1), (1, 0)] {
                let patches = draw(&halves[from], count, [20 + to as u64, view as u64], random);
                let found = Matches::within(&[(view, &halves[to])], &patches, control)?;
                worst = worst.max(found.rms());
                matches.add(&found);
                let picture = &views[view];
                let (w, h) = (picture.width / 2, picture.height / 2);
                let areas = PAIRS[0][from].map(|quadrant| [quadrant % 2 * w, quadrant / 2 * h, w, h]);
                let key = (random, 20 + 2 * view as u64 + from as u64);
                let squares = turned_squares(picture, &areas, EDGE, count, key);
                let patches: Vec<_> = squares.iter().map(|square| patch(|x, y| square.get(x, y))).collect();
                // In all exemplars, as oblique cuts are: equally near patches count for the first.
                let sets: Vec<_> = all.iter().map(|halves| &halves[to]).enumerate().collect();
                turned.add(&Matches::within(&sets, &patches, control)?);
            }
            all_own.add(&matches);
            own.push(matches);
        }
        let worst = (worst + FLOOR) / (all_own.rms() + FLOOR);
        Ok(Self { voxels, halves: all, own, all_own, turned, worst, samples, random, control })
    }

    fn view(&self, axis: usize) -> usize {
        axis.min(self.halves.len() - 1)
    }

    /// What the halves of the exemplar of an axis find in each other.
    pub fn own_of(&self, axis: usize) -> &Matches {
        &self.own[self.view(axis)]
    }

    /// What the halves of all exemplars find in each other.
    pub fn own(&self) -> &Matches {
        &self.all_own
    }

    /// What the halves of all exemplars find in each other when one is turned.
    pub fn own_turned(&self) -> &Matches {
        &self.turned
    }

    /// Slices across an axis.
    pub fn axis(&self, axis: usize) -> Result<Found, Cancelled> {
        let view = self.view(axis);
        let halves = &self.halves[view];
        let count = self.samples / 3 + usize::from(axis < self.samples % 3);
        let along = |transposed, count| axis_patches(self.voxels, axis, transposed, count, self.random);
        let within = |patches: &[Patch]| -> Result<Matches, Cancelled> {
            let mut matches = Matches::within(&[(view, &halves[0])], patches, self.control)?;
            matches.add(&Matches::within(&[(view, &halves[1])], patches, self.control)?);
            Ok(matches)
        };
        // A part of the patches tells which way round the exemplar is.
        let plain = within(&along(false, count / 8))?;
        let transposed = within(&along(true, count / 8))?.rms() < plain.rms();
        let there = within(&along(transposed, count))?;
        let found = PatchSet::of(along(transposed, halves[0].len()));
        let back = Matches::within(&[(0, &found)], &self.exemplar_patches(&[view], count), self.control)?;
        Ok(Found { there, back })
    }

    /// Oblique cuts; each patch in the nearest exemplar.
    pub fn oblique(&self) -> Result<Found, Cancelled> {
        let patches = oblique_patches(self.voxels, self.samples, self.random);
        let mut there = Matches::default();
        for half in 0..2 {
            let sets: Vec<_> = self.halves.iter().map(|halves| &halves[half]).enumerate().collect();
            there.add(&Matches::within(&sets, &patches, self.control)?);
        }
        let size = self.halves.iter().map(|halves| halves[0].len()).sum();
        let found = PatchSet::of(oblique_patches(self.voxels, size, self.random));
        let views: Vec<_> = (0..self.halves.len()).collect();
        let exemplar = self.exemplar_patches(&views, self.samples / views.len());
        let back = Matches::within(&[(0, &found)], &exemplar, self.control)?;
        Ok(Found { there, back })
    }

    /// How many cells of the exemplars are hit, and how many are effectively, over what their halves hit of each other (`own`).
    pub fn sources(&self, found: &Found, own: &Matches) -> [f64; 2] {
        let cells: usize = self.halves.iter().flatten().map(PatchSet::cell_count).sum();
        let draws = cells.min(own.count / 2);
        let coverage = found.there.variety(draws) / own.variety(draws).max(1e-9);
        [coverage, libm::exp(found.there.entropy() - own.entropy())]
    }

    /// Patches of both halves of exemplars.
    fn exemplar_patches(&self, views: &[usize], count: usize) -> Vec<Patch> {
        let draws = views.iter().flat_map(|&view| {
            let [a, b] = &self.halves[view];
            let keys = [22, 23].map(|purpose| [purpose, view as u64]);
            [draw(a, count, keys[0], self.random), draw(b, count, keys[1], self.random)]
        });
        draws.flatten().collect()
    }
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
    let pick = |i: usize| {
        let plane = oblique_plane(voxels.size, EDGE, random, 1 << 32 | i as u64)?;
        Some(patch(|column, row| {
            let point = plane.point([EDGE as u32; 2], column as u32, row as u32);
            voxels.get(std::array::from_fn(|c| (point[c].max(0.0) as usize).min(voxels.size[c] - 1)))
        }))
    };
    (0..count).filter_map(pick).collect()
}
