//! The state of one level over a sparse set of voxels, and the steps that change it.

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::color::OneColor;
use super::domain::Domain;
use super::initial::Initial;
use super::isa::Isa;
use super::kernel::{Job, SIDE, Weights, Window, Workspace, correct};
use super::pyramid::Pixel;
use super::tables::LevelTables;
use crate::control::{Cancelled, Control, check};
use crate::data::{BRICK_VOXELS, VoxelSet, indices, voxel_at};

/// The state of one brick; entries of voxels outside the set hold no meaning.
#[derive(Clone)]
pub(super) struct Brick {
    /// The pixel in each direction's exemplar.
    pub pixels: [[Pixel; BRICK_VOXELS]; 3],
    /// Colour and feature, little-endian RGBF.
    pub color: [u32; BRICK_VOXELS],
    /// The direction whose pixel is shown.
    pub shown: [u8; BRICK_VOXELS],
}

impl Brick {
    pub fn empty() -> Self {
        Self { pixels: [[0; BRICK_VOXELS]; 3], color: [0; BRICK_VOXELS], shown: [0; BRICK_VOXELS] }
    }

    #[inline(always)]
    pub fn set(&mut self, at: usize, pixels: [Pixel; 3], level: &LevelTables, color: OneColor) {
        let colors = std::array::from_fn(|e| {
            let view = &level.view(e).view;
            view.texels[view.index(pixels[e])]
        });
        (0..3).for_each(|e| self.pixels[e][at] = pixels[e]);
        let (color, shown) = color.of(colors);
        self.color[at] = u32::from_le_bytes(color);
        self.shown[at] = shown as u8;
    }

    /// Takes over the voxels of a mask from another brick.
    pub fn copy_masked(&mut self, from: &Self, mask: &[u64; 8]) {
        for at in indices(mask) {
            (0..3).for_each(|e| self.pixels[e][at] = from.pixels[e][at]);
            self.color[at] = from.color[at];
            self.shown[at] = from.shown[at];
        }
    }
}

/// What a correction works with.
#[derive(Clone, Copy)]
pub(super) struct Correction<'a> {
    pub domain: &'a Domain,
    pub level: &'a LevelTables,
    pub weights: Weights,
    pub color: OneColor,
    pub isa: Isa,
}

/// The state of one level over a sparse set of voxels.
pub(super) struct Field {
    slots: FxHashMap<[i32; 3], u32>,
    keys: Vec<[i32; 3]>,
    bricks: Vec<Brick>,
}

impl Field {
    fn build(
        set: &VoxelSet,
        control: &dyn Control,
        make: impl Fn([i32; 3], &[u64; 8]) -> Brick + Sync,
    ) -> Result<Self, Cancelled> {
        let keys = set.bricks();
        let bricks = keys
            .par_iter()
            .map(|&key| {
                check(control)?;
                Ok(make(key, set.mask(key).unwrap_or(&[0; 8])))
            })
            .collect::<Result<_, Cancelled>>()?;
        Ok(Self::of(keys, bricks))
    }

    /// A field from its bricks.
    pub fn of(keys: Vec<[i32; 3]>, bricks: Vec<Brick>) -> Self {
        let slots = keys.iter().zip(0..).map(|(&key, slot)| (key, slot)).collect();
        Self { slots, keys, bricks }
    }

    /// The bricks and their positions.
    pub fn into_parts(self) -> (Vec<[i32; 3]>, Vec<Brick>) {
        (self.keys, self.bricks)
    }

    /// Bricks with their positions.
    pub fn bricks(&self) -> impl Iterator<Item = ([i32; 3], &Brick)> {
        self.keys.iter().copied().zip(&self.bricks)
    }

    /// The brick at a position.
    pub fn brick(&self, key: [i32; 3]) -> Option<&Brick> {
        self.slots.get(&key).map(|&slot| &self.bricks[slot as usize])
    }

    /// The start level before its first correction.
    ///
    /// Voxels that are not `free`, if that is given, take the pixels given with it.
    pub fn start(
        set: &VoxelSet,
        initial: &Initial,
        seed: u64,
        free: Option<(&VoxelSet, [Pixel; 3])>,
        correction: &Correction<'_>,
        control: &dyn Control,
    ) -> Result<Self, Cancelled> {
        let Correction { domain, level, color, .. } = *correction;
        let views = std::array::from_fn(|e| &level.view(e).view);
        Self::build(set, control, |key, mask| {
            let moved = initial.jitter.map(|jitter| jitter.displacements(seed, domain, key));
            let mut brick = Brick::empty();
            let open = free.map(|(free, _)| free.mask(key).copied().unwrap_or_default());
            for at in indices(mask) {
                if let (Some(open), Some((_, taken))) = (open, free)
                    && open[at >> 6] >> (at & 63) & 1 == 0
                {
                    brick.set(at, taken, level, color);
                    continue;
                }
                let mut voxel = voxel_at(key, at);
                if let Some(moved) = &moved {
                    (0..3).for_each(|i| voxel[i] = voxel[i].wrapping_add(moved[at][i]));
                }
                // A slab may come from another exemplar than the tables.
                let triple = initial.triple(seed, voxel, views);
                brick.set(at, std::array::from_fn(|e| views[e].shifted(triple[e], 0, 0)), level, color);
            }
            brick
        })
    }

    /// A level before its first correction, from the finished next coarser one: every voxel inherits its parent's
    /// pixels, doubled, at its own place among the eight children (Dong et al. 2008, section 5.1, Upsampling).
    pub fn upsample(
        set: &VoxelSet,
        coarse: &Self,
        level: &LevelTables,
        color: OneColor,
        control: &dyn Control,
    ) -> Result<Self, Cancelled> {
        Self::build(set, control, |key, mask| {
            let mut brick = Brick::empty();
            let Some(parents) = coarse.brick(key.map(|c| c >> 1)) else { return brick };
            for at in indices(mask) {
                let voxel = voxel_at(key, at);
                let from = crate::data::local_index(voxel.map(|c| c >> 1));
                let pixels = std::array::from_fn(|e| {
                    let parent = parents.pixels[e][from];
                    let (x, y) = (i32::from(parent & 255), i32::from(parent >> 8));
                    let (u, v) = (voxel[(e + 1) % 3] & 1, voxel[(e + 2) % 3] & 1);
                    level.view(e).view.pixel(2 * x + u, 2 * y + v)
                });
                brick.set(at, pixels, level, color);
            }
            brick
        })
    }

    /// One sub-pass over the voxels of `set`; returns the sum of their costs.
    pub fn correct(
        &mut self,
        set: &VoxelSet,
        correction: &Correction<'_>,
        control: &dyn Control,
    ) -> Result<i64, Cancelled> {
        let Correction { domain, level, weights, color, isa } = *correction;
        let keys = set.bricks();
        let results = keys
            .par_iter()
            .map_init(Workspace::default, |workspace, &key| {
                check(control)?;
                let Some(mask) = set.mask(key) else { return Ok(None) };
                let Some(&slot) = self.slots.get(&key) else { return Ok(None) };
                self.fill_window(&mut workspace.window, domain, key);
                let mut brick = self.bricks[slot as usize].clone();
                let job = Job { level, weights, color };
                let cost = correct(isa, job, workspace, mask, &mut brick);
                Ok(Some((slot, brick, cost)))
            })
            .collect::<Result<Vec<_>, Cancelled>>()?;
        let mut total = 0;
        for (slot, brick, cost) in results.into_iter().flatten() {
            self.bricks[slot as usize] = brick;
            total += cost;
        }
        Ok(total)
    }

    /// Gathers the state around a brick.
    fn fill_window(&self, window: &mut Window, domain: &Domain, key: [i32; 3]) {
        let at = |axis: usize| -> [i32; SIDE] {
            std::array::from_fn(|i| domain.wrap(axis, key[axis] * 8 + i as i32 - 2))
        };
        let [xs, ys, zs] = [at(0), at(1), at(2)];
        let absent = Brick::empty();
        // The brick's own row in one piece, unless a period cuts it.
        let whole = xs[2] & 7 == 0 && xs[9] == xs[2] + 7;
        let mut columns: [&Brick; SIDE] = [&absent; SIDE];
        let mut to = 0;
        for z in zs {
            for y in 0..SIDE {
                let [by, bz] = [ys[y] >> 3, z >> 3];
                if y == 0 || by != ys[y - 1] >> 3 {
                    for x in 0..SIDE {
                        columns[x] = if x > 0 && xs[x] >> 3 == xs[x - 1] >> 3 {
                            columns[x - 1]
                        } else {
                            self.brick([xs[x] >> 3, by, bz]).unwrap_or(&absent)
                        };
                    }
                }
                let row = ((z & 7) << 6 | (ys[y] & 7) << 3) as usize;
                let single: &[usize] =
                    if whole { &[0, 1, 10, 11] } else { &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11] };
                for &x in single {
                    let (brick, from) = (columns[x], row | (xs[x] & 7) as usize);
                    window.color[to + x] = brick.color[from];
                    (0..3).for_each(|e| window.pixels[e][to + x] = brick.pixels[e][from]);
                }
                if whole {
                    let brick = columns[2];
                    window.color[to + 2..to + 10].copy_from_slice(&brick.color[row..row + 8]);
                    for e in 0..3 {
                        window.pixels[e][to + 2..to + 10].copy_from_slice(&brick.pixels[e][row..row + 8]);
                    }
                }
                to += SIDE;
            }
        }
    }
}
