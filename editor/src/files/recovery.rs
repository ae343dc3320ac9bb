//! Copies of unsaved documents, which outlive a crash.
//!
//! A running editor has a lock file in the folder and holds its lock, which the system frees when the process ends in
//! whatever way. A copy whose lock is free is therefore left over from a process that is gone. Looking for those, and
//! making a new lock, happen under a lock of the folder's own, so that none sees half of what another does.

use std::fs::{File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use breccia_engine::Digest;
use serde::{Deserialize, Serialize};

use super::state;
use super::whole::write_private;

/// How much time there is between copies.
pub const EVERY: Duration = Duration::from_secs(5);

/// The format of copies.
const FORMAT: &str = "breccia-recovery";
const VERSION: u32 = 1;

/// A document as it was at some time before it was saved.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Snapshot {
    format: String,
    version: u32,
    /// The file that the document came from, if any.
    pub original: Option<PathBuf>,
    /// What the document was called.
    pub title: String,
    /// When the copy was made.
    pub time: SystemTime,
    /// The document.
    pub text: String,
}

impl Snapshot {
    /// A copy of a document.
    pub fn new(original: Option<&Path>, title: &str, time: SystemTime, text: String) -> Self {
        // A path that is no text cannot be written down exactly, and the document is worth more than its path.
        let original = original.map(|path| PathBuf::from(path.to_string_lossy().into_owned()));
        Self { format: FORMAT.to_owned(), version: VERSION, original, title: title.to_owned(), time, text }
    }

    fn read(path: &Path) -> Result<Self, String> {
        let text = state::read_text(path).map_err(|error| error.to_string())?;
        let copy: Self = ron::from_str(&text).map_err(|error| error.to_string())?;
        if copy.format != FORMAT || copy.version != VERSION {
            let (format, version) = (copy.format, copy.version);
            return Err(format!("found `{format}` {version}, expected `{FORMAT}` {VERSION}"));
        }
        Ok(copy)
    }
}

/// The copy that this process keeps of its document. Writing waits for the disk, so this belongs on a worker thread.
#[derive(Debug)]
pub struct Recovery {
    copy: PathBuf,
    lock_path: PathBuf,
    /// Locked as long as the process lives.
    lock: Lock,
    /// When the last copy was made.
    last: Option<Instant>,
    /// What it held.
    held: Option<Digest>,
}

impl Recovery {
    /// Makes a place for copies in a folder, such as `recovery` in the folder of what is remembered.
    ///
    /// # Errors
    /// If the folder cannot be written.
    pub fn new(folder: &Path) -> io::Result<Self> {
        std::fs::create_dir_all(folder)?;
        let _guard = guard(folder)?;
        let process = std::process::id();
        for number in 0_u32.. {
            let lock_path = folder.join(format!("{process}-{number}.lock"));
            let copy = lock_path.with_extension("ron");
            // A number of a process may come again; what that one left is not ours.
            if copy.exists() {
                continue;
            }
            match OpenOptions::new().write(true).create_new(true).open(&lock_path) {
                Ok(lock) => {
                    let lock = Lock::try_new(lock).ok_or(io::ErrorKind::WouldBlock)?;
                    return Ok(Self { copy, lock_path, lock, last: None, held: None });
                }
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
        Err(io::ErrorKind::AlreadyExists.into())
    }

    /// Whether it is time for another copy.
    pub fn is_due(&self, now: Instant) -> bool {
        self.last.is_none_or(|last| now.saturating_duration_since(last) >= EVERY)
    }

    /// Keeps a copy, in place of the one before, if it is time for it; says whether one was written. What was kept
    /// already is not written again.
    ///
    /// # Errors
    /// If the copy cannot be written. The one before is still there then, and the next one is due after the usual time.
    pub fn keep(&mut self, now: Instant, copy: &Snapshot) -> io::Result<bool> {
        if !self.is_due(now) {
            return Ok(false);
        }
        self.last = Some(now);
        let digest = Digest::of(copy.text.as_bytes());
        if self.held == Some(digest) {
            return Ok(false);
        }
        let text = ron::to_string(copy).map_err(io::Error::other)?;
        write_private(&self.copy, text.as_bytes())?;
        self.held = Some(digest);
        Ok(true)
    }

    /// The document is saved, or given up: there is nothing to recover. The next change is kept at once.
    ///
    /// # Errors
    /// If the copy cannot be removed.
    pub fn clear(&mut self) -> io::Result<()> {
        (self.last, self.held) = (None, None);
        remove(&self.copy)
    }

    /// The program ends in an orderly way. Without this the copy stays, as it does after a crash.
    ///
    /// # Errors
    /// If the copy cannot be removed.
    pub fn close(mut self) -> io::Result<()> {
        self.clear()?;
        drop(self.lock);
        remove(&self.lock_path)
    }
}

/// A copy that a process left which is gone. As long as this lives, no other process is offered the copy.
#[derive(Debug)]
pub struct Leftover {
    /// The copy.
    pub copy: Snapshot,
    path: PathBuf,
    lock: Lock,
}

impl Leftover {
    /// Where the copy is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Removes the copy. After a recovery this comes once the document is kept or saved elsewhere.
    ///
    /// # Errors
    /// If the copy cannot be removed.
    pub fn discard(self) -> io::Result<()> {
        remove(&self.path)?;
        drop(self.lock);
        remove(&self.path.with_extension("lock"))
    }
}

/// What processes left in a folder.
#[derive(Debug, Default)]
pub struct Found {
    /// The copies, the newest first.
    pub leftovers: Vec<Leftover>,
    /// What was wrong with copies that cannot be read; they are put aside and told of once.
    pub messages: Vec<String>,
}

/// Looks for copies that were left by processes that are gone.
///
/// # Errors
/// If the folder cannot be read. A folder that is not there has no copies.
pub fn leftovers(folder: &Path) -> io::Result<Found> {
    let mut found = Found::default();
    if !folder.is_dir() {
        return Ok(found);
    }
    let _guard = guard(folder)?;
    let mut paths: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        paths.push(entry?.path());
    }
    paths.sort();
    let with = |extension: &'static str| {
        let fits = move |path: &&PathBuf| path.extension().is_some_and(|found| found == extension);
        paths.iter().filter(fits)
    };
    for path in with("ron") {
        let lock_path = path.with_extension("lock");
        let lock = OpenOptions::new().write(true).create(true).truncate(false).open(&lock_path)?;
        // Somebody has it, or is being offered it.
        let Some(lock) = Lock::try_new(lock) else { continue };
        match Snapshot::read(path) {
            Ok(copy) => found.leftovers.push(Leftover { copy, path: path.clone(), lock }),
            Err(error) => {
                let aside = path.with_extension("damaged");
                let shown = if std::fs::rename(path, &aside).is_ok() { &aside } else { path };
                found
                    .messages
                    .push(format!("a recovery copy cannot be read, `{}`: {error}", shown.display()));
                remove(&lock_path)?;
            }
        }
    }
    // Processes that had nothing to leave.
    for path in with("lock").filter(|path| !path.with_extension("ron").exists()) {
        let lock = OpenOptions::new().write(true).open(path);
        if lock.is_ok_and(|lock| Lock::try_new(lock).is_some()) {
            remove(path)?;
        }
    }
    found.leftovers.sort_by(|a, b| b.copy.time.cmp(&a.copy.time).then_with(|| a.path.cmp(&b.path)));
    Ok(found)
}

/// A locked file. It is unlocked in so many words, since a process that is just being started may have the file, too.
#[derive(Debug)]
struct Lock(File);

impl Lock {
    /// Locks a file, unless it is locked.
    fn try_new(file: File) -> Option<Self> {
        file.try_lock().is_ok().then_some(Self(file))
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        let _ = self.0.unlock();
    }
}

/// Holds the folder's own lock.
fn guard(folder: &Path) -> io::Result<Lock> {
    let guard = OpenOptions::new().write(true).create(true).truncate(false).open(folder.join("guard"))?;
    guard.lock()?;
    Ok(Lock(guard))
}

fn remove(path: &Path) -> io::Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests;
