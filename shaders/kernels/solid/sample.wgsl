// One map of a dense volume at points. Mirrors `sample` of solid/sample.rs over `VolumeSolid::evaluate`.
#import breccia::bricks::{GROUP_ROW, modulo}
#import breccia::taps::{step_to, weight, bytes, mean_bytes}

struct Params {
    // The first voxel; whether the volume repeats.
    origin: vec4<i32>,
    size: vec4<i32>,
    // The first workgroup of this submission.
    first: u32,
    points: u32,
    channels: u32,
    // Whether the sums themselves are wanted, four words a point.
    sums: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
// Voxels at low corners, and fractions.
@group(0) @binding(1) var<storage, read> taps: array<vec4<i32>>;
// The map, byte after byte.
@group(0) @binding(2) var<storage, read> map: array<u32>;
@group(0) @binding(3) var<storage, read_write> out: array<u32>;

// The place inside of a voxel along one axis.
fn inside(c: i32, origin: i32, size: i32) -> u32 {
    if params.origin.w == 0 {
        // Clamped before the difference, which could leave the numbers there are.
        return u32(clamp(c, origin, origin + size - 1) - origin);
    }
    return u32(modulo(modulo(c, size) - modulo(origin, size), size));
}

@compute @workgroup_size(128)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let at = (params.first + group.x + GROUP_ROW * group.y) * 128u + thread;
    if at >= params.points {
        return;
    }
    let tap = taps[at];
    let size = vec3<u32>(params.size.xyz);
    var sum = vec4<u32>(0u);
    for (var corner = 0u; corner < 8u; corner++) {
        let w = weight(bitcast<u32>(tap.w), corner);
        if w == 0u {
            continue;
        }
        let c = tap.xyz + step_to(corner);
        let x = inside(c.x, params.origin.x, params.size.x);
        let y = inside(c.y, params.origin.y, params.size.y);
        let z = inside(c.z, params.origin.z, params.size.z);
        let byte = ((z * size.y + y) * size.x + x) * params.channels;
        sum += w * bytes(map[byte >> 2u], map[(byte >> 2u) + 1u], byte);
    }
    if params.sums == 0u {
        out[at] = mean_bytes(sum);
        return;
    }
    for (var c = 0u; c < 4u; c++) {
        out[4u * at + c] = sum[c];
    }
}
