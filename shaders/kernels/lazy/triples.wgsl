// For each pixel the triples of least crossbar error among the pairs of its best strips. Mirrors `consistent_triples` of
// lazy/candidates.rs.
//
// A workgroup a pixel. Three times the least of many keys are wanted, in order: strips of the next exemplar, strips of the last, and pairs of them. The
// keys are computed again for each digit of the greatest key that is taken, instead of being kept; then those up to it
// are collected and sorted by counting. A key is an error of at most 22 binary digits and a number of 16, so no two are equal.
#import breccia::bricks::{GROUP_ROW}
#import breccia::level::{pixel, pixel_index}

struct Params {
    // Width, height, whether the picture continues at the opposite edge, margin: of this view.
    size: vec4<i32>,
    // For the next and the last view: the width, where strips and centres begin, and how many centres there are.
    next: vec4<u32>,
    last: vec4<u32>,
    // Where the strips of this view begin.
    strips: u32,
    // Strips taken of each view, and triples taken.
    most: u32,
    best: u32,
    exclusion: i32,
    // The first pixel, and how many.
    start: u32,
    count: u32,
    // The first workgroup of this submission.
    first: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
// For every pixel of every view five words of its row, and five of its column.
@group(0) @binding(1) var<storage, read> strips: array<u32>;
@group(0) @binding(2) var<storage, read> centres: array<u32>;
// For every pixel how many triples there are; then each one's pixels, that of the last view above, and its error.
@group(0) @binding(3) var<storage, read_write> triples: array<u32>;

const STRIP: u32 = 10u;
const COLUMN: u32 = 5u;
// Strips and triples that there is room for.
const MOST: u32 = 256u;
const ROOM: u32 = 400u;
// What is looked for.
const NEXT: u32 = 0u;
const LAST: u32 = 1u;
const PAIRS: u32 = 2u;

var<workgroup> histogram: array<atomic<u32>, 256>;
var<workgroup> sums: array<u32, 256>;
// The digit in which the greatest key lies, the keys of smaller ones, and whether all of its keys are taken.
var<workgroup> digit: vec3<u32>;
var<workgroup> collected: atomic<u32>;
var<workgroup> keys: array<vec2<u32>, ROOM>;
// Of both other views the strips that were taken: error and number of the centre.
var<workgroup> nexts: array<vec2<u32>, MOST>;
var<workgroup> lasts: array<vec2<u32>, MOST>;

// This workgroup's pixel, where its strips begin, and how many strips were taken.
var<private> own: u32;
var<private> own_strips: u32;
var<private> next_count: u32;
var<private> last_count: u32;

// The squared difference of two pieces of five pixels.
fn line(a: u32, b: u32) -> u32 {
    var sum = 0u;
    for (var i = 0u; i < 5u; i++) {
        let p = strips[a + i];
        let q = strips[b + i];
        sum += dot4U8Packed(p, p) + dot4U8Packed(q, q) - 2u * dot4U8Packed(p, q);
    }
    return sum;
}

fn strip_of(view: vec4<u32>, number: u32) -> u32 {
    let centre = centres[view.z + number];
    return view.y + STRIP * ((centre >> 8u) * view.x + (centre & 255u));
}

// Whether a pixel lies too near to this one.
fn excluded(other: u32) -> bool {
    if params.exclusion <= 0 {
        return false;
    }
    var d = abs(vec2<i32>(i32(own & 255u), i32(own >> 8u)) - vec2<i32>(i32(other & 255u), i32(other >> 8u)));
    if params.size.z != 0 {
        d = min(d, params.size.xy - d);
    }
    return max(d.x, d.y) < params.exclusion;
}

const SKIPPED: u32 = 0xffffffffu;

// The error of a strip or a pair, or that it is none.
fn error(what: u32, number: u32) -> u32 {
    if what == PAIRS {
        let a = nexts[number / last_count];
        let b = lasts[number % last_count];
        return a.x + b.x + line(strip_of(params.next, a.y) + COLUMN, strip_of(params.last, b.y));
    }
    if what == NEXT {
        if excluded(centres[params.next.z + number]) {
            return SKIPPED;
        }
        return line(own_strips + COLUMN, strip_of(params.next, number));
    }
    if excluded(centres[params.last.z + number]) {
        return SKIPPED;
    }
    return line(own_strips, strip_of(params.last, number) + COLUMN);
}

// Eight binary digits of a key, the highest first.
fn digit_of(key: vec2<u32>, place: u32) -> u32 {
    if place < 3u {
        return key.x >> (16u - 8u * place) & 255u;
    }
    return key.y >> (32u - 8u * place) & 255u;
}

// Whether a key agrees with another in the digits before a place.
fn agrees(key: vec2<u32>, other: vec2<u32>, place: u32) -> bool {
    if place <= 3u {
        // Shifts of 24, 16, 8 and 0.
        return key.x >> (24u - 8u * place) == other.x >> (24u - 8u * place);
    }
    return key.x == other.x && key.y >> 8u == other.y >> 8u;
}

fn ahead(a: vec2<u32>, b: vec2<u32>) -> bool {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}

// Puts the `take` least keys of so many into `keys`, in no order, and says how many there are.
fn select_least(what: u32, many: u32, take: u32, thread: u32) -> u32 {
    var limit = vec2<u32>(0u);
    var left = take;
    for (var place = 0u; place < 5u; place++) {
        atomicStore(&histogram[thread], 0u);
        workgroupBarrier();
        for (var i = thread; i < many; i += 256u) {
            let key = vec2<u32>(error(what, i), i);
            if key.x != SKIPPED && agrees(key, limit, place) {
                atomicAdd(&histogram[digit_of(key, place)], 1u);
            }
        }
        workgroupBarrier();
        let count = atomicLoad(&histogram[thread]);
        sums[thread] = count;
        if thread == 0u {
            // All of them, if there are no more than are wanted.
            digit = vec3<u32>(255u, 0u, 2u);
        }
        workgroupBarrier();
        for (var step = 1u; step < 256u; step *= 2u) {
            var more = 0u;
            if thread >= step {
                more = sums[thread - step];
            }
            workgroupBarrier();
            sums[thread] += more;
            workgroupBarrier();
        }
        let until = sums[thread];
        if count > 0u && until - count < left && left <= until {
            digit = vec3<u32>(thread, until - count, select(0u, 1u, left == until));
        }
        let found = workgroupUniformLoad(&digit);
        if found.z == 2u {
            limit = vec2<u32>(SKIPPED - 1u, SKIPPED);
            break;
        }
        if place < 3u {
            limit.x |= found.x << (16u - 8u * place);
        } else {
            limit.y |= found.x << (32u - 8u * place);
        }
        left -= found.y;
        if found.z == 1u {
            // Whatever begins like this.
            if place < 3u {
                limit.x |= (1u << (16u - 8u * place)) - 1u;
                limit.y = 0xffffu;
            } else {
                limit.y |= (1u << (32u - 8u * place)) - 1u;
            }
            break;
        }
    }
    if thread == 0u {
        atomicStore(&collected, 0u);
    }
    workgroupBarrier();
    for (var i = thread; i < many; i += 256u) {
        let key = vec2<u32>(error(what, i), i);
        if key.x != SKIPPED && !ahead(limit, key) {
            keys[atomicAdd(&collected, 1u)] = key;
        }
    }
    workgroupBarrier();
    return atomicLoad(&collected);
}

// How many keys come before one.
fn rank(key: vec2<u32>, count: u32) -> u32 {
    var sum = 0u;
    for (var i = 0u; i < count; i++) {
        sum += select(0u, 1u, ahead(keys[i], key));
    }
    return sum;
}

@compute @workgroup_size(256)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let at = params.first + group.x + GROUP_ROW * group.y;
    if at >= params.count {
        return;
    }
    let place = params.start + at;
    let width = u32(params.size.x);
    own = pixel(params.size, i32(place % width), i32(place / width));
    own_strips = params.strips + STRIP * pixel_index(params.size, own);

    next_count = select_least(NEXT, params.next.w, params.most, thread);
    if thread < next_count {
        nexts[rank(keys[thread], next_count)] = keys[thread];
    }
    workgroupBarrier();
    last_count = select_least(LAST, params.last.w, params.most, thread);
    if thread < last_count {
        lasts[rank(keys[thread], last_count)] = keys[thread];
    }
    workgroupBarrier();
    let count = select_least(PAIRS, next_count * last_count, params.best, thread);
    let base = at * (1u + 2u * params.best);
    if thread == 0u {
        triples[base] = count;
    }
    for (var i = thread; i < count; i += 256u) {
        let key = keys[i];
        let to = base + 1u + 2u * rank(key, count);
        let next = centres[params.next.z + nexts[key.y / last_count].y];
        let last = centres[params.last.z + lasts[key.y % last_count].y];
        triples[to] = next | last << 16u;
        triples[to + 1u] = key.x;
    }
}
