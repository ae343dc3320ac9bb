//! Both caches behind one door: records and values, in memory and on disk.

mod disk;
mod entry;
mod memory;
mod record;

use std::collections::HashMap;
use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::events::CacheLevel;
use crate::keys::Key;
use crate::value::{Digest, TypeInfo, Value};
use disk::Found;
pub use disk::{DiskCache, DiskInfo};
use entry::EntryKind;
use memory::MemoryCache;
pub(crate) use record::{OutputRecord, Record};

/// Records in each of two generations: when the young one is full, the old one is forgotten.
const GENERATION: usize = 1 << 16;

pub(crate) struct Cache {
    values: Mutex<MemoryCache>,
    records: Mutex<Generations>,
    pub disk: Option<DiskCache>,
}

#[derive(Default)]
struct Generations {
    young: HashMap<Key, Arc<Record>>,
    old: HashMap<Key, Arc<Record>>,
}

/// Something that was looked for: perhaps found, perhaps damaged.
pub(crate) struct Lookup<T> {
    pub found: Option<T>,
    pub warning: Option<String>,
}

impl<T> Lookup<T> {
    fn found(value: T) -> Self {
        Self { found: Some(value), warning: None }
    }

    fn nothing() -> Self {
        Self { found: None, warning: None }
    }

    fn damaged(what: &str, id: &Digest) -> Self {
        Self {
            found: None,
            warning: Some(format!("{what} {id} in the disk cache is damaged, it is made again")),
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // What the mutexes guard is whole between any two statements, even if a value's own code panicked.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Cache {
    pub fn new(memory: u64, disk: Option<DiskCache>) -> Self {
        Self { values: Mutex::new(MemoryCache::new(memory)), records: Mutex::default(), disk }
    }

    pub fn record_in_memory(&self, key: &Key) -> Option<Arc<Record>> {
        let mut records = lock(&self.records);
        if let Some(record) = records.young.get(key) {
            return Some(Arc::clone(record));
        }
        let record = records.old.get(key).cloned()?;
        records.insert(*key, Arc::clone(&record));
        Some(record)
    }

    pub fn record(&self, key: &Key) -> Lookup<Arc<Record>> {
        if let Some(record) = self.record_in_memory(key) {
            return Lookup::found(record);
        }
        let Some(disk) = &self.disk else { return Lookup::nothing() };
        let content = match disk.read(EntryKind::Record, key) {
            Found::Nothing => return Lookup::nothing(),
            Found::Damaged => return Lookup::damaged("record", key),
            Found::Content(content) => content,
        };
        match ron::de::from_bytes::<Record>(&content) {
            Ok(record) => {
                let record = Arc::new(record);
                lock(&self.records).insert(*key, Arc::clone(&record));
                Lookup::found(record)
            }
            Err(_) => Lookup::damaged("record", key),
        }
    }

    /// Keeps a node's outputs in memory.
    pub fn keep(&self, key: &Key, record: &Arc<Record>, values: &[Value]) {
        lock(&self.records).insert(*key, Arc::clone(record));
        let mut cache = lock(&self.values);
        for (output, value) in record.outputs.iter().zip(values) {
            cache.insert(output.value_id(), value.clone());
        }
    }

    /// Writes a node's record, and its values where they can be written and are worth it, to disk.
    pub fn store(&self, key: &Key, record: &Record, values: &[Value], worth_it: bool) -> io::Result<()> {
        let Some(disk) = &self.disk else { return Ok(()) };
        if worth_it {
            for (output, value) in record.outputs.iter().zip(values) {
                let id = output.value_id();
                if !disk.contains(EntryKind::Object, &id)
                    && let Some(bytes) = value.encode()
                {
                    disk.write(EntryKind::Object, &id, &bytes)?;
                }
            }
        }
        let text = ron::to_string(record).map_err(io::Error::other)?;
        disk.write(EntryKind::Record, key, text.as_bytes())
    }

    pub fn value_in_memory(&self, output: &OutputRecord) -> Option<Value> {
        lock(&self.values).get(&output.value_id())
    }

    /// Where a value is, without reading it.
    pub fn locate(&self, output: &OutputRecord) -> Option<CacheLevel> {
        let id = output.value_id();
        if lock(&self.values).contains(&id) {
            return Some(CacheLevel::Memory);
        }
        let on_disk = self.disk.as_ref().is_some_and(|disk| disk.contains(EntryKind::Object, &id));
        on_disk.then_some(CacheLevel::Disk)
    }

    /// Reads a value from disk and keeps it in memory.
    pub fn value_on_disk(&self, output: &OutputRecord, ty: &TypeInfo) -> Lookup<Value> {
        let id = output.value_id();
        let Some(disk) = &self.disk else { return Lookup::nothing() };
        let content = match disk.read(EntryKind::Object, &id) {
            Found::Nothing => return Lookup::nothing(),
            Found::Damaged => return Lookup::damaged("value", &id),
            Found::Content(content) => content,
        };
        match (ty.decode)(&content) {
            Ok(value) => {
                lock(&self.values).insert(id, value.clone());
                Lookup::found(value)
            }
            Err(_) => {
                disk.remove(EntryKind::Object, &id);
                Lookup::damaged("value", &id)
            }
        }
    }

    pub fn trim(&self) {
        lock(&self.values).trim();
    }

    pub fn set_memory(&self, budget: u64) {
        lock(&self.values).set_budget(budget);
    }

    pub fn memory_usage(&self) -> (usize, u64) {
        let values = lock(&self.values);
        (values.len(), values.bytes())
    }

    pub fn clear_memory(&self) {
        lock(&self.values).clear();
        *lock(&self.records) = Generations::default();
    }
}

impl Generations {
    fn insert(&mut self, key: Key, record: Arc<Record>) {
        if self.young.len() >= GENERATION {
            self.old = std::mem::take(&mut self.young);
        }
        self.young.insert(key, record);
    }
}
