//! What the editor keeps on disk. Nothing here knows a window, and nothing here keeps time: who calls says when.

pub mod bundle;
pub mod recent;
pub mod recovery;
pub mod state;
mod watch;

pub use watch::{Change, Watch};
