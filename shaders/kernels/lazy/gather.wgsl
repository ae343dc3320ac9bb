// Copies the states of some bricks, in order. Mirrors `Field::of` of lazy/field.rs: what goes back to the host is what was asked for.
#import breccia::bricks::{STATE, GROUP_ROW}

struct Params {
    bricks: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> slots: array<u32>;
@group(0) @binding(2) var<storage, read> state: array<u32>;
@group(0) @binding(3) var<storage, read_write> out: array<u32>;

@compute @workgroup_size(128)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let brick = group.x + GROUP_ROW * group.y;
    if brick >= params.bricks {
        return;
    }
    let source = slots[brick] * STATE;
    for (var i = thread; i < STATE; i += 128u) {
        out[brick * STATE + i] = state[source + i];
    }
}
