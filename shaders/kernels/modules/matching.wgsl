// What a search for matches is told, as `optimize/device.rs` tells it.
#define_import_path breccia::matching

struct Direction {
    // Width, height, whether the picture continues at the opposite edge, direction.
    size: vec4<i32>,
    // The centres' first and last column, first and last row.
    bounds: vec4<i32>,
    // Where coefficients (in eights), sets, weights and the sources of voxels begin.
    base: vec4<u32>,
}

struct Matching {
    // Voxels along x, y and z.
    size: vec4<u32>,
    directions: array<Direction, 3>,
    // Directions that are matched, those first.
    wanted: u32,
    // Coefficients, in eights.
    eights: u32,
    // Pixels along a window, before its centre, and how far from it sets are proposed.
    window: i32,
    lead: i32,
    reach: i32,
    // Pixels in a set, and the room for one.
    members: u32,
    room: u32,
    // The voxels: where in the list they begin, and how many.
    start: u32,
    count: u32,
    // The first workgroup of this submission.
    first: u32,
}
