//! The scheduler of a run. It works on the caller's thread, so no thread of the pool ever waits for a node.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use super::explain::apart;
use super::files::{self, FileState};
use super::state::{Action, Demand, RunState, Status};
use super::task::{Message, Task};
use super::{Failure, RunError, RunResult};
use crate::cache::Lookup;
use crate::device::Placed;
use crate::engine::Shared;
use crate::events::{CacheLevel, Event, FailureKind};
use crate::graph::{Graph, Problems, Source};
use crate::keys::Key;
use crate::node::{CancelToken, NodeError};
use crate::value::Value;

/// How often a run looks whether it is cancelled.
const TICK: Duration = Duration::from_millis(10);

/// What is to be run, and how.
pub(crate) struct Order<'a> {
    pub shared: &'a Arc<Shared>,
    pub graph: &'a Arc<Graph>,
    pub outputs: &'a [&'a str],
    pub cancel: &'a CancelToken,
    pub on_event: &'a dyn Fn(&Event),
    pub checked: bool,
}

pub(crate) fn run(order: &Order<'_>) -> Result<RunResult, RunError> {
    let mut named = Vec::new();
    let mut problems = Vec::new();
    for &name in order.outputs {
        match order.graph.find_output(name) {
            Ok(source) => named.push((name, source)),
            Err(found) => problems.extend(found.0),
        }
    }
    if !problems.is_empty() {
        return Err(Problems(problems).into());
    }
    let presence = order.graph.presence();
    let lacks: Vec<_> =
        named.iter().map(|(_, source)| order.graph.lacks(*source, &presence.absent)).collect();
    let there = named.iter().zip(&lacks).filter(|(_, lack)| lack.is_none());
    let targets = there.map(|((_, source), _)| *source).collect();
    let state =
        RunState::new(order.graph, presence, targets, order.checked, apart(order.shared, order.graph));

    let (sender, receiver) = channel();
    let mut scheduler = Scheduler {
        order,
        state,
        sender,
        receiver,
        pending: 0,
        busy: 0,
        waiting: Vec::new(),
        flying: Vec::new(),
        cancelled_at: Arc::default(),
        result: RunResult::default(),
        store_warned: false,
        device_told: false,
    };
    let start = Instant::now();
    // Results of earlier runs may have been let go of since.
    order.shared.cache.trim();
    scheduler.emit(Event::RunStarted {
        outputs: order.outputs.iter().map(|&name| name.to_owned()).collect(),
        threads: order.shared.threads(),
    });
    for node in order.shared.take_slow_stops() {
        let message = "went on for over a second after an earlier run was cancelled".to_owned();
        scheduler.emit(Event::Warning { node: Some(node), message });
    }
    for ((_, source), lack) in named.iter().zip(lacks) {
        if let Some(lack) = lack {
            scheduler.fail(lack.node, FailureKind::Input, lack.message);
            if lack.node != source.node {
                scheduler.skip(source.node, lack.node);
            }
        }
    }
    let cancelled = scheduler.work().is_err();
    for (name, source) in named {
        if let Some(value) = scheduler.state.nodes[source.node].held[source.output].clone() {
            scheduler.result.outputs.insert(name.to_owned(), value);
        }
    }
    scheduler.state.nodes.iter_mut().for_each(|node| node.held.clear());
    order.shared.cache.trim();
    scheduler.emit(Event::RunFinished {
        seconds: start.elapsed().as_secs_f64(),
        computed: scheduler.result.computed,
        cached: scheduler.result.cached,
        failed: scheduler.result.failures.len(),
        cancelled,
    });
    if cancelled { Err(RunError::Cancelled) } else { Ok(scheduler.result) }
}

/// The run was cancelled.
struct Cancelled;

struct Scheduler<'a> {
    order: &'a Order<'a>,
    state: RunState<'a>,
    sender: Sender<Message>,
    receiver: Receiver<Message>,
    /// Tasks that have not said their last word, including the writing of results.
    pending: usize,
    /// Nodes that compute now.
    busy: usize,
    /// Nodes whose key somebody else computes.
    waiting: Vec<(Key, usize)>,
    /// What this run computes, or did, and what stops it: another run may want it too.
    flying: Vec<(usize, CancelToken)>,
    cancelled_at: Arc<OnceLock<Instant>>,
    result: RunResult,
    store_warned: bool,
    device_told: bool,
}

impl Scheduler<'_> {
    fn emit(&self, event: Event) {
        (self.order.on_event)(&event);
    }

    fn is_machinery(&self, node: usize) -> bool {
        self.order.graph.nodes[node].is_machinery()
    }

    fn name(&self, node: usize) -> String {
        self.order.graph.nodes[node].name.clone()
    }

    fn work(&mut self) -> Result<(), Cancelled> {
        loop {
            if self.order.cancel.is_cancelled() {
                self.wind_down();
                return Err(Cancelled);
            }
            while self.step() {}
            if self.pending == 0 && self.waiting.is_empty() {
                return Ok(());
            }
            match self.receiver.recv_timeout(TICK) {
                Ok(message) => self.hear(message),
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {}
            }
            while let Ok(message) = self.receiver.try_recv() {
                self.hear(message);
            }
        }
    }

    /// Does what can be done at once and starts what can be started. True if that changed what is known.
    fn step(&mut self) -> bool {
        self.want_files();
        for (node, message) in self.state.advance_keys(&self.order.shared.cache) {
            let node = Some(self.name(node));
            self.emit(Event::Warning { node, message });
        }
        let demands = self.state.demands();
        let blocked = self.state.blocked(&demands);
        for &(node, culprit) in &blocked {
            self.skip(node, culprit);
        }
        if !blocked.is_empty() {
            return true;
        }
        let mut changed = false;
        for i in 0..self.state.region.len() {
            let node = self.state.region[i];
            changed |= match demands[node].action {
                Action::Load => self.load(node, &demands[node]),
                Action::Run if self.state.inputs_held(node) => self.start(node),
                Action::Run | Action::Wait | Action::Nothing => false,
            };
        }
        if !changed {
            self.tell_unneeded(&demands);
            self.state.release();
        }
        changed
    }

    /// Has all files read that are not yet; fails the nodes whose files are unreadable.
    fn want_files(&mut self) {
        for i in 0..self.state.region.len() {
            let node = self.state.region[i];
            if self.state.nodes[node].status != Status::Idle {
                continue;
            }
            let paths: Vec<String> = self.state.paths(node).map(|(_, path)| path.to_owned()).collect();
            for path in paths {
                if self.state.files.want_digest(&path) {
                    self.read_file(path);
                } else if let Some(FileState::Failed(message)) = self.state.files.get(&path) {
                    let message = message.clone();
                    self.fail(node, FailureKind::Input, message);
                }
            }
        }
    }

    fn read_file(&mut self, path: String) {
        let (shared, sender) = (Arc::clone(self.order.shared), self.sender.clone());
        self.pending += 1;
        self.order.shared.spawn(move || {
            let read = catch_unwind(AssertUnwindSafe(|| files::read(&*shared.files, &path)));
            let read = read.unwrap_or_else(|_| Err(format!("cannot read `{path}`: reading panicked")));
            let _ = sender.send(Message::File { path, read });
        });
    }

    /// Takes values from memory, or has them read from disk. True if some were in memory, or nowhere.
    fn load(&mut self, node: usize, demand: &Demand) -> bool {
        let mut changed = false;
        for (output, _) in demand.values.iter().enumerate().filter(|(_, want)| **want) {
            let source = Source { node, output };
            let Some(record) = self.state.output_record(source).cloned() else { continue };
            if self.state.nodes[node].held[output].is_some() {
                continue;
            }
            changed = true;
            let shared = self.order.shared;
            if let Some(value) = shared.cache.value_in_memory(&record) {
                self.state.nodes[node].held[output] = Some(value);
                self.tell_cached(node, CacheLevel::Memory);
                continue;
            }
            let ty = shared.registry.socket_type(&record.ty).copied();
            let Some(ty) = ty.filter(|_| shared.cache.locate(&record) == Some(CacheLevel::Disk)) else {
                self.state.nodes[node].lost = true;
                return true;
            };
            let (shared, sender) = (Arc::clone(shared), self.sender.clone());
            self.pending += 1;
            self.state.nodes[node].status = Status::Busy;
            self.order.shared.spawn(move || {
                let read = catch_unwind(AssertUnwindSafe(|| shared.cache.value_on_disk(&record, &ty)));
                let lookup = read.unwrap_or_else(|_| Lookup {
                    found: None,
                    warning: Some("a value in the disk cache cannot be decoded, it is made again".into()),
                });
                let _ = sender.send(Message::Loaded { node, output, lookup });
            });
            // One at a time: the rest follows when this one is there.
            return true;
        }
        changed
    }

    /// Starts a node whose inputs are there. True if it turned out that it need not run.
    fn start(&mut self, node: usize) -> bool {
        let Some(key) = self.state.nodes[node].key else { return false };
        if self.busy >= self.order.shared.threads() {
            return false;
        }
        let Some(files) = self.contents(node) else { return false };
        let Some(cancel) = self.order.shared.flights.take_off(key, &self.sender, self.order.cancel) else {
            self.state.nodes[node].status = Status::Busy;
            self.waiting.push((key, node));
            return false;
        };
        // Somebody may have landed between the look into the cache and the take-off.
        if !self.order.checked && self.found_after_all(node, &key) {
            self.order.shared.flights.land(key, None);
            return true;
        }
        let placed = self.place(node);
        let value = |source: &Source| self.state.nodes[source.node].held[source.output].clone();
        let inputs = self.state.linked(node);
        let task = Task {
            shared: Arc::clone(self.order.shared),
            graph: Arc::clone(self.order.graph),
            node,
            key,
            inputs: inputs.map(|links| links.iter().filter_map(value).collect()).collect(),
            files,
            cancel: cancel.clone(),
            cancelled_at: Arc::clone(&self.cancelled_at),
            check: self.order.checked.then(|| self.state.nodes[node].expected.clone()),
            device: placed.device.clone(),
            promised: self.state.is_apart(node) && self.state.apart.is_some(),
            sender: self.sender.clone(),
        };
        if !self.is_machinery(node) {
            let node_type = self.order.graph.nodes[node].ty.spec.id.to_owned();
            self.emit(Event::NodeStarted { node: self.name(node), node_type, device: placed.device() });
        }
        self.state.nodes[node].status = Status::Busy;
        self.busy += 1;
        self.pending += 1;
        self.flying.push((node, cancel));
        self.order.shared.spawn(move || task.run());
        false
    }

    /// Where a node runs. Tells once what there is to choose from.
    fn place(&mut self, node: usize) -> Placed {
        let graph_node = &self.order.graph.nodes[node];
        let devices = &self.order.shared.devices;
        if devices.asked(graph_node) && !std::mem::replace(&mut self.device_told, true) {
            self.emit(Event::DeviceChosen { message: devices.describe() });
        }
        let size = |source: &Source| self.state.output_record(*source).map(|record| record.bytes);
        devices.place(graph_node, &self.state.sizing(node, size))
    }

    fn found_after_all(&mut self, node: usize, key: &Key) -> bool {
        let cache = &self.order.shared.cache;
        let Some(record) = cache.record_in_memory(key) else { return false };
        let values: Option<Vec<Value>> = record.outputs.iter().map(|o| cache.value_in_memory(o)).collect();
        let state = &mut self.state.nodes[node];
        if record.outputs.len() != state.held.len() || (state.lost && values.is_none()) {
            return false;
        }
        state.record = Some(record);
        state.lost = false;
        true
    }

    /// The contents of a node's files; `None` while some are being read again.
    fn contents(&mut self, node: usize) -> Option<BTreeMap<&'static str, Arc<Vec<u8>>>> {
        let paths: Vec<_> = self.state.paths(node).map(|(name, path)| (name, path.to_owned())).collect();
        let mut files = BTreeMap::new();
        for (name, path) in &paths {
            if let Some(FileState::Known { contents: Some(contents), .. }) = self.state.files.get(path) {
                files.insert(*name, Arc::clone(contents));
            } else if self.state.files.want_contents(path) {
                self.read_file(path.clone());
            }
        }
        (files.len() == paths.len()).then_some(files)
    }

    fn hear(&mut self, message: Message) {
        match message {
            Message::File { path, read } => {
                self.pending -= 1;
                self.state.files.done(&path, read);
            }
            Message::Progress { node, fraction } => {
                self.emit(Event::NodeProgress { node: self.name(node), fraction });
            }
            Message::Loaded { node, output, lookup } => {
                self.pending -= 1;
                self.state.nodes[node].status = Status::Idle;
                if let Some(message) = lookup.warning {
                    self.emit(Event::Warning { node: Some(self.name(node)), message });
                }
                match lookup.found {
                    Some(value) => {
                        self.state.nodes[node].held[output] = Some(value);
                        self.tell_cached(node, CacheLevel::Disk);
                    }
                    None => self.state.nodes[node].lost = true,
                }
            }
            Message::Warned { node, message } => {
                self.emit(Event::Warning { node: Some(self.name(node)), message });
            }
            Message::Ran { node, seconds, device, result } => {
                self.busy -= 1;
                match result {
                    // The task goes on with writing, and is pending until that is done.
                    Ok((record, values)) => {
                        self.state.nodes[node].told = true;
                        if !self.is_machinery(node) {
                            self.result.computed += 1;
                            self.emit(Event::NodeFinished {
                                node: self.name(node),
                                seconds,
                                bytes: record.bytes(),
                                summary: record.summary(),
                                device,
                            });
                        }
                        if self.state.set_outputs(node, record, &values) {
                            let message = "the same inputs gave another result than before; \
                                           was the node changed without raising its version?";
                            self.emit(Event::Warning {
                                node: Some(self.name(node)),
                                message: message.into(),
                            });
                        }
                    }
                    Err(error) => {
                        self.pending -= 1;
                        self.node_error(node, error);
                    }
                }
            }
            Message::Stored { warning } => {
                self.pending -= 1;
                if let Some(message) = warning.filter(|_| !self.store_warned) {
                    self.store_warned = true;
                    self.emit(Event::Warning { node: None, message });
                }
            }
            Message::Approaching { key, fraction } => {
                let waiting: Vec<usize> = self.waiting.iter().filter(|w| w.0 == key).map(|w| w.1).collect();
                for node in waiting.into_iter().filter(|node| !self.is_machinery(*node)) {
                    self.emit(Event::NodeProgress { node: self.name(node), fraction });
                }
            }
            Message::Landed { key, outputs } => {
                let (landed, waiting) =
                    std::mem::take(&mut self.waiting).into_iter().partition(|w| w.0 == key);
                self.waiting = waiting;
                let landed: Vec<(Key, usize)> = landed;
                for (_, node) in landed {
                    self.state.nodes[node].status = Status::Idle;
                    if let Some((record, values)) = &outputs {
                        self.state.set_outputs(node, Arc::clone(record), values);
                        self.tell_cached(node, CacheLevel::Memory);
                    }
                }
            }
        }
    }

    fn node_error(&mut self, node: usize, error: NodeError) {
        match error {
            NodeError::Cancelled if self.order.cancel.is_cancelled() => {
                self.state.nodes[node].status = Status::Idle;
            }
            NodeError::Cancelled => {
                let message = "the node stopped as if cancelled, but nobody asked for that";
                self.fail(node, FailureKind::Failed, message.into());
            }
            NodeError::Input(message) => self.fail(node, FailureKind::Input, message),
            NodeError::Failed(message) => self.fail(node, FailureKind::Failed, message),
        }
    }

    fn fail(&mut self, node: usize, kind: FailureKind, message: String) {
        if self.state.nodes[node].failed_by.is_some() {
            return;
        }
        self.state.nodes[node].status = Status::Failed;
        self.state.nodes[node].failed_by = Some(node);
        let name = self.name(node);
        self.emit(Event::NodeFailed { node: name.clone(), kind, error: message.clone() });
        self.result.failures.push(Failure { node: name, kind, message, because_of: None });
    }

    fn skip(&mut self, node: usize, culprit: usize) {
        if self.state.nodes[node].failed_by.is_some() {
            return;
        }
        self.state.nodes[node].status = Status::Failed;
        self.state.nodes[node].failed_by = Some(culprit);
        let (name, because_of) = (self.name(node), self.name(culprit));
        let cause = self.result.failures.iter().find(|failure| failure.node == because_of);
        let kind = cause.map_or(FailureKind::Failed, |failure| failure.kind);
        let message = format!("it needs node `{because_of}`, which failed");
        self.emit(Event::NodeSkipped { node: name.clone(), because_of: because_of.clone() });
        self.result.failures.push(Failure { node: name, kind, message, because_of: Some(because_of) });
    }

    fn tell_cached(&mut self, node: usize, from: CacheLevel) {
        if std::mem::replace(&mut self.state.nodes[node].told, true) || self.is_machinery(node) {
            return;
        }
        let Some(record) = self.state.nodes[node].record.clone() else { return };
        self.result.cached += 1;
        let (bytes, summary) = (record.bytes(), record.summary());
        self.emit(Event::NodeCached { node: self.name(node), from, bytes, summary });
    }

    /// When nothing more is to be done: the nodes of which the digest was enough.
    fn tell_unneeded(&mut self, demands: &[Demand]) {
        if demands.iter().any(|demand| demand.action != Action::Nothing) || self.pending > 0 {
            return;
        }
        for i in 0..self.state.region.len() {
            let node = self.state.region[i];
            if self.state.nodes[node].record.is_some() && self.state.nodes[node].status == Status::Idle {
                self.tell_cached(node, CacheLevel::Digest);
            }
        }
    }

    /// The nodes that compute though nobody wants them any more.
    fn stopping(&self) -> impl Iterator<Item = usize> {
        let busy = |node: usize| self.state.nodes[node].status == Status::Busy;
        let waits = |node: usize| self.waiting.iter().any(|waiting| waiting.1 == node);
        self.flying
            .iter()
            .filter(move |(node, cancel)| busy(*node) && !waits(*node) && cancel.is_cancelled())
            .map(|(node, _)| *node)
    }

    /// Gives the nodes that compute a moment to notice the cancellation, then names those that did not.
    fn wind_down(&mut self) {
        let now = Instant::now();
        let since = *self.cancelled_at.get_or_init(|| now);
        let grace = self.order.shared.cancel_grace;
        // What another run wants goes on, and is not waited for.
        while self.stopping().next().is_some() && since.elapsed() < grace {
            if let Ok(message) = self.receiver.recv_timeout(TICK.min(grace)) {
                self.hear(message);
            }
        }
        for node in self.stopping().collect::<Vec<_>>() {
            let message = format!(
                "has not stopped {:.2} s after the cancellation, it is left behind",
                since.elapsed().as_secs_f64()
            );
            self.emit(Event::Warning { node: Some(self.name(node)), message });
        }
    }
}
