//! Which graphs there are once every group and every iteration stands for itself.

use std::cell::Cell;
use std::collections::BTreeMap;

use super::{MAX_NODES, Override, without_indices};
use crate::document::{Document, Group, Interface, NodeEntry, NodeMode, is_name, split_path};
use crate::flow;
use crate::graph::{Problem, ProblemKind};
use crate::registry::Registry;
use crate::spec::{ParamKind, ParamSpec, ParamValue};

/// How deep groups may lie in each other.
pub(super) const MAX_DEPTH: usize = 32;
/// How many groups are looked into for what a parameter takes.
const MAX_LOOKS: usize = 10_000;

/// One graph of the tree: the document's own, or one iteration of a group.
pub(super) struct Instance<'a> {
    pub interface: &'a Interface,
    pub entries: &'a BTreeMap<String, NodeEntry>,
    pub links: &'a [String],
    /// Groups that can be seen from here, innermost first.
    scopes: Vec<&'a BTreeMap<String, Group>>,
    /// What its nodes' names begin with.
    pub prefix: String,
    /// The instance whose node stands for this one, and that node.
    pub parent: Option<(usize, &'a str)>,
    /// Its place in the parent's zone, in the order of computation.
    pub iteration: usize,
    /// The nodes that stand for graphs.
    pub zones: BTreeMap<&'a str, Zone>,
    /// Parameters that its nodes are given from outside, by node and parameter.
    set: BTreeMap<(String, String), ParamValue>,
}

/// A node that stands for graphs, in one instance.
#[derive(Default)]
pub(super) struct Zone {
    /// The instances, in the order of computation.
    pub instances: Vec<usize>,
    /// Whether the body has an output that stops the zone.
    pub stops: bool,
    /// Whether not to stop is a failure.
    pub must_stop: bool,
}

pub(super) struct Tree<'a> {
    pub document: &'a Document,
    pub registry: &'a Registry,
    overrides: &'a [Override],
    pub instances: Vec<Instance<'a>>,
    pub problems: Vec<Problem>,
    nodes: usize,
    /// How many groups were looked into for one parameter.
    looks: Cell<usize>,
}

impl<'a> Tree<'a> {
    pub fn new(document: &'a Document, registry: &'a Registry, overrides: &'a [Override]) -> Self {
        let root = Instance {
            interface: &document.interface,
            entries: &document.nodes,
            links: &document.links,
            scopes: vec![&document.groups],
            prefix: String::new(),
            parent: None,
            iteration: 0,
            zones: BTreeMap::new(),
            set: BTreeMap::new(),
        };
        Self {
            document,
            registry,
            overrides,
            instances: vec![root],
            problems: Vec::new(),
            nodes: 0,
            looks: Cell::new(0),
        }
    }

    /// Makes all instances, level by level.
    pub fn grow(&mut self) {
        self.check_names();
        for param in self.document.interface.params.values() {
            let Some(default) = &param.default else { continue };
            if param.targets.iter().all(|target| self.zone_of(0, target).is_none()) {
                continue;
            }
            for (node, name) in param.targets.iter().filter_map(|target| split_path(target)) {
                self.instances[0].set.insert((node.to_owned(), name.to_owned()), default.clone());
            }
        }
        let mut next = 0;
        while next < self.instances.len() {
            self.nodes += self.instances[next].entries.len();
            if self.nodes > MAX_NODES || self.instances.len() > MAX_NODES {
                let found =
                    format!("more than {MAX_NODES} nodes, once groups and iterations are written out");
                let expected = format!("at most {MAX_NODES}; fewer iterations, or zones less deep");
                let problem = Problem::new(ProblemKind::TooLarge, None, "graph", found, expected);
                self.problems = vec![problem];
                return;
            }
            let entries = self.instances[next].entries;
            for (name, entry) in entries.iter().filter(|(_, entry)| flow::stands_for_graph(&entry.ty)) {
                self.zone(next, name, entry);
            }
            next += 1;
        }
    }

    fn check_names(&mut self) {
        fn walk(groups: &BTreeMap<String, Group>, problems: &mut Vec<Problem>) {
            for (name, group) in groups {
                let names = group.nodes.keys().map(|n| ("node", n));
                let names = names.chain(group.interface.inputs.keys().map(|n| ("input", n)));
                let names = names.chain(group.interface.outputs.keys().map(|n| ("output", n)));
                let names = names.chain(group.interface.params.keys().map(|n| ("parameter", n)));
                for (what, bad) in names.chain([("group", name)]).filter(|(_, n)| !is_name(n)) {
                    let item = format!("group `{name}`, name of a {what}");
                    let (found, expected) = (format!("`{bad}`"), "letters, digits, `_` and `-`");
                    problems.push(Problem::new(ProblemKind::BadName, None, item, found, expected));
                }
                walk(&group.groups, problems);
            }
        }
        walk(&self.document.groups, &mut self.problems);
    }

    /// The name that a node of an instance has in the flat graph.
    pub fn path(&self, instance: usize, node: &str) -> String {
        format!("{}{node}", self.instances[instance].prefix)
    }

    /// What a node of an instance is given: by the document, from outside, and by overrides.
    pub fn params(&self, instance: usize, node: &str) -> BTreeMap<String, ParamValue> {
        let here = &self.instances[instance];
        let mut params = here.entries.get(node).map(|entry| entry.params.clone()).unwrap_or_default();
        let outside = here.set.iter().filter(|((n, _), _)| n == node);
        params.extend(outside.map(|((_, param), value)| (param.clone(), value.clone())));
        let path = self.path(instance, node);
        let general = without_indices(&path);
        let later = self.overrides.iter().filter(|(n, ..)| *n == path || *n == general);
        params.extend(later.map(|(_, param, value)| (param.clone(), value.clone())));
        params
    }

    /// Whether something was set after the document was read.
    pub fn is_overridden(&self, target: &str) -> bool {
        split_path(target)
            .is_some_and(|(node, param)| self.overrides.iter().any(|o| o.0 == node && o.1 == param))
    }

    pub fn group(
        &self,
        instance: usize,
        name: &str,
    ) -> Option<(&'a Group, Vec<&'a BTreeMap<String, Group>>)> {
        let scopes = &self.instances[instance].scopes;
        let (depth, group) = scopes.iter().enumerate().find_map(|(i, scope)| Some((i, scope.get(name)?)))?;
        Some((group, [&group.groups].into_iter().chain(scopes[depth..].iter().copied()).collect()))
    }

    /// Makes the instances of a node that stands for a graph.
    fn zone(&mut self, instance: usize, name: &'a str, entry: &'a NodeEntry) {
        let path = self.path(instance, name);
        if entry.mode == NodeMode::Mute {
            self.instances[instance].zones.insert(name, Zone::default());
            return;
        }
        let params = self.params(instance, name);
        let body = match params.get("body") {
            Some(ParamValue::Text(body)) => body.clone(),
            _ => String::new(),
        };
        let Some((group, scopes)) = self.group(instance, &body) else {
            let known: Vec<&str> =
                self.instances[instance].scopes.iter().flat_map(|s| s.keys()).map(String::as_str).collect();
            let kind = ProblemKind::UnknownNode;
            self.problems.push(Problem::unknown(
                kind,
                Some(&path),
                "parameter `body`",
                &body,
                "groups",
                known,
            ));
            return;
        };
        if !group.file.is_empty() {
            let (found, expected) =
                (format!("the file `{}`, not read", group.file), "a group that has been included");
            let item = format!("group `{body}`");
            self.problems.push(Problem::new(ProblemKind::BadValue, Some(&path), item, found, expected));
            return;
        }
        if scopes.len() > MAX_DEPTH || path.matches('/').count() > MAX_DEPTH {
            let (found, expected) =
                (format!("group `{body}` within itself"), "groups that do not hold themselves");
            self.problems.push(Problem::new(
                ProblemKind::Cycle,
                Some(&path),
                "parameter `body`",
                found,
                expected,
            ));
            // One of these is enough.
            self.instances.truncate(1);
            self.nodes = MAX_NODES;
            return;
        }
        let own = self.own_params(&path, entry, &params);
        let count = match own.get("iterations").or(own.get("levels")) {
            _ if entry.mode.is_off() => 0,
            Some(ParamValue::Int(count)) => usize::try_from(*count).unwrap_or(0),
            _ => 1,
        };
        let given: Vec<(&String, &ParamValue)> =
            params.iter().filter(|(n, _)| !own.contains_key(n.as_str())).collect();
        self.check_given(&path, entry, group, &given);
        let stop = group.interface.outputs.get("stop");
        // Muted, it never says so.
        let stop = stop.filter(|out| group.nodes.get(&out.node).is_none_or(|n| n.mode != NodeMode::Mute));
        let stops = entry.ty == flow::REPEAT && stop.is_some();
        let mut instances = Vec::new();
        for iteration in 0..count {
            let level = count - 1 - iteration;
            let (prefix, counter) = match entry.ty.as_str() {
                flow::REPEAT => (format!("{path}[{iteration}]/"), Some(("iteration", iteration))),
                flow::LEVELS => (format!("{path}[{level}]/"), Some(("level", level))),
                _ => (format!("{path}/"), None),
            };
            let mut set = BTreeMap::new();
            for (param, spec) in &group.interface.params {
                let per_level = |value: &ParamValue| match value {
                    ParamValue::List(items) if entry.ty == flow::LEVELS && self.is_scalar(group, param) => {
                        items.get(iteration).or(items.last()).cloned()
                    }
                    other => Some(other.clone()),
                };
                let from_counter = counter.filter(|c| c.0 == param);
                let value = match from_counter {
                    Some((_, number)) => Some(ParamValue::Int(number as i64)),
                    None => given
                        .iter()
                        .find(|g| g.0 == param)
                        .and_then(|g| per_level(g.1))
                        .or(spec.default.clone()),
                };
                let Some(value) = value else { continue };
                for (node, name) in spec.targets.iter().filter_map(|target| split_path(target)) {
                    set.insert((node.to_owned(), name.to_owned()), value.clone());
                }
            }
            instances.push(self.instances.len());
            self.instances.push(Instance {
                interface: &group.interface,
                entries: &group.nodes,
                links: &group.links,
                scopes: scopes.clone(),
                prefix,
                parent: Some((instance, name)),
                iteration,
                zones: BTreeMap::new(),
                set,
            });
            if self.instances.len() > MAX_NODES {
                break;
            }
        }
        let must_stop = matches!(own.get("must_stop"), Some(ParamValue::Bool(true)));
        if must_stop && !stops {
            let (found, expected) = ("true", "a group with an output `stop` that can stop the zone");
            self.problems.push(Problem::new(
                ProblemKind::BadValue,
                Some(&path),
                "parameter `must_stop`",
                found,
                expected,
            ));
        }
        self.instances[instance].zones.insert(name, Zone { instances, stops, must_stop });
    }

    /// The parameters that the node itself takes, checked, defaults included.
    fn own_params(
        &mut self,
        path: &str,
        entry: &NodeEntry,
        params: &BTreeMap<String, ParamValue>,
    ) -> BTreeMap<&'static str, ParamValue> {
        let mut own = BTreeMap::new();
        let Some(ty) = self.registry.node(&entry.ty) else { return own };
        for spec in &ty.spec.params {
            let value = params.get(spec.name).unwrap_or(&spec.default);
            match spec.kind.check(value) {
                Ok(value) => {
                    own.insert(spec.name, value);
                }
                Err(mismatch) => {
                    own.insert(spec.name, spec.default.clone());
                    let item = format!("parameter `{}`", spec.name);
                    self.problems.push(Problem::mismatch(Some(path), item, mismatch));
                }
            }
        }
        own
    }

    /// Every parameter given to a zone must be one of its group.
    fn check_given(
        &mut self,
        path: &str,
        entry: &NodeEntry,
        group: &Group,
        given: &[(&String, &ParamValue)],
    ) {
        let counter = match entry.ty.as_str() {
            flow::REPEAT => "iteration",
            flow::LEVELS => "level",
            _ => "",
        };
        let known: Vec<&str> =
            group.interface.params.keys().map(String::as_str).filter(|n| *n != counter).collect();
        for (name, _) in given.iter().filter(|(name, _)| !known.contains(&name.as_str())) {
            let own = self
                .registry
                .node(&entry.ty)
                .into_iter()
                .flat_map(|ty| ty.spec.params.iter().map(|p| p.name));
            let all = known.iter().copied().chain(own);
            let kind = ProblemKind::UnknownParam;
            self.problems.push(Problem::unknown(kind, Some(path), "parameter", name, "parameters", all));
        }
        for name in entry.other_params.keys() {
            let (item, expected) =
                (format!("parameter `{name}`"), "true, false, a number, a quoted text or a list");
            self.problems.push(Problem::new(
                ProblemKind::BadValue,
                Some(path),
                item,
                "something else",
                expected,
            ));
        }
        self.problems.extend(Problem::fields(path, entry));
    }

    /// Whether a group's parameter takes a single value, so that a list means one for each level.
    fn is_scalar(&self, group: &'a Group, param: &str) -> bool {
        let spec = self.spec_within(&group.interface, &group.nodes, vec![&group.groups], param, 0);
        !matches!(spec.map(|spec| spec.kind), Some(ParamKind::Ints { .. } | ParamKind::Floats { .. }))
    }

    /// The declaration behind an interface's parameter.
    fn spec_within(
        &self,
        interface: &'a Interface,
        entries: &'a BTreeMap<String, NodeEntry>,
        scopes: Vec<&'a BTreeMap<String, Group>>,
        param: &str,
        depth: usize,
    ) -> Option<ParamSpec> {
        self.looks.set(if depth == 0 { 0 } else { self.looks.get() + 1 });
        if depth > MAX_DEPTH || self.looks.get() > MAX_LOOKS {
            return None;
        }
        let targets = &interface.params.get(param)?.targets;
        targets.iter().find_map(|target| {
            let (node, name) = split_path(target)?;
            let entry = entries.get(node)?;
            let own = self.registry.node(&entry.ty)?.spec.params.iter().find(|p| p.name == name);
            if own.is_some() || !flow::stands_for_graph(&entry.ty) {
                return own.cloned();
            }
            let Some(ParamValue::Text(body)) = entry.params.get("body") else { return None };
            let all = scopes.iter().copied().chain([&self.document.groups]);
            let group = all.clone().find_map(|scope| scope.get(body))?;
            let scopes = [&group.groups].into_iter().chain(all).collect();
            self.spec_within(&group.interface, &group.nodes, scopes, name, depth + 1)
        })
    }

    /// The node of a target, if it stands for a graph.
    pub fn zone_of(&self, instance: usize, target: &str) -> Option<&'a str> {
        let (node, _) = split_path(target)?;
        let (name, entry) = self.instances[instance].entries.get_key_value(node)?;
        flow::stands_for_graph(&entry.ty).then_some(name.as_str())
    }

    /// What a zone's parameter takes, and its value now.
    pub fn describe(&self, instance: usize, target: &str) -> Option<(ParamSpec, ParamValue)> {
        let (node, name) = split_path(target)?;
        let here = &self.instances[instance];
        let entry = here.entries.get(node)?;
        let given = self.params(instance, node).get(name).cloned();
        let own = self.registry.node(&entry.ty)?.spec.params.iter().find(|p| p.name == name);
        if let Some(own) = own {
            return Some((own.clone(), given.unwrap_or_else(|| own.default.clone())));
        }
        let Some(ParamValue::Text(body)) = entry.params.get("body") else { return None };
        let (group, scopes) = self.group(instance, body)?;
        let mut spec = self.spec_within(&group.interface, &group.nodes, scopes, name, 0)?;
        if let Some(default) = group.interface.params.get(name).and_then(|param| param.default.clone()) {
            spec.default = default;
        }
        let value = given.unwrap_or_else(|| spec.default.clone());
        Some((spec, value))
    }
}
