//! Where the contents of files come from.

use std::io;
use std::path::Path;
use std::sync::Arc;

/// Reads files. A host wraps [`PlainFiles`] to serve further schemes, such as files built into it.
pub trait FileSource: Send + Sync {
    /// The contents of a file.
    ///
    /// # Errors
    /// If there is no such file, or it cannot be read.
    fn read(&self, path: &str) -> io::Result<Arc<Vec<u8>>>;
}

/// Files of the file system, up to a size.
#[derive(Clone, Debug)]
pub struct PlainFiles {
    /// The largest file that is read, in bytes.
    pub limit: u64,
}

impl Default for PlainFiles {
    /// Up to 4 GiB.
    fn default() -> Self {
        Self { limit: 4 << 30 }
    }
}

impl FileSource for PlainFiles {
    fn read(&self, path: &str) -> io::Result<Arc<Vec<u8>>> {
        let path = Path::new(path);
        let metadata = std::fs::metadata(path)?;
        if metadata.is_dir() {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder, expected a file"));
        }
        if metadata.len() > self.limit {
            return Err(io::Error::new(
                io::ErrorKind::FileTooLarge,
                format!("it has {} bytes, files up to {} bytes are read", metadata.len(), self.limit),
            ));
        }
        Ok(Arc::new(std::fs::read(path)?))
    }
}

/// A path as it is seen from a folder. Absolute paths and paths with a scheme stay as they are.
pub(crate) fn join(folder: &Path, path: &str) -> String {
    if path.is_empty() || has_scheme(path) || Path::new(path).is_absolute() || folder.as_os_str().is_empty() {
        return path.to_owned();
    }
    format!("{}/{path}", folder.to_string_lossy().trim_end_matches('/'))
}

/// Whether a path has a scheme such as `builtin:`. One letter is a Windows drive.
pub(crate) fn has_scheme(path: &str) -> bool {
    path.split_once(':').is_some_and(|(scheme, _)| {
        scheme.len() > 1 && scheme.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '+' | '-'))
    })
}
