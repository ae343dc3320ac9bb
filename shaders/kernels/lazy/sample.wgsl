// One map of a lazy solid at points, from finished bricks. Mirrors `sample` of solid/sample.rs over `LazySolid::evaluate`.
#import breccia::bricks::{ABSENT, STATE, GROUP_ROW, wrapped, index, hash_key}
#import breccia::taps::{step_to, weight, bytes, mean_bytes}

struct Params {
    period: vec4<i32>,
    // For each direction the width of its picture, and the byte where the picture's map begins.
    views: array<vec4<u32>, 3>,
    // The first workgroup of this submission.
    first: u32,
    points: u32,
    channels: u32,
    // Whether the sums themselves are wanted, four words a point.
    sums: u32,
    // One less than the number of places in the table, a power of two.
    mask: u32,
    // Whether bricks show a colour of their own.
    own: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
// Voxels at low corners, and fractions.
@group(0) @binding(1) var<storage, read> taps: array<vec4<i32>>;
// Keys with their slots, at the place of their hash or behind it; a slot of -1 is empty.
@group(0) @binding(2) var<storage, read> places: array<vec4<i32>>;
@group(0) @binding(3) var<storage, read> state: array<u32>;
// The map of all pictures, byte after byte.
@group(0) @binding(4) var<storage, read> map: array<u32>;
@group(0) @binding(5) var<storage, read_write> out: array<u32>;

fn find(key: vec3<i32>) -> u32 {
    var at = hash_key(key) & params.mask;
    // The table is at most half full, so this ends.
    for (var tries = 0u; tries <= params.mask; tries++) {
        let entry = places[at];
        if entry.w < 0 {
            return ABSENT;
        }
        if all(entry.xyz == key) {
            return u32(entry.w);
        }
        at = (at + 1u) & params.mask;
    }
    return ABSENT;
}

fn shown(slot: u32, local: u32) -> vec4<u32> {
    let base = slot * STATE + local;
    if params.own != 0u {
        return unpack4xU8(state[base]);
    }
    let last = state[base + 1024u];
    let e = last >> 16u & 3u;
    var p = last & 0xffffu;
    if e < 2u {
        p = state[base + 512u] >> (16u * e) & 0xffffu;
    }
    let pixel = (p >> 8u) * params.views[e].x + (p & 255u);
    let at = params.views[e].y + pixel * params.channels;
    return bytes(map[at >> 2u], map[(at >> 2u) + 1u], at);
}

@compute @workgroup_size(128)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let at = (params.first + group.x + GROUP_ROW * group.y) * 128u + thread;
    if at >= params.points {
        return;
    }
    let tap = taps[at];
    var sum = vec4<u32>(0u);
    var slot = ABSENT;
    var home = vec3<i32>(0);
    for (var corner = 0u; corner < 8u; corner++) {
        let w = weight(bitcast<u32>(tap.w), corner);
        if w == 0u {
            continue;
        }
        let voxel = wrapped(tap.xyz + step_to(corner), params.period);
        let key = voxel >> vec3<u32>(3u);
        if slot == ABSENT || any(key != home) {
            home = key;
            slot = find(key);
        }
        if slot != ABSENT {
            sum += w * shown(slot, index(voxel & vec3<i32>(7)));
        }
    }
    if params.sums == 0u {
        out[at] = mean_bytes(sum);
        return;
    }
    for (var c = 0u; c < 4u; c++) {
        out[4u * at + c] = sum[c];
    }
}
