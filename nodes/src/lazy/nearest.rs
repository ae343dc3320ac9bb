//! Brute-force nearest neighbours over byte vectors: exact, and quick enough that no tree is needed.

/// Squared distances of `query` to every candidate. The loop compiles to the widest vectors of the machine.
pub(super) fn distances<const D: usize>(query: &[u8; D], candidates: &[[u8; D]], out: &mut Vec<u32>) {
    #[cfg(target_arch = "x86_64")]
    {
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has AVX2.
            return unsafe { distances_avx2(query, candidates, out) };
        }
    }
    distances_portable(query, candidates, out);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn distances_avx2<const D: usize>(query: &[u8; D], candidates: &[[u8; D]], out: &mut Vec<u32>) {
    distances_portable(query, candidates, out);
}

#[inline(always)]
fn distances_portable<const D: usize>(query: &[u8; D], candidates: &[[u8; D]], out: &mut Vec<u32>) {
    out.clear();
    out.resize(candidates.len(), 0);
    // Plain loops: closures would not be compiled for the caller's instruction set.
    for (out, candidate) in out.iter_mut().zip(candidates) {
        let mut sum = 0i32;
        for d in 0..D {
            let difference = i16::from(query[d]) - i16::from(candidate[d]);
            sum += i32::from(difference) * i32::from(difference);
        }
        *out = sum as u32;
    }
}

/// The `count` smallest distances with their indices, in ascending order; ties go to the lower index.
pub(super) fn smallest(distances: &[u32], count: usize) -> Vec<(u32, u32)> {
    let mut kept: Vec<u64> = Vec::with_capacity(2 * count + 1);
    let mut bound = u64::MAX;
    for (i, &distance) in distances.iter().enumerate() {
        let key = u64::from(distance) << 32 | i as u64;
        if key < bound {
            kept.push(key);
            if kept.len() > 2 * count {
                kept.select_nth_unstable(count);
                kept.truncate(count);
                bound = kept.iter().copied().max().unwrap_or(u64::MAX);
            }
        }
    }
    kept.sort_unstable();
    kept.truncate(count);
    kept.into_iter().map(|key| ((key >> 32) as u32, key as u32)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smallest_equals_a_full_sort() {
        let distances: Vec<u32> = (0..5000u32).map(|i| i.wrapping_mul(2654435761) % 700).collect();
        let mut expected: Vec<(u32, u32)> = distances.iter().zip(0..).map(|(&d, i)| (d, i)).collect();
        expected.sort_unstable();
        assert_eq!(smallest(&distances, 65), expected[..65]);
        assert_eq!(smallest(&distances[..3], 65).len(), 3);
    }
}
