// One sub-pass: every listed voxel gets the triple of least cost. Mirrors `correct` of lazy/kernel.rs; `corrected` of lazy/oracle.rs
// tells the same step by step.
//
// A thread a voxel. Per voxel it reads 61 neighbours, at most 3 · 9 similarity sets and their records, and at most 36 triples, all
// from tables that fit into a cache of some megabytes; it does about 6,000 multiplications. So arithmetic and the cache's
// latency are its limit, not the memory behind.
#import breccia::bricks::{LINKS, KEY, STATE, GROUP_ROW, lengths, link, place, position, index}
#import breccia::level::{Level, pixel_index, nearest, mean}

struct Params {
    // The first workgroup of this submission.
    first: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<uniform> level: Level;
@group(0) @binding(2) var<storage, read> tables: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> links: array<u32>;
// The number of voxels, then the voxels.
@group(0) @binding(4) var<storage, read> list: array<u32>;
@group(0) @binding(5) var<storage, read> before: array<u32>;
@group(0) @binding(6) var<storage, read_write> after: array<u32>;

// What one direction knows of a voxel.
struct Direction {
    // The descriptor of its neighbourhood, a byte a component.
    descriptor: vec4<u32>,
    norm: u32,
    // The pixels that continue a neighbour.
    continued: array<u32, 9>,
    best: u32,
    cost: i32,
}

var<private> directions: array<Direction, 3>;

const WORST: i32 = 0x7fffffff;

// The sum of squared differences of four bytes.
fn apart(a: u32, b: u32) -> u32 {
    return dot4U8Packed(a, a) + dot4U8Packed(b, b) - 2u * dot4U8Packed(a, b);
}

// The sum of squares of a descriptor's components.
fn norm(a: vec4<u32>) -> u32 {
    return dot4U8Packed(a.x, a.x) + dot4U8Packed(a.y, a.y) + dot4U8Packed(a.z, a.z) + dot4U8Packed(a.w, a.w);
}

fn record(e: u32, p: u32) -> u32 {
    return level.views[e].base.x + 2u * pixel_index(level.views[e].size, p);
}

// The cost of a pixel for one direction.
fn cost(e: u32, p: u32) -> i32 {
    let at = record(e, p);
    let descriptor = tables[at];
    // Usage weight; sum of squares, above a bit.
    let rest = tables[at + 1u].xy;
    let mine = directions[e].descriptor;
    // |a − b|² = |a|² + |b|² − 2 a·b
    var product = dot4U8Packed(mine.x, descriptor.x) + dot4U8Packed(mine.y, descriptor.y);
    if level.color.z > 2u {
        product += dot4U8Packed(mine.z, descriptor.z) + dot4U8Packed(mine.w, descriptor.w);
    }
    let distance = directions[e].norm + (rest.y >> 1u) - 2u * product;
    var factor = level.costs.z;
    for (var k = 0; k < 9; k++) {
        if directions[e].continued[k] == p {
            factor = 256u;
        }
    }
    return i32((distance * factor) >> 8u) + bitcast<i32>(rest.x);
}

// The pixel one step beyond another, around the picture or at its edge.
fn stepped(size: vec4<i32>, at: vec2<i32>) -> u32 {
    var to = clamp(at, vec2<i32>(size.w), size.xy - 1 - size.w);
    if size.z != 0 {
        to = select(select(at, at + size.xy, at < vec2<i32>(0)), at - size.xy, at >= size.xy);
    }
    return u32(to.x | to.y << 8u);
}

// Projects the neighbourhood across one direction, and finds the best pixel among those that its neighbours lead to.
fn search(e: u32, slot: u32, key: vec3<i32>, length: vec3<i32>, local: vec3<i32>) {
    let u = (e + 1u) % 3u;
    let v = (e + 2u) % 3u;
    let size = level.views[e].size;
    var sums = level.views[e].bias;
    for (var k = 0u; k < 25u; k++) {
        let du = i32(k % 5u) - 2;
        let dv = i32(k / 5u) - 2;
        var q = local;
        q[u] += du;
        q[v] += dv;
        let near = links[slot * LINKS + link(q, length)] * STATE + index(place(key, q, level.period));
        // Bytes from -128 on, as the weights are signed; the bias makes up for it.
        let color = before[near] ^ 0x80808080u;
        for (var d = 0u; d < level.color.z; d++) {
            let weights = level.views[e].weights[k * 4u + d];
            sums[d] += vec4<i32>(
                dot4I8Packed(color, weights.x),
                dot4I8Packed(color, weights.y),
                dot4I8Packed(color, weights.z),
                dot4I8Packed(color, weights.w),
            );
        }
        if abs(du) <= 1 && abs(dv) <= 1 {
            let word = before[near + select(512u, 1024u, e == 2u)];
            let p = select(word, word >> 16u, e == 1u);
            let step = vec2<i32>(i32(p & 255u), i32(p >> 8u & 255u)) - vec2<i32>(du, dv);
            directions[e].continued[u32((dv + 1) * 3 + du + 1)] = stepped(size, step);
        }
    }
    let shift = vec4<u32>(level.views[e].base.w);
    directions[e].descriptor = vec4<u32>(0u);
    for (var d = 0u; d < level.color.z; d++) {
        directions[e].descriptor[d] = pack4xU8(vec4<u32>(clamp(sums[d] >> shift, vec4<i32>(0), vec4<i32>(127))));
    }
    directions[e].norm = norm(directions[e].descriptor);
    var least = WORST;
    var best = 0u;
    for (var k = 0; k < 9; k++) {
        let leading = directions[e].continued[k];
        // Neighbours in one patch all lead to the same pixel, whose set is tried once.
        var repeated = false;
        for (var i = 0; i < k; i++) {
            repeated = repeated || directions[e].continued[i] == leading;
        }
        if repeated {
            continue;
        }
        let sets = tables[record(e, leading) + 1u].zw;
        for (var i = 0u; i < level.costs.x; i++) {
            let p = (sets[i >> 1u] >> (16u * (i & 1u))) & 0xffffu;
            let c = cost(e, p);
            if c < least {
                least = c;
                best = p;
            }
        }
    }
    directions[e].cost = least;
    directions[e].best = best;
}

// (a b) >> 24 of a product of 64 bits.
fn scaled(a: u32, b: u32) -> i32 {
    let low = (a & 0xffffu) * (b & 0xffffu);
    let left = (a & 0xffffu) * (b >> 16u);
    let right = (a >> 16u) * (b & 0xffffu);
    let middle = (low >> 16u) + (left & 0xffffu) + (right & 0xffffu);
    let high = (a >> 16u) * (b >> 16u) + (left >> 16u) + (right >> 16u) + (middle >> 16u);
    return i32(high << 8u | (middle >> 8u & 0xffu));
}

fn strips(e: u32, p: u32) -> u32 {
    return level.views[e].base.z + 3u * pixel_index(level.views[e].size, p);
}

// The squared difference of the column of one pixel and the row of another.
fn line(column: u32, row: u32) -> u32 {
    let a = tables[column + 1u];
    let b = tables[column + 2u];
    let c = tables[row];
    return apart(a.y, c.x) + apart(a.z, c.y) + apart(a.w, c.z) + apart(b.x, c.w)
        + apart(b.y, tables[row + 1u].x);
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let at = (params.first + group.x + GROUP_ROW * group.y) * 64u + thread;
    if at >= list[0] {
        return;
    }
    let voxel = list[at + 1u];
    let slot = voxel >> 9u;
    let local = position(voxel & 511u);
    let base = slot * LINKS + KEY;
    let key = bitcast<vec3<i32>>(vec3<u32>(links[base], links[base + 1u], links[base + 2u]));
    let length = lengths(key, level.period);

    for (var e = 0u; e < 3u; e++) {
        search(e, slot, key, length, local);
    }
    var pixels = array<u32, 3>(directions[0].best, directions[1].best, directions[2].best);
    let x = strips(0u, pixels[0]);
    let y = strips(1u, pixels[1]);
    let z = strips(2u, pixels[2]);
    let crossbar = line(x, y) + line(y, z) + line(z, x);
    // The mixed triple first, then those kept at the three best pixels.
    var least = directions[0].cost + directions[1].cost + directions[2].cost + scaled(crossbar, level.costs.w);
    var bests = pixels;
    for (var e = 0u; e < 3u; e++) {
        let next = (e + 1u) % 3u;
        let last = (e + 2u) % 3u;
        let source = level.views[e].base.y + 6u * pixel_index(level.views[e].size, bests[e]);
        for (var k = 0u; k < level.costs.y; k++) {
            let pair = tables[source + (k >> 1u)];
            let found = select(pair.xy, pair.zw, (k & 1u) == 1u);
            let p = found.x & 0xffffu;
            let q = found.x >> 16u;
            let c = directions[e].cost + scaled(found.y, level.costs.w)
                + cost(next, p) + cost(last, q);
            if c < least {
                least = c;
                pixels[e] = bests[e];
                pixels[next] = p;
                pixels[last] = q;
            }
        }
    }
    var colors: array<u32, 3>;
    for (var e = 0u; e < 3u; e++) {
        colors[e] = tables[strips(e, pixels[e]) + 2u].z;
    }
    let shown = nearest(colors, level.middle, level.color.x);
    var color = colors[shown];
    if level.color.y == 0u {
        color = mean(colors);
    }
    let to = slot * STATE + (voxel & 511u);
    after[to] = color;
    after[to + 512u] = pixels[0] | pixels[1] << 16u;
    after[to + 1024u] = pixels[2] | shown << 16u;
}
