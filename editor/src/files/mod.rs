//! What the editor keeps on disk.

mod library;
mod place;
mod whole;

pub use library::Library;
pub use place::{rebase, relative};
pub use whole::write_whole;

/// Stub.
pub fn import_bundle(_: &[u8], _: &std::path::Path) -> Result<std::path::PathBuf, String> {
    Err("not yet".into())
}

/// Stub.
pub fn export_bundle(
    _: &breccia_engine::Document,
    _: &std::path::Path,
    _: &breccia_engine::Registry,
    _: &dyn breccia_engine::FileSource,
) -> Result<Vec<u8>, String> {
    Err("not yet".into())
}
