// Boxes of voxels that repeat along all axes, x fastest, and the planes of directions in them. As in `optimize/phases.rs`.
#define_import_path breccia::box

// Where a voxel lies.
fn place(voxel: u32, size: vec4<u32>) -> vec3<u32> {
    return vec3<u32>(voxel % size.x, voxel / size.x % size.y, voxel / (size.x * size.y));
}

// What a step along each axis adds to an index.
fn strides(size: vec4<u32>) -> vec3<u32> {
    return vec3<u32>(1u, size.x, size.x * size.y);
}

// The coordinate `by` away, around the box.
fn around(at: u32, by: i32, length: u32) -> u32 {
    let n = i32(length);
    return u32(((i32(at) + by) % n + n) % n);
}
