//! Runs in the background, the newest wish first: what was asked for before is cancelled.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

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

/// How long an earlier wish goes on after a newer one: what both need is then computed once, and not begun again.
const OVERLAP: Duration = Duration::from_millis(60);

/// The wishes of a lane that are under way.
#[derive(Default)]
struct Under {
    newest: u64,
    threads: Vec<(CancelToken, JoinHandle<()>)>,
}

/// Runs wishes on one engine.
pub struct Runner {
    engine: Engine,
    lanes: BTreeMap<Lane, Under>,
    sender: Sender<(Lane, u64, Update)>,
    updates: Receiver<(Lane, u64, Update)>,
    wake: Wake,
}

/// Wakes the window.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

impl Runner {
    /// A runner on an engine. `wake` is called whenever there is news.
    pub fn new(engine: Engine, wake: Wake) -> Self {
        let (sender, updates) = channel();
        Self { engine, lanes: BTreeMap::new(), sender, updates, wake }
    }

    /// The engine.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// Gives the lane something else to do, and takes back what it is doing once what both need is known to be needed still.
    /// Without items it only stops.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn ask(&mut self, lane: Lane, items: Vec<Item>) -> std::io::Result<()> {
        let under = self.lanes.entry(lane).or_default();
        under.newest += 1;
        under.threads.retain(|(_, thread)| !thread.is_finished());
        let earlier: Vec<CancelToken> = under.threads.iter().map(|(cancel, _)| cancel.clone()).collect();
        if items.is_empty() {
            earlier.iter().for_each(CancelToken::cancel);
            return Ok(());
        }
        let cancel = CancelToken::default();
        let wish = Wish {
            lane,
            id: under.newest,
            items,
            cancel: cancel.clone(),
            engine: self.engine.clone(),
            sender: self.sender.clone(),
            wake: Arc::clone(&self.wake),
        };
        let thread = std::thread::Builder::new().name(format!("run-{lane:?}")).spawn(move || wish.run())?;
        under.threads.push((cancel, thread));
        if !earlier.is_empty() {
            std::thread::Builder::new().name("take-back".into()).spawn(move || {
                std::thread::sleep(OVERLAP);
                earlier.iter().for_each(CancelToken::cancel);
            })?;
        }
        Ok(())
    }

    /// News since the last call, of the newest wishes only.
    pub fn news(&self) -> Vec<(Lane, Update)> {
        let newest = |lane: &Lane| self.lanes.get(lane).map_or(0, |under| under.newest);
        let news = self.updates.try_iter().filter(|(lane, id, _)| *id == newest(lane));
        news.map(|(lane, _, update)| (lane, update)).collect()
    }
}

impl Drop for Runner {
    fn drop(&mut self) {
        for (cancel, thread) in self.lanes.values_mut().flat_map(|under| under.threads.drain(..)) {
            cancel.cancel();
            // A thread that panicked has nothing more to say.
            let _ = thread.join();
        }
    }
}

/// Something asked for, and the token that takes it back.
struct Wish {
    lane: Lane,
    id: u64,
    items: Vec<Item>,
    cancel: CancelToken,
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

impl Wish {
    fn run(self) {
        let outcome = self.fulfil();
        self.tell(Update::Ended(outcome));
    }

    fn tell(&self, update: Update) {
        // Nobody listens only while the window closes.
        let _ = self.sender.send((self.lane, self.id, update));
        (self.wake)();
    }

    fn fulfil(&self) -> Outcome {
        for item in &self.items {
            let names: Vec<&str> = item.outputs.iter().map(String::as_str).collect();
            let on_event = |event: &Event| self.tell(Update::Event(event.clone()));
            match self.engine.run(&item.graph, &names, &self.cancel, &on_event) {
                Ok(result) => {
                    for (name, value) in result.outputs {
                        if self.lane == Lane::Pictures {
                            let picture = thumbnail(&value, &Cancel(&self.cancel));
                            self.tell(Update::Picture(name, picture));
                        } else {
                            self.tell(Update::Value(name, value));
                        }
                    }
                }
                Err(RunError::Cancelled) => return Outcome::Cancelled,
                Err(error) => self.tell(Update::Refused(error.to_string())),
            }
            if self.cancel.is_cancelled() {
                return Outcome::Cancelled;
            }
        }
        Outcome::Finished
    }
}
