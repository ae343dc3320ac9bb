//! `optimize.start`: the first field of a level.

use breccia_engine::{Context, Node, NodeError, NodeSpec, ParamKind, Sizing};

use super::field::level_size;
use super::matches::Matches;
use super::solve::{SolveSettings, Solver, solve};
use super::start::{start, upsample};
use super::weights::WeightSettings;
use crate::data::{SolidValue, VoxelSet};
use crate::lazy::Pyramid;
use crate::search::Window;
use crate::solid::{available_memory, box_volume};

/// Bytes a voxel takes while a level is worked on: two fields and the matches of three directions.
pub(super) const VOXEL_BYTES: u64 = 28;

pub(super) struct StartNode;

impl Node for StartNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "optimize.start",
            1,
            "The first voxels of a level of optimisation",
            "Where the coarser level's matches are linked, they are brought to this level, direction by direction, and \
             solved for colours. Otherwise every voxel is a random texel of the exemplar, or, if a solid is linked, the \
             solid's colour there (of the voxel in the middle, at coarse levels). A box that does not \
             fit into memory is refused before anything is computed.",
        )
        .paper("Chen & Wang 2010, section 3, figure 2")
        .on_device()
        .input("pyramid", "pyramid", "The exemplar's levels.")
        .optional("matches", "matches", "The matches of the next coarser level.")
        .optional("solid", "solid", "What to start from at the coarsest level, in place of random texels.")
        .output("field", "field", "The voxels.")
        .param(
            "size",
            ParamKind::Ints { min_len: 1, max_len: 3, min: 4, max: 2048 },
            crate::solid::params::ints([64]),
            "voxels",
            "Edges of the box at the finest level along x, y and z; one number means a cube.",
        )
        .int("level", 0..=15, 0, "count", "The level; 0 is the finest.")
        .int("window", 1..=32, 8, "pixels", "Edge of this level's neighbourhood.")
        .int(
            "margin",
            0..=64,
            0,
            "voxels",
            "Voxels added on every side at the finest level and cut off in the end: 8 or more make a box that does not repeat.",
        )
        .int("seed", 0..=i64::MAX, 1, "count", "Every seed gives another solid.")
        .draft("size", 2, 32)
    }

    fn estimate(&self, sizing: &Sizing<'_>) -> Option<u64> {
        let margin = sizing.int("margin")?.unsigned_abs();
        let level = sizing.int("level")?.unsigned_abs().min(15);
        let edges = sizing.ints("size")?;
        let edge = |i: usize| Some((edges.get(i).or(edges.first())?.unsigned_abs() + 2 * margin) >> level);
        Some(edge(0)? * edge(1)? * edge(2)? * 6)
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let pyramid = context.input::<Pyramid>("pyramid")?;
        let level = context.int("level")? as usize;
        let views = pyramid.levels.get(level).ok_or_else(|| no_level(level, &pyramid))?;
        let margin = context.int("margin")? as usize;
        let size = match context.ints("size")?[..] {
            [n] => [n as usize; 3],
            [x, y, z] => [x, y, z].map(|n| n as usize),
            ref other => {
                return Err(NodeError::Failed(format!("a size takes 1 or 3 numbers, found {}", other.len())));
            }
        };
        let size = size.map(|n| n + 2 * margin);
        let voxels = level_size(size, level).iter().map(|&n| n as u64).product::<u64>();
        let (needed, free) = (voxels * VOXEL_BYTES, available_memory());
        if needed > free {
            let [x, y, z] = size;
            let edge = libm::cbrt((free / VOXEL_BYTES) as f64) as u64;
            return Err(NodeError::Failed(format!(
                "{x} × {y} × {z} voxels need {:.1} GB while they are optimised, {:.1} GB are free; expected at most a \
                 cube of about {edge}³",
                needed as f64 / 1e9,
                free as f64 / 1e9
            )));
        }
        let seed = context.int("seed")? as u64;
        let window = Window { size: context.int("window")? as i32 };
        if let Some(view) = views.iter().find(|view| !window.fits(view)) {
            return Err(NodeError::Failed(format!(
                "a neighbourhood of {0} × {0} pixels is larger than the exemplar at level {level}, {1} × {2} pixels",
                window.size, view.width, view.height
            )));
        }
        let mut field = start(size, level, views, seed);
        if let Some(matches) = context.optional::<Matches>("matches")? {
            if matches.level != level + 1 {
                return Err(NodeError::Failed(format!(
                    "the matches are of level {}, expected level {}",
                    matches.level,
                    level + 1
                )));
            }
            let fine = upsample(&matches, size, views, window);
            let weights = WeightSettings { position: 0.0, smoothing: 0, color: 0.0 };
            let settings = SolveSettings { solver: Solver::Discrete, gamma: 0.8, weights, seed, sweep: 0 };
            field = solve(&fine, views, None, None, &settings, context)?;
        } else if let Some(solid) = context.optional::<SolidValue>("solid")? {
            let step = 1i32 << level;
            let at = |i: usize| (i as i32) * step + step / 2 - margin as i32;
            let [width, height, _] = field.size;
            let solid = &*solid.0;
            if level == 0 {
                let sides = field.size.map(|n| n as u32);
                let volume = box_volume(solid, [-(margin as i32); 3], sides, available_memory(), context)?;
                if let Some(map) = volume.map("color") {
                    for (i, color) in field.colors.iter_mut().enumerate() {
                        (0..3).for_each(|c| color[c] = map.samples.get_u8(i * map.channels + c));
                    }
                }
            } else {
                for (slice, colors) in field.colors.chunks_mut(width * height).enumerate() {
                    let place = |i: usize| [at(i % width), at(i / width), at(slice)];
                    let found =
                        solid.evaluate(&VoxelSet::from_iter((0..colors.len()).map(place)), context)?;
                    let Some(map) = found.map("color") else { continue };
                    for (i, color) in colors.iter_mut().enumerate() {
                        if let Some(from) = found.index(place(i)) {
                            (0..3).for_each(|c| color[c] = map.samples.get_u8(from * map.channels + c));
                        }
                    }
                }
            }
        }
        context.set("field", field);
        Ok(())
    }
}

/// The pyramid has no such level.
pub(super) fn no_level(level: usize, pyramid: &Pyramid) -> NodeError {
    NodeError::Failed(format!(
        "found level {level}, the pyramid has {} levels; expected `levels` to be the same for both",
        pyramid.levels.len()
    ))
}
