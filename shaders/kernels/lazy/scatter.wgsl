// Lists the voxels that a sub-pass corrects: slot times 512 plus index. Third step of the compaction.
#import breccia::bricks::{ABSENT, GROUP_ROW}

struct Params {
    subset: array<vec4<u32>, 4>,
    bricks: u32,
    after: u32,
    free: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> masks: array<u32>;
@group(0) @binding(2) var<storage, read> starts: array<u32>;
// The number of voxels, then the voxels.
@group(0) @binding(3) var<storage, read_write> list: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let slot = (group.x + GROUP_ROW * group.y) * 64u + thread;
    if slot == 0u {
        list[0] = starts[params.bricks];
    }
    if slot >= params.bricks {
        return;
    }
    var to = starts[slot] + 1u;
    for (var word = 0u; word < 16u; word++) {
        var bits = masks[params.after + slot * 16u + word] & params.subset[word >> 2u][word & 3u];
        if params.free != ABSENT {
            bits &= masks[params.free + slot * 16u + word];
        }
        while bits != 0u {
            list[to] = slot * 512u + word * 32u + firstTrailingBit(bits);
            to++;
            bits &= bits - 1u;
        }
    }
}
