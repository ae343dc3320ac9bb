//! Counter-based random numbers: pure functions of (seed, purpose, position), the PCG hash of O'Neill 2014 in
//! the form of Jarzynski & Olano 2020.

/// Mixes a number into a hash.
pub(crate) fn mix(state: u32, value: u32) -> u32 {
    let s = (state ^ value).wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((s >> ((s >> 28) + 4)) ^ s).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// The hash of a seed, a purpose and a position.
pub(crate) fn hash(seed: u64, purpose: u32, position: [i32; 3]) -> u32 {
    let start = mix(mix(mix(0x9e37_79b9, seed as u32), (seed >> 32) as u32), purpose);
    position.iter().fold(start, |state, &c| mix(state, c as u32))
}

/// A number from 0 (inclusive) to 1 (exclusive), from a hash.
pub(crate) fn unit(hash: u32) -> f64 {
    f64::from(hash) / 4_294_967_296.0
}
