//! What a run shows while it goes on: bars on a terminal, lines elsewhere, events for programs, or nothing.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::io::{self, IsTerminal, Write};

use breccia_engine::{Device, Event};
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};
use serde::Serialize;

use crate::sizes::human;
use crate::term;

/// Shows the events of a run.
pub enum Progress {
    /// Bars on the terminal behind standard error.
    Bars(Bars),
    /// Lines on standard error.
    Lines,
    /// Each event as a line of JSON on standard output.
    Json(JsonLines),
    /// Warnings and errors alone.
    Quiet,
}

impl Progress {
    /// What suits the options and the terminal.
    pub fn new(json: bool, quiet: bool) -> Self {
        if json {
            Self::Json(JsonLines::default())
        } else if quiet {
            Self::Quiet
        } else if io::stderr().is_terminal() {
            Self::Bars(Bars::default())
        } else {
            Self::Lines
        }
    }

    /// Shows an event. Failures are left to whoever looks at the result.
    pub fn show(&self, event: &Event) {
        if let Self::Json(lines) = self {
            return lines.write(event);
        }
        if let Self::Bars(bars) = self {
            bars.show(event);
        }
        let line = match event {
            Event::Warning { node: Some(node), message } => format!("warning: node `{node}`: {message}"),
            Event::Warning { node: None, message } => format!("warning: {message}"),
            _ if matches!(self, Self::Quiet) => return,
            Event::DeviceChosen { message } => format!("note: {message}"),
            Event::NodeFinished { node, seconds, bytes, summary, device } => {
                let place = if *device == Device::Gpu { ", on the device" } else { "" };
                format!("{node}: {} ({}, {seconds:.2} s{place})", term::brief(summary), human(*bytes))
            }
            Event::RunFinished { seconds, computed, cached, cancelled: false, .. } => {
                format!("computed {computed} nodes, found {cached} in the cache, in {seconds:.2} s")
            }
            _ => return,
        };
        self.note(&line);
    }

    /// A line about something else than an event.
    pub fn note(&self, line: &str) {
        match self {
            Self::Bars(bars) => bars.all.suspend(|| term::note(line)),
            _ => term::note(line),
        }
    }

    /// Something that the run did besides computing, for people or as an event.
    pub fn tell(&self, event: &impl Serialize, line: &str) {
        match self {
            Self::Json(lines) => lines.write(event),
            Self::Quiet => {}
            Self::Lines | Self::Bars(_) => self.note(line),
        }
    }
}

/// Lines of JSON on standard output, until nobody reads them any more.
#[derive(Default)]
pub struct JsonLines {
    closed: Cell<bool>,
}

impl JsonLines {
    fn write(&self, event: &impl Serialize) {
        let Ok(line) = serde_json::to_string(event) else { return };
        if !self.closed.get() {
            let mut out = io::stdout().lock();
            // The run goes on for its outputs' sake.
            self.closed.set(writeln!(out, "{line}").and_then(|()| out.flush()).is_err());
        }
    }
}

/// A bar for each node that is at work.
#[derive(Default)]
pub struct Bars {
    all: MultiProgress,
    running: RefCell<BTreeMap<String, ProgressBar>>,
}

/// Steps of a full bar.
const STEPS: u64 = 1000;

impl Bars {
    fn show(&self, event: &Event) {
        let mut running = self.running.borrow_mut();
        match event {
            Event::NodeStarted { node, node_type, .. } => {
                let bar = self.all.add(ProgressBar::new(STEPS));
                if let Ok(style) =
                    ProgressStyle::with_template("{msg:24!} [{bar:32}] {percent:>3}% {elapsed}")
                {
                    bar.set_style(style.progress_chars("=> "));
                }
                bar.set_message(format!("{node} ({node_type})"));
                running.insert(node.clone(), bar);
            }
            Event::NodeProgress { node, fraction } => {
                if let Some(bar) = running.get(node) {
                    bar.set_position((f64::from(*fraction) * STEPS as f64) as u64);
                }
            }
            Event::NodeFinished { node, .. } | Event::NodeFailed { node, .. } => {
                if let Some(bar) = running.remove(node) {
                    bar.finish_and_clear();
                }
            }
            Event::RunFinished { .. } => {
                running.values().for_each(ProgressBar::finish_and_clear);
                running.clear();
            }
            _ => {}
        }
    }
}
