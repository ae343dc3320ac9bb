// What searches for the nearest coefficients share: distances, costs of 64 bits, and the order of candidates. As in
// `search/nearest.rs`.
#define_import_path breccia::nearest

// Four coefficients each: those of even places, and those of odd ones, of eight that are packed in pairs of 16 bits.
fn even(packed: vec4<u32>) -> vec4<i32> {
    return bitcast<vec4<i32>>(packed << vec4<u32>(16u)) >> vec4<u32>(16u);
}

fn odd(packed: vec4<u32>) -> vec4<i32> {
    return bitcast<vec4<i32>>(packed) >> vec4<u32>(16u);
}

// The part of a squared distance that eight coefficients make. Coefficients lie from -8192 to 8191, so four squares fit.
fn gap(evens: vec4<i32>, odds: vec4<i32>, packed: vec4<u32>) -> u32 {
    let a = evens - even(packed);
    let b = odds - odd(packed);
    return u32(dot(a, a)) + u32(dot(b, b));
}

// (distance + 1) · weight, the high word first.
fn weighed(distance: u32, weight: u32) -> vec2<u32> {
    let low = (distance & 0xffffu) * (weight & 0xffffu);
    let left = (distance & 0xffffu) * (weight >> 16u);
    let right = (distance >> 16u) * (weight & 0xffffu);
    let middle = (low >> 16u) + (left & 0xffffu) + (right & 0xffffu);
    let high = (distance >> 16u) * (weight >> 16u) + (left >> 16u) + (right >> 16u) + (middle >> 16u);
    let product = middle << 16u | (low & 0xffffu);
    let sum = product + weight;
    return vec2<u32>(high + select(0u, 1u, sum < product), sum);
}

// Whether one pair of words comes before another, the first word the greater.
fn before(a: vec2<u32>, b: vec2<u32>) -> bool {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}

// Whether a candidate is better: its cost in two words, and among equals its place.
fn better(a: vec3<u32>, b: vec3<u32>) -> bool {
    return before(a.xy, b.xy) || (all(a.xy == b.xy) && a.z < b.z);
}

// A squared distance as a code: six binary digits after the first (`code` of optimize/matches.rs).
fn code(distance: u32) -> u32 {
    let d = max(distance, 1u);
    let exponent = firstLeadingBit(d);
    let digits = select(d << (6u - min(exponent, 6u)), d >> (max(exponent, 6u) - 6u), exponent > 6u);
    return exponent << 6u | (digits & 63u);
}
