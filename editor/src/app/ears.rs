//! Hears that there is no dialog. The crate that shows dialogs answers the same when the user cancels and when it has nothing to show, at
//! times only after a desktop service has kept it waiting for half a minute; but it says so to the log.

use std::cell::Cell;

use log::{LevelFilter, Log, Metadata, Record};

thread_local! {
    /// Whether the dialog of this thread could not be shown.
    static HEARD: Cell<bool> = const { Cell::new(false) };
}

/// Listens to what is said on the thread that it was made on.
pub(super) struct Ears(());

impl Ears {
    /// Begins to listen. Where another log was set up nothing is heard, and only time tells.
    pub fn open() -> Self {
        // The level first: another thread that finds the log set up must be heard already.
        if log::max_level() < LevelFilter::Error {
            log::set_max_level(LevelFilter::Error);
        }
        // Fails where it was set up before, by another dialog or another log.
        let _ = log::set_logger(&Listener);
        HEARD.set(false);
        Self(())
    }

    /// Whether there was no dialog.
    pub fn heard(&self) -> bool {
        HEARD.get()
    }
}

struct Listener;

impl Log for Listener {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.level() == log::Level::Error && metadata.target().starts_with("rfd")
    }

    fn log(&self, record: &Record<'_>) {
        // The last that is tried: if it fails there is nothing else.
        if self.enabled(record.metadata()) && record.args().to_string().contains("zenity") {
            HEARD.set(true);
        }
    }

    fn flush(&self) {}
}

#[cfg(test)]
mod tests {
    use super::Ears;

    #[test]
    fn only_a_dialog_that_cannot_be_shown_is_heard() {
        let ears = Ears::open();
        log::error!(target: "rfd::backend", "OpenFile failed: no answer");
        log::error!("zenity is of no interest to others");
        assert!(!ears.heard());
        log::error!(target: "rfd::backend", "Failed to pick file with zenity: not found");
        assert!(ears.heard());
        assert!(!Ears::open().heard());
    }
}
