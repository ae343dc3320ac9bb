//! How far the colours of one set of pixels are from those of another.

/// Bins along each of red, green and blue.
const BINS: usize = 8;

/// What is added to each bin's fraction, so that a colour which one side lacks costs a finite amount.
const SMOOTHING: f64 = 1e-4;

/// The Kullback-Leibler divergence of joint colour histograms, `Σ p ln(p / q)` in nats, of `truth` (p)
/// from `found` (q).
///
/// Each histogram has 8 × 8 × 8 bins of RGB in sRGB encoding; a bin's probability is its share of the
/// pixels plus 10⁻⁴, normalised. 0 means equal histograms; colours of `truth` that `found` lacks weigh
/// most. Two halves of one homogeneous picture score about 0.01 to 0.05.
pub fn color_divergence(truth: &[[u8; 3]], found: &[[u8; 3]]) -> f64 {
    let (p, q) = (histogram(truth), histogram(found));
    p.iter().zip(&q).map(|(p, q)| p * libm::log(p / q)).sum::<f64>().max(0.0)
}

fn histogram(pixels: &[[u8; 3]]) -> Vec<f64> {
    let mut counts = vec![0u64; BINS * BINS * BINS];
    for rgb in pixels {
        let [r, g, b] = rgb.map(|c| usize::from(c) * BINS / 256);
        counts[(r * BINS + g) * BINS + b] += 1;
    }
    let n = pixels.len().max(1) as f64;
    let total = 1.0 + SMOOTHING * counts.len() as f64;
    counts.iter().map(|&count| (count as f64 / n + SMOOTHING) / total).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_does_not_matter_and_colours_do() {
        let a: Vec<[u8; 3]> = (0..200).map(|i| [i, 255 - i, 40]).collect();
        let reversed: Vec<_> = a.iter().rev().copied().collect();
        assert_eq!(color_divergence(&a, &reversed), 0.0);
        assert!(color_divergence(&a, &[[9, 9, 9]]) > 3.0);
        let half: Vec<_> =
            a.iter().map(|&[r, g, b]| if r < 100 { [r, g, b] } else { [50, 205, 40] }).collect();
        assert!(color_divergence(&a, &half) > color_divergence(&half, &a));
    }
}
