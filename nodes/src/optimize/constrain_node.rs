//! `optimize.constrain`: voxels that must keep a colour.

use std::collections::BTreeMap;

use breccia_engine::{Context, Node, NodeError, NodeSpec, Sizing};
use rayon::prelude::*;

use super::field::Field;
use super::start_node::no_level;
use crate::control::check;
use crate::data::{SolidValue, VoxelMap, VoxelSet};
use crate::lazy::{LevelView, Pixel, Pyramid};

pub(super) struct ConstrainNode;

impl Node for ConstrainNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "optimize.constrain",
            1,
            "Voxels that must keep a colour",
            "Paints colours over the voxels wherever a mask is bright, and notes the exemplar's texel of the nearest colour \
             as where they came from. In a zone that repeats search and solve, the texture grows around what is painted, \
             since every search sees it. Colours that the exemplar does not have stay as they are painted only where \
             `exact` is set.",
        )
        .memory_only()
        .on_device()
        .input("field", "field", "The voxels.")
        .input("pyramid", "pyramid", "The exemplar's levels.")
        .input("paint", "solid", "The colours to keep.")
        .input("mask", "solid", "Where: voxels whose luminance is above `threshold`.")
        .output("field", "field", "The voxels, painted.")
        .float("threshold", 0.0..=1.0, 0.5, "1", "Luminance of the mask above which a voxel is painted.")
        .flag("exact", false, "Keep the painted colour itself, rather than the nearest colour of the exemplar.")
        .int("margin", 0..=64, 0, "voxels", "The margin that the optimisation was started with.")
    }

    fn estimate(&self, sizing: &Sizing<'_>) -> Option<u64> {
        sizing.input("field")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let field = context.input::<Field>("field")?;
        let pyramid = context.input::<Pyramid>("pyramid")?;
        let paint = context.input::<SolidValue>("paint")?;
        let mask = context.input::<SolidValue>("mask")?;
        let views = pyramid.levels.get(field.level).ok_or_else(|| no_level(field.level, &pyramid))?;
        if views.len() != field.sources.len() {
            return Err(NodeError::Failed("the voxels are of another exemplar than the pyramid".into()));
        }
        let threshold = context.float("threshold")? * 255.0;
        let exact = context.flag("exact")?;
        let mut painted = Field::clone(&field);
        let step = 1i32 << field.level.min(15);
        let margin = context.int("margin")? as i32;
        let [width, height, depth] = field.size;
        for z in 0..depth {
            check(context)?;
            let at = |i: usize| [i % width, i / width, z].map(|n| n as i32 * step + step / 2 - margin);
            let slice = VoxelSet::from_iter((0..width * height).map(at));
            let mask = mask.0.evaluate(&slice, context)?;
            let bright = |i: &usize| {
                color_of(&mask, at(*i)).is_some_and(|[r, g, b]| {
                    0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b) > threshold
                })
            };
            let wanted: Vec<usize> = (0..width * height).filter(bright).collect();
            if wanted.is_empty() {
                continue;
            }
            let colors = paint.0.evaluate(&VoxelSet::from_iter(wanted.iter().map(|&i| at(i))), context)?;
            let wanted: Vec<(usize, [u8; 3])> =
                wanted.into_iter().filter_map(|i| Some((i, color_of(&colors, at(i))?))).collect();
            // Few colours are painted many times.
            let palette: BTreeMap<[u8; 3], ()> = wanted.iter().map(|&(_, color)| (color, ())).collect();
            let palette: Vec<[u8; 3]> = palette.into_keys().collect();
            let found: Vec<Vec<Pixel>> = palette
                .par_iter()
                .map(|&color| views.iter().map(|view| nearest(view, color)).collect())
                .collect();
            let found: BTreeMap<[u8; 3], Vec<Pixel>> = palette.into_iter().zip(found).collect();
            for (i, color) in wanted {
                let voxel = z * width * height + i;
                let Some(sources) = found.get(&color) else { continue };
                for (to, &source) in painted.sources.iter_mut().zip(sources) {
                    to[voxel] = source;
                }
                let view = painted.view_of(voxel);
                painted.colors[voxel] = views[view].texels[views[view].index(sources[view])];
                if exact {
                    painted.colors[voxel][..3].copy_from_slice(&color);
                }
            }
        }
        context.set("field", painted);
        Ok(())
    }
}

fn color_of(map: &VoxelMap, voxel: [i32; 3]) -> Option<[u8; 3]> {
    let (at, color) = (map.index(voxel)?, map.map("color")?);
    Some(std::array::from_fn(|c| color.samples.get_u8(at * color.channels + c)))
}

/// The first texel of the nearest colour.
fn nearest(view: &LevelView, color: [u8; 3]) -> Pixel {
    let gap =
        |texel: &[u8; 4]| -> i32 { (0..3).map(|c| (i32::from(texel[c]) - i32::from(color[c])).pow(2)).sum() };
    let best =
        view.texels.iter().enumerate().min_by_key(|(_, texel)| gap(texel)).map_or(0, |(i, _)| i as i32);
    ((best % view.width) | ((best / view.width) << 8)) as Pixel
}
