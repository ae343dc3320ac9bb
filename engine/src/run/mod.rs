//! Running a graph: first keys, then only what is needed and missing, each node once, in parallel.

pub(crate) mod explain;
pub(crate) mod files;
pub(crate) mod flight;
pub(crate) mod scheduler;
pub(crate) mod state;
pub(crate) mod task;

use std::collections::BTreeMap;

use serde::Serialize;

use crate::events::FailureKind;
use crate::graph::Problems;
use crate::value::Value;

/// What a run brought.
#[derive(Debug, Default)]
pub struct RunResult {
    /// The outputs that could be had, by the names they were asked for.
    pub outputs: BTreeMap<String, Value>,
    /// The nodes that failed, and those that could not run because of them.
    pub failures: Vec<Failure>,
    /// How many nodes computed.
    pub computed: usize,
    /// How many nodes were found in a cache.
    pub cached: usize,
}

/// A node without a result.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Failure {
    /// The node.
    pub node: String,
    /// Whose fault it is; that of the node it failed because of, if there is one.
    pub kind: FailureKind,
    /// What was found and what was expected.
    pub message: String,
    /// The node that failed first, if this one could not run because of it.
    pub because_of: Option<String>,
}

/// Why a run brought nothing.
#[derive(Clone, Debug, thiserror::Error)]
pub enum RunError {
    /// The run was cancelled.
    #[error("cancelled")]
    Cancelled,
    /// Outputs were asked for that the graph does not have.
    #[error(transparent)]
    Graph(#[from] Problems),
}
