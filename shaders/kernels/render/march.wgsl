// A picture of a box of voxels, some opaque and the others as translucent as a table says, cut by planes. Mirrors `Scene::look` of
// render/march.rs, which marches in 64 bits: pictures agree closely, not bit for bit.
//
// A thread a pixel, four rays each. A ray reads a word a voxel, and the 125 voxels around the first opaque one.
#import breccia::bricks::GROUP_ROW

struct Params {
    // All in voxels, y down, z away: the eye, the ray through the picture's first corner, its steps from column to column and row to row.
    eye: vec4<f32>,
    ray: vec4<f32>,
    right: vec4<f32>,
    down: vec4<f32>,
    // Where light comes from.
    light: vec4<f32>,
    // What lies beyond n · p = d is not there; n is 0 where nothing is cut.
    cuts: array<vec4<f32>, 3>,
    size: vec4<i32>,
    width: u32,
    height: u32,
    // The first workgroup of this submission.
    first: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
// How much a voxel hides, by its key; then the linear light of a byte.
@group(0) @binding(1) var<storage, read> tables: array<f32>;
// Colours, and keys above them.
@group(0) @binding(2) var<storage, read> voxels: array<u32>;
// Two digits a voxel: whether there is anything, and whether it is opaque whatever the table says.
@group(0) @binding(3) var<storage, read> flags: array<u32>;
// Linear light times coverage, and coverage, of each pixel.
@group(0) @binding(4) var<storage, read_write> out: array<vec4<f32>>;

fn is_within(voxel: vec3<i32>) -> bool {
    return all(voxel >= vec3<i32>(0)) && all(voxel < params.size.xyz);
}

fn index(voxel: vec3<i32>) -> u32 {
    return u32((voxel.z * params.size.y + voxel.y) * params.size.x + voxel.x);
}

// What a voxel hides of what lies behind it: 0 to 1.
fn opacity(at: u32) -> f32 {
    let flag = flags[at >> 4u] >> (2u * (at & 15u)) & 3u;
    if (flag & 1u) == 0u {
        return 0.0;
    }
    if flag == 3u {
        return 1.0;
    }
    return tables[voxels[at] >> 24u];
}

fn lit(normal: vec3<f32>) -> f32 {
    return 0.42 + 0.68 * max(dot(normal, params.light.xyz), 0.0);
}

// How light a voxel is, from the way in which opaque voxels around it lie.
fn shade(voxel: vec3<i32>) -> f32 {
    var normal = vec3<i32>(0);
    for (var k = 0; k < 125; k++) {
        let d = vec3<i32>(k % 5, k / 5 % 5, k / 25) - 2;
        let near = voxel + d;
        if !is_within(near) || opacity(index(near)) < 1.0 {
            normal += d;
        }
    }
    if all(normal == vec3<i32>(0)) {
        return lit(params.light.xyz);
    }
    return lit(normalize(vec3<f32>(normal)));
}

fn look(eye: vec3<f32>, toward: vec3<f32>) -> vec4<f32> {
    // No component is zero, so that all quotients are numbers.
    let ray = select(toward, vec3<f32>(1e-9), abs(toward) < vec3<f32>(1e-9));
    let size = vec3<f32>(params.size.xyz);
    let a = -eye / ray;
    let b = (size - eye) / ray;
    let low = min(a, b);
    let high = max(a, b);
    var enter = max(max(low.x, low.y), max(low.z, 0.0));
    let leave = min(min(high.x, high.y), high.z);
    // Where the last cut ends the ray, and the cut through which it enters.
    var end = 3e38;
    var face = 3u;
    for (var k = 0u; k < 3u; k++) {
        let cut = params.cuts[k];
        let above = dot(cut.xyz, eye) - cut.w;
        let slope = dot(cut.xyz, ray);
        if abs(slope) < 1e-12 {
            if above > 0.0 {
                return vec4<f32>(0.0);
            }
            continue;
        }
        let t = -above / slope;
        if slope > 0.0 {
            end = min(end, t);
        } else if t > enter {
            enter = t;
            face = k;
        }
    }
    if enter >= min(leave, end) {
        return vec4<f32>(0.0);
    }
    let start = eye + ray * (enter * 1.000001);
    var voxel = vec3<i32>(clamp(floor(start), vec3<f32>(0.0), size - 1.0));
    let stride = select(vec3<i32>(1), vec3<i32>(-1), ray < vec3<f32>(0.0));
    var next = (vec3<f32>(voxel + max(stride, vec3<i32>(0))) - eye) / ray;
    let further = abs(1.0 / ray);
    let far = length(ray);
    var light = vec3<f32>(0.0);
    var cover = 0.0;
    var t = enter;
    while is_within(voxel) && t < end {
        var axis = 2u;
        if next.x <= next.y && next.x <= next.z {
            axis = 0u;
        } else if next.y <= next.z {
            axis = 1u;
        }
        let until = next[axis];
        let at = index(voxel);
        var part = opacity(at);
        var shading = 0.8;
        if part >= 1.0 {
            part = 1.0;
            if face < 3u && t == enter {
                shading = lit(params.cuts[face].xyz);
            } else {
                shading = shade(voxel);
            }
        } else if part > 0.0 {
            part = 1.0 - pow(1.0 - part, max(min(until, end) - t, 0.0) * far);
        }
        if part > 0.0 {
            let color = unpack4xU8(voxels[at]);
            let linear = vec3<f32>(tables[256u + color.x], tables[256u + color.y], tables[256u + color.z]);
            light += (1.0 - cover) * part * shading * linear;
            cover += (1.0 - cover) * part;
            if cover > 0.995 {
                break;
            }
        }
        t = until;
        voxel[axis] += stride[axis];
        next[axis] += further[axis];
    }
    return vec4<f32>(light, cover);
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let tiles = (params.width + 7u) / 8u;
    let tile = params.first + group.x + GROUP_ROW * group.y;
    // A workgroup draws a square, whose rays read the same voxels.
    let x = tile % tiles * 8u + thread % 8u;
    let y = tile / tiles * 8u + thread / 8u;
    if x >= params.width || y >= params.height {
        return;
    }
    var sum = vec4<f32>(0.0);
    for (var k = 0u; k < 4u; k++) {
        let place = vec2<f32>(f32(x), f32(y)) + vec2<f32>(f32(k % 2u), f32(k / 2u)) * 0.5 + 0.25;
        sum += look(params.eye.xyz, params.ray.xyz + place.x * params.right.xyz + place.y * params.down.xyz);
    }
    out[y * params.width + x] = 0.25 * sum;
}
