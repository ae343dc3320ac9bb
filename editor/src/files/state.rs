//! The folder of what the editor remembers from one start to the next, and safe writing into it.

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

/// The largest file of the state folder that is read, in bytes.
const LIMIT: u64 = 64 << 20;

/// The state folder of the user; `None` if the user has no home.
pub fn folder() -> Option<PathBuf> {
    let from =
        |name: &str| std::env::var_os(name).filter(|value: &OsString| !value.is_empty()).map(PathBuf::from);
    let base = match from("XDG_STATE_HOME").filter(|path| path.is_absolute()) {
        Some(base) => Some(base),
        None if cfg!(windows) => from("LOCALAPPDATA"),
        None if cfg!(target_os = "macos") => {
            from("HOME").map(|home| home.join("Library/Application Support"))
        }
        None => from("HOME").map(|home| home.join(".local/state")),
    };
    base.map(|base| base.join("breccia"))
}

/// Reads a text of moderate size.
pub(super) fn read_text(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    let file = File::open(path)?;
    if !file.metadata()?.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is no file"));
    }
    let read = file.take(LIMIT + 1).read_to_string(&mut text)?;
    if read as u64 > LIMIT {
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, format!("it has more than {LIMIT} bytes")));
    }
    Ok(text)
}

/// Writes a file that only the user may read, whole or not at all, so that neither a crash nor a full disk leaves half
/// of one. Folders that are not there are made.
///
/// # Errors
/// If the file cannot be written; what was there before is still there then.
pub(super) fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(folder)?;
    let mut temporary = tempfile::Builder::new().prefix(".breccia-").tempfile_in(folder)?;
    temporary.write_all(bytes)?;
    temporary.as_file().sync_all()?;
    temporary.persist(path).map_err(|error| error.error)?;
    // The name, too, shall be there after a crash. Where a folder cannot be opened there is no need to.
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_replaced_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b/file");
        write(&path, b"one").unwrap();
        write(&path, b"three").unwrap();
        assert_eq!(read_text(&path).unwrap(), "three");
        assert_eq!(std::fs::read_dir(folder.path().join("a/b")).unwrap().count(), 1, "nothing is left over");
    }

    #[test]
    fn what_cannot_be_written_leaves_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        std::fs::create_dir_all(path.join("taken")).unwrap();
        assert!(write(&path, b"one").is_err());
        assert!(path.join("taken").is_dir());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left over");
        assert!(read_text(&path).is_err());
    }
}
