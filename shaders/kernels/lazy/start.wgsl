// The start level before its first correction: slab or random pixels, distorted. Mirrors `Field::start` of lazy/field.rs,
// `Initial::triple` of lazy/initial.rs and `Jitter::displacements` of lazy/jitter.rs.
#import breccia::bricks::{LINKS, KEY, ABSENT, STATE, GROUP_ROW, modulo, divide, position}
#import breccia::level::{Level, pixel, pixel_index, nearest, mean}
#import breccia::random::{mix_in, hash}

struct Params {
    seed: vec2<u32>,
    // Width and height of the slab; a width of 0 means random pixels.
    slab: vec2<i32>,
    // The pixels of voxels that another solid has, as in a state.
    taken: vec2<u32>,
    bricks: u32,
    aligned: u32,
    // Where the masks of wanted voxels begin, and those of free ones or all ones.
    wanted: u32,
    free: u32,
    jitter: u32,
}

struct Gaussian {
    // Centre from the brick's first voxel, in 256ths; largest squared distance that it reaches.
    centre: vec4<i32>,
    // Push in 1024ths; shift in the lowest eight bits, factor above.
    push: vec4<i32>,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<uniform> level: Level;
@group(0) @binding(2) var<storage, read> tables: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> links: array<u32>;
@group(0) @binding(4) var<storage, read> masks: array<u32>;
@group(0) @binding(5) var<storage, read> slab: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read> gaussians: array<Gaussian>;
// For every brick where its Gaussians begin, and the end; behind them the falling exponential.
@group(0) @binding(7) var<storage, read> ranges: array<u32>;
@group(0) @binding(8) var<storage, read_write> state: array<u32>;

fn displacement(slot: u32, local: vec3<i32>) -> vec3<i32> {
    var sum = vec3<i32>(0);
    for (var i = ranges[slot]; i < ranges[slot + 1u]; i++) {
        let gaussian = gaussians[i];
        let d = local * 256 + 128 - gaussian.centre.xyz;
        let square = dot(d, d);
        if square <= gaussian.centre.w {
            let shape = bitcast<u32>(gaussian.push.w);
            let at = min((u32(square) >> (shape & 255u)) * (shape >> 8u) >> 16u, 1152u);
            let weight = i32(ranges[params.bricks + 1u + at]);
            sum += (gaussian.push.xyz * weight) >> vec3<u32>(8u);
        }
    }
    return (sum + (1 << 17u)) >> vec3<u32>(18u);
}

fn draw(e: u32, h: u32) -> u32 {
    let size = level.views[e].size;
    let x = ((h & 0xffffu) * u32(size.x - 2 * size.w)) >> 16u;
    let y = ((h >> 16u) * u32(size.y - 2 * size.w)) >> 16u;
    return pixel(size, size.w + i32(x), size.w + i32(y));
}

fn barred(e: u32, p: u32) -> bool {
    let at = level.views[e].base.x + 2u * pixel_index(level.views[e].size, p);
    return (tables[at + 1u].y & 1u) != 0u;
}

fn random_pixel(e: u32, voxel: vec3<i32>) -> u32 {
    let first = hash(params.seed, 2u + e, voxel);
    for (var k = 0u; k < 32u; k++) {
        var h = first;
        if k > 0u {
            h = mix_in(first, k);
        }
        let p = draw(e, h);
        if !barred(e, p) {
            return p;
        }
    }
    return draw(e, first);
}

fn triple(voxel: vec3<i32>) -> vec2<u32> {
    if params.slab.x == 0 {
        return vec2<u32>(
            random_pixel(0u, voxel) | random_pixel(1u, voxel) << 16u,
            random_pixel(2u, voxel),
        );
    }
    let layer = select(divide(voxel.z, 5), 0, params.aligned != 0u);
    let shift = hash(params.seed, 1u, vec3<i32>(0, 0, layer));
    let x = modulo(voxel.x + i32(shift & 0xffffu), params.slab.x);
    let y = modulo(voxel.y + i32(shift >> 16u), params.slab.y);
    return slab[(modulo(voxel.z, 5) * params.slab.y + y) * params.slab.x + x];
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let at = (group.x + GROUP_ROW * group.y) * 64u + thread;
    let slot = at >> 9u;
    if slot >= params.bricks {
        return;
    }
    let i = at & 511u;
    let word = slot * 16u + (i >> 5u);
    if (masks[params.wanted + word] >> (i & 31u) & 1u) == 0u {
        return;
    }
    let base = slot * LINKS + KEY;
    let key = bitcast<vec3<i32>>(vec3<u32>(links[base], links[base + 1u], links[base + 2u]));
    let local = position(i);
    var pixels = params.taken;
    if params.free == ABSENT || (masks[params.free + word] >> (i & 31u) & 1u) == 1u {
        var voxel = key * 8 + local;
        if params.jitter != 0u {
            voxel += displacement(slot, local);
        }
        pixels = triple(voxel);
    }
    var colors: array<u32, 3>;
    for (var e = 0u; e < 3u; e++) {
        let p = select(pixels.x >> (16u * (e & 1u)), pixels.y, e == 2u) & 0xffffu;
        colors[e] = tables[level.views[e].base.z + 3u * pixel_index(level.views[e].size, p) + 2u].z;
    }
    let shown = nearest(colors, level.middle, level.color.x);
    var color = colors[shown];
    if level.color.y == 0u {
        color = mean(colors);
    }
    let to = slot * STATE + i;
    state[to] = color;
    state[to + 512u] = pixels.x;
    state[to + 1024u] = pixels.y | shown << 16u;
}
