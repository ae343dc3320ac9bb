//! How the three colours of a voxel become one.

use super::schedule::ColorRule;
use super::tables::LevelTables;

/// The choice among the three colours that a triple gives a voxel.
#[derive(Clone, Copy, Debug)]
pub(super) struct OneColor {
    rule: ColorRule,
    /// Three times the mean colour of the level's views.
    pub middle: [i16; 4],
    /// How much further from the middle than the mean of the three the wanted colour lies, in 256ths: where the
    /// three disagree, choosing among them costs contrast, and this restores it.
    pub stretch: i16,
}

impl OneColor {
    /// The choice at a level.
    pub fn new(rule: ColorRule, level: &LevelTables) -> Self {
        Self { rule, middle: level.middle, stretch: level.stretch.min(255) as i16 }
    }

    /// Whether a voxel takes one of the three colours, not their mean.
    pub fn takes_one(&self) -> bool {
        self.rule == ColorRule::Nearest
    }

    /// Which of the colours lies nearest to the wanted one, the first of equals.
    #[inline(always)]
    pub fn nearest(&self, colors: [[u8; 4]; 3]) -> usize {
        let wanted: [i32; 4] = std::array::from_fn(|c| {
            let sum: i32 = colors.iter().map(|color| i32::from(color[c])).sum();
            sum + (((sum - i32::from(self.middle[c])) * i32::from(self.stretch) + 128) >> 8)
        });
        let apart =
            |color: [u8; 4]| -> i32 { (0..4).map(|c| (3 * i32::from(color[c]) - wanted[c]).pow(2)).sum() };
        first_least(colors.map(apart))
    }

    /// The colour of a voxel, and the direction whose pixel is nearest to it.
    #[inline(always)]
    pub fn of(&self, colors: [[u8; 4]; 3]) -> ([u8; 4], usize) {
        let nearest = self.nearest(colors);
        (if self.takes_one() { colors[nearest] } else { mean(colors) }, nearest)
    }
}

/// The mean of three colours.
#[inline(always)]
pub(super) fn mean(colors: [[u8; 4]; 3]) -> [u8; 4] {
    std::array::from_fn(|c| {
        let sum: u32 = colors.iter().map(|color| u32::from(color[c])).sum();
        ((sum + 1) / 3) as u8
    })
}

/// The place of the least of three numbers, the first of equals.
#[inline(always)]
pub(super) fn first_least(gaps: [i32; 3]) -> usize {
    let nearest = usize::from(gaps[1] < gaps[0]);
    if gaps[2] < gaps[nearest] { 2 } else { nearest }
}

/// The spread of colours, gathered one by one; sums of integers, so their order does not matter.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Contrast {
    count: u64,
    sum: u64,
    squares: u64,
}

impl Contrast {
    /// Takes in a colour.
    pub fn add(&mut self, color: [u8; 4]) {
        let luminance = color[..3].iter().zip([54u64, 183, 19]).map(|(&c, w)| u64::from(c) * w).sum::<u64>();
        self.count += 1;
        self.sum += luminance;
        self.squares += luminance * luminance;
    }

    /// The standard deviation of their luminance, in 256ths of a byte.
    pub fn deviation(&self) -> f64 {
        let count = self.count.max(1) as f64;
        let mean = self.sum as f64 / count;
        libm::sqrt((self.squares as f64 / count - mean * mean).max(0.0))
    }
}
