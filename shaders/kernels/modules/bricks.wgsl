// Sparse bricks of 8³ voxels, and who lies next to whom.
//
// Every brick has 128 words in `links`: the slots of the bricks that hold the voxels around it, and its key. Along an axis a
// voxel lies two or one before the brick, in it, or one or two behind it: five cases an axis, since a period that is no multiple of 8
// may put all five into different bricks.
#define_import_path breccia::bricks

const LINKS: u32 = 128u;
const KEY: u32 = 125u;
const ABSENT: u32 = 0xffffffffu;
// Words of a brick's state: colours; the pixels of directions x and y; the pixel of z and the direction shown.
const STATE: u32 = 1536u;
const GROUP_ROW: u32 = 32768u;

fn modulo(a: i32, n: i32) -> i32 {
    return ((a % n) + n) % n;
}

fn divide(a: i32, n: i32) -> i32 {
    return (a - modulo(a, n)) / n;
}

// How many of a brick's voxels lie before the end of the period, along each axis.
fn lengths(key: vec3<i32>, period: vec4<i32>) -> vec3<i32> {
    if period.w == 0 {
        return vec3<i32>(8);
    }
    return clamp(period.xyz - key * 8, vec3<i32>(0), vec3<i32>(8));
}

fn side(q: i32, length: i32) -> u32 {
    if q < 0 {
        return u32(q + 2);
    }
    if q >= length {
        return u32(3 + q - length);
    }
    return 2u;
}

// Which link leads to the voxel at `q` from a brick's first.
fn link(q: vec3<i32>, length: vec3<i32>) -> u32 {
    return side(q.x, length.x) + 5u * side(q.y, length.y) + 25u * side(q.z, length.z);
}

fn wrapped(c: vec3<i32>, period: vec4<i32>) -> vec3<i32> {
    if period.w == 0 {
        return c;
    }
    return vec3<i32>(modulo(c.x, period.x), modulo(c.y, period.y), modulo(c.z, period.z));
}

// The place in its own brick of the voxel at `q` from the first of the brick `key`.
fn place(key: vec3<i32>, q: vec3<i32>, period: vec4<i32>) -> vec3<i32> {
    // A period of whole bricks does not shift what lies in them.
    if period.w < 2 {
        return q & vec3<i32>(7);
    }
    return wrapped(key * 8 + q, period) & vec3<i32>(7);
}

fn index(local: vec3<i32>) -> u32 {
    return u32(local.x | local.y << 3u | local.z << 6u);
}

fn position(at: u32) -> vec3<i32> {
    return vec3<i32>(i32(at & 7u), i32(at >> 3u & 7u), i32(at >> 6u & 7u));
}

fn hash_key(key: vec3<i32>) -> u32 {
    let k = bitcast<vec3<u32>>(key);
    var h = k.x * 73856093u ^ k.y * 19349663u ^ k.z * 83492791u;
    h = (h ^ (h >> 15u)) * 0x2c1b3c6du;
    return h ^ (h >> 13u);
}
