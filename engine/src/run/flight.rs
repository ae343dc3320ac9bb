//! Single flight: no key is computed twice at the same time, whether in one run or in several.

use std::collections::HashMap;
use std::sync::mpsc::Sender;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::task::{Message, Outputs};
use crate::keys::Key;

#[derive(Default)]
pub(crate) struct Flights(Mutex<HashMap<Key, Vec<Sender<Message>>>>);

impl Flights {
    fn lock(&self) -> MutexGuard<'_, HashMap<Key, Vec<Sender<Message>>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// True if the caller is to compute the key, and to [`Self::land`] afterwards whatever happens.
    /// Otherwise somebody computes it already, and `waiter` will hear of it.
    pub fn take_off(&self, key: Key, waiter: &Sender<Message>) -> bool {
        let mut flights = self.lock();
        match flights.get_mut(&key) {
            Some(waiters) => {
                waiters.push(waiter.clone());
                false
            }
            None => {
                flights.insert(key, Vec::new());
                true
            }
        }
    }

    /// Tells all who wait; `None` means that one of them has to compute the key.
    pub fn land(&self, key: Key, outputs: Option<&Outputs>) {
        let waiters = self.lock().remove(&key).unwrap_or_default();
        for waiter in waiters {
            // Who has gone does not need to hear.
            let _ = waiter.send(Message::Landed { key, outputs: outputs.cloned() });
        }
    }
}
