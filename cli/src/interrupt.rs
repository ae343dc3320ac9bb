//! Ctrl-C: stop soon, and leave nothing behind.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use breccia_engine::CancelToken;

use crate::exit::{Code, Failure};
use crate::term;

/// How long after a signal the program ends, whatever it is doing.
const PATIENCE: Duration = Duration::from_millis(90);

/// Stops a run on the first signal.
#[derive(Clone, Default)]
pub struct Interrupt {
    /// What the engine looks at.
    pub cancel: CancelToken,
    /// Folders of half-written outputs.
    staged: Arc<Mutex<Vec<PathBuf>>>,
    /// Whether somebody already says that the run was cancelled.
    announced: Arc<AtomicBool>,
}

impl Interrupt {
    /// Listens to Ctrl-C, and to requests to terminate.
    pub fn install() -> Self {
        let interrupt = Self::default();
        let on_signal = interrupt.clone();
        // Without a handler a signal ends the program all the same, only less tidily.
        let _ = ctrlc::set_handler(move || on_signal.stop());
        interrupt
    }

    /// Asks the run to stop, and ends the program if that takes too long. Writers of files do not listen, so
    /// there is no point in waiting for them.
    fn stop(&self) {
        self.cancel.cancel();
        if self.lock().is_empty() {
            std::thread::sleep(PATIENCE);
        }
        let staged = self.lock();
        for folder in staged.iter() {
            // A folder that cannot be removed now cannot be removed at all: the program is about to end.
            let _ = std::fs::remove_dir_all(folder);
        }
        if !self.announced.swap(true, Ordering::Relaxed) {
            term::note("cancelled");
        }
        std::process::exit(i32::from(Code::Cancelled as u8));
    }

    /// The failure that a cancelled run ends with.
    pub fn failure(&self) -> Failure {
        let silent = self.announced.swap(true, Ordering::Relaxed);
        Failure::new(Code::Cancelled, if silent { "" } else { "cancelled" })
    }

    /// An error if the user wants to stop.
    pub fn check(&self) -> Result<(), Failure> {
        if self.cancel.is_cancelled() { Err(self.failure()) } else { Ok(()) }
    }

    /// Makes a folder for half-written outputs inside `parent`; a signal removes it.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn stage(&self, parent: &Path) -> std::io::Result<tempfile::TempDir> {
        let mut staged = self.lock();
        let folder = tempfile::Builder::new().prefix(".breccia-").tempdir_in(parent)?;
        staged.push(folder.path().to_owned());
        Ok(folder)
    }

    /// Gives files their final names, which no signal may interrupt; nothing is half-written afterwards.
    pub fn publish<T>(&self, rename: impl FnOnce() -> T) -> T {
        let mut staged = self.lock();
        let result = rename();
        staged.clear();
        result
    }

    fn lock(&self) -> MutexGuard<'_, Vec<PathBuf>> {
        self.staged.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
