//! What is remembered from one run of the program to the next, and what keeps work safe.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Sender, channel};
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

/// Recent files, copies for recovery, and whether the open file changed on disk.
pub struct Memory {
    folder: Option<PathBuf>,
    recent: Recent,
    leftovers: Vec<Leftover>,
    keeper: Option<Keeper>,
    /// The revision that was kept last, and when.
    kept: Option<(u64, Instant)>,
    watch: Option<(Watch, Instant)>,
    /// What went wrong, to be told once.
    pub messages: Vec<String>,
}

/// A thread that writes copies, since a disk may take its time.
struct Keeper {
    copies: Option<Sender<Option<Snapshot>>>,
    thread: Option<JoinHandle<()>>,
}

impl Keeper {
    fn new(mut recovery: Recovery) -> Self {
        let (copies, receiver) = channel::<Option<Snapshot>>();
        let thread = std::thread::spawn(move || {
            for copy in receiver {
                // A copy that cannot be written is tried again with the next change.
                let _ = match copy {
                    Some(copy) => recovery.keep(Instant::now(), &copy).map(|_| ()),
                    None => recovery.clear(),
                };
            }
            // The sender is gone: the window was closed on purpose.
            let _ = recovery.close();
        });
        Self { copies: Some(copies), thread: Some(thread) }
    }

    fn keep(&self, copy: Option<Snapshot>) {
        if let Some(copies) = &self.copies {
            // The thread lives as long as this.
            let _ = copies.send(copy);
        }
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        self.copies = None;
        if let Some(thread) = self.thread.take() {
            // A thread that panicked leaves its copy behind, which is what copies are for.
            let _ = thread.join();
        }
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
            keeper: recovery.map(Keeper::new),
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
        self.leftovers.iter().map(|found| (found.copy.title.clone(), found.path().to_owned())).collect()
    }

    /// The text of a leftover, and the file that it was of.
    pub fn recovered(&self, path: &Path) -> Option<(String, Option<PathBuf>)> {
        let found = self.leftovers.iter().find(|found| found.path() == path)?;
        Some((found.copy.text.clone(), found.copy.original.clone()))
    }

    /// A leftover is not needed any more.
    pub fn discard(&mut self, path: &Path) {
        if let Some(at) = self.leftovers.iter().position(|found| found.path() == path) {
            if let Err(error) = self.leftovers.remove(at).discard() {
                self.messages.push(format!("the copy cannot be removed: {error}"));
            }
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
                    keeper.keep(Some(copy));
                }
                self.memory.kept = Some((revision, now));
            }
            _ => {
                if let Some(keeper) = &self.memory.keeper {
                    keeper.keep(None);
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
        for message in std::mem::take(&mut self.memory.messages) {
            self.say(message);
        }
    }
}
