//! Where the files of a graph come from: the file system, and the files built into the program.

use std::io;
use std::sync::Arc;

use breccia_engine::{FileSource, PlainFiles};

use crate::exit::did_you_mean;

/// What paths of built-in files begin with.
pub const SCHEME: &str = "builtin:";

/// Plain files, and `builtin:NAME`.
#[derive(Default)]
pub struct Sources(PlainFiles);

impl FileSource for Sources {
    fn read(&self, path: &str) -> io::Result<Arc<Vec<u8>>> {
        let Some(name) = path.strip_prefix(SCHEME) else { return self.0.read(path) };
        breccia_graphs::asset(name).map(|bytes| Arc::new(bytes.to_vec())).ok_or_else(|| {
            let known = breccia_graphs::assets().iter().map(|asset| asset.name);
            let hint = did_you_mean(name, known);
            io::Error::new(io::ErrorKind::NotFound, format!("no such file is built in{hint}"))
        })
    }
}

/// The set that a built-in file belongs to: the folder it is in.
pub fn set_of(path: &str) -> Option<&str> {
    path.strip_prefix(SCHEME)?.split_once('/').map(|(set, _)| set)
}
