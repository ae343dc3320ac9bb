//! What a run knows of its nodes, and what follows from it: keys, and what to do next.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::files::{FileState, Files};
use crate::cache::{Cache, OutputRecord, Record};
use crate::estimate::Sizing;
use crate::flow::Flag;
use crate::graph::{Graph, GraphNode, Presence, Source};
use crate::keys::{Key, node_key};
use crate::spec::{ParamKind, ParamValue, Placement};
use crate::value::{Data, Value};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Status {
    /// Nothing is going on.
    Idle,
    /// A task of this run computes it or reads its values, or another run computes it.
    Busy,
    /// It has computed.
    Done,
    /// It failed, or another node that it needs did.
    Failed,
}

pub(crate) struct NodeState {
    pub status: Status,
    /// Known once the digests of all inputs are.
    pub key: Option<Key>,
    /// Known once the outputs' digests are.
    pub record: Option<Arc<Record>>,
    /// In a checked run: what the cache holds, to be compared.
    pub expected: Option<Arc<Record>>,
    /// The values at hand.
    pub held: Vec<Option<Value>>,
    /// A value is in no cache, although its digest is known.
    pub lost: bool,
    /// The node that failed, if this one did or could not run because of it.
    pub failed_by: Option<usize>,
    /// Whether the run has told how it came by the node's result.
    pub told: bool,
}

/// What is asked of a node.
#[derive(Clone, Debug, Default)]
pub(crate) struct Demand {
    pub digest: bool,
    /// For every output whether its value is asked for.
    pub values: Vec<bool>,
    pub action: Action,
}

/// What is to be done about a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Action {
    /// Nothing.
    #[default]
    Nothing,
    /// Its values are to be found in a cache.
    Load,
    /// It has to compute.
    Run,
    /// Its key is not known yet.
    Wait,
}

pub(crate) struct RunState<'a> {
    pub graph: &'a Graph,
    pub presence: Presence,
    /// The nodes that the targets depend on, sources first.
    pub region: Vec<usize>,
    pub targets: Vec<Source>,
    pub nodes: Vec<NodeState>,
    pub files: Files,
    /// Whether cached results are computed again and compared.
    pub checked: bool,
    /// The compute device, if nodes that round otherwise there run on it.
    pub apart: Option<String>,
}

impl<'a> RunState<'a> {
    /// The state before anything is known. Targets must be present.
    pub fn new(
        graph: &'a Graph,
        presence: Presence,
        targets: Vec<Source>,
        checked: bool,
        apart: Option<String>,
    ) -> Self {
        let mut needed = vec![false; graph.nodes.len()];
        for target in &targets {
            needed[target.node] = true;
        }
        for &node in graph.order.iter().rev() {
            if needed[node] {
                presence.sources[node].iter().flatten().for_each(|source| needed[source.node] = true);
            }
        }
        let region = graph.order.iter().copied().filter(|&node| needed[node]).collect();
        let nodes = graph.nodes.iter().zip(&needed).map(|(node, &needed)| {
            let bound = needed && node.is_bound();
            NodeState {
                status: Status::Idle,
                key: None,
                record: bound.then(|| Arc::new(bound_record(&node.bound))),
                expected: None,
                held: node.bound.clone(),
                lost: false,
                failed_by: None,
                told: bound,
            }
        });
        let nodes = nodes.collect();
        Self { graph, presence, region, targets, nodes, files: Files::default(), checked, apart }
    }

    /// The links into a node whose values it needs, as far as that is known.
    pub fn sources(&self, node: usize) -> impl Iterator<Item = Source> {
        self.linked(node).flatten().copied()
    }

    /// For every input of a node the links whose values it needs, as far as that is known. A gate first needs to know
    /// which value to take, then that value alone: what leads to the other is never computed.
    pub fn linked(&self, node: usize) -> impl Iterator<Item = &[Source]> {
        let sources = &self.presence.sources[node];
        let only = self.graph.nodes[node].is_gate().then(|| match self.stopped(node) {
            None => 0,
            Some(true) => 1,
            Some(false) => 2,
        });
        let needed = move |socket: usize| only.is_none_or(|only| only == socket);
        sources.iter().enumerate().map(move |(i, links)| if needed(i) { &links[..] } else { &[] })
    }

    /// Whether the zone of a gate had stopped, once that is known.
    fn stopped(&self, gate: usize) -> Option<bool> {
        let Some(stop) = self.presence.sources[gate].first().and_then(|links| links.first()) else {
            return Some(false);
        };
        let record = self.nodes[stop.node].record.as_ref()?;
        Some(record.outputs.get(stop.output)?.digest == Flag(true).digest())
    }

    /// The file parameters of a node and their paths.
    pub fn paths(&self, node: usize) -> impl Iterator<Item = (&'static str, &str)> {
        let node = &self.graph.nodes[node];
        let files = node.ty.spec.params.iter().filter(|_| !node.is_bound());
        files.filter(|p| matches!(p.kind, ParamKind::File { .. })).filter_map(|p| {
            match node.params.get(p.name) {
                Some(ParamValue::Text(path)) => Some((p.name, path.as_str())),
                _ => None,
            }
        })
    }

    /// Finds the keys and records that can be known by now. Returns warnings, with the node.
    pub fn advance_keys(&mut self, cache: &Cache) -> Vec<(usize, String)> {
        let mut warnings = Vec::new();
        for i in 0..self.region.len() {
            let node = self.region[i];
            let state = &self.nodes[node];
            if state.key.is_some() || state.status != Status::Idle || self.graph.nodes[node].is_bound() {
                continue;
            }
            let Some(key) = self.key(node) else { continue };
            let lookup = cache.record(&key);
            warnings.extend(lookup.warning.map(|warning| (node, warning)));
            // A record with another number of outputs belongs to a node whose version was not raised.
            let outputs = self.graph.nodes[node].ty.spec.outputs.len();
            let record = lookup.found.filter(|record| record.outputs.len() == outputs);
            let state = &mut self.nodes[node];
            state.key = Some(key);
            if self.checked {
                state.expected = record;
            } else {
                state.record = record;
            }
        }
        warnings
    }

    /// What a node guesses its own size and work from; `size` tells the bytes of an output, if they are known.
    pub fn sizing(&self, node: usize, size: impl Fn(&Source) -> Option<u64>) -> Sizing<'_> {
        let GraphNode { ty, params, links, .. } = &self.graph.nodes[node];
        let sum = |links: &Vec<Source>| {
            let known = links.iter().map(&size);
            known.reduce(|a, b| Some(a?.saturating_add(b?))).flatten()
        };
        let inputs = ty.spec.inputs.iter().zip(links).map(|(socket, links)| (socket.name, sum(links)));
        Sizing { params, inputs: inputs.collect() }
    }

    /// Whether a node's results on a compute device are kept apart.
    pub fn is_apart(&self, node: usize) -> bool {
        self.graph.nodes[node].ty.spec.placement == Placement::Apart
    }

    fn key(&self, node: usize) -> Option<Key> {
        let mut files = BTreeMap::new();
        for (name, path) in self.paths(node) {
            match self.files.get(path) {
                Some(FileState::Known { digest, .. }) => files.insert(name, *digest),
                _ => return None,
            };
        }
        let digest = |source: &Source| {
            let record = self.nodes[source.node].record.as_ref()?;
            Some(record.outputs.get(source.output)?.digest)
        };
        if self.graph.nodes[node].is_gate() && self.stopped(node).is_none() {
            return None;
        }
        let inputs = self.linked(node).map(|links| links.iter().map(digest).collect::<Option<Vec<_>>>());
        let inputs = inputs.collect::<Option<Vec<_>>>()?;
        let device = self.apart.as_deref().filter(|_| self.is_apart(node));
        Some(node_key(&self.graph.nodes[node], &files, &inputs, device))
    }

    /// The record of one output, if it is known.
    pub fn output_record(&self, source: Source) -> Option<&OutputRecord> {
        self.nodes[source.node].record.as_ref()?.outputs.get(source.output)
    }

    /// What is asked of each node, from the targets back.
    pub fn demands(&self) -> Vec<Demand> {
        let mut demands: Vec<Demand> = self
            .nodes
            .iter()
            .map(|state| Demand { values: vec![false; state.held.len()], ..Demand::default() })
            .collect();
        for target in &self.targets {
            demands[target.node].values[target.output] = true;
            demands[target.node].digest = true;
        }
        for &node in self.region.iter().rev() {
            let state = &self.nodes[node];
            if matches!(state.status, Status::Busy | Status::Failed) {
                continue;
            }
            let value_missing =
                demands[node].values.iter().zip(&state.held).any(|(&want, held)| want && held.is_none());
            if !value_missing && (state.record.is_some() || !demands[node].digest) {
                continue;
            }
            let action = match (state.key, &state.record) {
                (None, _) => Action::Wait,
                (Some(_), Some(_)) if !state.lost => Action::Load,
                (Some(_), _) => Action::Run,
            };
            demands[node].action = action;
            for source in self.sources(node) {
                match action {
                    Action::Wait => demands[source.node].digest = true,
                    Action::Run => demands[source.node].values[source.output] = true,
                    Action::Load | Action::Nothing => {}
                }
            }
        }
        demands
    }

    /// The nodes that cannot do what is asked of them, since a node that they need failed. Each comes with
    /// the node that failed first.
    pub fn blocked(&self, demands: &[Demand]) -> Vec<(usize, usize)> {
        let mut blocked: Vec<(usize, usize)> = Vec::new();
        for &node in &self.region {
            let action = demands[node].action;
            let culprit = self.sources(node).find_map(|source| {
                let state = &self.nodes[source.node];
                let needed = match action {
                    Action::Wait => state.record.is_none(),
                    Action::Run => state.held[source.output].is_none(),
                    Action::Load | Action::Nothing => false,
                };
                let just_now = blocked.iter().find(|b| b.0 == source.node).map(|b| b.1);
                needed.then(|| state.failed_by.or(just_now)).flatten()
            });
            blocked.extend(culprit.map(|culprit| (node, culprit)));
        }
        blocked
    }

    /// Whether every input of the node is at hand.
    pub fn inputs_held(&self, node: usize) -> bool {
        self.sources(node).all(|source| self.nodes[source.node].held[source.output].is_some())
    }

    /// Takes note of what a node computed. True if the cache had promised something else.
    pub fn set_outputs(&mut self, node: usize, record: Arc<Record>, values: &[Value]) -> bool {
        let state = &mut self.nodes[node];
        let promised = state.record.replace(Arc::clone(&record));
        state.held = values.iter().cloned().map(Some).collect();
        state.lost = false;
        state.status = Status::Done;
        let surprise = promised.is_some_and(|promised| !promised.same_content(&record));
        if surprise {
            self.forget_keys_after(node);
        }
        surprise
    }

    /// Forgets all keys that were made from a node's digests.
    fn forget_keys_after(&mut self, node: usize) {
        let mut stale = vec![false; self.nodes.len()];
        stale[node] = true;
        for i in 0..self.region.len() {
            let n = self.region[i];
            if n != node && self.sources(n).any(|source| stale[source.node]) {
                stale[n] = true;
                let state = &mut self.nodes[n];
                if state.status == Status::Idle {
                    (state.key, state.record, state.lost) = (None, None, false);
                    state.held.fill(None);
                }
            }
        }
    }

    /// Lets go of the values and files that no node of this run can need any more.
    pub fn release(&mut self) {
        let mut wanted: Vec<Vec<bool>> = self.nodes.iter().map(|s| vec![false; s.held.len()]).collect();
        for target in &self.targets {
            wanted[target.node][target.output] = true;
        }
        let mut may_run = vec![false; self.nodes.len()];
        for &node in self.region.iter().rev() {
            let state = &self.nodes[node];
            let missing = wanted[node].iter().zip(&state.held).any(|(&want, held)| want && held.is_none());
            may_run[node] = match state.status {
                Status::Done | Status::Failed => false,
                Status::Busy => true,
                Status::Idle => missing || state.record.is_none(),
            };
            if may_run[node] {
                for source in self.presence.sources[node].iter().flatten() {
                    wanted[source.node][source.output] = true;
                }
            }
        }
        for (state, wanted) in self.nodes.iter_mut().zip(wanted) {
            for (held, wanted) in state.held.iter_mut().zip(wanted) {
                if !wanted {
                    *held = None;
                }
            }
        }
        let kept: Vec<String> = self
            .region
            .iter()
            .filter(|&&node| may_run[node])
            .flat_map(|&node| self.paths(node).map(|(_, path)| path.to_owned()))
            .collect();
        self.files.release(|path| kept.iter().any(|k| k == path));
    }
}

/// What is known of values given from outside; nobody asks for the outputs in between.
fn bound_record(bound: &[Option<Value>]) -> Record {
    let outputs = bound.iter().map(|value| match value {
        Some(value) => OutputRecord::of(value),
        None => OutputRecord {
            ty: String::new(),
            digest: crate::value::Digest::of(&[]),
            bytes: 0,
            summary: String::new(),
        },
    });
    Record { outputs: outputs.collect() }
}
