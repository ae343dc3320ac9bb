//! Two phases from luminance.

/// The threshold of Otsu 1979 on a histogram of 256 grey levels: levels above it are the bright phase. It makes the variance between
/// both phases largest; of several that do so (no level between them occurs) it is the middle one. `None` if there is one level only.
pub fn otsu(histogram: &[u64; 256]) -> Option<f64> {
    let count: u64 = histogram.iter().sum();
    let total: u64 = histogram.iter().enumerate().map(|(level, n)| level as u64 * n).sum();
    let (mut below, mut sum) = (0u64, 0u64);
    let (mut best, mut first, mut last) = (0.0, None, 0);
    for (level, &n) in histogram.iter().enumerate() {
        below += n;
        sum += level as u64 * n;
        if below == 0 || below == count {
            continue;
        }
        let above = count - below;
        let (dark, bright) = (sum as f64 / below as f64, (total - sum) as f64 / above as f64);
        let between = below as f64 * above as f64 * (bright - dark) * (bright - dark);
        if between > best {
            (best, first) = (between, Some(level));
        }
        if between == best {
            last = level;
        }
    }
    first.map(|first| (first + last) as f64 / 2.0 + 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_threshold_parts_two_heaps_in_the_middle_of_their_gap() {
        let mut histogram = [0; 256];
        assert_eq!(otsu(&histogram), None);
        histogram[40] = 10;
        assert_eq!(otsu(&histogram), None);
        histogram[200] = 3;
        // From 40, which is dark, to 199, after which comes 200.
        assert_eq!(otsu(&histogram), Some(120.0));
        histogram[60] = 5;
        assert_eq!(otsu(&histogram), Some(130.0));
    }
}
