// How many voxels of every brick a sub-pass corrects. First step of the compaction that `indices` of data/voxels.rs does a brick.
#import breccia::bricks::{ABSENT, GROUP_ROW}

struct Params {
    subset: array<vec4<u32>, 4>,
    bricks: u32,
    after: u32,
    free: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> masks: array<u32>;
@group(0) @binding(2) var<storage, read_write> counts: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let slot = (group.x + GROUP_ROW * group.y) * 64u + thread;
    if slot >= params.bricks {
        return;
    }
    var count = 0u;
    for (var word = 0u; word < 16u; word++) {
        var bits = masks[params.after + slot * 16u + word] & params.subset[word >> 2u][word & 3u];
        if params.free != ABSENT {
            bits &= masks[params.free + slot * 16u + word];
        }
        count += countOneBits(bits);
    }
    counts[slot] = count;
}
