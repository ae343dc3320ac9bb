//! Random numbers by key: pure functions, so that nothing depends on an order.

/// Random numbers of one seed.
#[derive(Clone, Copy)]
pub(super) struct Random(pub u64);

impl Random {
    /// 64 random bits (SplitMix64 over the key).
    fn bits(self, key: [u64; 3]) -> u64 {
        key.iter().fold(self.0, |state, &k| {
            let mut h = (state ^ k).wrapping_add(0x9e37_79b9_7f4a_7c15);
            h = (h ^ h >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            h = (h ^ h >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
            h ^ h >> 31
        })
    }

    /// A number below `n`, which must not be 0.
    pub fn below(self, n: usize, key: [u64; 3]) -> usize {
        ((u128::from(self.bits(key)) * n as u128) >> 64) as usize
    }

    /// A number from 0 to below 1.
    pub fn fraction(self, key: [u64; 3]) -> f64 {
        (self.bits(key) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A normal deviate of mean 0 and variance 1 (Box and Muller).
    pub fn normal(self, key: [u64; 3]) -> f64 {
        let [a, b, c] = key;
        let (u, v) = (1.0 - self.fraction([a, b, 2 * c]), self.fraction([a, b, 2 * c + 1]));
        libm::sqrt(-2.0 * libm::log(u)) * libm::cos(2.0 * std::f64::consts::PI * v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviates_have_the_moments_of_their_distributions() {
        let n = 20_000;
        let mean = |f: &dyn Fn(u64) -> f64| (0..n).map(f).sum::<f64>() / n as f64;
        let random = Random(3);
        assert!((mean(&|i| random.fraction([1, i, 0])) - 0.5).abs() < 0.01);
        assert!(mean(&|i| random.normal([2, i, 0])).abs() < 0.03);
        assert!((mean(&|i| random.normal([2, i, 0]).powi(2)) - 1.0).abs() < 0.04);
        assert!((0..n).all(|i| random.below(7, [3, i, 0]) < 7));
    }
}
