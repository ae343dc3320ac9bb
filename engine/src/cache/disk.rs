//! Values and records on disk, shared by any number of processes.
//!
//! Files appear whole, by renaming, and carry checksums, so reading needs no lock. Only one process at a
//! time removes the least recently used ones, behind a file lock.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, SystemTime};

use super::entry::{self, EntryKind};
use crate::value::Digest;

/// Temporary files older than this were left by a process that died.
const STALE: Duration = Duration::from_secs(3600);

/// A folder of cached values and records.
#[derive(Debug)]
pub struct DiskCache {
    root: PathBuf,
    limit: u64,
    fill: Mutex<Fill>,
}

/// What this process knows of how full the folder is.
#[derive(Debug, Default)]
struct Fill {
    /// Bytes found at the last look.
    found: Option<u64>,
    /// Bytes written since.
    written: u64,
}

/// What a disk cache holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct DiskInfo {
    /// Number of values.
    pub objects: u64,
    /// Their bytes on disk.
    pub object_bytes: u64,
    /// Number of records, which say what is known of a node's outputs.
    pub records: u64,
    /// Their bytes on disk.
    pub record_bytes: u64,
    /// Damaged files that were found and removed; only [`DiskCache::verify`] looks for them.
    pub damaged: u64,
}

/// What was found under an id.
pub(crate) enum Found {
    Nothing,
    Damaged,
    Content(Vec<u8>),
}

struct Entry {
    path: PathBuf,
    kind: EntryKind,
    bytes: u64,
    used: SystemTime,
}

impl EntryKind {
    const ALL: [Self; 2] = [Self::Object, Self::Record];

    fn folder(self) -> &'static str {
        match self {
            Self::Object => "objects",
            Self::Record => "records",
        }
    }
}

impl DiskCache {
    /// A cache in a folder, which is made when something is first written. Beyond `limit` bytes the
    /// least recently used files are removed.
    pub fn new(root: impl Into<PathBuf>, limit: u64) -> Self {
        Self { root: root.into(), limit, fill: Mutex::default() }
    }

    /// The folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The most bytes it holds for long.
    pub fn limit(&self) -> u64 {
        self.limit
    }

    fn path(&self, kind: EntryKind, id: &Digest) -> PathBuf {
        let name = id.to_string();
        self.root.join(kind.folder()).join(name.get(..2).unwrap_or("")).join(name)
    }

    pub(crate) fn contains(&self, kind: EntryKind, id: &Digest) -> bool {
        self.path(kind, id).is_file()
    }

    /// Reads an entry and notes that it was used. A damaged one is removed.
    pub(crate) fn read(&self, kind: EntryKind, id: &Digest) -> Found {
        let path = self.path(kind, id);
        let Ok(file) = fs::read(&path) else { return Found::Nothing };
        match entry::content(kind, id, file) {
            Some(content) => {
                // Modification times stand for use; where they cannot be set the oldest go first.
                let _ = File::open(&path).and_then(|file| file.set_modified(SystemTime::now()));
                Found::Content(content)
            }
            None => {
                self.remove(kind, id);
                Found::Damaged
            }
        }
    }

    /// Removes an entry that turned out to be no good.
    pub(crate) fn remove(&self, kind: EntryKind, id: &Digest) {
        // If it cannot be removed it will be found damaged again, and computed again.
        let _ = fs::remove_file(self.path(kind, id));
    }

    /// Writes an entry, whole or not at all.
    pub(crate) fn write(&self, kind: EntryKind, id: &Digest, content: &[u8]) -> io::Result<()> {
        let path = self.path(kind, id);
        let temporary = self.root.join("tmp");
        fs::create_dir_all(&temporary)?;
        let mut file = tempfile::NamedTempFile::new_in(&temporary)?;
        file.write_all(&entry::header(kind, id, content))?;
        file.write_all(content)?;
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        file.persist(&path).map_err(|error| error.error)?;
        self.grown(content.len() as u64)
    }

    /// Notes that bytes were written, and makes room if there may be too many.
    fn grown(&self, bytes: u64) -> io::Result<()> {
        let full = {
            let mut fill = self.fill.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            fill.written = fill.written.saturating_add(bytes);
            // Other processes write as well, so one looks again now and then.
            match fill.found {
                None => true,
                Some(found) => {
                    found.saturating_add(fill.written) > self.limit || fill.written > self.limit / 16
                }
            }
        };
        if full { self.make_room() } else { Ok(()) }
    }

    /// Removes the least recently used files until nine tenths of the limit are left.
    fn make_room(&self) -> io::Result<()> {
        let lock = File::create(self.root.join("lock"))?;
        if fs4::FileExt::try_lock(&lock).is_err() {
            return Ok(()); // another process is at it
        }
        self.remove_stale();
        let mut entries = self.entries();
        let mut bytes = entries.iter().fold(0u64, |sum, entry| sum.saturating_add(entry.bytes));
        if bytes > self.limit {
            entries.sort_by(|a, b| a.used.cmp(&b.used).then_with(|| a.path.cmp(&b.path)));
            for entry in entries {
                if bytes <= self.limit / 10 * 9 {
                    break;
                }
                if fs::remove_file(&entry.path).is_ok() {
                    bytes = bytes.saturating_sub(entry.bytes);
                }
            }
        }
        let mut fill = self.fill.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        *fill = Fill { found: Some(bytes), written: 0 };
        Ok(())
    }

    fn remove_stale(&self) {
        let Ok(files) = fs::read_dir(self.root.join("tmp")) else { return };
        for file in files.flatten() {
            let age = file.metadata().and_then(|m| m.modified()).ok().and_then(|t| t.elapsed().ok());
            if age.is_some_and(|age| age > STALE) {
                let _ = fs::remove_file(file.path()); // tried again at the next occasion
            }
        }
    }

    /// All files of the cache that can be looked at.
    fn entries(&self) -> Vec<Entry> {
        let mut entries = Vec::new();
        for kind in EntryKind::ALL {
            let Ok(folders) = fs::read_dir(self.root.join(kind.folder())) else { continue };
            let files = folders.flatten().filter_map(|folder| fs::read_dir(folder.path()).ok()).flatten();
            for file in files.flatten() {
                if let Ok(metadata) = file.metadata()
                    && metadata.is_file()
                {
                    let used = metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH);
                    entries.push(Entry { path: file.path(), kind, bytes: metadata.len(), used });
                }
            }
        }
        entries
    }

    /// Counts what is there.
    pub fn info(&self) -> DiskInfo {
        let mut info = DiskInfo::default();
        for entry in self.entries() {
            info.add(&entry);
        }
        info
    }

    /// Reads every file, removes the damaged ones, and counts.
    ///
    /// # Errors
    /// If a damaged file cannot be removed.
    pub fn verify(&self) -> io::Result<DiskInfo> {
        let mut info = DiskInfo::default();
        for entry in self.entries() {
            let id = entry.path.file_name().and_then(|name| Digest::parse(&name.to_string_lossy()));
            let Ok(file) = fs::read(&entry.path) else { continue }; // removed in the meantime
            if id.and_then(|id| entry::content(entry.kind, &id, file)).is_some() {
                info.add(&entry);
            } else {
                fs::remove_file(&entry.path)?;
                info.damaged += 1;
            }
        }
        Ok(info)
    }

    /// Removes everything that the cache has written, and says what that was.
    ///
    /// # Errors
    /// If a file cannot be removed.
    pub fn clear(&self) -> io::Result<DiskInfo> {
        let info = self.info();
        for folder in ["objects", "records", "tmp"] {
            match fs::remove_dir_all(self.root.join(folder)) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                _ => {}
            }
        }
        *self.fill.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = Fill::default();
        Ok(info)
    }
}

impl DiskInfo {
    fn add(&mut self, entry: &Entry) {
        let (count, bytes) = match entry.kind {
            EntryKind::Object => (&mut self.objects, &mut self.object_bytes),
            EntryKind::Record => (&mut self.records, &mut self.record_bytes),
        };
        *count += 1;
        *bytes = bytes.saturating_add(entry.bytes);
    }

    /// Bytes of all files.
    pub fn bytes(&self) -> u64 {
        self.object_bytes.saturating_add(self.record_bytes)
    }
}
