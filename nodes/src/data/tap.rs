//! Points at which solids are sampled, as whole numbers, so that every processor and device finds the same bits.

use bytemuck::{Pod, Zeroable};

/// How a point gets its value from the voxels around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// The voxel that holds the point.
    Nearest,
    /// The eight voxels whose centres surround the point, weighted linearly (in the encoding they are stored in) at 1/256 of a
    /// voxel. Labels are always taken from the nearest voxel; maps named `normal` keep unit length.
    Trilinear,
}

/// A point of voxel space: the voxel at the low corner of the eight that surround it, and how far it lies from that voxel's centre
/// towards the next. Where that is nothing along an axis, the next voxel there does not count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Tap {
    /// The voxel at the low corner.
    pub base: [i32; 3],
    /// 256ths of a voxel along x, y and z: a byte each, lowest first.
    fractions: u32,
}

impl Tap {
    /// The sum of the weights of a point's voxels.
    pub const FULL: u32 = 1 << 24;

    /// The tap of a point in voxel coordinates; `None` beyond ±2³¹ (less a brick, so that neighbours have numbers too) and where a
    /// coordinate is not a number.
    pub fn new(point: [f64; 3], filter: Filter) -> Option<Self> {
        let mut tap = Self::default();
        for (i, c) in point.into_iter().enumerate() {
            let steps = match filter {
                Filter::Nearest => c.floor() * 256.0,
                Filter::Trilinear => ((c - 0.5) * 256.0 + 0.5).floor(),
            };
            if !(steps > (f64::from(i32::MIN) + 16.0) * 256.0 && steps < (f64::from(i32::MAX) - 16.0) * 256.0)
            {
                return None;
            }
            let steps = steps as i64;
            tap.base[i] = (steps >> 8) as i32;
            tap.fractions |= ((steps & 255) as u32) << (8 * i);
        }
        Some(tap)
    }

    /// How far the point lies behind its voxel's centre along x, y and z, in 256ths of a voxel.
    #[inline(always)]
    pub fn fractions(&self) -> [u32; 3] {
        [0, 8, 16].map(|shift| self.fractions >> shift & 255)
    }

    /// Whether one voxel alone counts.
    #[inline(always)]
    pub fn is_single(&self) -> bool {
        self.fractions == 0
    }

    /// The weights of the eight voxels from `base` on, x fastest; 2²⁴ in all. Those beyond a fraction of 0 weigh nothing.
    #[inline(always)]
    pub fn weights(&self) -> [u32; 8] {
        let [x, y, z] = self.fractions().map(|f| [256 - f, f]);
        std::array::from_fn(|corner| x[corner & 1] * y[corner >> 1 & 1] * z[corner >> 2])
    }
}

/// The byte that a sum of bytes times [`Tap::weights`] stands for.
#[inline(always)]
pub fn mean_byte(sum: u32) -> u8 {
    ((sum + (Tap::FULL >> 1)) >> 24) as u8
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_nearest_voxel_holds_the_point() {
        for (point, base) in [([0.0, -0.001, 7.999], [0, -1, 7]), ([-8.0, 3.5, 1e9], [-8, 3, 1_000_000_000])]
        {
            let tap = Tap::new(point, Filter::Nearest).unwrap();
            assert!(tap.is_single() && tap.base == base, "{tap:?}");
        }
    }

    #[test]
    fn points_without_a_voxel_are_refused() {
        for c in [f64::NAN, f64::INFINITY, -2_147_483_640.0, 3e9] {
            assert_eq!(Tap::new([0.0, c, 0.0], Filter::Trilinear), None);
            assert_eq!(Tap::new([c, 0.0, 0.0], Filter::Nearest), None);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn weights_are_linear_to_a_512th_of_a_voxel(point in prop::array::uniform3(-1e6f64..1e6)) {
            let tap = Tap::new(point, Filter::Trilinear).unwrap();
            let weights = tap.weights();
            prop_assert_eq!(weights.iter().sum::<u32>(), Tap::FULL);
            for (i, &c) in point.iter().enumerate() {
                let upper: u32 = (0..8).filter(|corner| corner >> i & 1 == 1).map(|corner| weights[corner]).sum();
                let found = f64::from(tap.base[i]) + 0.5 + f64::from(upper) / f64::from(Tap::FULL);
                prop_assert!((found - c).abs() <= 1.0 / 512.0 + 1e-9);
            }
        }
    }
}
