//! Feature distance: how far a pixel lies inside or outside the features of a picture, as one more channel
//! to match. It keeps structures whole that colours alone leave ambiguous (Kopf et al. 2007, section 3;
//! Dong et al. 2008, section 6).

use crate::data::Image;

/// Where the feature mask comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// The mask where one is given, else none.
    Mask,
    /// The mask where one is given, else a threshold on luminance (Otsu 1979).
    Auto,
    /// No feature channel.
    None,
}

/// Luminance of an sRGB colour in its own encoding, 0 to 255 (Rec. 601 weights, in integers).
pub(crate) fn luminance([r, g, b]: [u8; 3]) -> u8 {
    ((u32::from(r) * 77 + u32::from(g) * 150 + u32::from(b) * 29) >> 8) as u8
}

/// The threshold on luminance that separates two classes best (Otsu 1979), after a 3 × 3 box blur:
/// `true` where brighter. `None` for a picture of a single luminance.
pub fn otsu_mask(color: &Image) -> Option<Vec<bool>> {
    let (w, h) = (color.width() as i32, color.height() as i32);
    let raw: Vec<u8> =
        (0..h).flat_map(|y| (0..w).map(move |x| luminance(color.rgb8(x as u32, y as u32)))).collect();
    let blurred: Vec<u8> = (0..w * h)
        .map(|i| {
            let at = |x: i32, y: i32| u32::from(raw[(y.clamp(0, h - 1) * w + x.clamp(0, w - 1)) as usize]);
            let (x, y) = (i % w, i / w);
            ((-1..=1)
                .flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)))
                .map(|(dx, dy)| at(x + dx, y + dy))
                .sum::<u32>()
                / 9) as u8
        })
        .collect();
    let mut histogram = [0u64; 256];
    blurred.iter().for_each(|&l| histogram[l as usize] += 1);
    let total: u64 = blurred.len() as u64;
    let sum: u64 = histogram.iter().enumerate().map(|(l, n)| l as u64 * n).sum();
    let (mut below, mut below_sum, mut best) = (0u64, 0u64, (0.0, None));
    for (l, n) in histogram.iter().enumerate() {
        below += n;
        below_sum += l as u64 * n;
        if below == 0 || below == total {
            continue;
        }
        let above = total - below;
        let apart = below_sum as f64 / below as f64 - (sum - below_sum) as f64 / above as f64;
        let between = below as f64 * above as f64 * apart * apart;
        if between > best.0 {
            best = (between, Some(l as u8));
        }
    }
    best.1.map(|threshold| blurred.iter().map(|&l| l > threshold).collect())
}

/// The signed Euclidean distance in pixels to the border of the mask: positive inside, negative outside,
/// half a pixel at least. Exact, by the lower envelope of parabolas (Felzenszwalb & Huttenlocher 2012).
pub fn signed_distance(mask: &[bool], width: usize, height: usize, tileable: bool) -> Vec<f32> {
    let inside = squared_distance(mask, width, height, tileable, false);
    let outside = squared_distance(mask, width, height, tileable, true);
    mask.iter()
        .zip(inside.iter().zip(&outside))
        .map(|(&m, (&i, &o))| if m { libm::sqrt(i) as f32 - 0.5 } else { 0.5 - libm::sqrt(o) as f32 })
        .collect()
}

/// Squared distance of every pixel to the nearest pixel whose mask equals `to`.
fn squared_distance(mask: &[bool], width: usize, height: usize, tileable: bool, to: bool) -> Vec<f64> {
    // A finite stand-in for infinity, so that envelopes of empty rows stay well-defined.
    let far = ((width + height) * (width + height) * 4) as f64;
    let mut grid: Vec<f64> = mask.iter().map(|&m| if m == to { 0.0 } else { far }).collect();
    for y in 0..height {
        let row = envelope(&grid[y * width..][..width], tileable);
        grid[y * width..][..width].copy_from_slice(&row);
    }
    for x in 0..width {
        let column: Vec<f64> = (0..height).map(|y| grid[y * width + x]).collect();
        for (y, d) in envelope(&column, tileable).into_iter().enumerate() {
            grid[y * width + x] = d;
        }
    }
    grid
}

/// `min over q of f(q) + (p − q)²` for every `p`; around the ends if `tileable`.
fn envelope(f: &[f64], tileable: bool) -> Vec<f64> {
    let n = f.len() as i64;
    let (from, to) = if tileable { (-n, 2 * n) } else { (0, n) };
    let value = |q: i64| f[q.rem_euclid(n) as usize];
    let (mut hull, mut bounds): (Vec<i64>, Vec<f64>) = (Vec::new(), Vec::new());
    for q in from..to {
        let mut bound = f64::NEG_INFINITY;
        while let Some(&top) = hull.last() {
            bound =
                ((value(q) + (q * q) as f64) - (value(top) + (top * top) as f64)) / (2 * (q - top)) as f64;
            if bounds.last().is_some_and(|&b| bound <= b) {
                hull.pop();
                bounds.pop();
                bound = f64::NEG_INFINITY;
            } else {
                break;
            }
        }
        hull.push(q);
        bounds.push(bound);
    }
    let mut k = 0;
    (0..n)
        .map(|p| {
            while k + 1 < hull.len() && bounds[k + 1] < p as f64 {
                k += 1;
            }
            let q = hull[k];
            value(q) + ((p - q) * (p - q)) as f64
        })
        .collect()
}

/// The feature channel: 128 at the border, ± `amplitude` at the 98th percentile of the distance.
pub(crate) fn feature_channel(distance: &[f32], amplitude: f32) -> Vec<u8> {
    let mut sizes: Vec<f32> = distance.iter().map(|d| d.abs()).collect();
    sizes.sort_by(f32::total_cmp);
    let reference = sizes[(sizes.len() - 1) * 98 / 100].max(0.5);
    distance.iter().map(|d| (128.5 + amplitude * d / reference).clamp(0.0, 255.0) as u8).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_equal_a_brute_force_search() {
        let (w, h) = (13usize, 9usize);
        let mask: Vec<bool> = (0..w * h).map(|i| (i * 7919 + i / 5) % 11 < 3).collect();
        for tileable in [false, true] {
            let fast = signed_distance(&mask, w, h, tileable);
            for (i, d) in fast.iter().enumerate() {
                let (x, y) = ((i % w) as i64, (i / w) as i64);
                let nearest = (0..w * h)
                    .filter(|&j| mask[j] != mask[i])
                    .map(|j| {
                        let gap = |a: i64, b: i64, n: i64| {
                            let d = (a - b).abs();
                            if tileable { d.min(n - d) } else { d }
                        };
                        let dx = gap(x, (j % w) as i64, w as i64);
                        let dy = gap(y, (j / w) as i64, h as i64);
                        dx * dx + dy * dy
                    })
                    .min()
                    .expect("the mask holds both values");
                assert!((d.abs() - ((nearest as f32).sqrt() - 0.5)).abs() < 1e-4);
                assert_eq!(*d > 0.0, mask[i]);
            }
        }
    }
}
