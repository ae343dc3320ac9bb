// What must be known before a sub-pass: what must be known after it, and the crossbars of what it corrects.
// Mirrors `dilate` of lazy/dependency.rs and one step of `dependency_among`.
#import breccia::bricks::{LINKS, KEY, ABSENT, GROUP_ROW, lengths, link, place}

struct Params {
    period: vec4<i32>,
    // The voxels of a brick that the sub-pass corrects.
    subset: array<vec4<u32>, 4>,
    bricks: u32,
    // Where the masks of what is known after the sub-pass begin, and where those of before go.
    after: u32,
    before: u32,
    // Where the masks of the voxels that may be corrected begin, or all ones.
    free: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> links: array<u32>;
// Sixteen words a brick: bit x + 8 (y mod 4) of word 2 z + y / 4.
@group(0) @binding(2) var<storage, read_write> masks: array<u32>;

// Eight bits of the corrected voxels of a brick.
fn byte(slot: u32, y: i32, z: i32) -> u32 {
    if slot == ABSENT {
        return 0u;
    }
    let word = u32(2 * z + (y >> 2u));
    var bits = masks[params.after + slot * 16u + word] & params.subset[word >> 2u][word & 3u];
    if params.free != ABSENT {
        bits &= masks[params.free + slot * 16u + word];
    }
    return bits >> u32(8 * (y & 3)) & 255u;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let at = (group.x + GROUP_ROW * group.y) * 64u + thread;
    let slot = at >> 4u;
    if slot >= params.bricks {
        return;
    }
    let word = at & 15u;
    let base = slot * LINKS;
    let key = bitcast<vec3<i32>>(vec3<u32>(links[base + KEY], links[base + KEY + 1u], links[base + KEY + 2u]));
    let length = lengths(key, params.period);
    let z = i32(word >> 1u);
    let y = i32(word & 1u) * 4;
    // Rows y - 2 to y + 5 of layers z - 2 to z + 2: bit x + 2 is voxel x.
    var rows: array<u32, 40>;
    for (var dz = 0; dz < 5; dz++) {
        for (var dy = 0; dy < 8; dy++) {
            let q = vec3<i32>(0, y + dy - 2, z + dz - 2);
            // Beyond what can be reached from the voxels before the period's end.
            if any(q.yz >= length.yz + 2) {
                continue;
            }
            let near = place(key, q, params.period);
            let first = base + link(q, length) - 2u;
            var row = byte(links[first + 2u], near.y, near.z) << 2u;
            for (var i = 0; i < 2; i++) {
                let low = place(key, vec3<i32>(i - 2, 0, 0), params.period).x;
                let high = place(key, vec3<i32>(length.x + i, 0, 0), params.period).x;
                row |= (byte(links[first + u32(i)], near.y, near.z) >> u32(low) & 1u) << u32(i);
                row |= (byte(links[first + 3u + u32(i)], near.y, near.z) >> u32(high) & 1u) << u32(length.x + i + 2);
            }
            rows[dz * 8 + dy] = row;
        }
    }
    var out = 0u;
    for (var r = 0; r < 4; r++) {
        if y + r >= length.y || z >= length.z {
            continue;
        }
        // Across x: the square of rows. Across y and z: rows spread along x.
        var square = 0u;
        var wide = 0u;
        for (var d = 0; d < 5; d++) {
            for (var e = 0; e < 5; e++) {
                square |= rows[d * 8 + r + e];
            }
            wide |= rows[2 * 8 + r + d] | rows[d * 8 + r + 2];
        }
        wide |= wide << 1u | wide << 2u | wide >> 1u | wide >> 2u;
        let row = (square | wide) >> 2u & ((1u << u32(length.x)) - 1u);
        out |= row << u32(8 * r);
    }
    masks[params.before + slot * 16u + word] = masks[params.after + slot * 16u + word] | out;
}
