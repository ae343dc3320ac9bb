//! Unpacking a bundle that anybody may have made.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Cursor, Read, Write};
use std::path::{Path, PathBuf};

use breccia_engine::Document;
use zip::ZipArchive;

use super::{BundleError, FILES, GRAPH, LIMITS};

/// How many names are tried for the folder.
const TRIES: usize = 1000;

/// Unpacks a bundle into a new folder and gives the path of its graph. If there is something at `into` already, the
/// folder gets a free name beside it. The folder is there with all files, or not at all.
///
/// # Errors
/// If this is no bundle, if it holds too much or something that leads out of the folder, or if it cannot be written.
pub fn import(bytes: &[u8], into: &Path) -> Result<PathBuf, BundleError> {
    let mut archive = ZipArchive::new(Cursor::new(bytes))?;
    let names = check(&mut archive)?;
    let parent = match into.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(parent).map_err(|error| cannot_write(parent, error))?;
    let temporary = tempfile::Builder::new().prefix(".breccia-").tempdir_in(parent);
    let temporary = temporary.map_err(|error| cannot_write(parent, error))?;
    // Inside, for the temporary folder itself is closed to everybody else.
    let folder = temporary.path().join("bundle");
    std::fs::create_dir_all(folder.join(FILES)).map_err(|error| cannot_write(&folder, error))?;
    let mut left = LIMITS.total;
    for (index, name) in names {
        let target = folder.join(&name);
        let mut file = File::create_new(&target).map_err(|error| cannot_write(&target, error))?;
        left -= unpack(&mut archive, index, &name, left, &mut file)?;
        file.sync_all().map_err(|error| cannot_write(&target, error))?;
    }
    let graph = folder.join(GRAPH);
    let text = std::fs::read(&graph).map_err(|error| cannot_write(&graph, error))?;
    Document::parse_bytes(&text).map_err(BundleError::Graph)?;
    Ok(put(&folder, into)?.join(GRAPH))
}

/// The files of an archive by index, if all entries are such as a bundle has.
fn check(archive: &mut ZipArchive<Cursor<&[u8]>>) -> Result<Vec<(usize, String)>, BundleError> {
    if archive.len() > LIMITS.entries {
        return Err(too_large(format!("{} files", archive.len()), format!("{} files", LIMITS.entries)));
    }
    let entry = |what, name: &str| BundleError::Entry { what, name: name.to_owned() };
    if archive.has_duplicate_names() {
        return Err(entry("twice the name of", "a file"));
    }
    let (mut names, mut taken, mut total) = (Vec::new(), BTreeSet::new(), 0_u64);
    for index in 0..archive.len() {
        let file = archive.by_index(index)?;
        let name = file.name()?.into_owned();
        if file.is_dir() && name == format!("{FILES}/") {
            continue;
        }
        if !file.is_file() {
            return Err(entry(if file.is_symlink() { "a link" } else { "a folder" }, &name));
        }
        let is_plain = name == GRAPH || name.strip_prefix("files/").is_some_and(is_plain);
        if !is_plain {
            return Err(entry("the entry", &name));
        }
        // Some file systems do not tell upper case from lower case.
        if !taken.insert(name.to_lowercase()) {
            return Err(entry("twice the name", &name));
        }
        // The sizes are claims. They are checked again while unpacking.
        total = total.saturating_add(file.size());
        if total > LIMITS.total {
            return Err(too_large(format!("{total} bytes"), format!("{} bytes", LIMITS.total)));
        }
        names.push((index, name));
    }
    if taken.contains(GRAPH) { Ok(names) } else { Err(BundleError::NoGraph) }
}

/// Whether a name is that of a file, on every system.
fn is_plain(name: &str) -> bool {
    let fits =
        |c: char| !c.is_control() && !matches!(c, '/' | '\\' | ':' | '*' | '?' | '"' | '<' | '>' | '|');
    let ends = |c: char| matches!(c, '.' | ' ');
    !name.is_empty()
        && name.len() <= 255
        && name.chars().all(fits)
        && !name.starts_with('.')
        && !name.ends_with(ends)
        && !is_device(name)
}

/// Whether Windows takes a name for a device, whatever its extension.
pub(super) fn is_device(name: &str) -> bool {
    let stem = name.split('.').next().unwrap_or_default().trim_end().to_ascii_lowercase();
    let numbered = |device: &str| stem.strip_prefix(device).is_some_and(|n| n.chars().count() == 1);
    matches!(stem.as_str(), "con" | "prn" | "aux" | "nul") || numbered("com") || numbered("lpt")
}

/// Writes an entry, and says how many bytes it had.
fn unpack(
    archive: &mut ZipArchive<Cursor<&[u8]>>,
    index: usize,
    name: &str,
    left: u64,
    to: &mut impl Write,
) -> Result<u64, BundleError> {
    let most = left.min(if name == GRAPH { LIMITS.graph } else { LIMITS.each });
    let mut bytes = archive.by_index(index)?.take(most + 1);
    // Damage shows while reading; writing fails for a full disk.
    let mut buffer = vec![0; 1 << 16];
    let mut size = 0;
    loop {
        let read = match bytes.read(&mut buffer) {
            Ok(0) => return Ok(size),
            Ok(read) => read,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(BundleError::Archive(error.into())),
        };
        size += read as u64;
        if size > most {
            return Err(too_large(
                format!("`{name}` of more than {most} bytes"),
                format!("{most} bytes there"),
            ));
        }
        let part = buffer.get(..read).unwrap_or_default();
        to.write_all(part).map_err(|error| cannot_write(Path::new(name), error))?;
    }
}

/// Moves a complete folder to its place, or beside it.
fn put(folder: &Path, into: &Path) -> Result<PathBuf, BundleError> {
    let name = into.file_name().unwrap_or_else(|| "bundle".as_ref()).to_string_lossy().into_owned();
    let more = (2..TRIES).map(|i| into.with_file_name(format!("{name}-{i}")));
    for target in std::iter::once(into.with_file_name(&name)).chain(more) {
        if target.symlink_metadata().is_ok() {
            continue;
        }
        return match std::fs::rename(folder, &target) {
            Ok(()) => Ok(target),
            Err(error) => Err(cannot_write(&target, error)),
        };
    }
    Err(cannot_write(into, io::ErrorKind::AlreadyExists.into()))
}

fn cannot_write(path: &Path, error: io::Error) -> BundleError {
    BundleError::Write { path: path.display().to_string(), error }
}

fn too_large(found: String, expected: String) -> BundleError {
    BundleError::TooLarge { found, expected }
}
