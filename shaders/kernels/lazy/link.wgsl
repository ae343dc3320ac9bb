// Finds the bricks around every brick. Mirrors `Field::fill_window` of lazy/field.rs, as far as it looks bricks up.
#import breccia::bricks::{LINKS, KEY, ABSENT, GROUP_ROW, lengths, wrapped, hash_key}

struct Params {
    period: vec4<i32>,
    bricks: u32,
    // One less than the number of places in the table, a power of two.
    mask: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
// Keys with their slots, at the place of their hash or behind it; a slot of -1 is empty.
@group(0) @binding(1) var<storage, read> places: array<vec4<i32>>;
@group(0) @binding(2) var<storage, read> keys: array<vec4<i32>>;
@group(0) @binding(3) var<storage, read_write> links: array<u32>;

fn find(key: vec3<i32>) -> u32 {
    var at = hash_key(key) & params.mask;
    // The table is at most half full, so this ends.
    for (var tries = 0u; tries <= params.mask; tries++) {
        let entry = places[at];
        if entry.w < 0 {
            return ABSENT;
        }
        if all(entry.xyz == key) {
            return u32(entry.w);
        }
        at = (at + 1u) & params.mask;
    }
    return ABSENT;
}

fn offset(side: u32, length: i32) -> i32 {
    if side < 2u {
        return i32(side) - 2;
    }
    if side == 2u {
        return 0;
    }
    return length + i32(side) - 3;
}

@compute @workgroup_size(128)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let slot = group.x + GROUP_ROW * group.y;
    if slot >= params.bricks {
        return;
    }
    let key = keys[slot].xyz;
    if thread >= KEY {
        links[slot * LINKS + thread] = bitcast<u32>(key[thread - KEY]);
        return;
    }
    let length = lengths(key, params.period);
    let q = vec3<i32>(
        offset(thread % 5u, length.x),
        offset(thread / 5u % 5u, length.y),
        offset(thread / 25u, length.z),
    );
    links[slot * LINKS + thread] = find(wrapped(key * 8 + q, params.period) >> vec3<u32>(3u));
}
