//! Runs in the background, the newest wish first: what was asked for before is cancelled.

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use breccia_engine::{CancelToken, Engine, Event, Graph, RunError, Value};
use breccia_nodes::control::Control;

use super::thumbnail::{Thumbnail, thumbnail};

/// Which of the threads a wish goes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Lane {
    /// What is looked at, or was asked for.
    Main,
    /// Small pictures.
    Pictures,
}

/// One thing to compute.
#[derive(Clone)]
pub struct Item {
    /// The graph.
    pub graph: Arc<Graph>,
    /// Its outputs, by their names in the interface or as `node.socket`.
    pub outputs: Vec<String>,
}

/// How a wish ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All that could be computed is there.
    Finished,
    /// Something newer was asked for, or the user stopped it.
    Cancelled,
}

/// News from a run.
pub enum Update {
    /// Something happened in a run.
    Event(Event),
    /// An output is there.
    Value(String, Value),
    /// A small picture is there; `None` for values that have none.
    Picture(String, Option<Thumbnail>),
    /// The run could not begin.
    Refused(String),
    /// A wish is done with.
    Ended(Outcome),
}

/// A wish, and the token that takes it back.
struct Wish {
    id: u64,
    items: Vec<Item>,
    cancel: CancelToken,
}

#[derive(Default)]
struct Desk {
    next: Option<Wish>,
    current: Option<CancelToken>,
    closed: bool,
}

struct LaneState {
    desk: Mutex<Desk>,
    ready: Condvar,
}

impl LaneState {
    fn desk(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Two threads that run wishes on one engine.
pub struct Runner {
    engine: Engine,
    lanes: BTreeMap<Lane, (Arc<LaneState>, Option<JoinHandle<()>>, u64)>,
    updates: Receiver<(Lane, u64, Update)>,
}

/// Wakes the window.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

impl Runner {
    /// Starts the threads. `wake` is called whenever there is news.
    ///
    /// # Errors
    /// If the system gives no threads.
    pub fn new(engine: Engine, wake: Wake) -> std::io::Result<Self> {
        let (sender, updates) = channel();
        let mut lanes = BTreeMap::new();
        for lane in [Lane::Main, Lane::Pictures] {
            let state = Arc::new(LaneState { desk: Mutex::default(), ready: Condvar::new() });
            let work = Worker { lane, state: Arc::clone(&state), engine: engine.clone(), sender: sender.clone(), wake: Arc::clone(&wake) };
            let thread = std::thread::Builder::new().name(format!("run-{lane:?}")).spawn(move || work.run())?;
            lanes.insert(lane, (state, Some(thread), 0));
        }
        Ok(Self { engine, lanes, updates })
    }

    /// The engine.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// Takes back what the lane is doing and gives it something else to do. Without items it only stops.
    pub fn ask(&mut self, lane: Lane, items: Vec<Item>) {
        let Some((state, _, id)) = self.lanes.get_mut(&lane) else { return };
        *id += 1;
        let mut desk = state.desk();
        if let Some(current) = &desk.current {
            current.cancel();
        }
        desk.next = Some(Wish { id: *id, items, cancel: CancelToken::default() });
        state.ready.notify_one();
    }

    /// News since the last call, of the newest wishes only.
    pub fn news(&self) -> Vec<(Lane, Update)> {
        let newest = |lane: &Lane| self.lanes.get(lane).map_or(0, |(_, _, id)| *id);
        let news = self.updates.try_iter().filter(|(lane, id, _)| *id == newest(lane));
        news.map(|(lane, _, update)| (lane, update)).collect()
    }
}

impl Drop for Runner {
    fn drop(&mut self) {
        for (state, ..) in self.lanes.values() {
            let mut desk = state.desk();
            desk.closed = true;
            desk.current.iter().for_each(CancelToken::cancel);
            state.ready.notify_one();
        }
        for (_, thread, _) in self.lanes.values_mut() {
            if let Some(thread) = thread.take() {
                // A thread that panicked has nothing more to say.
                let _ = thread.join();
            }
        }
    }
}

struct Worker {
    lane: Lane,
    state: Arc<LaneState>,
    engine: Engine,
    sender: Sender<(Lane, u64, Update)>,
    wake: Wake,
}

struct Cancel<'a>(&'a CancelToken);

impl Control for Cancel<'_> {
    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }
}

impl Worker {
    fn run(self) {
        while let Some(wish) = self.next() {
            let outcome = self.fulfil(&wish);
            self.tell(wish.id, Update::Ended(outcome));
        }
    }

    /// The next wish; `None` when the window is closed.
    fn next(&self) -> Option<Wish> {
        let mut desk = self.state.desk();
        desk.current = None;
        loop {
            if desk.closed {
                return None;
            }
            if let Some(wish) = desk.next.take() {
                desk.current = Some(wish.cancel.clone());
                return Some(wish);
            }
            desk = self.state.ready.wait(desk).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn tell(&self, id: u64, update: Update) {
        // Nobody listens only while the window closes.
        let _ = self.sender.send((self.lane, id, update));
        (self.wake)();
    }

    fn fulfil(&self, wish: &Wish) -> Outcome {
        for item in &wish.items {
            let names: Vec<&str> = item.outputs.iter().map(String::as_str).collect();
            let on_event = |event: &Event| self.tell(wish.id, Update::Event(event.clone()));
            match self.engine.run(&item.graph, &names, &wish.cancel, &on_event) {
                Ok(result) => {
                    for (name, value) in result.outputs {
                        if self.lane == Lane::Pictures {
                            let picture = thumbnail(&value, &Cancel(&wish.cancel));
                            self.tell(wish.id, Update::Picture(name, picture));
                        } else {
                            self.tell(wish.id, Update::Value(name, value));
                        }
                    }
                }
                Err(RunError::Cancelled) => return Outcome::Cancelled,
                Err(error) => self.tell(wish.id, Update::Refused(error.to_string())),
            }
            if wish.cancel.is_cancelled() {
                return Outcome::Cancelled;
            }
        }
        Outcome::Finished
    }
}
