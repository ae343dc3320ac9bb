//! The correction of a voxel as section 5.1 of Dong et al. 2008 tells it, one candidate after the other, against the
//! kernel.

use super::color::OneColor;
use super::field::Brick;
use super::isa::available;
use super::kernel::{Job, SIDE, Weights, Workspace, correct};
use super::pyramid::{N, Pixel};
use super::random::hash;
use super::schedule::ColorRule;
use super::tables::LevelTables;
use super::tests::tables_of_noise;
use crate::data::indices;

/// The best triple around window voxel `at`, its cost and its colour.
fn corrected(job: &Job<'_>, workspace: &Workspace, at: [usize; 3]) -> ([Pixel; 3], i64, [u8; 4]) {
    let Job { level, weights, color } = *job;
    let (window, stride) = (&workspace.window, [1, SIDE, SIDE * SIDE]);
    let views = [level.view(0), level.view(1), level.view(2)];
    // The voxel (du, dv) away in the plane across direction e.
    let near = |e: usize, du: i32, dv: i32| -> usize {
        let at: usize = (0..3).map(|i| at[i] * stride[i]).sum();
        let (u, v) = (stride[(e + 1) % 3] as i32, stride[(e + 2) % 3] as i32);
        (at as i32 + du * u + dv * v) as usize
    };
    let square = || (-1..=1).flat_map(|dv| (-1..=1).map(move |du| (du, dv)));
    let descriptor = |e: usize| {
        let neighbourhood: [[u8; 4]; N * N] =
            std::array::from_fn(|k| window.color[near(e, k as i32 % 5 - 2, k as i32 / 5 - 2)].to_le_bytes());
        views[e].basis.project(&neighbourhood)
    };
    let continuing: Vec<Vec<Pixel>> = (0..3)
        .map(|e| {
            let step = |(du, dv)| views[e].view.shifted(window.pixels[e][near(e, du, dv)], -du, -dv);
            square().map(step).collect()
        })
        .collect();
    let own: Vec<_> = (0..3).map(descriptor).collect();
    // The cost of a pixel for one direction.
    let cost = |e: usize, pixel: Pixel| -> i64 {
        let record = &views[e].records[views[e].view.index(pixel)];
        let theirs = views[e].basis.project(&views[e].view.neighbourhood(pixel));
        let distance: i64 =
            own[e].iter().zip(theirs).map(|(&a, b)| (i64::from(a) - i64::from(b)).pow(2)).sum();
        let factor = if continuing[e].contains(&pixel) { 256 } else { i64::from(weights.incoherent) };
        distance * factor / 256 + i64::from(record.usage)
    };
    let crossbar = |pixels: [Pixel; 3]| -> i64 {
        let mut error = 0;
        for e in 0..3 {
            let next = (e + 1) % 3;
            let column = views[e].view.neighbourhood(pixels[e]);
            let row = views[next].view.neighbourhood(pixels[next]);
            for k in 0..N {
                for c in 0..4 {
                    error += (i64::from(column[k * N + 2][c]) - i64::from(row[2 * N + k][c])).pow(2);
                }
            }
        }
        (error * i64::from(level.scale) * weights.crossbar as i64) >> 24
    };
    let mut best = [0; 3];
    for e in 0..3 {
        let sets = continuing[e].iter().flat_map(|&pixel| {
            let set = views[e].records[views[e].view.index(pixel)].similar;
            set.into_iter().take(weights.similar)
        });
        // The first of equals.
        best[e] = sets.min_by_key(|&pixel| cost(e, pixel)).expect("a candidate");
    }
    let mut triples = vec![best];
    for e in 0..3 {
        let lists = &views[e].triples;
        for k in 0..weights.triples {
            let triple = lists[k / 2][views[e].view.index(best[e])][k % 2];
            let mut pixels = best;
            (pixels[(e + 1) % 3], pixels[(e + 2) % 3]) = (triple.next, triple.last);
            triples.push(pixels);
        }
    }
    let whole = |pixels: &[Pixel; 3]| (0..3).map(|e| cost(e, pixels[e])).sum::<i64>() + crossbar(*pixels);
    let chosen = triples.into_iter().min_by_key(whole).expect("the mixed triple");
    let colors = std::array::from_fn(|e| views[e].view.texels[views[e].view.index(chosen[e])]);
    (chosen, whole(&chosen), color.of(colors).0)
}

fn noise_window(level: &LevelTables) -> Workspace {
    let mut workspace = Workspace::default();
    for i in 0..SIDE * SIDE * SIDE {
        for e in 0..3 {
            let view = &level.view(e).view;
            let random = hash(5, e as u32, [i as i32, 0, 0]);
            // Patches along x, so that neighbours continue each other now and then.
            let x = (i % SIDE) as i32 + (hash(5, 9, [i as i32 / 3, 0, 0]) & 15) as i32;
            workspace.window.pixels[e][i] = view.pixel(x, (random >> 8 & 31) as i32);
        }
        let view = &level.view(0).view;
        workspace.window.color[i] =
            u32::from_le_bytes(view.texels[view.index(workspace.window.pixels[0][i])]);
    }
    workspace
}

#[test]
fn the_kernel_equals_the_paper_step_by_step() {
    let mask: [u64; 8] = std::array::from_fn(|z| match z {
        0 => u64::MAX,
        1 => 0,
        2 => 1 << 63,
        _ => u64::from(hash(1, 1, [z as i32, 0, 0])) << 16 | u64::from(hash(1, 2, [z as i32, 0, 0])),
    });
    for (dims, tileable, similar, triples) in
        [(8, false, 2, 2), (8, true, 4, 12), (16, false, 1, 3), (12, true, 3, 0)]
    {
        let tables = tables_of_noise(dims, tileable);
        let level = &tables.levels[0];
        let weights = Weights { similar, triples, incoherent: 358, crossbar: 768 };
        for rule in [ColorRule::Nearest, ColorRule::Mean] {
            let job = Job { level, weights, color: OneColor::new(rule, level) };
            for isa in available() {
                let mut workspace = noise_window(level);
                let mut brick = Brick::empty();
                let cost = correct(isa, job, &mut workspace, &mask, &mut brick);
                let mut sum = 0;
                for voxel in indices(&mask) {
                    let at = [voxel & 7, voxel >> 3 & 7, voxel >> 6].map(|c| c + 2);
                    let (pixels, cost, color) = corrected(&job, &workspace, at);
                    assert_eq!(brick.pixels.map(|p| p[voxel]), pixels, "{isa:?}, voxel {voxel}, {dims} dims");
                    assert_eq!(brick.color[voxel].to_le_bytes(), color, "{isa:?}, voxel {voxel}");
                    sum += cost;
                }
                assert_eq!(cost, sum, "{isa:?}");
            }
        }
    }
}
