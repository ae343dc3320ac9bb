// Counter-based random numbers, as in `lazy/random.rs`.
#define_import_path breccia::random

fn mix_in(state: u32, value: u32) -> u32 {
    let s = (state ^ value) * 747796405u + 2891336453u;
    let word = ((s >> ((s >> 28u) + 4u)) ^ s) * 277803737u;
    return (word >> 22u) ^ word;
}

fn hash(seed: vec2<u32>, purpose: u32, position: vec3<i32>) -> u32 {
    var state = mix_in(mix_in(mix_in(0x9e3779b9u, seed.x), seed.y), purpose);
    state = mix_in(state, bitcast<u32>(position.x));
    state = mix_in(state, bitcast<u32>(position.y));
    return mix_in(state, bitcast<u32>(position.z));
}
