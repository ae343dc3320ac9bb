//! What stays on the device between computations: tables and volumes, by the digest of what they hold, least recently
//! used first out.

use std::any::Any;
use std::sync::{Arc, Mutex, PoisonError};

/// The digest of what an entry holds.
pub(crate) type Id = [u8; 32];

#[derive(Default)]
pub(crate) struct Resident {
    /// Least recently used first.
    entries: Mutex<Vec<(Id, Arc<dyn Any + Send + Sync>)>>,
}

impl Resident {
    pub fn find<T: Any + Send + Sync>(&self, id: &Id) -> Option<Arc<T>> {
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        let at = entries.iter().position(|(other, _)| other == id)?;
        let entry = entries.remove(at);
        let found = Arc::clone(&entry.1).downcast().ok();
        entries.push(entry);
        found
    }

    pub fn keep<T: Any + Send + Sync>(&self, id: Id, value: Arc<T>) {
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        entries.retain(|(other, _)| *other != id);
        entries.push((id, value));
    }

    /// Lets go of the entry that was not used for longest, among those that nobody uses now. False if there is none.
    pub fn evict(&self) -> bool {
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        let idle = entries.iter().position(|(_, value)| Arc::strong_count(value) == 1);
        idle.map(|at| entries.remove(at)).is_some()
    }

    pub fn clear(&self) {
        self.entries.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    pub fn len(&self) -> usize {
        self.entries.lock().unwrap_or_else(PoisonError::into_inner).len()
    }
}
