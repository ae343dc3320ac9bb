// Colours of voxels from the matches around them. Mirrors `solve_voxels` of optimize/solve.rs, up to rounding: sums are taken in
// the same order, but a device may contract a product and a sum to one operation, and divide less exactly.
//
// A thread a voxel. It meets the texels that overlap there twice: once for their mean, once for the one nearest to it.
#import breccia::bricks::{GROUP_ROW}
#import breccia::box::{place, strides, around}

struct Params {
    // Voxels along x, y and z, and in all.
    size: vec4<u32>,
    // For each direction that is matched the direction and its view.
    directions: array<vec4<u32>, 3>,
    // For each view where its texels begin, texels along a row, and rows and columns before its first pixel.
    views: array<vec4<u32>, 3>,
    // Directions that are matched, those first, and views.
    wanted: u32,
    count_of_views: u32,
    // Pixels along a window, and those after its centre: as many lie before the centre of the mirrored one.
    window: u32,
    lead: i32,
    // Whether the mean is the colour.
    mean: u32,
    // The voxels: where in the list they begin, and how many.
    start: u32,
    count: u32,
    // The first workgroup of this submission.
    first: u32,
}

struct Texel {
    // Four channels of a byte.
    color: u32,
    weight: f32,
}

@group(0) @binding(0) var<uniform> params: Params;
// The weight of a match for each code of a distance.
@group(0) @binding(1) var<storage, read> weights: array<f32>;
// For each direction that is matched and each voxel the pixel, and the code of its distance above.
@group(0) @binding(2) var<storage, read> matches: array<u32>;
// The texels of each view with a margin, so that windows never leave it.
@group(0) @binding(3) var<storage, read> texels: array<Texel>;
// The pixels that they are, two a word.
@group(0) @binding(4) var<storage, read> pixels: array<u32>;
@group(0) @binding(5) var<storage, read> list: array<u32>;
// For each voxel three words: the colour; the nearest pixels of two views; that of the third, and the chosen view above.
@group(0) @binding(6) var<storage, read_write> solved: array<u32>;

// Greater than every squared distance of colours.
const FAR: f32 = 3e38;

fn channels(color: u32) -> vec4<f32> {
    return vec4<f32>(vec4<u32>(color, color >> 8u, color >> 16u, color >> 24u) & vec4<u32>(255u));
}

fn pixel(texel: u32) -> u32 {
    return pixels[texel >> 1u] >> (16u * (texel & 1u)) & 0xffffu;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let at = (params.first + group.x + GROUP_ROW * group.y) * 64u + thread;
    if at >= params.count {
        return;
    }
    let voxel = list[params.start + at];
    let here = place(voxel, params.size);
    let stride = strides(params.size);
    var sums = vec4<f32>(0.0);
    var total = 0.0;
    var mean = vec4<f32>(0.0);
    var best = array<f32, 3>(FAR, FAR, FAR);
    var nearest = array<u32, 3>(params.views[0].x, params.views[1].x, params.views[2].x);
    // First the mean, then the texels nearest to it.
    for (var turn = 0u; turn < 2u; turn++) {
        for (var slot = 0u; slot < params.wanted; slot++) {
            let direction = params.directions[slot].x;
            let number = params.directions[slot].y;
            let view = params.views[number];
            let c = (direction + 1u) % 3u;
            let r = (direction + 2u) % 3u;
            let own = slot * params.size.w + here[direction] * stride[direction];
            let left = around(here[c], -params.lead, params.size[c]);
            var row = around(here[r], -params.lead, params.size[r]);
            var gap_here = best[number];
            var texel_here = nearest[number];
            for (var i = 0u; i < params.window; i++) {
                var column = left;
                // The texel lies as far after the match's centre as the voxel lies after the matched one.
                let offset = view.x + (view.z + u32(params.lead) - i) * view.y + view.z + u32(params.lead);
                for (var k = 0u; k < params.window; k++) {
                    let matched = matches[own + row * stride[r] + column * stride[c]];
                    let index = offset + (matched >> 8u & 255u) * view.y + (matched & 255u) - k;
                    let texel = texels[index];
                    let color = channels(texel.color);
                    if turn == 0u {
                        let weight = weights[matched >> 16u & 2047u] * texel.weight;
                        sums += weight * color;
                        total += weight;
                    } else {
                        let difference = color - mean;
                        let squares = difference * difference;
                        let gap = (squares.x + squares.z) + (squares.y + squares.w);
                        if gap < gap_here {
                            gap_here = gap;
                            texel_here = index;
                        }
                    }
                    column = select(column + 1u, 0u, column + 1u == params.size[c]);
                }
                row = select(row + 1u, 0u, row + 1u == params.size[r]);
            }
            best[number] = gap_here;
            nearest[number] = texel_here;
        }
        if total > 0.0 {
            mean = sums / total;
        }
    }
    var chosen = 0u;
    for (var view = 1u; view < params.count_of_views; view++) {
        if best[view] < best[chosen] {
            chosen = view;
        }
    }
    var color = texels[nearest[chosen]].color;
    if params.mean != 0u {
        let rounded = min(vec4<u32>(mean + vec4<f32>(0.5)), vec4<u32>(255u));
        color = rounded.x | rounded.y << 8u | rounded.z << 16u | rounded.w << 24u;
    }
    solved[3u * at] = color;
    solved[3u * at + 1u] = pixel(nearest[0]) | pixel(nearest[1]) << 16u;
    solved[3u * at + 2u] = pixel(nearest[2]) | chosen << 16u;
}
