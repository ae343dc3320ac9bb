//! Where the files of a graph come from: the file system, and what is built in.

use std::io;
use std::sync::Arc;

use breccia_engine::{FileSource, PlainFiles, closest};

use crate::{asset, assets};

/// What paths of built-in files begin with.
pub const SCHEME: &str = "builtin:";

/// Plain files, and `builtin:NAME`; perhaps one more that only memory holds.
///
/// ```
/// use breccia_engine::FileSource;
///
/// let files = breccia_graphs::Sources::default();
/// assert!(files.read("builtin:spot/spot.glb").is_ok());
/// let error = files.read("builtin:spot/sport.glb").unwrap_err();
/// assert!(error.to_string().contains("did you mean `spot/spot.glb`?"));
/// ```
#[derive(Clone, Debug, Default)]
pub struct Sources {
    plain: PlainFiles,
    held: Option<(&'static str, Arc<Vec<u8>>)>,
}

impl Sources {
    /// Sources that also have a file of this name, which is in memory.
    pub fn holding(name: &'static str, bytes: Vec<u8>) -> Self {
        Self { plain: PlainFiles::default(), held: Some((name, Arc::new(bytes))) }
    }
}

impl FileSource for Sources {
    fn read(&self, path: &str) -> io::Result<Arc<Vec<u8>>> {
        if let Some((_, bytes)) = self.held.as_ref().filter(|(name, _)| *name == path) {
            return Ok(Arc::clone(bytes));
        }
        let Some(name) = path.strip_prefix(SCHEME) else { return self.plain.read(path) };
        asset(name).map(|bytes| Arc::new(bytes.to_vec())).ok_or_else(|| {
            let hint = closest(name, assets().iter().map(|asset| asset.name));
            let hint = hint.map_or(String::new(), |known| format!("; did you mean `{known}`?"));
            io::Error::new(io::ErrorKind::NotFound, format!("no such file is built in{hint}"))
        })
    }
}

/// The set that a built-in file belongs to: the folder it is in.
///
/// ```
/// assert_eq!(breccia_graphs::set_of("builtin:cobbles/color_64.png"), Some("cobbles"));
/// assert_eq!(breccia_graphs::set_of("cobbles/color_64.png"), None);
/// ```
pub fn set_of(path: &str) -> Option<&str> {
    path.strip_prefix(SCHEME)?.split_once('/').map(|(set, _)| set)
}
