//! What is remembered from one run of the program to the next, and what keeps work safe.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime};

use eframe::egui::Context;

use super::{App, Question};
use crate::files::recent::Recent;
use crate::files::recovery::{EVERY, Leftover, Recovery, Snapshot, leftovers};
use crate::files::{Change, Watch};
use crate::model::text_of;

/// How often the open file is looked at.
const LOOK: Duration = Duration::from_secs(2);

/// Length and time of a file; none if it is not there.
type Stamp = Option<(u64, SystemTime)>;

/// Recent files, copies for recovery, and whether the open file changed on disk.
pub struct Memory {
    folder: Option<PathBuf>,
    recent: Recent,
    leftovers: Vec<Leftover>,
    /// Leftovers that are being worked on.
    taken_over: Vec<PathBuf>,
    keeper: Option<Keeper>,
    /// Length and time of the files that nodes read, and when they were looked at.
    inputs: (BTreeMap<PathBuf, Stamp>, Option<Instant>),
    /// The revision that was kept last, and when.
    kept: Option<(u64, Instant)>,
    watch: Option<(Watch, Instant)>,
    /// What went wrong, to be told once.
    pub messages: Vec<String>,
}

/// What the thread that writes copies is told.
enum Order {
    /// Keep this, as of this moment.
    Keep(Instant, Box<Snapshot>),
    /// There is nothing to keep any more.
    Clear,
    /// The window is closed on purpose.
    Close,
}

/// A thread that writes copies, since a disk may take its time.
struct Keeper {
    orders: Sender<Order>,
    errors: Receiver<String>,
    thread: Option<JoinHandle<()>>,
}

impl Keeper {
    fn new(mut recovery: Recovery) -> Self {
        let (orders, receiver) = channel();
        let (sender, errors) = channel();
        let thread = std::thread::spawn(move || {
            for order in receiver {
                let done = match order {
                    Order::Keep(now, copy) => recovery.keep(now, &copy).map(|_| ()),
                    Order::Clear => recovery.clear(),
                    Order::Close => {
                        // The program ends; a copy that cannot be removed is offered next time.
                        let _ = recovery.close();
                        return;
                    }
                };
                if let Err(error) = done {
                    // Nobody listens only while the window closes.
                    let _ = sender.send(format!("no copy for recovery can be kept: {error}"));
                }
            }
            // Nobody said that the window is closed: the copy stays, as it does after a crash.
        });
        Self { orders, errors, thread: Some(thread) }
    }

    fn tell(&self, order: Order) {
        // The thread lives as long as this.
        let _ = self.orders.send(order);
    }
}

impl Memory {
    /// What is remembered in a folder; nothing without one.
    pub fn new(folder: Option<PathBuf>) -> Self {
        let mut messages = Vec::new();
        let copies = folder.as_ref().map(|folder| folder.join("recovery"));
        let found = copies.as_ref().map(|folder| leftovers(folder)).transpose().unwrap_or_else(|error| {
            messages.push(format!("what was not saved last time cannot be looked for: {error}"));
            None
        });
        let found = found.unwrap_or_default();
        messages.extend(found.messages);
        let recovery = copies.and_then(|folder| match Recovery::new(&folder) {
            Ok(recovery) => Some(recovery),
            Err(error) => {
                messages.push(format!("no copies for recovery can be kept in {}: {error}", folder.display()));
                None
            }
        });
        Self {
            recent: folder.as_ref().map(|folder| Recent::load(folder)).unwrap_or_default(),
            leftovers: found.leftovers,
            taken_over: Vec::new(),
            keeper: recovery.map(Keeper::new),
            inputs: (BTreeMap::new(), None),
            kept: None,
            watch: None,
            messages,
            folder,
        }
    }

    /// Recent files, the newest first.
    pub fn recent(&self) -> Vec<PathBuf> {
        self.recent.files().to_vec()
    }

    /// A file was read or written, and held these bytes.
    pub fn opened(&mut self, path: &Path, contents: &[u8]) {
        self.recent.add(path);
        if let Some(folder) = &self.folder {
            // A list that cannot be kept is only shorter next time.
            let _ = self.recent.save(folder);
        }
        self.watch = Some((Watch::new(path, contents), Instant::now()));
    }

    /// No file is open.
    pub fn closed(&mut self) {
        self.watch = None;
    }

    /// Whether the open file was changed by somebody else; looked at every few seconds.
    fn changed(&mut self, now: Instant) -> bool {
        let Some((watch, last)) = &mut self.watch else { return false };
        if now.saturating_duration_since(*last) < LOOK {
            return false;
        }
        *last = now;
        matches!(watch.look(), Change::Changed)
    }

    /// The change is known: it is told again only after another one.
    pub fn accept(&mut self) {
        if let Some((watch, _)) = &mut self.watch {
            watch.accept();
        }
    }

    /// Documents that earlier runs did not save: titles and where the copies are.
    pub fn leftovers(&self) -> Vec<(String, PathBuf)> {
        let open =
            self.leftovers.iter().filter(|found| !self.taken_over.iter().any(|path| path == found.path()));
        open.map(|found| (found.copy.title.clone(), found.path().to_owned())).collect()
    }

    /// The text of a leftover, and the file that it was of.
    pub fn recovered(&self, path: &Path) -> Option<(String, Option<PathBuf>)> {
        let found = self.leftovers.iter().find(|found| found.path() == path)?;
        Some((found.copy.text.clone(), found.copy.original.clone()))
    }

    /// A leftover is what is being worked on now: it is not offered again, and goes once that is saved.
    pub fn take_over(&mut self, path: &Path) {
        self.taken_over.push(path.to_owned());
        self.kept = None;
    }

    /// The document is saved.
    pub fn saved(&mut self) {
        for path in std::mem::take(&mut self.taken_over) {
            self.discard(&path);
        }
    }

    /// The window is closed on purpose: no copy is needed.
    pub fn close(&mut self) {
        if let Some(mut keeper) = self.keeper.take() {
            keeper.tell(Order::Close);
            if let Some(thread) = keeper.thread.take() {
                // A thread that panicked leaves its copy behind, which is what copies are for.
                let _ = thread.join();
            }
        }
    }

    /// Whether this is the first time that the program runs for this user; true only once.
    pub fn is_first_time(&self) -> bool {
        let Some(mark) = self.folder.as_ref().map(|folder| folder.join("first_steps_shown")) else {
            return false;
        };
        !mark.exists() && crate::files::write_whole(&mark, b"").is_ok()
    }

    /// A leftover is not needed any more.
    pub fn discard(&mut self, path: &Path) {
        if let Some(at) = self.leftovers.iter().position(|found| found.path() == path)
            && let Err(error) = self.leftovers.remove(at).discard()
        {
            self.messages.push(format!("the copy cannot be removed: {error}"));
        }
    }
}

impl App {
    /// Keeps a copy of what is not saved, every few seconds; looks after the open file.
    pub(super) fn keep_safe(&mut self, ctx: &Context) {
        let now = Instant::now();
        let dirty = self.project.is_dirty();
        let revision = self.project.revision();
        match self.memory.kept {
            None if !dirty => {}
            Some((kept, _)) if dirty && kept == revision => {}
            Some((_, last)) if dirty && now.saturating_duration_since(last) < EVERY => {
                ctx.request_repaint_after(EVERY - now.saturating_duration_since(last));
            }
            _ if dirty => {
                let text = text_of(self.project.state());
                let copy = Snapshot::new(
                    self.project.path.as_deref(),
                    &self.project.name(),
                    SystemTime::now(),
                    text,
                );
                if let Some(keeper) = &self.memory.keeper {
                    keeper.tell(Order::Keep(now, Box::new(copy)));
                }
                self.memory.kept = Some((revision, now));
            }
            _ => {
                if let Some(keeper) = &self.memory.keeper {
                    keeper.tell(Order::Clear);
                }
                self.memory.kept = None;
            }
        }
        if self.memory.changed(now) && self.question.is_none() {
            self.question = Some(Question::Changed);
        }
        if self.memory.watch.is_some() {
            ctx.request_repaint_after(LOOK);
        }
        self.look_at_inputs(now);
        let errors =
            self.memory.keeper.iter().flat_map(|keeper| keeper.errors.try_iter()).collect::<Vec<_>>();
        self.memory.messages.extend(errors);
        for message in std::mem::take(&mut self.memory.messages) {
            self.say(message);
        }
    }

    /// Computes again when a file changed that a node reads.
    fn look_at_inputs(&mut self, now: Instant) {
        if self.memory.inputs.1.is_some_and(|last| now.saturating_duration_since(last) < LOOK) {
            return;
        }
        self.memory.inputs.1 = Some(now);
        let folder = self.project.folder().map(Path::to_owned).unwrap_or_default();
        let mut paths = Vec::new();
        let mut document = (*self.checked.included).clone();
        document.change_paths(&self.registry, &folder, &mut |path| {
            paths.push(PathBuf::from(path));
            None
        });
        let state = |path: &Path| {
            let found = std::fs::metadata(path).ok()?;
            Some((found.len(), found.modified().ok()?))
        };
        let states: BTreeMap<PathBuf, _> =
            paths.into_iter().map(|path| (path.clone(), state(&path))).collect();
        let before = std::mem::replace(&mut self.memory.inputs.0, states);
        let changed = self
            .memory
            .inputs
            .0
            .iter()
            .find(|(path, state)| before.get(*path).is_some_and(|was| was != *state));
        if let Some((path, _)) = changed {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            self.say(format!("{name} changed on disk: what hangs on it is computed again"));
            self.results.values_mut().for_each(|subject| subject.stale = true);
            self.board.stale();
            self.due = true;
        }
    }
}
