//! Making a bundle.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Cursor, Write};
use std::path::Path;

use breccia_engine::{Document, FileSource, Registry};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::{BundleError, FILES, GRAPH, LIMITS};

/// The most characters of a name in a bundle.
const NAME: usize = 80;

/// Packs a document, whose paths are relative to `folder`, and all files that its nodes read.
///
/// # Errors
/// Names the file that cannot be read, or says how much too large the bundle would be.
pub fn export(
    document: &Document,
    folder: &Path,
    registry: &Registry,
    files: &dyn FileSource,
) -> Result<Vec<u8>, BundleError> {
    let mut bundled = document.clone();
    bundled.include(folder, files)?;
    let mut names = Names::default();
    bundled.change_paths(registry, folder, &mut |path| Some(format!("{FILES}/{}", names.of(path))));
    // A group that is built in can be named wherever the bundle goes.
    for (name, group) in &document.groups {
        if group.file.starts_with(breccia_graphs::SCHEME) {
            bundled.groups.insert(name.clone(), group.clone());
        }
    }
    let mut archive = Archive::default();
    archive.add(GRAPH, bundled.to_ron().as_bytes())?;
    for (path, name) in &names.by_path {
        let bytes = files.read(path).map_err(|error| BundleError::Read { path: path.clone(), error })?;
        archive.add(&format!("{FILES}/{name}"), &bytes)?;
    }
    Ok(archive.zip.finish()?.into_inner())
}

/// The archive, and how much is in it.
struct Archive {
    zip: ZipWriter<Cursor<Vec<u8>>>,
    total: u64,
    entries: usize,
}

impl Default for Archive {
    fn default() -> Self {
        Self { zip: ZipWriter::new(Cursor::default()), total: 0, entries: 0 }
    }
}

impl Archive {
    /// Adds an entry, unless nobody could unpack it.
    fn add(&mut self, name: &str, bytes: &[u8]) -> Result<(), BundleError> {
        let size = bytes.len() as u64;
        self.total = self.total.saturating_add(size);
        self.entries += 1;
        let each = if name == GRAPH { LIMITS.graph } else { LIMITS.each };
        let (found, expected) = if size > each {
            (format!("`{name}` of {size} bytes"), format!("{each} bytes a file"))
        } else if self.total > LIMITS.total {
            (format!("{} bytes", self.total), format!("{} bytes", LIMITS.total))
        } else if self.entries > LIMITS.entries {
            (format!("{} files", self.entries), format!("{} files", LIMITS.entries))
        } else {
            self.zip.start_file(name, SimpleFileOptions::default())?;
            return self.zip.write_all(bytes).map_err(|error| BundleError::Archive(error.into()));
        };
        Err(BundleError::TooLarge { found, expected })
    }
}

/// Names in the bundle, by path.
#[derive(Default)]
struct Names {
    by_path: BTreeMap<String, String>,
    /// In lower case: some file systems do not tell them apart.
    taken: BTreeSet<String>,
}

impl Names {
    /// The name of the file at this path: its own as far as it can be kept.
    fn of(&mut self, path: &str) -> String {
        if let Some(name) = self.by_path.get(path) {
            return name.clone();
        }
        let plain = plain_name(path);
        let (stem, extension) = match plain.rsplit_once('.') {
            Some((stem, extension)) => (stem, format!(".{extension}")),
            None => (plain.as_str(), String::new()),
        };
        let more = (2..).map(|i| format!("{stem}-{i}{extension}"));
        let mut all = std::iter::once(plain.clone()).chain(more);
        // There are more names than files.
        let name = all.find(|name| !self.taken.contains(&name.to_lowercase())).unwrap_or_default();
        self.taken.insert(name.to_lowercase());
        self.by_path.insert(path.to_owned(), name.clone());
        name
    }
}

/// The last part of a path, with nothing in it that a file system could object to.
fn plain_name(path: &str) -> String {
    let last = path.rsplit(['/', '\\']).next().unwrap_or_default();
    let plain = |c: char| if c.is_alphanumeric() || matches!(c, '-' | '_' | '.') { c } else { '_' };
    let name: String = last.chars().map(plain).collect();
    let name = name.trim_matches('.');
    let (stem, extension) = match name.rsplit_once('.') {
        Some((stem, extension)) if extension.chars().count() < NAME / 2 => (stem, Some(extension)),
        _ => (name, None),
    };
    let mut short: String = stem.chars().take(NAME / 2).collect();
    if short.is_empty() || super::unpack::is_device(&short) {
        short.insert_str(0, "file_");
    }
    match extension {
        Some(extension) => format!("{short}.{extension}"),
        None => short,
    }
}
