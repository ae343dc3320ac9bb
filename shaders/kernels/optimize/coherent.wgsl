// The nearest neighbourhood among those that continue what the voxels of a window came from. Mirrors `matches` of
// optimize/coherence.rs.
//
// A workgroup a voxel and direction: its threads propose, then share what is proposed. Whatever the order in which candidates are met, the
// first of the least cost in the order of the window is taken, so a pixel that was proposed before may be dropped or not.
#import breccia::bricks::{GROUP_ROW}
#import breccia::box::{place, strides, around}
#import breccia::matching::{Matching}
#import breccia::nearest::{even, odd, gap, weighed, better, code}

@group(0) @binding(0) var<uniform> params: Matching;
@group(0) @binding(1) var<storage, read> coefficients: array<vec4<u32>>;
// Indices of pixels, two a word.
@group(0) @binding(2) var<storage, read> sets: array<u32>;
@group(0) @binding(3) var<storage, read> weights: array<u32>;
// Pixels, two a word.
@group(0) @binding(4) var<storage, read> sources: array<u32>;
@group(0) @binding(5) var<storage, read> list: array<u32>;
@group(0) @binding(6) var<storage, read> queries: array<vec4<u32>>;
// For each voxel and direction the pixel, and the code of its distance above.
@group(0) @binding(7) var<storage, read_write> found: array<u32>;

// Marks a pixel whose set is proposed.
const NEAR: u32 = 0x10000u;
// Marks a pixel where no window fits.
const OUTSIDE: u32 = 0x20000u;
// Places in a window at most.
const MOST: u32 = 1024u;

// The coefficients of the voxel's window, of even and of odd places in turn.
var<workgroup> query: array<vec4<i32>, 16>;
// What continues each voxel of the window.
var<workgroup> continued: array<u32, MOST>;
// Index of the pixel, place in the window above: those that propose themselves from the front, those that propose sets from the back.
var<workgroup> proposed: array<u32, MOST>;
var<workgroup> alone: atomic<u32>;
var<workgroup> whole: atomic<u32>;
// The least cost that each thread met, and place, member and pixel in one word.
var<workgroup> bests: array<vec3<u32>, 64>;

fn source(base: u32, voxel: u32) -> u32 {
    let at = base + voxel;
    return sources[at >> 1u] >> (16u * (at & 1u)) & 0xffffu;
}

fn member(base: u32, at: u32) -> u32 {
    return sets[(base + at) >> 1u] >> (16u * ((base + at) & 1u)) & 0xffffu;
}

fn distance_to(base: u32, at: u32) -> u32 {
    var sum = 0u;
    for (var i = 0u; i < params.eights; i++) {
        sum += gap(query[2u * i], query[2u * i + 1u], coefficients[base + at * params.eights + i]);
    }
    return sum;
}

// The pixel that continues a source a step away.
fn leads_to(direction: u32, pixel: u32, along: i32, across: i32) -> u32 {
    let size = params.directions[direction].size;
    let bounds = params.directions[direction].bounds;
    var column = i32(pixel & 255u) - along;
    var line = i32(pixel >> 8u) - across;
    var mark = select(0u, NEAR, abs(along) <= params.reach && abs(across) <= params.reach);
    if size.z != 0 {
        // No window is larger than the view.
        column += select(0, size.x, column < 0);
        column -= select(0, size.x, column >= size.x);
        line += select(0, size.y, line < 0);
        line -= select(0, size.y, line >= size.y);
    } else if column < bounds.x || column > bounds.y || line < bounds.z || line > bounds.w {
        mark = OUTSIDE;
    }
    let last = u32(size.x * size.y - 1);
    return min(bitcast<u32>(line * size.x + column), last) | mark;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let at = params.first + group.x + GROUP_ROW * group.y;
    let number = at / params.wanted;
    if number >= params.count {
        return;
    }
    let slot = at % params.wanted;
    let size = params.directions[slot].size;
    let base = params.directions[slot].base;
    let direction = u32(size.w);
    let c = (direction + 1u) % 3u;
    let r = (direction + 2u) % 3u;
    let voxel = list[params.start + number];
    let here = place(voxel, params.size);
    let stride = strides(params.size);
    let own = here[direction] * stride[direction];
    if thread < params.eights {
        let packed = queries[at * params.eights + thread];
        query[2u * thread] = even(packed);
        query[2u * thread + 1u] = odd(packed);
    }
    let pixels = u32(params.window * params.window);
    for (var i = thread; i < pixels; i += 64u) {
        let along = i32(i) % params.window - params.lead;
        let across = i32(i) / params.window - params.lead;
        let column = around(here[c], along, params.size[c]);
        let row = around(here[r], across, params.size[r]);
        let pixel = source(base.w, own + row * stride[r] + column * stride[c]);
        continued[i] = leads_to(slot, pixel, along, across);
    }
    workgroupBarrier();
    for (var i = thread; i < pixels; i += 64u) {
        let mine = continued[i];
        // Most pixels were proposed by the voxel before or above already.
        let previous = continued[max(i, 1u) - 1u];
        let above = continued[max(i, u32(params.window)) - u32(params.window)];
        let again = i > 0u && (previous == mine || previous == (mine | NEAR))
            || i >= u32(params.window) && (above == mine || above == (mine | NEAR));
        if mine < OUTSIDE && !again {
            let entry = (mine & 0xffffu) | i << 16u;
            if mine < NEAR {
                proposed[atomicAdd(&alone, 1u)] = entry;
            } else {
                proposed[MOST - 1u - atomicAdd(&whole, 1u)] = entry;
            }
        }
    }
    workgroupBarrier();
    var singles = atomicLoad(&alone);
    let families = atomicLoad(&whole);
    if singles + families == 0u {
        // Every source lies so near to an edge that no window fits: the centre nearest to the voxel's own.
        let pixel = source(base.w, voxel);
        let bounds = params.directions[slot].bounds;
        let column = clamp(i32(pixel & 255u), bounds.x, bounds.y);
        let line = clamp(i32(pixel >> 8u), bounds.z, bounds.w);
        if thread == 0u {
            proposed[0] = u32(line * size.x + column);
        }
        singles = 1u;
    }
    workgroupBarrier();
    var best = vec3<u32>(0xffffffffu);
    var nearest = 0u;
    // In the order of the window, the members of each set in theirs: sixteen bits of the pixel, five of the member, ten of the place.
    let all = singles + families * params.members;
    for (var i = thread; i < all; i += 64u) {
        var entry = 0u;
        var which = 0u;
        if i < singles {
            entry = proposed[i];
        } else {
            entry = proposed[MOST - 1u - (i - singles) / params.members];
            which = (i - singles) % params.members;
        }
        var pixel = entry & 0xffffu;
        if which > 0u {
            pixel = member(base.y, pixel * params.room + which);
        }
        let distance = distance_to(base.x, pixel);
        let order = (entry >> 16u) << 5u | which;
        let candidate = vec3<u32>(weighed(distance, weights[base.z + pixel]), order << 16u | pixel);
        if better(candidate, best) {
            best = candidate;
            nearest = distance;
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
    // One thread met it: a place and member are proposed once.
    if best.z == bests[0].z && best.z != 0xffffffffu {
        let pixel = best.z & 0xffffu;
        let width = u32(size.x);
        found[at] = pixel % width | (pixel / width) << 8u | code(nearest) << 16u;
    }
}
