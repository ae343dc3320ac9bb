//! Reading a document with its groups, from a preset or from a file.

use std::path::{Path, PathBuf};

use breccia_engine::{Document, DocumentError, IncludeError};

use crate::{Preset, Sources};

/// A document that cannot be read.
#[derive(Debug)]
pub enum ReadError {
    /// There is no such file.
    Missing,
    /// The file cannot be read.
    Unreadable(std::io::Error),
    /// It is no document.
    Document(DocumentError),
    /// One of its groups stands in a file that cannot be used.
    Group(IncludeError),
}

impl std::fmt::Display for ReadError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Missing => f.write_str("there is no such file"),
            Self::Unreadable(error) => error.fmt(f),
            Self::Document(error) => error.fmt(f),
            Self::Group(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for ReadError {}

impl Preset {
    /// Its document, groups in files included.
    ///
    /// # Errors
    /// None: every preset can be read. Who asks need not rely on that.
    pub fn document(&self) -> Result<Document, ReadError> {
        include(Document::parse(self.ron), Path::new(""))
    }
}

/// The document in a file, groups in files included, and the folder that its paths are relative to.
///
/// # Errors
/// Says what is wrong with the file, or with that of a group.
pub fn read(path: &Path) -> Result<(Document, PathBuf), ReadError> {
    let bytes = std::fs::read(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => ReadError::Missing,
        _ => ReadError::Unreadable(error),
    })?;
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    Ok((include(Document::parse_bytes(&bytes), &folder)?, folder))
}

fn include(document: Result<Document, DocumentError>, folder: &Path) -> Result<Document, ReadError> {
    let mut document = document.map_err(ReadError::Document)?;
    document.include(folder, &Sources::default()).map_err(ReadError::Group)?;
    Ok(document)
}
