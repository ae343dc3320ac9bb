//! From a mask to cross-sections: components, holes, touching particles, the border (Du et al. 2013, section 3.1).

use std::collections::BTreeMap;

use super::cells::cells;
use super::section::{Section, Sections};
use crate::control::{Cancelled, Control, check};
use crate::exemplar::{View, signed_distance};

/// What becomes of sections that the border of the picture cuts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Border {
    /// They are left out.
    Drop,
    /// They stay as they are.
    Keep,
    /// Those that one edge cuts are completed by their mirror image, others are left out.
    Complete,
}

/// How sections are found.
#[derive(Clone, Copy, Debug)]
pub struct SectionSettings {
    /// What becomes of sections at the border.
    pub border: Border,
    /// Touching particles are split where the neck between them is thinner than this fraction of the thinner one; 0 never.
    pub split: f64,
    /// Sections of fewer pixels are left out.
    pub least: u32,
    /// Sections that cover more than this fraction of the picture are left out.
    pub most: f64,
}

impl Default for SectionSettings {
    fn default() -> Self {
        Self { border: Border::Drop, split: 0.6, least: 12, most: 0.25 }
    }
}

/// The sections of a picture whose mask is `true` inside particles.
///
/// # Errors
/// [`Cancelled`].
pub fn find_sections(
    view: &View,
    mask: &[bool],
    settings: &SectionSettings,
    control: &dyn Control,
) -> Result<Sections, Cancelled> {
    let (w, h) = (view.width as usize, view.height as usize);
    let grid = Grid { w: w as i32, h: h as i32, tileable: view.tileable };
    let labels = if settings.split > 0.0 && mask.contains(&true) && mask.contains(&false) {
        basins(mask, &grid, settings.split)
    } else {
        mask.iter().map(|&m| u32::from(m)).collect()
    };
    check(control)?;
    let mut seen = vec![false; mask.len()];
    let (mut sections, mut left_out) = (Vec::new(), 0);
    let mut kept = vec![0u32; mask.len()];
    for start in 0..mask.len() {
        if !mask[start] || seen[start] {
            continue;
        }
        check(control)?;
        let pixels = component(&labels, &grid, start, &mut seen);
        match section(pixels, &grid, settings) {
            Some(section) => {
                sections.push(section);
                let label = sections.len() as u32;
                for [x, y] in sections[sections.len() - 1].pixels() {
                    if let Some(i) = grid.index(x, y) {
                        kept[i] = label;
                    }
                }
            }
            None => left_out += 1,
        }
    }
    let covered = mask.iter().filter(|&&m| m).count();
    let fraction = covered as f32 / mask.len() as f32;
    let thickness = thickness(&kept, mask, &grid, control)?;
    Ok(Sections { view: view.clone(), mask: mask.to_vec(), sections, left_out, fraction, thickness })
}

/// The pixels of a picture and who is next to whom.
struct Grid {
    w: i32,
    h: i32,
    tileable: bool,
}

impl Grid {
    /// The index of a pixel; around the edges if tileable.
    fn index(&self, x: i32, y: i32) -> Option<usize> {
        let (x, y) = if self.tileable { (x.rem_euclid(self.w), y.rem_euclid(self.h)) } else { (x, y) };
        ((0..self.w).contains(&x) && (0..self.h).contains(&y)).then(|| (y * self.w + x) as usize)
    }
}

const FOUR: [[i32; 2]; 4] = [[1, 0], [-1, 0], [0, 1], [0, -1]];

/// The pixels of one label connected along rows and columns to `start`, in coordinates that go on beyond a tileable picture's
/// edges.
fn component(labels: &[u32], grid: &Grid, start: usize, seen: &mut [bool]) -> Vec<[i32; 2]> {
    let mut pixels = vec![[start as i32 % grid.w, start as i32 / grid.w]];
    seen[start] = true;
    let mut next = 0;
    while let Some(&[x, y]) = pixels.get(next) {
        next += 1;
        for [dx, dy] in FOUR {
            if let Some(i) = grid.index(x + dx, y + dy)
                && !seen[i]
                && labels[i] == labels[start]
            {
                seen[i] = true;
                pixels.push([x + dx, y + dy]);
            }
        }
    }
    pixels
}

/// The section of a component, unless it is to be left out.
fn section(mut pixels: Vec<[i32; 2]>, grid: &Grid, settings: &SectionSettings) -> Option<Section> {
    let touches =
        |edge: usize| pixels.iter().any(|&[x, y]| [x == 0, x == grid.w - 1, y == 0, y == grid.h - 1][edge]);
    let edges: Vec<usize> = if grid.tileable { Vec::new() } else { (0..4).filter(|&e| touches(e)).collect() };
    match (settings.border, &edges[..]) {
        (_, []) | (Border::Keep, _) => {}
        (Border::Complete, &[edge]) => {
            let mirrored = pixels.iter().map(|&[x, y]| match edge {
                0 => [-1 - x, y],
                1 => [2 * grid.w - 1 - x, y],
                2 => [x, -1 - y],
                _ => [x, 2 * grid.h - 1 - y],
            });
            let mirrored: Vec<_> = mirrored.collect();
            pixels.extend(mirrored);
        }
        _ => return None,
    }
    let mut section = Section::of(&pixels, !edges.is_empty())?;
    fill_holes(&mut section);
    let most = settings.most * f64::from(grid.w) * f64::from(grid.h);
    (section.area >= settings.least && f64::from(section.area) <= most).then_some(section)
}

/// Adds what a section encloses.
fn fill_holes(section: &mut Section) {
    let [w, h] = section.size.map(|n| n as i32);
    let mut outside = vec![false; section.inside.len()];
    let border = (0..w).flat_map(|x| [[x, 0], [x, h - 1]]).chain((0..h).flat_map(|y| [[0, y], [w - 1, y]]));
    let mut queue: Vec<[i32; 2]> = border.collect();
    while let Some([x, y]) = queue.pop() {
        if !(0..w).contains(&x) || !(0..h).contains(&y) {
            continue;
        }
        let at = (y * w + x) as usize;
        if outside[at] || section.inside[at] {
            continue;
        }
        outside[at] = true;
        queue.extend(FOUR.map(|[dx, dy]| [x + dx, y + dy]));
    }
    let pixels: Vec<[i32; 2]> = (0..outside.len())
        .filter(|&i| !outside[i])
        .map(|i| [section.low[0] + i as i32 % w, section.low[1] + i as i32 / w])
        .collect();
    if let Some(filled) = Section::of(&pixels, section.cut) {
        *section = filled;
    }
}

/// Splits touching particles along the watershed of the distance to the matrix. Basins are flooded from their deepest pixels;
/// where two meet they stay apart if the neck is thinner than `split` times the shallower of the two, else they are one.
fn basins(mask: &[bool], grid: &Grid, split: f64) -> Vec<u32> {
    let depth = signed_distance(mask, grid.w as usize, grid.h as usize, grid.tileable);
    let mut order: Vec<usize> = (0..mask.len()).filter(|&i| mask[i]).collect();
    order.sort_by(|&a, &b| depth[b].total_cmp(&depth[a]).then(a.cmp(&b)));
    let mut basin = vec![0u32; mask.len()];
    let (mut parent, mut peak) = (vec![0u32], vec![0.0f32]);
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    for &i in &order {
        let (x, y) = (i as i32 % grid.w, i as i32 / grid.w);
        let mut around = Vec::new();
        for dy in -1..=1 {
            for dx in -1..=1 {
                if let Some(j) = grid.index(x + dx, y + dy)
                    && basin[j] != 0
                {
                    around.push(root(&mut parent, basin[j]));
                }
            }
        }
        around.sort_by(|&a, &b| peak[b as usize].total_cmp(&peak[a as usize]).then(a.cmp(&b)));
        around.dedup();
        let Some((&deepest, others)) = around.split_first() else {
            let new = parent.len() as u32;
            parent.push(new);
            peak.push(depth[i]);
            basin[i] = new;
            continue;
        };
        for &other in others {
            if f64::from(depth[i]) > split * f64::from(peak[other as usize]) {
                parent[other as usize] = deepest;
            }
        }
        basin[i] = deepest;
    }
    basin.iter().map(|&b| if b == 0 { 0 } else { root(&mut parent, b) }).collect()
}

/// The mean over sections of how thin the matrix is where it is thinnest between them and another. (Where particles lie far apart
/// the mean over all of the matrix would say little about how near they may come.)
fn thickness(labels: &[u32], mask: &[bool], grid: &Grid, control: &dyn Control) -> Result<f32, Cancelled> {
    let (w, h) = (grid.w as usize, grid.h as usize);
    // Particles that were left out bound the matrix too.
    let all: Vec<u32> =
        labels.iter().zip(mask).map(|(&l, &m)| if l == 0 && m { u32::MAX } else { l }).collect();
    let found = cells(&all, [w, h, 1], grid.tileable, control)?;
    let mut least: BTreeMap<u32, f64> = BTreeMap::new();
    for i in 0..all.len() {
        let (x, y) = (i as i32 % grid.w, i as i32 / grid.w);
        for [dx, dy] in [[1, 0], [0, 1]] {
            let Some(j) = grid.index(x + dx, y + dy) else { continue };
            if all[i] != 0 || found.owner[i] == found.owner[j] {
                continue;
            }
            // Half a pixel less than to the centre of the particle's first pixel, on both sides, and the step between.
            let depth = |k: usize| libm::sqrt(f64::from(found.squared[k])) - 0.5;
            let gap = if all[j] == 0 { depth(i) + depth(j) + 1.0 } else { depth(i) + 0.5 };
            for owner in [found.owner[i], found.owner[j]] {
                let entry = least.entry(owner).or_insert(gap);
                *entry = entry.min(gap);
            }
        }
    }
    least.remove(&u32::MAX);
    Ok(if least.is_empty() { 1.0 } else { (least.values().sum::<f64>() / least.len() as f64) as f32 })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(w: u32, h: u32, tileable: bool) -> View {
        let color = crate::data::Image::from_fn(w, h, |x, y| [x as u8, y as u8, 0]);
        let texels = vec![[0; 4]; (w * h) as usize];
        let carried = vec![("color".to_owned(), color)];
        View { width: w, height: h, texels, carried, tileable, guided: true, barred: Vec::new() }
    }

    fn disc(x: i32, y: i32, cx: i32, cy: i32, r: i32) -> bool {
        (x - cx).pow(2) + (y - cy).pow(2) <= r * r
    }

    fn mask(w: i32, h: i32, inside: impl Fn(i32, i32) -> bool) -> Vec<bool> {
        (0..w * h).map(|i| inside(i % w, i / w)).collect()
    }

    #[test]
    fn touching_discs_are_split_and_long_ones_are_not() {
        let (w, h) = (60, 40);
        let two = mask(w, h, |x, y| disc(x, y, 20, 20, 9) || disc(x, y, 36, 20, 9));
        let long = mask(w, h, |x, y| (12..48).contains(&x) && (14..26).contains(&y));
        let count = |mask: &[bool], split| {
            let settings = SectionSettings { split, ..SectionSettings::default() };
            find_sections(&view(60, 40, false), mask, &settings, &()).unwrap().sections.len()
        };
        assert_eq!((count(&two, 0.0), count(&two, 0.6)), (1, 2));
        assert_eq!((count(&long, 0.0), count(&long, 0.6)), (1, 1));
    }

    #[test]
    fn holes_are_filled_and_the_border_is_a_choice() {
        let (w, h) = (50, 50);
        let ring = |x: i32, y: i32| disc(x, y, 25, 25, 10) && !disc(x, y, 25, 25, 4);
        let mask = mask(w, h, |x, y| ring(x, y) || disc(x, y, 0, 10, 6) || disc(x, y, 0, 49, 6));
        let found = |border| {
            let settings = SectionSettings { border, ..SectionSettings::default() };
            find_sections(&view(50, 50, false), &mask, &settings, &()).unwrap()
        };
        let whole = mask.len() as f32;
        let dropped = found(Border::Drop);
        assert_eq!((dropped.sections.len(), dropped.left_out), (1, 2));
        assert_eq!(
            dropped.sections[0].area as i32,
            (0..50 * 50).filter(|i| disc(i % 50, i / 50, 25, 25, 10)).count() as i32
        );
        assert_eq!(found(Border::Keep).sections.len(), 3);
        let complete = found(Border::Complete);
        assert_eq!((complete.sections.len(), complete.left_out), (2, 1));
        let full = complete.sections.iter().find(|s| s.cut).unwrap();
        assert_eq!(full.size, [14, 13]);
        assert!((complete.fraction * whole - dropped.fraction * whole).abs() < 0.5);
    }

    #[test]
    fn a_tileable_picture_joins_its_edges() {
        let wrapped = mask(40, 40, |x, y| disc((x + 20) % 40, y, 20, 20, 8));
        let found = find_sections(&view(40, 40, true), &wrapped, &SectionSettings::default(), &()).unwrap();
        assert_eq!(found.sections.len(), 1);
        assert_eq!(found.sections[0].size, [17, 17]);
    }

    #[test]
    fn the_thickness_of_parallel_bars_is_their_distance() {
        let bars = mask(64, 64, |x, _| x % 16 < 11);
        let settings = SectionSettings { border: Border::Keep, ..SectionSettings::default() };
        let found = find_sections(&view(64, 64, false), &bars, &settings, &()).unwrap();
        assert!((found.thickness - 5.0).abs() < 1.0, "{}", found.thickness);
    }
}
