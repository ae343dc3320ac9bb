//! An automatic mask of particles: two classes of brightness or several of colour, then clean-up.

use crate::data::Image;
use crate::exemplar::{View, otsu_mask};

/// How pixels are told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Classes {
    /// A threshold on luminance (Otsu 1979).
    Otsu,
    /// This many clusters of colour (k-means; Lloyd 1982).
    Colors(usize),
}

/// Which class is the particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inside {
    /// The brighter half of the classes.
    Bright,
    /// The darker half.
    Dark,
    /// The class whose pixels lie together in the thicker pieces.
    Thick,
}

/// A mask of the particles in a picture: classes, a majority filter of 3 × 3 pixels, and pieces and holes of fewer than
/// `least` pixels removed.
pub fn auto_mask(view: &View, color: &Image, classes: Classes, inside: Inside, least: usize) -> Vec<bool> {
    let (w, h) = (view.width as usize, view.height as usize);
    let bright = match classes {
        Classes::Otsu => otsu_mask(color).unwrap_or_else(|| vec![true; w * h]),
        Classes::Colors(k) => clusters(color, k),
    };
    let mean_depth = |to: bool| {
        let mask: Vec<bool> = bright.iter().map(|&b| b == to).collect();
        let deep = crate::exemplar::signed_distance(&mask, w, h, view.tileable);
        let within = || deep.iter().filter(|&&d| d > 0.0);
        within().map(|&d| f64::from(d)).sum::<f64>() / within().count().max(1) as f64
    };
    let invert = match inside {
        Inside::Bright => false,
        Inside::Dark => true,
        Inside::Thick => mean_depth(false) > mean_depth(true),
    };
    let mut mask: Vec<bool> = bright.iter().map(|&b| b != invert).collect();
    mask = majority(&mask, w, h, view.tileable);
    for value in [true, false] {
        remove_small(&mut mask, w, h, view.tileable, value, least);
    }
    mask
}

/// Whether a pixel belongs to the brighter half of `k` clusters of colour. The clusters start from quantiles of luminance.
fn clusters(color: &Image, k: usize) -> Vec<bool> {
    let (w, h) = (color.width(), color.height());
    let pixels: Vec<[f64; 3]> = (0..w * h).map(|i| color.rgb8(i % w, i / w).map(f64::from)).collect();
    let light = |p: &[f64; 3]| 0.299 * p[0] + 0.587 * p[1] + 0.114 * p[2];
    let mut order: Vec<usize> = (0..pixels.len()).collect();
    order.sort_by(|&a, &b| light(&pixels[a]).total_cmp(&light(&pixels[b])).then(a.cmp(&b)));
    let k = k.clamp(2, 8);
    let mut centres: Vec<[f64; 3]> =
        (0..k).map(|c| pixels[order[(2 * c + 1) * pixels.len() / (2 * k)]]).collect();
    let squared = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|c| (a[c] - b[c]) * (a[c] - b[c])).sum::<f64>();
    let mut class = vec![0usize; pixels.len()];
    for _ in 0..32 {
        let nearest = |p: &[f64; 3]| {
            (0..k).min_by(|&a, &b| squared(p, &centres[a]).total_cmp(&squared(p, &centres[b]))).unwrap_or(0)
        };
        let next: Vec<usize> = pixels.iter().map(nearest).collect();
        let same = next == class;
        class = next;
        for (c, centre) in centres.iter_mut().enumerate() {
            let (mut sum, mut count) = ([0.0; 3], 0.0);
            for (p, _) in pixels.iter().zip(&class).filter(|(_, of)| **of == c) {
                (0..3).for_each(|i| sum[i] += p[i]);
                count += 1.0;
            }
            if count > 0.0 {
                *centre = sum.map(|s| s / count);
            }
        }
        if same {
            break;
        }
    }
    let mut by_light: Vec<usize> = (0..k).collect();
    by_light.sort_by(|&a, &b| light(&centres[a]).total_cmp(&light(&centres[b])).then(a.cmp(&b)));
    let bright: Vec<usize> = by_light.split_off(k / 2);
    class.iter().map(|c| bright.contains(c)).collect()
}

/// Every pixel takes what most of its 3 × 3 neighbourhood are.
fn majority(mask: &[bool], w: usize, h: usize, tileable: bool) -> Vec<bool> {
    (0..mask.len())
        .map(|i| {
            let votes = near(i, w, h, tileable, true).filter(|&j| mask[j]).count();
            let all = near(i, w, h, tileable, true).count();
            2 * votes > all || 2 * votes == all && mask[i]
        })
        .collect()
}

/// The pixels around a pixel, itself included: eight, or four.
fn near(i: usize, w: usize, h: usize, tileable: bool, eight: bool) -> impl Iterator<Item = usize> {
    let (x, y, w, h) = ((i % w) as i32, (i / w) as i32, w as i32, h as i32);
    (0..9).filter_map(move |k| {
        let (dx, dy) = (k % 3 - 1, k / 3 - 1);
        if !eight && dx != 0 && dy != 0 {
            return None;
        }
        let (x, y) = (x + dx, y + dy);
        if tileable {
            Some((y.rem_euclid(h) * w + x.rem_euclid(w)) as usize)
        } else {
            ((0..w).contains(&x) && (0..h).contains(&y)).then_some((y * w + x) as usize)
        }
    })
}

/// Turns connected pieces of `value` with fewer than `least` pixels into their opposite.
fn remove_small(mask: &mut [bool], w: usize, h: usize, tileable: bool, value: bool, least: usize) {
    let mut seen = vec![false; mask.len()];
    for start in 0..mask.len() {
        if seen[start] || mask[start] != value {
            continue;
        }
        seen[start] = true;
        let mut piece = vec![start];
        let mut next = 0;
        while let Some(&i) = piece.get(next) {
            next += 1;
            for j in near(i, w, h, tileable, false) {
                if !seen[j] && mask[j] == value {
                    seen[j] = true;
                    piece.push(j);
                }
            }
        }
        if piece.len() < least {
            piece.into_iter().for_each(|i| mask[i] = !value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: u32 = 60;

    fn inside(x: u32, y: u32) -> bool {
        let (dx, dy) = ((x % 20) as i32 - 10, (y % 20) as i32 - 10);
        dx * dx + dy * dy <= 81
    }

    /// Discs on a ground, both with grain, and a few stray pixels.
    fn found(disc: [u8; 3], ground: [u8; 3], classes: Classes, which: Inside) -> f64 {
        let color = Image::from_fn(SIDE, SIDE, |x, y| {
            let grain = (crate::lazy::random::hash(1, 2, [x as i32, y as i32, 0]) % 24) as u8;
            let stray = (x * 7 + y * 13) % 211 == 0;
            if inside(x, y) != stray { disc.map(|c| c + grain) } else { ground.map(|c| c + grain) }
        });
        let view = View {
            width: SIDE,
            height: SIDE,
            texels: vec![[0; 4]; (SIDE * SIDE) as usize],
            carried: Vec::new(),
            tileable: false,
            guided: false,
            barred: Vec::new(),
        };
        let mask = auto_mask(&view, &color, classes, which, 12);
        let right = (0..SIDE * SIDE).filter(|&i| mask[i as usize] == inside(i % SIDE, i / SIDE)).count();
        right as f64 / f64::from(SIDE * SIDE)
    }

    #[test]
    fn discs_are_found_by_brightness_and_by_colour() {
        let (light, dark) = ([180; 3], [40; 3]);
        for classes in [Classes::Otsu, Classes::Colors(2)] {
            assert!(found(light, dark, classes, Inside::Bright) > 0.97);
            assert!(found(dark, light, classes, Inside::Dark) > 0.97);
            // Discs are thicker than what lies between them, whatever is lighter.
            assert!(found(light, dark, classes, Inside::Thick) > 0.97);
            assert!(found(dark, light, classes, Inside::Thick) > 0.97);
        }
        // Equal luminance, other hue.
        let (warm, cold) = ([190, 100, 40], [60, 125, 190]);
        assert!(found(cold, warm, Classes::Colors(2), Inside::Thick) > 0.97);
    }
}
