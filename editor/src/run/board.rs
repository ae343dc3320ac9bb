//! What is known of every node: gathered from the events of runs.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

use breccia_engine::{CacheLevel, Device, Event};

use super::general;

/// How far a node is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Phase {
    /// Nobody has asked for it.
    #[default]
    Idle,
    /// It computes.
    Running,
    /// It has computed.
    Done,
    /// Its result was there already.
    Cached(CacheLevel),
    /// It failed.
    Failed,
    /// It could not run because of another one.
    Skipped,
}

/// What is known of a node.
#[derive(Clone, Debug, Default)]
pub struct NodeStatus {
    /// How far it is.
    pub phase: Phase,
    /// What of it is done, 0 to 1.
    pub fraction: f32,
    /// Seconds that it took last time it computed, with all iterations and inner nodes.
    pub seconds: f64,
    /// Bytes of its outputs.
    pub bytes: u64,
    /// Its outputs in words.
    pub summary: String,
    /// Where it ran.
    pub device: Option<Device>,
    /// Why it failed or could not run.
    pub error: Option<String>,
    /// Warnings.
    pub warnings: Vec<String>,
    /// Whether the graph has changed since.
    pub stale: bool,
    /// Inner nodes that run now.
    running: usize,
    /// The run that the seconds are of.
    run: u64,
}

/// What is known of all nodes.
#[derive(Default)]
pub struct Board {
    nodes: BTreeMap<String, NodeStatus>,
    /// What nodes run on that have a choice.
    pub device: Option<String>,
    /// Warnings that are about no node.
    pub warnings: Vec<String>,
    /// When the run that goes on began.
    pub started: Option<Instant>,
    /// How long the last run took, in seconds, and how many nodes it computed and found.
    pub last: Option<(f64, usize, usize)>,
    run: u64,
}

impl Board {
    /// What is known of a node, by its name in a run without numbers of iterations.
    pub fn get(&self, path: &str) -> Option<&NodeStatus> {
        self.nodes.get(path)
    }

    /// All nodes with something wrong.
    pub fn failures(&self) -> impl Iterator<Item = (&str, &NodeStatus)> {
        self.nodes.iter().filter(|(_, s)| s.phase == Phase::Failed).map(|(name, s)| (name.as_str(), s))
    }

    /// Nodes that compute now, and how far they are.
    pub fn running(&self) -> impl Iterator<Item = (&str, f32)> {
        self.nodes
            .iter()
            .filter(|(_, s)| s.phase == Phase::Running)
            .map(|(name, s)| (name.as_str(), s.fraction))
    }

    /// The graph has changed: what was true may not be any more.
    pub fn stale(&mut self) {
        for status in self.nodes.values_mut() {
            status.stale = true;
        }
    }

    /// Forgets nodes that are not there, or do not run, any more. Groups stand for the nodes in them.
    pub fn keep(&mut self, nodes: &BTreeSet<String>) {
        let within = |name: &str| {
            let inner = format!("{name}/");
            nodes.range(inner.clone()..).next().is_some_and(|next| next.starts_with(&inner))
        };
        self.nodes.retain(|name, _| nodes.contains(name) || within(name));
    }

    /// A run begins.
    pub fn begin(&mut self) {
        self.run += 1;
        self.started = Some(Instant::now());
        self.warnings.clear();
        for status in self.nodes.values_mut() {
            status.running = 0;
            status.warnings.clear();
            if status.phase == Phase::Running {
                status.phase = Phase::Idle;
            }
        }
    }

    /// The run ended.
    pub fn end(&mut self) {
        self.started = None;
        for status in self.nodes.values_mut().filter(|status| status.phase == Phase::Running) {
            status.phase = Phase::Idle;
            status.running = 0;
        }
    }

    /// Forgets everything, as for another document.
    pub fn clear(&mut self) {
        *self = Self { run: self.run, ..Self::default() };
    }

    /// Takes note of what happened.
    pub fn note(&mut self, event: &Event) {
        match event {
            Event::DeviceChosen { message } => self.device = Some(message.clone()),
            Event::Warning { node: None, message } => self.warnings.push(message.clone()),
            Event::RunFinished { seconds, computed, cached, cancelled: false, .. } => {
                self.last = Some((*seconds, *computed, *cached));
            }
            _ => {}
        }
        let Some(node) = event.node() else { return };
        let path = general(node);
        let run = self.run;
        // A group or zone is as far as what it stands for.
        let ends = path.match_indices('/').map(|(end, _)| end).chain([path.len()]);
        for end in ends {
            let own = end == path.len();
            let status = self.nodes.entry(path[..end].to_owned()).or_default();
            status.note(event, own && !node.contains('['), run);
        }
    }
}

impl NodeStatus {
    /// `single` says whether the event is about this node itself and there is just one of it.
    fn note(&mut self, event: &Event, single: bool, run: u64) {
        match event {
            Event::NodeStarted { device, .. } => {
                if self.run != run {
                    (self.run, self.seconds, self.running) = (run, 0.0, 0);
                }
                self.phase = Phase::Running;
                self.running += 1;
                self.fraction = 0.0;
                self.device = Some(*device);
                self.error = None;
            }
            Event::NodeProgress { fraction, .. } => {
                // Another run may have begun it.
                self.phase = Phase::Running;
                self.fraction = *fraction;
            }
            Event::NodeFinished { seconds, bytes, summary, device, .. } => {
                self.running = self.running.saturating_sub(1);
                self.seconds = if single { *seconds } else { self.seconds + seconds };
                self.bytes = *bytes;
                self.summary.clone_from(summary);
                self.device = Some(*device);
                if self.running == 0 && self.phase != Phase::Failed {
                    self.phase = Phase::Done;
                }
                self.stale = false;
                self.error = None;
            }
            Event::NodeCached { from, bytes, summary, .. } => {
                // What has just computed stays so to the eye, though a second request finds it in the cache.
                if !(self.phase == Phase::Done && self.run == run) {
                    self.running = 0;
                    self.phase = Phase::Cached(*from);
                    self.error = None;
                }
                self.bytes = *bytes;
                self.summary.clone_from(summary);
                self.stale = false;
            }
            Event::NodeFailed { error, .. } => {
                self.running = self.running.saturating_sub(1);
                self.phase = Phase::Failed;
                self.stale = false;
                self.error = Some(error.clone());
            }
            Event::NodeSkipped { because_of, .. } => {
                self.phase = Phase::Skipped;
                self.stale = false;
                self.error = Some(format!("it needs `{because_of}`, which failed"));
            }
            Event::Warning { message, .. } if single => self.warnings.push(message.clone()),
            _ => {}
        }
    }
}
