//! What a run reports while it goes on: one stream for progress bars, badges, logs and tests.

use serde::{Deserialize, Serialize};

/// Where a node runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Device {
    /// CPU threads.
    Cpu,
    /// The compute device.
    Gpu,
}

/// How much of a node's result was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CacheLevel {
    /// The value was in memory.
    Memory,
    /// The value was read from disk.
    Disk,
    /// The value's digest was known, and nobody needed the value itself.
    Digest,
}

/// Whose fault a failure is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FailureKind {
    /// A file or another input is missing, unreadable or invalid.
    Input,
    /// The computation could not be done.
    Failed,
}

/// Something that happened in a run. All events of a run come from one thread, in order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Event {
    /// The run began.
    RunStarted {
        /// The outputs asked for.
        outputs: Vec<String>,
        /// The number of threads.
        threads: usize,
    },
    /// What the nodes run on that have a choice; told once in a run, before the first of them.
    DeviceChosen {
        /// In words.
        message: String,
    },
    /// A node began to compute.
    NodeStarted {
        /// The node.
        node: String,
        /// The id of its type.
        node_type: String,
        /// Where it runs.
        device: Device,
    },
    /// A node got on.
    NodeProgress {
        /// The node.
        node: String,
        /// The fraction done, 0 to 1.
        fraction: f32,
    },
    /// A node computed its outputs.
    NodeFinished {
        /// The node.
        node: String,
        /// How long it took.
        seconds: f64,
        /// Size of all outputs in memory.
        bytes: u64,
        /// The outputs in words.
        summary: String,
        /// Where it ran.
        device: Device,
    },
    /// A node did not need to compute.
    NodeCached {
        /// The node.
        node: String,
        /// Where its result was found.
        from: CacheLevel,
        /// Size of all outputs in memory.
        bytes: u64,
        /// The outputs in words.
        summary: String,
    },
    /// A node failed.
    NodeFailed {
        /// The node.
        node: String,
        /// Whose fault it is.
        kind: FailureKind,
        /// What was found and what was expected.
        error: String,
    },
    /// A node could not run because of another one.
    NodeSkipped {
        /// The node.
        node: String,
        /// The node that failed.
        because_of: String,
    },
    /// Something that does not stop the run.
    Warning {
        /// The node that it is about, if any.
        node: Option<String>,
        /// What happened.
        message: String,
    },
    /// The run ended.
    RunFinished {
        /// How long it took.
        seconds: f64,
        /// How many nodes computed.
        computed: usize,
        /// How many nodes were found in a cache.
        cached: usize,
        /// How many nodes failed or were skipped.
        failed: usize,
        /// Whether the run was cancelled.
        cancelled: bool,
    },
}

impl Event {
    /// The node that the event is about.
    pub fn node(&self) -> Option<&str> {
        match self {
            Self::NodeStarted { node, .. }
            | Self::NodeProgress { node, .. }
            | Self::NodeFinished { node, .. }
            | Self::NodeCached { node, .. }
            | Self::NodeFailed { node, .. }
            | Self::NodeSkipped { node, .. } => Some(node),
            Self::Warning { node, .. } => node.as_deref(),
            Self::RunStarted { .. } | Self::DeviceChosen { .. } | Self::RunFinished { .. } => None,
        }
    }
}
