//! Node `mesh.read`.

use breccia_engine::{Context, Node, NodeError, NodeSpec};

use super::read::{EXTENSIONS, MeshError, decode_mesh};

/// Reads a mesh from a file.
pub(super) struct Read;

impl Node for Read {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "mesh.read",
            1,
            "Reads a mesh from a file",
            "OBJ (materials are ignored), GLB, glTF with embedded buffers, and PLY. Polygons are triangulated, all \
             objects merged, glTF's node transforms applied, textures left out. Degenerate triangles are dropped \
             and counted in the mesh's summary; missing normals are computed.",
        )
        .output("mesh", "mesh", "The mesh.")
        .file("path", EXTENSIONS, "The file.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let path = context.text("path")?.to_owned();
        let bytes = context.file("path")?;
        let extension = std::path::Path::new(&path).extension().unwrap_or_default().to_string_lossy();
        let mesh = decode_mesh(&bytes, &extension)
            .map_err(|error: MeshError| NodeError::Input(format!("{path}: {error}")))?;
        context.set("mesh", mesh);
        Ok(())
    }
}
