//! How well a packing resembles the pictures it was made of: fractions, sizes of cross-sections, directions between neighbours.

use rayon::prelude::*;

use super::anatomy::Anatomy;
use super::axes::AXES;
use super::index::Index;
use super::packing::Packing;
use super::quota::stands_for;
use super::section::Sections;
use crate::control::{Cancelled, Control, check};
use crate::data::{BRICK, Curves, Plot, Report, Row, Series};

/// Sectors of half a circle in the histogram of directions.
const SECTORS: usize = 12;
/// Nearest cross-sections whose directions count.
const NEAR: usize = 6;
/// Layers from one slice to the next.
const EVERY: usize = 4;

/// A cross-section of a particle in a slice, or of a picture.
#[derive(Clone, Copy)]
struct Cut {
    area: f64,
    center: [f64; 2],
    /// How many it stands for: large ones at the border of a picture are left out more often (Miles 1974).
    weight: f64,
}

/// Compares the slices of a packing with its pictures, view by view.
///
/// # Errors
/// [`Cancelled`].
pub fn likeness(packing: &Packing, control: &dyn Control) -> Result<(Report, Curves), Cancelled> {
    let labels = labels(packing, control)?;
    control.progress(0.4);
    let set = &packing.set;
    let filled = labels.iter().filter(|&&label| label != 0).count() as f64 / labels.len() as f64;
    let mut report = Report::new("Likeness of particles");
    let mut curves = Curves::new("Sizes of particles");
    let row = |name: String, value: f64, unit: &str, reference: Option<f64>, good: Option<[f64; 2]>| Row {
        name,
        value,
        unit: unit.to_owned(),
        reference,
        good,
    };
    let fraction = set.fraction();
    let good = Some([fraction - 0.03, fraction + 0.03]);
    report.rows.push(row("volume_fraction".into(), filled, "fraction of the domain", Some(fraction), good));
    let mut sum = [0.0; 2];
    for v in 0..3 {
        check(control)?;
        let own = of_picture(set.view(v));
        let slices = slices(packing, &labels, v, set.view(v));
        let found: Vec<Cut> = slices.iter().flatten().copied().collect();
        let distance = kolmogorov_smirnov(&own, &found);
        let view = &set.view(v).view;
        let size = [view.width, view.height].map(f64::from);
        let turns = [
            directions(std::slice::from_ref(&own), size, view.tileable),
            directions(&slices, AXES[v].map(|a| f64::from(packing.size[a])), packing.wrap),
        ];
        let turned = 0.5 * (0..SECTORS).map(|s| (turns[0][s] - turns[1][s]).abs()).sum::<f64>();
        let axis = ["x", "y", "z"][v];
        report.rows.push(row(format!("section_size_ks_{axis}"), distance, "1", None, Some([0.0, 0.15])));
        report.rows.push(row(format!("direction_distance_{axis}"), turned, "1", None, Some([0.0, 0.2])));
        sum[0] += distance / 3.0;
        sum[1] += turned / 3.0;
        let series = |name: &str, cuts: &[Cut]| Series { name: name.into(), points: cumulative(cuts) };
        curves.plots.push(Plot::new(
            format!("Cross-sections normal to {axis}"),
            "area (pixels)",
            "fraction that is smaller",
            vec![series("picture", &own), series("solid", &found)],
        ));
    }
    report.rows.push(row("section_size_ks".into(), sum[0], "1, mean of the views", None, Some([0.0, 0.15])));
    report.rows.push(row(
        "direction_distance".into(),
        sum[1],
        "1, mean of the views",
        None,
        Some([0.0, 0.2]),
    ));
    control.progress(0.8);
    let anatomies: Vec<Anatomy> =
        packing.placed.par_iter().filter_map(|placed| Anatomy::of(&packing.bits(placed))).collect();
    let mean =
        |f: &dyn Fn(&Anatomy) -> f64| anatomies.iter().map(f).sum::<f64>() / anatomies.len().max(1) as f64;
    let volume = mean(&|a| a.volume);
    let spread = libm::sqrt(mean(&|a| (a.volume - volume) * (a.volume - volume)));
    report.row("particles", packing.placed.len() as f64, "count");
    report.row("mean_volume", volume, "voxels");
    report.row("volume_spread", spread / volume.max(1e-9), "standard deviation against the mean");
    report.row("sphericity", mean(&Anatomy::sphericity), "1 for balls, less for all else");
    report.row("elongation", mean(&|a| a.axes[0] / a.axes[2].max(1e-9)), "longest axis against shortest");
    let mut volumes: Vec<Cut> =
        anatomies.iter().map(|a| Cut { area: a.volume, center: [0.0; 2], weight: 1.0 }).collect();
    volumes.sort_by(|a, b| a.area.total_cmp(&b.area));
    let points = cumulative(&volumes);
    let series = vec![Series { name: "solid".into(), points }];
    curves.plots.push(Plot::new("Volumes", "volume (voxels)", "fraction that is smaller", series));
    Ok((report, curves))
}

/// The particle of every voxel of the domain, x fastest.
fn labels(packing: &Packing, control: &dyn Control) -> Result<Vec<u32>, Cancelled> {
    let index = Index::new(packing);
    let [nx, ny, nz] = packing.size.map(|n| n as usize);
    let mut labels = vec![0u32; nx * ny * nz];
    labels.par_chunks_mut(nx * ny * BRICK as usize).enumerate().try_for_each(|(bz, slab)| {
        for by in 0..ny.div_ceil(8) {
            check(control)?;
            for bx in 0..nx.div_ceil(8) {
                let brick = index.label_brick(packing, [bx, by, bz].map(|b| b as i32));
                for (at, &(label, _)) in brick.iter().enumerate() {
                    let [x, y, z] = [bx * 8 + (at & 7), by * 8 + (at >> 3 & 7), at >> 6];
                    if x < nx && y < ny && (z * ny + y) * nx + x < slab.len() {
                        slab[(z * ny + y) * nx + x] = label;
                    }
                }
            }
        }
        Ok(())
    })?;
    Ok(labels)
}

/// The cross-sections of a picture.
fn of_picture(of: &Sections) -> Vec<Cut> {
    let cuts = of.sections.iter().map(|s| Cut {
        area: s.area.into(),
        center: s.centroid.map(f64::from),
        weight: stands_for(of, s.size),
    });
    cuts.collect()
}

/// Of a particle in a slice: pixels, sums of offsets from its first pixel, that pixel, bounds of the offsets.
type Tally = (u32, [i64; 2], [i64; 2], [i64; 4]);

/// The cross-sections in every fourth slice across an axis; as small ones are left out as in the picture, and in a domain that
/// ends those that its border cuts.
fn slices(packing: &Packing, labels: &[u32], axis: usize, like: &Sections) -> Vec<Vec<Cut>> {
    let size = packing.size.map(|n| n as usize);
    let [u, w] = AXES[axis];
    let least = like.sections.iter().map(|s| s.area).min().unwrap_or(1);
    (0..size[axis])
        .step_by(EVERY)
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|layer| {
            let mut found: std::collections::BTreeMap<u32, Tally> = Default::default();
            for j in 0..size[w] {
                for i in 0..size[u] {
                    let mut at = [0; 3];
                    (at[axis], at[u], at[w]) = (layer, i, j);
                    let label = labels[(at[2] * size[1] + at[1]) * size[0] + at[0]];
                    if label == 0 {
                        continue;
                    }
                    let place = [i as i64, j as i64];
                    let entry = found.entry(label).or_insert((0, [0; 2], place, [0; 4]));
                    entry.0 += 1;
                    for (k, edge) in [size[u], size[w]].into_iter().enumerate() {
                        let n = edge as i64;
                        let d = place[k] - entry.2[k];
                        let d = if packing.wrap { (d + n / 2).rem_euclid(n) - n / 2 } else { d };
                        entry.1[k] += d;
                        entry.3[2 * k] = entry.3[2 * k].min(d);
                        entry.3[2 * k + 1] = entry.3[2 * k + 1].max(d);
                    }
                }
            }
            let edges = [size[u] as i64, size[w] as i64];
            let cut = |(area, sum, first, bounds): &Tally| {
                let border = !packing.wrap
                    && (0..2).any(|k| {
                        first[k] + bounds[2 * k] <= 0 || first[k] + bounds[2 * k + 1] >= edges[k] - 1
                    });
                let weight = (0..2).map(|k| {
                    let extent = (bounds[2 * k + 1] - bounds[2 * k] + 1) as f64;
                    if packing.wrap { 1.0 } else { (1.0 - extent / edges[k] as f64).max(0.05) }
                });
                let center = [0, 1].map(|k| first[k] as f64 + sum[k] as f64 / f64::from(*area));
                (!border && *area >= least).then(|| Cut {
                    area: f64::from(*area),
                    center,
                    weight: 1.0 / weight.product::<f64>(),
                })
            };
            found.values().filter_map(cut).collect()
        })
        .collect()
}

/// The largest difference of the cumulative distributions of areas, 0 to 1.
fn kolmogorov_smirnov(a: &[Cut], b: &[Cut]) -> f64 {
    let total = |cuts: &[Cut]| cuts.iter().map(|c| c.weight).sum::<f64>();
    let (ta, tb) = (total(a), total(b));
    if ta == 0.0 || tb == 0.0 {
        return 1.0;
    }
    let mut all: Vec<(f64, f64)> =
        a.iter().map(|c| (c.area, c.weight / ta)).chain(b.iter().map(|c| (c.area, -c.weight / tb))).collect();
    all.sort_by(|x, y| x.0.total_cmp(&y.0));
    let (mut difference, mut largest) = (0.0, 0.0f64);
    for (i, (area, step)) in all.iter().enumerate() {
        difference += step;
        // Equal areas step together.
        if all.get(i + 1).is_none_or(|next| next.0 > *area) {
            largest = largest.max(f64::abs(difference));
        }
    }
    largest
}

/// The cumulative distribution of areas at a hundred places.
fn cumulative(cuts: &[Cut]) -> Vec<[f64; 2]> {
    let mut sorted: Vec<(f64, f64)> = cuts.iter().map(|c| (c.area, c.weight)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = sorted.iter().map(|s| s.1).sum();
    let every = sorted.len().div_ceil(100).max(1);
    let mut sum = 0.0;
    let points = sorted.iter().map(|&(area, weight)| {
        sum += weight / total;
        [area, sum]
    });
    let points: Vec<[f64; 2]> = points.collect();
    points.iter().enumerate().filter(|(i, _)| (i + 1) % every == 0).map(|(_, p)| *p).collect()
}

/// How often the nearest cross-sections lie in each direction.
fn directions(slices: &[Vec<Cut>], size: [f64; 2], wrap: bool) -> [f64; SECTORS] {
    let mut counts = [0.0; SECTORS];
    for cuts in slices {
        for (i, one) in cuts.iter().enumerate() {
            let offset = |other: &Cut| -> [f64; 2] {
                std::array::from_fn(|k| {
                    let d = other.center[k] - one.center[k];
                    if wrap { d - size[k] * libm::round(d / size[k]) } else { d }
                })
            };
            let mut near: Vec<(f64, [f64; 2])> = cuts
                .iter()
                .enumerate()
                .filter(|(j, _)| *j != i)
                .map(|(_, other)| {
                    let d = offset(other);
                    (d[0] * d[0] + d[1] * d[1], d)
                })
                .collect();
            if near.len() > NEAR {
                near.select_nth_unstable_by(NEAR, |a, b| a.0.total_cmp(&b.0));
                near.truncate(NEAR);
            }
            for (_, d) in near {
                let angle = libm::atan2(d[1], d[0]).rem_euclid(std::f64::consts::PI);
                counts[((angle / std::f64::consts::PI * SECTORS as f64) as usize).min(SECTORS - 1)] += 1.0;
            }
        }
    }
    let total: f64 = counts.iter().sum();
    counts.map(|c| c / total.max(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cuts(areas: &[f64]) -> Vec<Cut> {
        areas.iter().map(|&area| Cut { area, center: [0.0; 2], weight: 1.0 }).collect()
    }

    #[test]
    fn equal_distributions_are_at_distance_nought_and_disjoint_ones_at_one() {
        let a = cuts(&[1.0, 2.0, 2.0, 5.0]);
        assert!(kolmogorov_smirnov(&a, &cuts(&[2.0, 5.0, 1.0, 2.0, 1.0, 2.0, 2.0, 5.0])) < 1e-9);
        assert!((kolmogorov_smirnov(&a, &cuts(&[6.0, 7.0])) - 1.0).abs() < 1e-9);
        assert!((kolmogorov_smirnov(&a, &cuts(&[1.0, 2.0, 2.0, 9.0])) - 0.25).abs() < 1e-9);
        assert_eq!(kolmogorov_smirnov(&a, &[]), 1.0);
    }

    #[test]
    fn a_row_has_one_direction() {
        let row =
            (0..9).map(|i| Cut { area: 1.0, center: [f64::from(i) * 10.0, 0.0], weight: 1.0 }).collect();
        let found = directions(&[row], [90.0, 90.0], true);
        assert!(found[0] > 0.99, "{found:?}");
    }
}
