//! Any bytes are a mesh whose indices are in range, or an error.
#![no_main]

use breccia_nodes::mesh::decode_mesh;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(mesh) = decode_mesh(bytes, "obj") {
        assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < mesh.positions.len()));
    }
});
