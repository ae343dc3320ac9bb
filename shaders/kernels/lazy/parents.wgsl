// The voxels of the next coarser level that a set of voxels descends from. Mirrors `parents` of lazy/dependency.rs.
#import breccia::bricks::{ABSENT, GROUP_ROW}

struct Params {
    bricks: u32,
    // Where the masks of the finer level begin, and where those of the coarser go.
    fine: u32,
    coarse: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
// For every brick of the coarser level the slots of its eight children.
@group(0) @binding(1) var<storage, read> children: array<u32>;
@group(0) @binding(2) var<storage, read> masks: array<u32>;
@group(0) @binding(3) var<storage, read_write> coarse_masks: array<u32>;

// Four bits: which of the pairs along x of eight bits hold any.
fn pairs(row: u32) -> u32 {
    let any = row | row >> 1u;
    return (any & 1u) | (any >> 1u & 2u) | (any >> 2u & 4u) | (any >> 3u & 8u);
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let at = (group.x + GROUP_ROW * group.y) * 64u + thread;
    let slot = at >> 4u;
    if slot >= params.bricks {
        return;
    }
    let word = at & 15u;
    // Layer z and rows 4 h to 4 h + 3 come from the children with these z and y.
    let z = word >> 1u;
    let h = word & 1u;
    var out = 0u;
    for (var cx = 0u; cx < 2u; cx++) {
        let child = children[slot * 8u + cx + 2u * h + 4u * (z >> 2u)];
        if child == ABSENT {
            continue;
        }
        for (var r = 0u; r < 4u; r++) {
            // Rows 2 r and 2 r + 1 of layers 2 z and 2 z + 1 of the child.
            var row = 0u;
            for (var d = 0u; d < 2u; d++) {
                let layer = 2u * (z & 3u) + d;
                let words = masks[params.fine + child * 16u + 2u * layer + (r >> 1u)] >> (16u * (r & 1u));
                row |= (words | words >> 8u) & 255u;
            }
            out |= pairs(row) << (4u * cx + 8u * r);
        }
    }
    coarse_masks[params.coarse + slot * 16u + word] = out;
}
