// The tables of one level of a lazy synthesis, as `lazy/tables.rs` has them.
#define_import_path breccia::level

struct View {
    // Width, height, whether the picture continues at the opposite edge, margin.
    size: vec4<i32>,
    // Where the records, triples and strips of the view begin; binary digits that a projection drops.
    base: vec4<u32>,
    bias: array<vec4<i32>, 4>,
    // For each pixel and component the weights of four channels, a byte each.
    weights: array<vec4<u32>, 100>,
}

struct Level {
    views: array<View, 3>,
    // Three times the mean colour.
    middle: vec4<i32>,
    // 2D candidates, 3D candidates, 256 (1 + κ), what a crossbar error is multiplied with for its cost times 2^24.
    costs: vec4<u32>,
    // Stretch in 256ths, whether a voxel takes one of its three colours, words of a descriptor that are not zero.
    color: vec4<u32>,
    // The period; 0 if there is none, 1 if it is of whole bricks, else 2.
    period: vec4<i32>,
}

// The pixel nearest to (x, y) that can be the centre of a neighbourhood.
fn pixel(size: vec4<i32>, x: i32, y: i32) -> u32 {
    if size.z != 0 {
        return u32(((x % size.x) + size.x) % size.x | (((y % size.y) + size.y) % size.y) << 8u);
    }
    return u32(clamp(x, size.w, size.x - 1 - size.w) | clamp(y, size.w, size.y - 1 - size.w) << 8u);
}

fn pixel_index(size: vec4<i32>, p: u32) -> u32 {
    return (p >> 8u) * u32(size.x) + (p & 255u);
}

// Which of three colours lies nearest to the wanted one, the first of equals (`OneColor::nearest`).
fn nearest(colors: array<u32, 3>, middle: vec4<i32>, stretch: u32) -> u32 {
    let a = vec4<i32>(unpack4xU8(colors[0]));
    let b = vec4<i32>(unpack4xU8(colors[1]));
    let c = vec4<i32>(unpack4xU8(colors[2]));
    let sum = a + b + c;
    let wanted = sum + (((sum - middle) * i32(stretch) + 128) >> vec4<u32>(8u));
    let da = 3 * a - wanted;
    let db = 3 * b - wanted;
    let dc = 3 * c - wanted;
    let gap = vec3<i32>(dot(da, da), dot(db, db), dot(dc, dc));
    let first = select(0u, 1u, gap.y < gap.x);
    return select(first, 2u, gap.z < min(gap.x, gap.y));
}

// The mean of three colours.
fn mean(colors: array<u32, 3>) -> u32 {
    let sum = unpack4xU8(colors[0]) + unpack4xU8(colors[1]) + unpack4xU8(colors[2]);
    return pack4xU8((sum + 1u) / 3u);
}
