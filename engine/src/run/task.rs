//! What the threads of the pool do for a run, and what they tell it.

use std::any::Any;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use super::files::FileRead;
use crate::cache::{Lookup, OutputRecord, Record};
use crate::device::ComputeDevice;
use crate::engine::Shared;
use crate::events::Device;
use crate::graph::Graph;
use crate::keys::Key;
use crate::node::{CancelToken, Context, NodeError};
use crate::spec::Placement;
use crate::value::Value;

/// A node that goes on for longer than this after a cancellation is named.
const PROMPT: Duration = Duration::from_secs(1);

/// A node's outputs: what is known of them, and the values in the order of the declaration.
pub(crate) type Outputs = (Arc<Record>, Vec<Value>);

/// What the scheduler of a run is told.
pub(crate) enum Message {
    /// A file was read.
    File { path: String, read: FileRead },
    /// A node got on.
    Progress { node: usize, fraction: f32 },
    /// A value was read from disk, or could not be.
    Loaded { node: usize, output: usize, lookup: Lookup<Value> },
    /// A node computed, or failed.
    Ran { node: usize, seconds: f64, device: Device, result: Result<Outputs, NodeError> },
    /// A node tells of something that does not stop it.
    Warned { node: usize, message: String },
    /// A node's outputs were written to disk, or could not be.
    Stored { warning: Option<String> },
    /// A key that somebody else computed is there, or has to be computed after all.
    Landed { key: Key, outputs: Option<Outputs> },
    /// How far a key is that somebody else computes.
    Approaching { key: Key, fraction: f32 },
}

/// One computation of one node.
pub(crate) struct Task {
    pub shared: Arc<Shared>,
    pub graph: Arc<Graph>,
    pub node: usize,
    pub key: Key,
    pub inputs: Vec<Vec<Value>>,
    pub files: BTreeMap<&'static str, Arc<Vec<u8>>>,
    /// Stops it once no run wants it any more.
    pub cancel: CancelToken,
    /// When the run noticed that it was cancelled.
    pub cancelled_at: Arc<OnceLock<Instant>>,
    /// In a checked run: what the cache holds, if anything.
    pub check: Option<Option<Arc<Record>>>,
    /// The compute device, if the node is to run there.
    pub device: Option<Arc<dyn ComputeDevice>>,
    /// Whether the key says that the node runs there.
    pub promised: bool,
    pub sender: Sender<Message>,
}

impl Task {
    /// Computes, keeps the outputs in the caches, and tells the run and all who wait.
    pub fn run(mut self) {
        let start = Instant::now();
        let used = AtomicBool::new(false);
        let result = self.compute(&used);
        let device = if used.into_inner() { Device::Gpu } else { Device::Cpu };
        let seconds = start.elapsed().as_secs_f64();
        // What is let go of before the run hears can be let go of by the memory cache as well.
        self.inputs.clear();
        self.files.clear();
        // A device that was lost leaves a result of the CPU under a key that is not its own: good for this run alone.
        let lost = self.device.as_ref().is_none_or(|device| device.lost().is_some());
        let broken = self.promised && (lost || device == Device::Cpu);
        if let (Ok((record, values)), false) = (&result, broken) {
            self.shared.cache.keep(&self.key, record, values);
        }
        self.shared.flights.land(self.key, result.as_ref().ok());
        if self.cancel.is_cancelled() && self.cancelled_at.get().is_some_and(|at| at.elapsed() > PROMPT) {
            self.shared.note_slow_stop(&self.graph.nodes[self.node].name);
        }
        let outputs = result.as_ref().ok().cloned();
        // If the run has returned already, there is nobody to tell.
        let _ = self.sender.send(Message::Ran { node: self.node, seconds, device, result });
        if let Some((record, values)) = outputs {
            let warning = if broken { None } else { self.store(&record, &values) };
            drop(values);
            let _ = self.sender.send(Message::Stored { warning });
        }
    }

    /// Runs the node, in a checked run twice if the cache holds nothing to compare with.
    fn compute(&self, used: &AtomicBool) -> Result<Outputs, NodeError> {
        let outputs = self.compute_once(used)?;
        let Some(expected) = &self.check else { return Ok(outputs) };
        let expected = match expected {
            Some(record) => Arc::clone(record),
            None => self.compute_once(used)?.0,
        };
        let spec = &self.graph.nodes[self.node].ty.spec;
        let pairs = spec.outputs.iter().zip(expected.outputs.iter().zip(&outputs.0.outputs));
        for (socket, (before, now)) in pairs {
            if before.digest != now.digest {
                return Err(NodeError::Failed(format!(
                    "the node is no pure function of its declared inputs, parameters and files: its output \
                     `{}` was {} ({}) and is now {} ({})",
                    socket.name, before.digest, before.summary, now.digest, now.summary
                )));
            }
        }
        Ok(outputs)
    }

    fn compute_once(&self, used: &AtomicBool) -> Result<Outputs, NodeError> {
        if self.cancel.is_cancelled() {
            return Err(NodeError::Cancelled);
        }
        match catch_unwind(AssertUnwindSafe(|| self.compute_unguarded(used))) {
            Ok(result) => result,
            Err(panic) => Err(NodeError::Failed(format!("the node panicked: {}", panic_text(&*panic)))),
        }
    }

    fn compute_unguarded(&self, used: &AtomicBool) -> Result<Outputs, NodeError> {
        let node = &self.graph.nodes[self.node];
        let spec = &node.ty.spec;
        let progress = Progress { last: Mutex::new((0.0, None)), task: self };
        let report = |fraction: f32| progress.report(fraction);
        let warn = |message: String| {
            let _ = self.sender.send(Message::Warned { node: self.node, message });
        };
        let mut context = Context {
            inputs: spec.inputs.iter().map(|socket| socket.name).zip(self.inputs.iter().cloned()).collect(),
            params: node.params.clone(),
            files: self.files.clone(),
            outputs: BTreeMap::new(),
            cancel: &self.cancel,
            progress: &report,
            device: self.device.clone(),
            apart: spec.placement == Placement::Apart,
            device_used: AtomicBool::new(false),
            warn: &warn,
        };
        let ran = node.ty.node.run(&mut context);
        used.fetch_or(context.device_used.load(Ordering::Relaxed), Ordering::Relaxed);
        ran?;
        let mut set = context.outputs;
        let mut values = Vec::with_capacity(spec.outputs.len());
        for socket in &spec.outputs {
            let value = set.remove(socket.name).ok_or_else(|| {
                NodeError::Failed(format!("the node did not set its output `{}`", socket.name))
            })?;
            if value.type_name() != socket.ty {
                return Err(NodeError::Failed(format!(
                    "the node set its output `{}` to a value of type {}, it declares {}",
                    socket.name,
                    value.type_name(),
                    socket.ty
                )));
            }
            values.push(value);
        }
        if let Some(name) = set.keys().next() {
            return Err(NodeError::Failed(format!("the node set an undeclared output `{name}`")));
        }
        let record = Record { outputs: values.iter().map(OutputRecord::of).collect() };
        Ok((Arc::new(record), values))
    }

    fn store(&self, record: &Record, values: &[Value]) -> Option<String> {
        let worth_it = self.graph.nodes[self.node].ty.spec.disk_cache;
        let store = || self.shared.cache.store(&self.key, record, values, worth_it);
        let error = match catch_unwind(AssertUnwindSafe(store)) {
            Ok(Ok(())) => return None,
            Ok(Err(error)) => error.to_string(),
            Err(panic) => format!("encoding panicked: {}", panic_text(&*panic)),
        };
        let root = self.shared.cache.disk.as_ref().map(|disk| disk.root().display().to_string());
        Some(format!(
            "results are not kept, the disk cache {} cannot be written: {error}",
            root.unwrap_or_default()
        ))
    }
}

/// Passes progress on, but not every tiny step.
struct Progress<'a> {
    last: Mutex<(f32, Option<Instant>)>,
    task: &'a Task,
}

impl Progress<'_> {
    fn report(&self, fraction: f32) {
        let fraction = if fraction.is_nan() { 0.0 } else { fraction.clamp(0.0, 1.0) };
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let recent = last.1.is_some_and(|at| at.elapsed() < Duration::from_millis(20));
        if recent || fraction <= last.0 {
            return;
        }
        *last = (fraction, Some(Instant::now()));
        let _ = self.task.sender.send(Message::Progress { node: self.task.node, fraction });
        self.task.shared.flights.approach(self.task.key, fraction);
    }
}

/// What a panic said.
pub(crate) fn panic_text(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}
