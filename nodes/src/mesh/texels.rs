//! Which triangle covers which texel, and which covered texel is nearest to an uncovered one.

use rayon::prelude::*;

use crate::data::Mesh;

/// Stands for no triangle and no texel.
pub const NONE: u32 = u32::MAX;

/// Rows that one thread fills at a time.
const BAND: usize = 16;

/// The triangle that covers each texel's centre, or [`NONE`]; rows from top to bottom.
///
/// Where charts overlap, the triangle of lowest number wins. A triangle too small to hold a texel's centre
/// takes the texel its centroid lies in if that is free, so that no chart stays without a texel.
pub fn cover(uvs: &[[f32; 2]], triangles: &[[u32; 3]], size: usize) -> Vec<u32> {
    let corners = |t: &[u32; 3]| -> Option<[[f64; 2]; 3]> {
        let mut out = [[0.0; 2]; 3];
        for (out, &i) in out.iter_mut().zip(t) {
            *out = uvs.get(i as usize)?.map(|c| f64::from(c) * size as f64);
            out.iter().all(|c| c.is_finite()).then_some(())?;
        }
        Some(out)
    };
    let mut bands = vec![Vec::new(); size.div_ceil(BAND)];
    for (t, triangle) in triangles.iter().enumerate() {
        let Some(corners) = corners(triangle) else { continue };
        let (lo, hi) = extremes(corners.map(|c| c[1]));
        if hi < 0.0 || bands.is_empty() {
            continue;
        }
        let last = (hi as usize / BAND).min(bands.len() - 1);
        for band in bands.iter_mut().take(last + 1).skip(lo.max(0.0) as usize / BAND) {
            band.push((t as u32, corners));
        }
    }
    let mut owner = vec![NONE; size * size];
    owner.par_chunks_mut((BAND * size).max(1)).zip(&bands).enumerate().for_each(
        |(band, (rows, triangles))| {
            for (t, corners) in triangles {
                for (row, texels) in rows.chunks_exact_mut(size).enumerate() {
                    let y = (band * BAND + row) as f64 + 0.5;
                    let Some((from, to)) = span(corners, y, size) else { continue };
                    for texel in &mut texels[from..to] {
                        if *texel == NONE {
                            *texel = *t;
                        }
                    }
                }
            }
        },
    );
    let mut covered = vec![false; triangles.len()];
    for &t in &owner {
        if let Some(covered) = covered.get_mut(t as usize) {
            *covered = true;
        }
    }
    for (t, triangle) in triangles.iter().enumerate().filter(|&(t, _)| !covered[t]) {
        let Some(corners) = corners(triangle) else { continue };
        let [x, y] =
            [0, 1].map(|i| ((corners[0][i] + corners[1][i] + corners[2][i]) / 3.0).max(0.0) as usize);
        let texel = &mut owner[y.min(size - 1) * size + x.min(size - 1)];
        if *texel == NONE {
            *texel = t as u32;
        }
    }
    owner
}

fn extremes(values: [f64; 3]) -> (f64, f64) {
    (values[0].min(values[1]).min(values[2]), values[0].max(values[1]).max(values[2]))
}

/// The texels of row centre `y` whose centres lie in the triangle, edges included.
fn span(corners: &[[f64; 2]; 3], y: f64, size: usize) -> Option<(usize, usize)> {
    let [a, b, c] = *corners;
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if area == 0.0 {
        return None;
    }
    let (y_lo, y_hi) = extremes([a[1], b[1], c[1]]);
    if y < y_lo || y > y_hi {
        return None;
    }
    let (mut from, mut to) = extremes([a[0], b[0], c[0]]);
    for [p, q] in [[a, b], [b, c], [c, a]] {
        let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
        if dy == 0.0 {
            continue;
        }
        let x = p[0] + dx * ((y - p[1]) / dy);
        // With positive area (clockwise on screen, y down) the inside lies right of rising edges.
        if (dy < 0.0) == (area > 0.0) { from = from.max(x) } else { to = to.min(x) }
    }
    // Texel x has its centre at x + 0.5. The slack lets both triangles at an edge reach its centres.
    const SLACK: f64 = 1e-7;
    let first = (from - 0.5 - SLACK).ceil().max(0.0);
    let last = (to - 0.5 + SLACK).floor().min(size as f64 - 1.0);
    (first <= last).then(|| (first as usize, last as usize + 1))
}

/// The surface position of a texel's centre on a triangle; centres outside it take a point on its edge.
pub fn position(mesh: &Mesh, triangle: u32, texel: usize, size: usize) -> [f64; 3] {
    let corners = mesh.triangles.get(triangle as usize).copied().unwrap_or_default();
    let get = |i: u32| {
        let uv = mesh.uvs.get(i as usize).copied().unwrap_or_default();
        (uv.map(|c| f64::from(c) * size as f64), mesh.positions.get(i as usize).copied().unwrap_or_default())
    };
    let [(a, pa), (b, pb), (c, pc)] = corners.map(get);
    let p = [(texel % size) as f64 + 0.5, (texel / size) as f64 + 0.5];
    let cross =
        |u: [f64; 2], v: [f64; 2], w: [f64; 2]| (v[0] - u[0]) * (w[1] - u[1]) - (v[1] - u[1]) * (w[0] - u[0]);
    let area = cross(a, b, c);
    let mut weights = [1.0 / 3.0; 3];
    if area != 0.0 {
        let inside = [cross(p, b, c), cross(p, c, a), cross(p, a, b)].map(|w| (w / area).max(0.0));
        let sum: f64 = inside.iter().sum();
        if sum.is_finite() && sum > 0.0 {
            weights = inside.map(|w| w / sum);
        }
    }
    std::array::from_fn(|i| {
        f64::from(pa[i]) * weights[0] + f64::from(pb[i]) * weights[1] + f64::from(pc[i]) * weights[2]
    })
}

/// The covered texel nearest to each texel and at most `reach` texels away, or [`NONE`].
///
/// Distances are Euclidean and exact; of equally near texels the upper, then the left one is taken.
pub fn nearest_covered(owner: &[u32], size: usize, reach: u32) -> Vec<u32> {
    let reach = reach as usize;
    // In each row first: the column of the nearest covered texel.
    let mut columns = vec![NONE; owner.len()];
    columns.par_chunks_mut(size.max(1)).zip(owner.par_chunks(size.max(1))).for_each(|(columns, owner)| {
        let mut last = None;
        for x in 0..owner.len() {
            if owner[x] != NONE {
                last = Some(x);
            }
            if let Some(l) = last.filter(|l| x - l <= reach) {
                columns[x] = l as u32;
            }
        }
        let mut next = None;
        for x in (0..owner.len()).rev() {
            if owner[x] != NONE {
                next = Some(x);
            }
            if let Some(n) = next.filter(|n| n - x <= reach)
                && (columns[x] == NONE || n - x < x - columns[x] as usize)
            {
                columns[x] = n as u32;
            }
        }
    });
    let mut nearest = vec![NONE; owner.len()];
    nearest.par_chunks_mut(size.max(1)).enumerate().for_each(|(y, nearest)| {
        for (x, nearest) in nearest.iter_mut().enumerate() {
            if owner[y * size + x] != NONE {
                *nearest = (y * size + x) as u32;
                continue;
            }
            let mut best = reach * reach + 1;
            for row in y.saturating_sub(reach)..=(y + reach).min(size - 1) {
                let column = columns[row * size + x];
                if column == NONE {
                    continue;
                }
                let distance = row.abs_diff(y).pow(2) + x.abs_diff(column as usize).pow(2);
                if distance < best {
                    best = distance;
                    *nearest = (row * size) as u32 + column;
                }
            }
        }
    });
    nearest
}
