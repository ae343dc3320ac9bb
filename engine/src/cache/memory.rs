//! Values in memory: least recently used go first, those that somebody holds stay.

use std::collections::{BTreeMap, HashMap};

use crate::value::{Digest, Value};

#[derive(Debug)]
pub(crate) struct MemoryCache {
    budget: u64,
    entries: HashMap<Digest, Entry>,
    /// The entries by the time of their last use.
    by_use: BTreeMap<u64, Digest>,
    clock: u64,
}

#[derive(Debug)]
struct Entry {
    value: Value,
    used: u64,
}

impl MemoryCache {
    pub fn new(budget: u64) -> Self {
        Self { budget, entries: HashMap::new(), by_use: BTreeMap::new(), clock: 0 }
    }

    /// Keeps values up to another number of bytes from now on.
    pub fn set_budget(&mut self, budget: u64) {
        self.budget = budget;
        self.trim();
    }

    pub fn contains(&self, id: &Digest) -> bool {
        self.entries.contains_key(id)
    }

    pub fn get(&mut self, id: &Digest) -> Option<Value> {
        let entry = self.entries.get_mut(id)?;
        self.clock += 1;
        self.by_use.remove(&entry.used);
        entry.used = self.clock;
        self.by_use.insert(self.clock, *id);
        Some(entry.value.clone())
    }

    pub fn insert(&mut self, id: Digest, value: Value) {
        self.clock += 1;
        if let Some(old) = self.entries.insert(id, Entry { value, used: self.clock }) {
            self.by_use.remove(&old.used);
        }
        self.by_use.insert(self.clock, id);
        self.trim();
    }

    /// Lets go of values until the rest fits the budget. Values that somebody holds stay: letting go of
    /// them would free nothing, and they would have to be computed again.
    pub fn trim(&mut self) {
        // Sizes are asked anew, since values such as solids grow as they remember bricks.
        let mut bytes = self.bytes();
        if bytes <= self.budget {
            return;
        }
        let by_age: Vec<(u64, Digest)> = self.by_use.iter().map(|(used, id)| (*used, *id)).collect();
        for (used, id) in by_age {
            if bytes <= self.budget {
                break;
            }
            if self.entries.get(&id).is_some_and(|entry| entry.value.owners() == 1) {
                self.by_use.remove(&used);
                if let Some(entry) = self.entries.remove(&id) {
                    bytes = bytes.saturating_sub(entry.value.byte_size());
                }
            }
        }
    }

    pub fn bytes(&self) -> u64 {
        self.entries.values().fold(0, |sum, entry| sum.saturating_add(entry.value.byte_size()))
    }

    pub fn len(&self) -> usize {
        self.entries.len()
    }

    pub fn clear(&mut self) {
        self.entries.clear();
        self.by_use.clear();
    }
}
