//! Flat regions, the sign of a collapse to one place of the exemplar.

use super::views::{Pixels, luminance};

/// Neighbours that differ by no more belong to one flat region, in grey levels.
const STEP: f64 = 3.0;

/// The share of a picture that its largest flat region takes: the largest set of pixels joined along rows and columns by
/// steps of at most three grey levels. 0 to 1.
pub(super) fn largest_flat(picture: &Pixels) -> f64 {
    let (w, h) = (picture.width, picture.height);
    let levels: Vec<f64> = picture.data.iter().map(|&pixel| luminance(pixel)).collect();
    let mut seen = vec![false; w * h];
    let mut largest = 0;
    let mut open = Vec::new();
    for start in 0..w * h {
        if seen[start] {
            continue;
        }
        seen[start] = true;
        open.push(start);
        let mut size = 0;
        while let Some(at) = open.pop() {
            size += 1;
            let (x, y) = (at % w, at / w);
            let mut visit = |other: usize| {
                if !seen[other] && (levels[at] - levels[other]).abs() <= STEP {
                    seen[other] = true;
                    open.push(other);
                }
            };
            if x > 0 {
                visit(at - 1);
            }
            if x + 1 < w {
                visit(at + 1);
            }
            if y > 0 {
                visit(at - w);
            }
            if y + 1 < h {
                visit(at + w);
            }
        }
        largest = largest.max(size);
    }
    f64::from(largest) / (w * h).max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_region_counts_and_edges_part_regions() {
        // A frame of noise around 6 × 5 equal pixels, cut in two by a bright line.
        let level = |x: usize, y: usize| match (x, y) {
            (4, 2..7) => 250,
            (2..8, 2..7) => 100,
            _ => ((x * 89 + y * 57) % 16 * 16) as u8,
        };
        let data = (0..100).map(|i| [level(i % 10, i / 10); 3]).collect();
        assert_eq!(largest_flat(&Pixels { width: 10, height: 10, data }), 0.15);
    }
}
