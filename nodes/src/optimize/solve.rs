//! The optimisation phase: colours from matches (Chen & Wang 2010, section 4.2).

use rayon::prelude::*;

use super::control_map::ControlMap;
use super::field::Field;
use super::matches::{CODES, Matches, decode};
use super::phases::{Columns, PHASES, Place, phase, place};
use super::weights::{Usage, WeightSettings};
use crate::control::{Cancelled, Control, check};
use crate::lazy::{LevelView, Pixel};

/// What becomes a voxel's colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solver {
    /// The texel nearest to the weighted mean, among those that overlap at the voxel (Han et al. 2006).
    Discrete,
    /// The weighted mean itself (Kopf et al. 2007).
    Mean,
}

/// How colours are solved for.
#[derive(Clone, Debug, PartialEq)]
pub struct SolveSettings {
    /// What becomes a voxel's colour.
    pub solver: Solver,
    /// The exponent γ of the energy: a match at distance r weighs r^(γ − 2).
    pub gamma: f64,
    /// How texels that are used too often are held back.
    pub weights: WeightSettings,
    /// The order of rows.
    pub seed: u64,
}

const PURPOSE: u32 = 0x501e_e002;

/// A texel of a view that has a margin on all sides, so that windows never leave it.
#[derive(Clone, Copy)]
struct Texel {
    color: [u8; 4],
    weight: f32,
}

/// A view with a margin of a window's size.
struct Padded {
    pitch: usize,
    margin: i32,
    texels: Vec<Texel>,
    sources: Vec<Pixel>,
}

impl Padded {
    fn new(view: &LevelView, margin: i32) -> Self {
        let pitch = view.width + 2 * margin;
        let mut padded = Self { pitch: pitch as usize, margin, texels: Vec::new(), sources: Vec::new() };
        for y in -margin..view.height + margin {
            for x in -margin..view.width + margin {
                let (x, y) = if view.tileable {
                    (x.rem_euclid(view.width), y.rem_euclid(view.height))
                } else {
                    (x.clamp(0, view.width - 1), y.clamp(0, view.height - 1))
                };
                padded.texels.push(Texel { color: view.texel(x, y), weight: 1.0 });
                padded.sources.push((x | y << 8) as Pixel);
            }
        }
        padded
    }

    fn weigh(&mut self, view: &LevelView, weights: &[f32]) {
        for (texel, &source) in self.texels.iter_mut().zip(&self.sources) {
            texel.weight = weights[view.index(source)];
        }
    }
}

/// Colours from matches: the weighted mean of all texels that overlap at a voxel (equation 2), or the texel nearest to it.
/// `before` is the field that the matches were made from; its histograms are the ones to start with.
///
/// # Errors
/// [`Cancelled`].
pub fn solve(
    matches: &Matches,
    views: &[LevelView],
    before: Option<&Field>,
    theta: Option<&ControlMap>,
    settings: &SolveSettings,
    control: &dyn Control,
) -> Result<Field, Cancelled> {
    let [width, height, depth] = matches.size;
    let voxels = width * height * depth;
    let before = before.filter(|field| field.size == matches.size && field.sources.len() == views.len());
    let mut usage = Usage::new(views);
    if let Some(before) = before {
        for (i, &color) in before.colors.iter().enumerate() {
            let view = before.view_of(i);
            usage.add(views, view, before.sources[view][i], color);
        }
    }
    let mut field = Field {
        size: matches.size,
        level: matches.level,
        colors: vec![[0; 4]; voxels],
        sources: views.iter().map(|_| vec![0; voxels]).collect(),
        chosen: if views.len() > 1 { vec![0; voxels] } else { Vec::new() },
        index: index_histogram(matches, views),
    };
    let mut tables: Vec<Padded> = views.iter().map(|view| Padded::new(view, matches.window.size)).collect();
    let distance_weights = distance_weights(settings.gamma);
    let columns = Columns::new(width);
    let mut phases = rows_by_phase(&mut field, settings.seed);
    for (p, rows) in phases.iter_mut().enumerate() {
        check(control)?;
        control.progress(p as f32 / PHASES as f32);
        for (v, table) in tables.iter_mut().enumerate() {
            table.weigh(&views[v], &usage.weights(views, v, theta, &settings.weights));
        }
        let job = Job {
            matches,
            tables: &tables,
            distance_weights: &distance_weights,
            columns: &columns,
            solver: settings.solver,
        };
        rows.par_iter_mut().try_for_each(|row| {
            check(control)?;
            solve_row(&job, row);
            Ok(())
        })?;
        for row in rows {
            let start = (row.z * height + row.y) * width;
            for x in 0..width {
                if let Some(before) = before {
                    let view = before.view_of(start + x);
                    usage.remove(views, view, before.sources[view][start + x], before.colors[start + x]);
                }
                let view = row.chosen.get(x).map_or(0, |&view| usize::from(view));
                usage.add(views, view, row.sources[view][x], row.colors[x]);
            }
        }
    }
    drop(phases);
    Ok(field)
}

/// A row of the field.
struct Row<'a> {
    y: usize,
    z: usize,
    colors: &'a mut [[u8; 4]],
    sources: Vec<&'a mut [Pixel]>,
    chosen: &'a mut [u8],
}

fn rows_by_phase(field: &mut Field, seed: u64) -> Vec<Vec<Row<'_>>> {
    let [width, height, depth] = field.size;
    let mut phases: Vec<Vec<Row<'_>>> = (0..PHASES).map(|_| Vec::new()).collect();
    let mut colors = field.colors.chunks_exact_mut(width);
    let mut chosen = field.chosen.chunks_exact_mut(width);
    let mut sources: Vec<_> = field.sources.iter_mut().map(|s| s.chunks_exact_mut(width)).collect();
    for z in 0..depth {
        for y in 0..height {
            let Some(colors) = colors.next() else { continue };
            let sources = sources.iter_mut().filter_map(Iterator::next).collect();
            let chosen = chosen.next().unwrap_or_default();
            phases[phase(seed, PURPOSE, y, z)].push(Row { y, z, colors, sources, chosen });
        }
    }
    phases
}

/// For each code of a distance the weight r^(γ − 2) of a match.
fn distance_weights(gamma: f64) -> Vec<f32> {
    // A match of no distance must not outweigh all others: one grey level is as near as it gets.
    let least = f64::from(crate::search::SCALE).powi(2);
    (0..CODES).map(|code| libm::pow((decode(code) + least) / least, (gamma - 2.0) / 2.0) as f32).collect()
}

/// How often each pixel is matched.
fn index_histogram(matches: &Matches, views: &[LevelView]) -> Vec<Vec<u32>> {
    let mut index: Vec<Vec<u32>> = views.iter().map(|view| vec![0; view.texels.len()]).collect();
    for (direction, matched) in matches.directions.iter().enumerate() {
        let view = direction.min(views.len() - 1);
        for &pixel in &matched.pixels {
            index[view][views[view].index(pixel)] += 1;
        }
    }
    index
}

struct Job<'a> {
    matches: &'a Matches,
    tables: &'a [Padded],
    distance_weights: &'a [f32],
    columns: &'a Columns,
    solver: Solver,
}

/// A window's texel that overlaps at the voxels of a row.
struct Overlap {
    direction: usize,
    view: usize,
    /// Where the matched neighbourhood's centre lies.
    place: Place,
    /// From the centre's texel to the overlapping one, in the padded view.
    offset: usize,
}

fn solve_row(job: &Job<'_>, row: &mut Row<'_>) {
    let matches = job.matches;
    let mut overlaps = Vec::new();
    for (direction, matched) in matches.directions.iter().enumerate() {
        if matched.pixels.is_empty() {
            continue;
        }
        let view = direction.min(job.tables.len() - 1);
        let table = &job.tables[view];
        for (c, r) in matches.window.offsets() {
            let place = place(matches.size, direction, row.y, row.z, -c, -r);
            let offset = (r + table.margin) as usize * table.pitch + (c + table.margin) as usize;
            overlaps.push(Overlap { direction, view, place, offset });
        }
    }
    let mut at = vec![0u32; overlaps.len()];
    for x in 0..row.colors.len() {
        let mut sums = [0.0f32; 4];
        let mut total = 0.0f32;
        for (overlap, at) in overlaps.iter().zip(&mut at) {
            let voxel = job.columns.at(overlap.place, x);
            let matched = &matches.directions[overlap.direction];
            let pixel = usize::from(matched.pixels[voxel]);
            let table = &job.tables[overlap.view];
            let index = (pixel >> 8) * table.pitch + (pixel & 255) + overlap.offset;
            let texel = table.texels[index];
            let weight = job.distance_weights[usize::from(matched.codes[voxel]) & (CODES - 1)] * texel.weight;
            for (sum, channel) in sums.iter_mut().zip(texel.color) {
                *sum += weight * f32::from(channel);
            }
            total += weight;
            *at = index as u32;
        }
        let mean = sums.map(|sum| if total > 0.0 { sum / total } else { 0.0 });
        let mut best = [(f32::INFINITY, 0usize); 3];
        for (overlap, &at) in overlaps.iter().zip(&at) {
            let color = job.tables[overlap.view].texels[at as usize].color;
            let mut gap = 0.0;
            for (channel, mean) in color.into_iter().zip(mean) {
                let difference = f32::from(channel) - mean;
                gap += difference * difference;
            }
            if gap < best[overlap.view].0 {
                best[overlap.view] = (gap, at as usize);
            }
        }
        let mut chosen = 0;
        for view in 0..job.tables.len() {
            row.sources[view][x] = job.tables[view].sources[best[view].1];
            if best[view].0 < best[chosen].0 {
                chosen = view;
            }
        }
        if let Some(to) = row.chosen.get_mut(x) {
            *to = chosen as u8;
        }
        row.colors[x] = match job.solver {
            Solver::Discrete => job.tables[chosen].texels[best[chosen].1].color,
            Solver::Mean => mean.map(|m| (m + 0.5) as u8),
        };
    }
}
