//! Files that appear whole or not at all.

use std::fs::File;
use std::io::{self, Write as _};
use std::path::Path;

/// Writes a file under another name first, so that what was there stays until all of the new is on disk. Folders that are not
/// there are made. The file keeps the rights that it had, or gets the usual ones.
///
/// # Errors
/// If the file cannot be written; what was there before is still there then.
pub fn write_whole(path: &Path, contents: &[u8]) -> io::Result<()> {
    put(path, contents, false)
}

/// As [`write_whole`], but only the user may read the file.
///
/// # Errors
/// As [`write_whole`].
pub(super) fn write_private(path: &Path, contents: &[u8]) -> io::Result<()> {
    put(path, contents, true)
}

fn put(path: &Path, contents: &[u8], private: bool) -> io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    // Temporary files are their user's alone.
    let mut file = tempfile::Builder::new().prefix(".breccia-").tempfile_in(folder)?;
    file.write_all(contents)?;
    #[cfg(unix)]
    if !private {
        use std::os::unix::fs::PermissionsExt as _;
        let mode = std::fs::metadata(path).map_or(0o644, |found| found.permissions().mode());
        file.as_file().set_permissions(std::fs::Permissions::from_mode(mode))?;
    }
    #[cfg(not(unix))]
    let _ = private;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| error.error)?;
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
        write_private(&path, b"one").unwrap();
        write_private(&path, b"three").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "three");
        assert_eq!(std::fs::read_dir(folder.path().join("a/b")).unwrap().count(), 1, "nothing is left over");
    }

    #[test]
    fn what_cannot_be_written_leaves_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        std::fs::create_dir_all(path.join("taken")).unwrap();
        assert!(write_private(&path, b"one").is_err());
        assert!(path.join("taken").is_dir());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left over");
    }
}
