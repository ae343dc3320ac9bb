//! Whether a file was changed on disk by somebody else.

use std::fs::Metadata;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use breccia_engine::Digest;

/// How long ago a file was written for its time to tell the next change: file systems count in up to two seconds.
const SETTLED: Duration = Duration::from_secs(3);

/// A file as it was when it was read or written last. It looks only when it is asked.
#[derive(Clone, Debug)]
pub struct Watch {
    path: PathBuf,
    seen: Option<Seen>,
}

/// What is known of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seen {
    length: u64,
    /// Its time, once that tells changes apart.
    modified: Option<SystemTime>,
    contents: Digest,
}

/// What became of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// It holds what it held.
    None,
    /// It holds something else.
    Changed,
    /// It is not there any more, or cannot be read.
    Gone,
}

impl Watch {
    /// Watches a file that was just read or written, and held these bytes.
    pub fn new(path: impl Into<PathBuf>, contents: &[u8]) -> Self {
        let mut watch = Self { path: path.into(), seen: None };
        watch.renew(contents);
        watch
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file was read or written again, and held these bytes.
    pub fn renew(&mut self, contents: &[u8]) {
        // Its time now may be that of a change since, so the next look reads it.
        let seen = Seen { length: contents.len() as u64, modified: None, contents: Digest::of(contents) };
        self.seen = Some(seen);
    }

    /// The user knows that the file has changed, or is gone, and wants to keep what is in the program: it is told
    /// again only after another change.
    pub fn accept(&mut self) {
        let contents = std::fs::read(&self.path).ok();
        match contents {
            Some(contents) => self.renew(&contents),
            None => self.seen = None,
        }
    }

    /// What became of the file. It is read only where its length or its time do not tell.
    pub fn look(&mut self) -> Change {
        let Some(metadata) = self.path.metadata().ok().filter(Metadata::is_file) else { return self.gone() };
        let Some(seen) = self.seen else { return Change::Changed };
        if metadata.len() != seen.length {
            return Change::Changed;
        }
        let modified = metadata.modified().ok();
        if modified.is_some() && modified == seen.modified {
            return Change::None;
        }
        let Ok(contents) = std::fs::read(&self.path) else { return self.gone() };
        if Digest::of(&contents) != seen.contents {
            return Change::Changed;
        }
        // A time of a moment ago may be that of another change in the same moment.
        let settled = |time: &SystemTime| time.elapsed().is_ok_and(|age| age > SETTLED);
        self.seen = Some(Seen { modified: modified.filter(settled), ..seen });
        Change::None
    }

    fn gone(&self) -> Change {
        if self.seen.is_some() { Change::Gone } else { Change::None }
    }
}

#[cfg(test)]
mod tests {
    use std::fs::File;

    use super::*;

    fn file(contents: &str) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("graph.ron");
        std::fs::write(&path, contents).unwrap();
        (folder, path)
    }

    fn touch(path: &Path, seconds: u64) {
        let time = SystemTime::UNIX_EPOCH + Duration::from_secs(seconds);
        File::options().write(true).open(path).unwrap().set_modified(time).unwrap();
    }

    #[test]
    fn what_others_write_is_seen() {
        let (_folder, path) = file("one");
        let mut watch = Watch::new(&path, b"one");
        assert_eq!(watch.look(), Change::None);
        std::fs::write(&path, "three").unwrap();
        assert_eq!(watch.look(), Change::Changed);
        assert_eq!(watch.look(), Change::Changed, "until the user has said something");
        watch.renew(b"three");
        assert_eq!(watch.look(), Change::None);
        std::fs::write(&path, "other").unwrap();
        touch(&path, 1_000);
        assert_eq!(watch.look(), Change::Changed, "the length is the same");
        assert_eq!(watch.path(), path);
    }

    #[test]
    fn writing_the_same_again_is_no_change() {
        let (_folder, path) = file("one");
        let mut watch = Watch::new(&path, b"one");
        touch(&path, 1_000);
        assert_eq!(watch.look(), Change::None);
        assert_eq!(watch.look(), Change::None);
    }

    #[test]
    fn a_file_that_was_written_while_it_was_read_is_seen() {
        let (_folder, path) = file("longer than what was read");
        assert_eq!(Watch::new(&path, b"one").look(), Change::Changed);
    }

    #[test]
    fn a_file_that_goes_and_comes_back() {
        let (_folder, path) = file("one");
        let mut watch = Watch::new(&path, b"one");
        std::fs::remove_file(&path).unwrap();
        assert_eq!(watch.look(), Change::Gone);
        watch.accept();
        assert_eq!(watch.look(), Change::None);
        std::fs::write(&path, "one").unwrap();
        assert_eq!(watch.look(), Change::Changed);
        std::fs::remove_file(&path).unwrap();
        std::fs::create_dir(&path).unwrap();
        assert_eq!(watch.look(), Change::None, "a folder is no file");
    }

    #[test]
    fn what_the_user_keeps_is_not_told_again() {
        let (_folder, path) = file("one");
        let mut watch = Watch::new(&path, b"one");
        std::fs::write(&path, "three").unwrap();
        assert_eq!(watch.look(), Change::Changed);
        watch.accept();
        assert_eq!(watch.look(), Change::None);
        std::fs::write(&path, "one").unwrap();
        assert_eq!(watch.look(), Change::Changed);
    }
}
