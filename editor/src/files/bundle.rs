//! Self-contained bundles: a ZIP archive with a graph and the files that it uses.
//!
//! An archive has `graph.ron` and, in the folder `files`, what the graph's nodes read. Unpacked anywhere, the graph
//! runs. Files that are built in stay where they are; groups in files of their own are written out.

mod pack;
mod unpack;

#[cfg(test)]
mod tests;

use std::io;

use breccia_engine::{DocumentError, IncludeError};

pub use pack::export;
pub use unpack::import;

/// The document's name in a bundle.
const GRAPH: &str = "graph.ron";
/// The folder of the files that the graph uses.
const FILES: &str = "files";

/// How much a bundle may hold. More is taken for an attack.
struct Limits {
    /// The most entries, folders included.
    entries: usize,
    /// The most bytes of an entry.
    each: u64,
    /// The most bytes of all entries.
    total: u64,
    /// The most bytes of the graph.
    graph: u64,
}

const LIMITS: Limits = Limits { entries: 4096, each: 1 << 30, total: 2 << 30, graph: 16 << 20 };

/// A bundle that cannot be made or unpacked.
#[derive(Debug, thiserror::Error)]
pub enum BundleError {
    /// A file of the graph cannot be read.
    #[error("cannot read `{path}`, which the graph uses: {error}")]
    Read {
        /// The file.
        path: String,
        /// What went wrong.
        error: io::Error,
    },
    /// A group stands in a file that cannot be used.
    #[error(transparent)]
    Group(#[from] IncludeError),
    /// The archive is damaged, or of a sort that is not read.
    #[error("found no archive that can be read, expected a bundle: {0}")]
    Archive(#[from] zip::result::ZipError),
    /// The archive holds more than a bundle may.
    #[error("found {found}, expected a bundle of at most {expected}")]
    TooLarge {
        /// How much there is.
        found: String,
        /// How much there may be.
        expected: String,
    },
    /// An entry that bundles do not have: a path that leads elsewhere, a link, a file beside the graph.
    #[error("found {what} `{name}`, expected `graph.ron` and files in `files/`")]
    Entry {
        /// What is wrong with it.
        what: &'static str,
        /// Its name.
        name: String,
    },
    /// There is no graph.
    #[error("found no `graph.ron`, expected one in a bundle")]
    NoGraph,
    /// The graph cannot be read.
    #[error("`graph.ron`: {0}")]
    Graph(DocumentError),
    /// The folder cannot be written.
    #[error("cannot write `{path}`: {error}")]
    Write {
        /// What was being written.
        path: String,
        /// What went wrong.
        error: io::Error,
    },
}
