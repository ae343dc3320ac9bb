//! Single flight: no key is computed twice at the same time, whether in one run or in several.

use std::collections::HashMap;
use std::sync::mpsc::Sender;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::task::{Message, Outputs};
use crate::keys::Key;
use crate::node::CancelToken;

/// A key that is being computed.
struct Flight {
    waiters: Vec<Sender<Message>>,
    /// Stops the computation once nobody wants it any more.
    cancel: CancelToken,
}

#[derive(Default)]
pub(crate) struct Flights(Mutex<HashMap<Key, Flight>>);

impl Flights {
    fn lock(&self) -> MutexGuard<'_, HashMap<Key, Flight>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What stops the computation, if the caller is to compute the key, and to [`Self::land`] afterwards whatever happens.
    /// Otherwise somebody computes it already, goes on as long as the caller's run does, and `waiter` will hear of it.
    pub fn take_off(&self, key: Key, waiter: &Sender<Message>, run: &CancelToken) -> Option<CancelToken> {
        let mut flights = self.lock();
        match flights.get_mut(&key) {
            Some(flight) => {
                flight.waiters.push(waiter.clone());
                flight.cancel.join(run);
                None
            }
            None => {
                let cancel = run.shared();
                flights.insert(key, Flight { waiters: Vec::new(), cancel: cancel.clone() });
                Some(cancel)
            }
        }
    }

    /// Tells those who wait how far it is.
    pub fn approach(&self, key: Key, fraction: f32) {
        if let Some(flight) = self.lock().get(&key) {
            for waiter in &flight.waiters {
                // Who has gone does not need to hear.
                let _ = waiter.send(Message::Approaching { key, fraction });
            }
        }
    }

    /// Tells all who wait; `None` means that one of them has to compute the key.
    pub fn land(&self, key: Key, outputs: Option<&Outputs>) {
        let waiters = self.lock().remove(&key).map(|flight| flight.waiters).unwrap_or_default();
        for waiter in waiters {
            // Who has gone does not need to hear.
            let _ = waiter.send(Message::Landed { key, outputs: outputs.cloned() });
        }
    }
}
