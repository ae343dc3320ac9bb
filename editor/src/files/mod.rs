//! What the editor keeps on disk. Nothing here knows a window, and nothing here keeps time: who calls says when.

pub mod bundle;
mod library;
mod place;
pub mod recent;
pub mod recovery;
mod state;
mod watch;
mod whole;

pub use library::Library;
pub use place::{rebase, relative};
pub use watch::{Change, Watch};
pub use whole::write_whole;
