// A level before its first correction: every voxel inherits its parent's pixels, doubled. Mirrors `Field::upsample` of
// lazy/field.rs.
#import breccia::bricks::{LINKS, KEY, ABSENT, STATE, GROUP_ROW, position, index}
#import breccia::level::{Level, pixel, pixel_index, nearest, mean}

struct Params {
    bricks: u32,
    wanted: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<uniform> level: Level;
@group(0) @binding(2) var<storage, read> tables: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> links: array<u32>;
@group(0) @binding(4) var<storage, read> masks: array<u32>;
// For every brick the slot of the coarser brick that it descends from.
@group(0) @binding(5) var<storage, read> ancestors: array<u32>;
@group(0) @binding(6) var<storage, read> coarse: array<u32>;
@group(0) @binding(7) var<storage, read_write> state: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let at = (group.x + GROUP_ROW * group.y) * 64u + thread;
    let slot = at >> 9u;
    if slot >= params.bricks {
        return;
    }
    let i = at & 511u;
    let ancestor = ancestors[slot];
    if ancestor == ABSENT || (masks[params.wanted + slot * 16u + (i >> 5u)] >> (i & 31u) & 1u) == 0u {
        return;
    }
    let base = slot * LINKS + KEY;
    let key = bitcast<vec3<i32>>(vec3<u32>(links[base], links[base + 1u], links[base + 2u]));
    let local = position(i);
    let source = ancestor * STATE + index((key & vec3<i32>(1)) * 4 + (local >> vec3<u32>(1u)));
    let parents = vec2<u32>(coarse[source + 512u], coarse[source + 1024u]);
    var colors: array<u32, 3>;
    var pixels: array<u32, 3>;
    for (var e = 0u; e < 3u; e++) {
        let parent = select(parents.x >> (16u * (e & 1u)), parents.y, e == 2u);
        let x = 2 * i32(parent & 255u) + (local[(e + 1u) % 3u] & 1);
        let y = 2 * i32(parent >> 8u & 255u) + (local[(e + 2u) % 3u] & 1);
        let size = level.views[e].size;
        pixels[e] = pixel(size, x, y);
        colors[e] = tables[level.views[e].base.z + 3u * pixel_index(size, pixels[e]) + 2u].z;
    }
    let shown = nearest(colors, level.middle, level.color.x);
    var color = colors[shown];
    if level.color.y == 0u {
        color = mean(colors);
    }
    let to = slot * STATE + i;
    state[to] = color;
    state[to + 512u] = pixels[0] | pixels[1] << 16u;
    state[to + 1024u] = pixels[2] | shown << 16u;
}
