//! What a run would do, found out without running anything.

use serde::Serialize;

use super::RunError;
use super::files;
use super::state::{Action, RunState, Status};
use crate::engine::Shared;
use crate::events::{CacheLevel, Device};
use crate::graph::{Graph, Problems, Source};
use crate::spec::Placement;

/// What would happen to a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Forecast {
    /// Its result is in a cache.
    Cached(CacheLevel),
    /// It would compute.
    WouldRun,
    /// That depends on what nodes before it compute.
    Unknown,
    /// It cannot run: an input is not given, or a file is unreadable.
    Fails,
}

/// What would happen to a node, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlanEntry {
    /// The node.
    pub node: String,
    /// The id of its type.
    pub node_type: String,
    /// What would happen.
    pub forecast: Forecast,
    /// Size of its outputs in memory, if an earlier run found out.
    pub bytes: Option<u64>,
    /// What the node guesses that size to be, if no earlier run found out.
    pub estimate: Option<u64>,
    /// The outputs in words, if an earlier run found out; else why it fails.
    pub summary: Option<String>,
    /// Where a node would run that has a choice, and why.
    pub placement: Option<(Device, String)>,
}

/// What a run would do, node by node, sources first.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Plan {
    /// The nodes that the outputs depend on.
    pub nodes: Vec<PlanEntry>,
}

impl Plan {
    /// The number of nodes with this forecast.
    pub fn count(&self, forecast: impl Fn(Forecast) -> bool) -> usize {
        self.nodes.iter().filter(|entry| forecast(entry.forecast)).count()
    }

    /// The known sizes of all outputs together, and the guessed ones of the others.
    pub fn bytes(&self) -> u64 {
        self.nodes.iter().filter_map(|entry| entry.bytes.or(entry.estimate)).fold(0, u64::saturating_add)
    }
}

pub(crate) fn explain(shared: &Shared, graph: &Graph, outputs: &[&str]) -> Result<Plan, RunError> {
    let mut targets = Vec::new();
    let mut problems = Vec::new();
    let mut plan = Plan::default();
    let presence = graph.presence();
    for name in outputs {
        match graph.find_output(name) {
            Ok(source) => match graph.lacks(source, &presence.absent) {
                None => targets.push(source),
                Some(lack) => {
                    let node = &graph.nodes[lack.node];
                    plan.nodes.push(PlanEntry {
                        node: node.name.clone(),
                        node_type: node.ty.spec.id.to_owned(),
                        forecast: Forecast::Fails,
                        bytes: None,
                        estimate: None,
                        summary: Some(lack.message),
                        placement: None,
                    });
                }
            },
            Err(found) => problems.extend(found.0),
        }
    }
    if !problems.is_empty() {
        return Err(Problems(problems).into());
    }
    let mut state = RunState::new(graph, presence, targets, false, apart(shared, graph));
    let mut failures = read_files(shared, &mut state);
    let levels = settle(shared, &mut state);
    let demands = state.demands();
    for (node, culprit) in state.blocked(&demands) {
        state.nodes[node].status = Status::Failed;
        failures.push((node, format!("it needs node `{}`, which fails", graph.nodes[culprit].name)));
    }
    let estimates = estimates(&state);
    for &node in state.region.iter().filter(|&&node| !graph.nodes[node].is_machinery()) {
        let known = &state.nodes[node];
        let graph_node = &graph.nodes[node];
        let forecast = match demands[node].action {
            _ if known.status == Status::Failed => Forecast::Fails,
            Action::Run => Forecast::WouldRun,
            Action::Wait => Forecast::Unknown,
            Action::Load => Forecast::Cached(levels[node].unwrap_or(CacheLevel::Digest)),
            Action::Nothing if known.record.is_none() => Forecast::Unknown,
            Action::Nothing if graph_node.is_bound() => Forecast::Cached(CacheLevel::Memory),
            Action::Nothing => Forecast::Cached(CacheLevel::Digest),
        };
        let failure = failures.iter().find(|f| f.0 == node).map(|f| f.1.clone());
        plan.nodes.push(PlanEntry {
            node: graph_node.name.clone(),
            node_type: graph_node.ty.spec.id.to_owned(),
            forecast,
            bytes: known.record.as_ref().map(|record| record.bytes()),
            estimate: if known.record.is_some() { None } else { estimates[node] },
            summary: failure.or_else(|| known.record.as_ref().map(|record| record.summary())),
            placement: placement(shared, &state, &estimates, node)
                .filter(|_| matches!(forecast, Forecast::WouldRun | Forecast::Unknown)),
        });
    }
    Ok(plan)
}

/// For every node the size of its outputs, known or guessed from the sizes before it.
fn estimates(state: &RunState<'_>) -> Vec<Option<u64>> {
    let mut sizes: Vec<Option<u64>> = vec![None; state.nodes.len()];
    // Sources come first.
    for &node in &state.region {
        sizes[node] = match &state.nodes[node].record {
            Some(record) => Some(record.bytes()),
            None => {
                let sizing = state.sizing(node, |source| sizes[source.node]);
                state.graph.nodes[node].ty.node.estimate(&sizing)
            }
        };
    }
    sizes
}

/// The device that makes a difference to keys, opened only if there is a node that it makes one to.
pub(crate) fn apart(shared: &Shared, graph: &Graph) -> Option<String> {
    let any = graph.nodes.iter().any(|node| node.ty.spec.placement == Placement::Apart);
    any.then(|| shared.devices.apart()).flatten()
}

/// Where a node would run, if it has a choice, and why.
fn placement(
    shared: &Shared,
    state: &RunState<'_>,
    sizes: &[Option<u64>],
    node: usize,
) -> Option<(Device, String)> {
    let graph_node = &state.graph.nodes[node];
    if !shared.devices.asked(graph_node) {
        return None;
    }
    let placed = shared.devices.place(graph_node, &state.sizing(node, |source| sizes[source.node]));
    Some((placed.device(), placed.why))
}

/// Reads and hashes the files; nodes whose files are unreadable fail.
fn read_files(shared: &Shared, state: &mut RunState<'_>) -> Vec<(usize, String)> {
    let mut failures = Vec::new();
    for i in 0..state.region.len() {
        let node = state.region[i];
        let paths: Vec<String> = state.paths(node).map(|(_, path)| path.to_owned()).collect();
        for path in paths {
            if state.files.want_digest(&path) {
                state.files.done(&path, files::read(&*shared.files, &path));
            }
            if let Some(files::FileState::Failed(message)) = state.files.get(&path) {
                failures.push((node, message.clone()));
                state.nodes[node].status = Status::Failed;
                state.nodes[node].failed_by = Some(node);
            }
        }
        state.files.release(|_| false);
    }
    failures
}

/// Finds out where values are, until nothing changes: a value in no cache is computed, and asks for more.
fn settle(shared: &Shared, state: &mut RunState<'_>) -> Vec<Option<CacheLevel>> {
    loop {
        state.advance_keys(&shared.cache);
        let demands = state.demands();
        let mut levels = vec![None; state.nodes.len()];
        let mut lost = Vec::new();
        for &node in state.region.iter().filter(|&&node| demands[node].action == Action::Load) {
            let wanted = demands[node].values.iter().enumerate().filter(|(_, want)| **want);
            let found: Option<Vec<CacheLevel>> = wanted
                .map(|(output, _)| shared.cache.locate(state.output_record(Source { node, output })?))
                .collect();
            match found {
                Some(found) if found.contains(&CacheLevel::Disk) => levels[node] = Some(CacheLevel::Disk),
                Some(_) => levels[node] = Some(CacheLevel::Memory),
                None => lost.push(node),
            }
        }
        if lost.is_empty() {
            return levels;
        }
        lost.into_iter().for_each(|node| state.nodes[node].lost = true);
    }
}
