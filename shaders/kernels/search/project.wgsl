// The coefficients of the windows around voxels, in each direction that is wanted. Mirrors `project` of search/nearest.rs.
//
// A thread makes four coefficients of one window. Threads side by side read the same colours, and weights that lie together.
#import breccia::bricks::{GROUP_ROW}
#import breccia::box::{place, strides, around}

struct Params {
    // Voxels along x, y and z.
    size: vec4<u32>,
    // For each direction that is wanted the direction, and where the weights and the biases of its view begin.
    directions: array<vec4<u32>, 3>,
    wanted: u32,
    // Coefficients, in fours.
    fours: u32,
    window: i32,
    // Pixels of a window before its centre.
    lead: i32,
    // The voxels: where in the list they begin, and how many.
    start: u32,
    count: u32,
    // The first workgroup of this submission.
    first: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
// For each view the weights, `[pair of samples][component]`, two weights a word; then the biases.
@group(0) @binding(1) var<storage, read> basis: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> colors: array<u32>;
@group(0) @binding(3) var<storage, read> list: array<u32>;
// For each voxel and direction the coefficients, two a word.
@group(0) @binding(4) var<storage, read_write> queries: array<vec2<u32>>;

// Two weights of four components with two samples.
fn weigh(weights: vec4<u32>, low: u32, high: u32) -> vec4<i32> {
    let evens = bitcast<vec4<i32>>(weights << vec4<u32>(16u)) >> vec4<u32>(16u);
    let odds = bitcast<vec4<i32>>(weights) >> vec4<u32>(16u);
    return evens * i32(low) + odds * i32(high);
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let at = (params.first + group.x + GROUP_ROW * group.y) * 64u + thread;
    let part = at % params.fours;
    let query = at / params.fours;
    let number = query / params.wanted;
    if number >= params.count {
        return;
    }
    let direction = params.directions[query % params.wanted];
    let voxel = place(list[params.start + number], params.size);
    let stride = strides(params.size);
    let c = (direction.x + 1u) % 3u;
    let r = (direction.x + 2u) % 3u;
    let own = voxel[direction.x] * stride[direction.x];
    let column = around(voxel[c], -params.lead, params.size[c]);
    var row = around(voxel[r], -params.lead, params.size[r]);
    var sum = bitcast<vec4<i32>>(basis[direction.z + part]);
    var weights = direction.y + part;
    for (var i = 0; i < params.window; i++) {
        var along = column;
        for (var j = 0; j < params.window; j++) {
            let color = unpack4xU8(colors[own + row * stride[r] + along * stride[c]]);
            sum += weigh(basis[weights], color.x, color.y);
            sum += weigh(basis[weights + params.fours], color.z, color.w);
            weights += 2u * params.fours;
            along = select(along + 1u, 0u, along + 1u == params.size[c]);
        }
        row = select(row + 1u, 0u, row + 1u == params.size[r]);
    }
    let coefficients = bitcast<vec4<u32>>(clamp(sum >> vec4<u32>(10u), vec4<i32>(-8192), vec4<i32>(8191)));
    queries[query * params.fours + part] = (coefficients.xz & vec2<u32>(0xffffu)) | coefficients.yw << vec2<u32>(16u);
}
