// For every pixel those with the most similar coefficients, kept apart. Mirrors `similar_sets` of search/similar.rs and `view_sets` of
// lazy/similarity.rs.
//
// A workgroup a pixel, whose threads share the centres. In every round all centres are compared again and the nearest that keeps its distance
// from the members so far becomes one; whoever was passed over before lies too near to a member for good. So nothing has
// to be sorted or kept. The processor looks at no more than the `keep` nearest: the next round counts how many were nearer.
#import breccia::bricks::{GROUP_ROW}
#import breccia::nearest::{even, odd, gap, before}

struct Params {
    // Width, height, whether the picture continues at the opposite edge, least distance between members.
    size: vec4<i32>,
    // Coefficients, in eights.
    eights: u32,
    centres: u32,
    // Members of a set, at most 32.
    members: u32,
    keep: u32,
    // The pixels: how many.
    count: u32,
    // The first workgroup of this submission.
    first: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
// Of every pixel, row by row, two a word.
@group(0) @binding(1) var<storage, read> coefficients: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> centres: array<u32>;
// For every pixel the centre nearest to it; above whether that is the first of its set.
@group(0) @binding(3) var<storage, read> own: array<u32>;
// For every pixel its set; what is missing is all ones.
@group(0) @binding(4) var<storage, read_write> sets: array<u32>;

const NONE: vec2<u32> = vec2<u32>(0xffffffffu, 0xffffffffu);

var<workgroup> query: array<vec4<i32>, 16>;
var<workgroup> chosen: array<u32, 32>;
// The nearest that each thread met and its number, and how many it met that are nearer than the last member.
var<workgroup> bests: array<vec2<u32>, 64>;
var<workgroup> nearer: array<u32, 64>;
var<workgroup> winner: vec2<u32>;
var<workgroup> rank: u32;

fn index(pixel: u32) -> u32 {
    return (pixel >> 8u) * u32(params.size.x) + (pixel & 255u);
}

fn distance_to(pixel: u32) -> u32 {
    let row = index(pixel) * params.eights;
    var sum = 0u;
    for (var i = 0u; i < params.eights; i++) {
        sum += gap(query[2u * i], query[2u * i + 1u], coefficients[row + i]);
    }
    return sum;
}

// The larger of the distances along x and y.
fn apart(a: u32, b: u32) -> i32 {
    var d = abs(vec2<i32>(i32(a & 255u), i32(a >> 8u)) - vec2<i32>(i32(b & 255u), i32(b >> 8u)));
    if params.size.z != 0 {
        d = min(d, params.size.xy - d);
    }
    return max(d.x, d.y);
}

fn keeps_distance(pixel: u32, members: u32) -> bool {
    for (var i = 0u; i < members; i++) {
        if apart(chosen[i], pixel) < params.size.w {
            return false;
        }
    }
    return true;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let at = params.first + group.x + GROUP_ROW * group.y;
    if at >= params.count {
        return;
    }
    let mine = own[at];
    if thread < params.eights {
        let packed = coefficients[index(mine & 0xffffu) * params.eights + thread];
        query[2u * thread] = even(packed);
        query[2u * thread + 1u] = odd(packed);
    }
    var members = mine >> 16u;
    if thread == 0u && members == 1u {
        chosen[0] = mine & 0xffffu;
    }
    // The last member, if it is still to be found out whether it was near enough.
    var last = NONE;
    var asks = false;
    // Every round adds a member or is the last.
    for (var round = 0u; round <= params.members; round++) {
        workgroupBarrier();
        var best = NONE;
        var count = 0u;
        for (var i = thread; i < params.centres; i += 64u) {
            let pixel = centres[i];
            let candidate = vec2<u32>(distance_to(pixel), i);
            count += select(0u, 1u, before(candidate, last));
            if before(candidate, best) && keeps_distance(pixel, members) {
                best = candidate;
            }
        }
        bests[thread] = best;
        nearer[thread] = count;
        for (var step = 32u; step > 0u; step >>= 1u) {
            workgroupBarrier();
            if thread < step {
                nearer[thread] += nearer[thread + step];
                if before(bests[thread + step], bests[thread]) {
                    bests[thread] = bests[thread + step];
                }
            }
        }
        if thread == 0u {
            winner = bests[0];
            rank = nearer[0];
        }
        let found = workgroupUniformLoad(&winner);
        if asks && workgroupUniformLoad(&rank) >= params.keep {
            members--;
            break;
        }
        if members == params.members || all(found == NONE) {
            break;
        }
        if thread == 0u {
            chosen[members] = centres[found.y];
        }
        members++;
        last = found;
        asks = params.keep < params.centres;
        if members == params.members && !asks {
            break;
        }
    }
    workgroupBarrier();
    for (var i = thread; i < params.members; i += 64u) {
        sets[at * params.members + i] = select(0xffffffffu, chosen[i], i < members);
    }
}
