// Points between voxels, as `data/tap.rs` has them: the voxel at the low corner of eight, and three fractions of a byte each.
#define_import_path breccia::taps

// A corner's place among the eight, x fastest.
fn step_to(corner: u32) -> vec3<i32> {
    return vec3<i32>(i32(corner & 1u), i32(corner >> 1u & 1u), i32(corner >> 2u & 1u));
}

// What a corner weighs; 2^24 in all (`Tap::weights`).
fn weight(fractions: u32, corner: u32) -> u32 {
    let f = vec3<u32>(fractions, fractions >> 8u, fractions >> 16u) & vec3<u32>(255u);
    let w = select(256u - f, f, step_to(corner) == vec3<i32>(1));
    return w.x * w.y * w.z;
}

// Four bytes from the byte `at` on, given the word that holds it and the next.
fn bytes(low: u32, high: u32, at: u32) -> vec4<u32> {
    let shift = 8u * (at & 3u);
    // A shift by all 32 digits is no shift at all, hence in two steps.
    return unpack4xU8(low >> shift | (high << 1u) << (31u - shift));
}

// The bytes that four sums stand for (`mean_byte`).
fn mean_bytes(sums: vec4<u32>) -> u32 {
    return pack4xU8((sums + (1u << 23u)) >> vec4<u32>(24u));
}
