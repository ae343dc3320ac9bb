// The nearest of all neighbourhoods. Mirrors `PatchTable::nearest` of search/nearest.rs as `matches` of optimize/coherence.rs
// uses it.
//
// A workgroup a voxel and direction, whose threads share the centres.
#import breccia::bricks::{GROUP_ROW}
#import breccia::matching::{Matching}
#import breccia::nearest::{even, odd, gap, weighed, better, code}

@group(0) @binding(0) var<uniform> params: Matching;
@group(0) @binding(1) var<storage, read> coefficients: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> weights: array<u32>;
@group(0) @binding(3) var<storage, read> queries: array<vec4<u32>>;
// For each voxel and direction the pixel, and the code of its distance above.
@group(0) @binding(4) var<storage, read_write> found: array<u32>;

// The coefficients of the voxel's window, of even and of odd places in turn.
var<workgroup> query: array<vec4<i32>, 16>;
// The least cost that each thread met, and the number of the centre.
var<workgroup> bests: array<vec3<u32>, 64>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let at = params.first + group.x + GROUP_ROW * group.y;
    if at / params.wanted >= params.count {
        return;
    }
    let slot = at % params.wanted;
    let bounds = params.directions[slot].bounds;
    let base = params.directions[slot].base;
    let width = u32(params.directions[slot].size.x);
    if thread < params.eights {
        let packed = queries[at * params.eights + thread];
        query[2u * thread] = even(packed);
        query[2u * thread + 1u] = odd(packed);
    }
    workgroupBarrier();
    let columns = u32(bounds.y - bounds.x + 1);
    let centres = columns * u32(bounds.w - bounds.z + 1);
    var best = vec3<u32>(0xffffffffu);
    var nearest = 0u;
    var pixel = 0u;
    for (var i = thread; i < centres; i += 64u) {
        let index = (u32(bounds.z) + i / columns) * width + u32(bounds.x) + i % columns;
        var distance = 0u;
        for (var k = 0u; k < params.eights; k++) {
            distance += gap(query[2u * k], query[2u * k + 1u], coefficients[base.x + index * params.eights + k]);
        }
        let candidate = vec3<u32>(weighed(distance, weights[base.z + index]), i);
        if better(candidate, best) {
            best = candidate;
            nearest = distance;
            pixel = index;
        }
    }
    bests[thread] = best;
    for (var step = 32u; step > 0u; step >>= 1u) {
        workgroupBarrier();
        if thread < step && better(bests[thread + step], bests[thread]) {
            bests[thread] = bests[thread + step];
        }
    }
    workgroupBarrier();
    if best.z == bests[0].z && best.z != 0xffffffffu {
        found[at] = pixel % width | (pixel / width) << 8u | code(nearest) << 16u;
    }
}
