//! What the editor keeps on disk.
