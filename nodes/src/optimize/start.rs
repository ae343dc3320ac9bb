//! The first field of a level: random texels, the coarser level's matches, or any solid.

use super::field::{Field, level_size};
use super::matches::{DirectionMatches, Matches};
use crate::lazy::random::hash;
use crate::lazy::{LevelView, Pixel};
use crate::search::Window;

const PURPOSE: u32 = 0x57a2_7003;

/// Random texels (Chen & Wang 2010, figure 2). With three views every voxel takes one of them, at random as well.
pub fn start(size: [usize; 3], level: usize, views: &[LevelView], seed: u64) -> Field {
    let size = level_size(size, level);
    let [width, height, _] = size;
    let voxels: usize = size.iter().product();
    let mut field = Field {
        size,
        level,
        colors: Vec::with_capacity(voxels),
        sources: views.iter().map(|_| Vec::with_capacity(voxels)).collect(),
        chosen: Vec::new(),
        index: Vec::new(),
    };
    for i in 0..voxels {
        let place = [i % width, i / width % height, i / width / height].map(|c| c as i32);
        let draw =
            |purpose: u32, count: i32| ((u64::from(hash(seed, purpose, place)) * count as u64) >> 32) as i32;
        let chosen = draw(PURPOSE, views.len() as i32) as usize;
        for (v, view) in views.iter().enumerate() {
            let purpose = PURPOSE + 1 + 2 * v as u32;
            let source = (draw(purpose, view.width) | draw(purpose + 1, view.height) << 8) as Pixel;
            field.sources[v].push(source);
            if v == chosen {
                field.colors.push(view.texels[view.index(source)]);
            }
        }
        if views.len() > 1 {
            field.chosen.push(chosen as u8);
        }
    }
    field
}

/// The matches of a coarser level, brought to the next finer one: the children of a voxel match the children of the pixel
/// that it matched, each direction by itself.
pub fn upsample(coarse: &Matches, size: [usize; 3], views: &[LevelView], window: Window) -> Matches {
    let level = coarse.level.saturating_sub(1);
    let size = level_size(size, level);
    let [width, height, _] = size;
    let voxels: usize = size.iter().product();
    let mut directions = <[DirectionMatches; 3]>::default();
    for (d, (fine, coarse_matches)) in directions.iter_mut().zip(&coarse.directions).enumerate() {
        if coarse_matches.pixels.is_empty() {
            continue;
        }
        let view = &views[d.min(views.len() - 1)];
        let (along, across) = ((d + 1) % 3, (d + 2) % 3);
        for i in 0..voxels {
            let place = [i % width, i / width % height, i / width / height];
            let parent: [usize; 3] = std::array::from_fn(|a| (place[a] / 2).min(coarse.size[a] - 1));
            let from = (parent[2] * coarse.size[1] + parent[1]) * coarse.size[0] + parent[0];
            let pixel = coarse_matches.pixels[from];
            let column = 2 * i32::from(pixel & 255) + (place[along] % 2) as i32;
            let line = 2 * i32::from(pixel >> 8) + (place[across] % 2) as i32;
            fine.pixels.push(window.centre(view, column, line));
            fine.codes.push(coarse_matches.codes[from]);
        }
    }
    Matches { size, level, window, directions }
}
