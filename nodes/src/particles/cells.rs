//! Discrete Voronoi cells: for every place of a grid the nearest labelled place (Du et al. 2013, section 3.4).

use rayon::prelude::*;

use crate::control::{Cancelled, Control, check};

/// For every place of a grid (x fastest) the label of the nearest labelled place, and the squared distance to it.
///
/// A grid of one layer is a picture.
#[derive(Clone, Debug)]
pub struct Cells {
    /// The label, 0 if the grid has none at all.
    pub owner: Vec<u32>,
    /// The squared Euclidean distance between the centres of the places.
    pub squared: Vec<u32>,
}

/// A stand-in for infinity that can be squared and added without overflow.
const FAR: u32 = 1 << 30;

/// The exact cells of the labelled places (label 0 is empty) of a grid of `size` places along x, y and z, around its
/// ends if `wrap`. Separable: each axis takes the lower envelope of the parabolas that the axes before left
/// (Felzenszwalb & Huttenlocher 2012), and carries the labels along. Of two places equally near, either may win, but always the
/// same.
///
/// # Errors
/// [`Cancelled`].
pub fn cells(
    labels: &[u32],
    size: [usize; 3],
    wrap: bool,
    control: &dyn Control,
) -> Result<Cells, Cancelled> {
    let mut owner = labels.to_vec();
    let mut squared: Vec<u32> = labels.iter().map(|&label| if label == 0 { FAR } else { 0 }).collect();
    let [nx, ny, nz] = size;
    // Lines along x lie together.
    owner.par_chunks_mut(nx).zip(squared.par_chunks_mut(nx)).try_for_each(|(owner, squared)| {
        check(control)?;
        envelope(owner, squared, wrap);
        Ok(())
    })?;
    if ny > 1 {
        owner.par_chunks_mut(nx * ny).zip(squared.par_chunks_mut(nx * ny)).try_for_each(
            |(owner, squared)| {
                check(control)?;
                let (mut labels, mut line) = (vec![0; ny], vec![0; ny]);
                for x in 0..nx {
                    for y in 0..ny {
                        (labels[y], line[y]) = (owner[y * nx + x], squared[y * nx + x]);
                    }
                    envelope(&mut labels, &mut line, wrap);
                    for y in 0..ny {
                        (owner[y * nx + x], squared[y * nx + x]) = (labels[y], line[y]);
                    }
                }
                Ok(())
            },
        )?;
    }
    if nz > 1 {
        let layer = nx * ny;
        // Lines along z cross all layers: one row of them at a time, gathered, then written back in order.
        let rows: Vec<(Vec<u32>, Vec<u32>)> = (0..ny)
            .into_par_iter()
            .map(|y| {
                check(control)?;
                let (mut labels, mut line) = (vec![0; nx * nz], vec![0; nx * nz]);
                for z in 0..nz {
                    for x in 0..nx {
                        labels[x * nz + z] = owner[z * layer + y * nx + x];
                        line[x * nz + z] = squared[z * layer + y * nx + x];
                    }
                }
                for (labels, line) in labels.chunks_mut(nz).zip(line.chunks_mut(nz)) {
                    envelope(labels, line, wrap);
                }
                Ok((labels, line))
            })
            .collect::<Result<_, Cancelled>>()?;
        owner.par_chunks_mut(layer).zip(squared.par_chunks_mut(layer)).enumerate().for_each(
            |(z, (owner, squared))| {
                for (y, (labels, line)) in rows.iter().enumerate() {
                    for x in 0..nx {
                        owner[y * nx + x] = labels[x * nz + z];
                        squared[y * nx + x] = line[x * nz + z];
                    }
                }
            },
        );
    }
    Ok(Cells { owner, squared })
}

/// Replaces a line by `min over q of f(q) + (p − q)²` and the labels where that minimum lies.
fn envelope(labels: &mut [u32], f: &mut [u32], wrap: bool) {
    let n = f.len() as i64;
    if f.iter().all(|&d| d >= FAR) {
        return;
    }
    let (from, to) = if wrap { (-(n / 2) - 1, n + n / 2 + 1) } else { (0, n) };
    let at = |q: i64| q.rem_euclid(n) as usize;
    let (mut hull, mut starts): (Vec<i64>, Vec<i64>) = (Vec::new(), Vec::new());
    for q in from..to {
        let value = i64::from(f[at(q)]);
        if value >= i64::from(FAR) {
            continue;
        }
        let mut start = i64::MIN;
        while let Some(&top) = hull.last() {
            // The first whole place where q is strictly nearer than the top of the hull.
            let other = i64::from(f[at(top)]);
            let above = (value + q * q) - (other + top * top);
            start = above.div_euclid(2 * (q - top)) + 1;
            if starts.last().is_some_and(|&s| start <= s) {
                hull.pop();
                starts.pop();
                start = i64::MIN;
            } else {
                break;
            }
        }
        hull.push(q);
        starts.push(start);
    }
    let mut k = 0;
    let found: Vec<(u32, u32)> = (0..n)
        .map(|p| {
            while k + 1 < hull.len() && starts[k + 1] <= p {
                k += 1;
            }
            let q = hull[k];
            let distance = i64::from(f[at(q)]) + (p - q) * (p - q);
            (labels[at(q)], distance.min(i64::from(FAR)) as u32)
        })
        .collect();
    for (p, (label, distance)) in found.into_iter().enumerate() {
        (labels[p], f[p]) = (label, distance);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_equal_a_brute_force_search() {
        let size = [11usize, 7, 9];
        let count = size.iter().product::<usize>();
        let labels: Vec<u32> =
            (0..count as u32).map(|i| if (i * 7919 + 13) % 97 < 3 { i + 1 } else { 0 }).collect();
        for wrap in [false, true] {
            let found = cells(&labels, size, wrap, &()).unwrap();
            let place = |i: usize| [i % size[0], i / size[0] % size[1], i / size[0] / size[1]];
            let squared = |a: usize, b: usize| -> u32 {
                let (a, b) = (place(a), place(b));
                (0..3)
                    .map(|k| {
                        let d = a[k].abs_diff(b[k]);
                        (if wrap { d.min(size[k] - d) } else { d }).pow(2) as u32
                    })
                    .sum()
            };
            for i in 0..count {
                let seeds = || (0..count).filter(|&j| labels[j] != 0);
                let least = seeds().map(|j| squared(i, j)).min().unwrap();
                assert_eq!(found.squared[i], least, "{wrap} {i}");
                assert!(seeds().any(|j| labels[j] == found.owner[i] && squared(i, j) == least));
            }
        }
    }

    #[test]
    fn a_grid_without_labels_has_no_owners() {
        let found = cells(&[0; 60], [5, 4, 3], true, &()).unwrap();
        assert!(found.owner.iter().all(|&owner| owner == 0));
    }
}
