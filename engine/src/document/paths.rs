//! The files that a document names.

use std::collections::BTreeMap;
use std::path::Path;

use super::{Document, Group, Interface, NodeEntry, split_path};
use crate::files::{has_scheme, join};
use crate::flow;
use crate::registry::Registry;
use crate::spec::{ParamKind, ParamValue};

/// How many targets are followed to find out what a parameter of a group is.
const MAX_STEPS: usize = 10_000;
/// How deep groups may lie in each other.
const MAX_DEPTH: usize = 32;

type Scopes<'a> = Vec<&'a BTreeMap<String, Group>>;

impl Document {
    /// Changes the paths of files: those that nodes of known types take, in groups too, and those that interfaces and
    /// groups hand on to such nodes. `change` is given a path as it is seen from `folder`, which the document's
    /// paths are relative to, and says what to put in its place; `None` leaves it. Empty paths and those with a
    /// scheme, such as `builtin:stone.png`, stay as they are. Groups in files take part once they are
    /// [included](Document::include).
    pub fn change_paths(
        &mut self,
        registry: &Registry,
        folder: &Path,
        change: &mut dyn FnMut(&str) -> Option<String>,
    ) {
        let known = self.groups.clone();
        let mut walk = Walk { registry, change };
        walk.graph(&mut self.interface, &mut self.nodes, folder, &vec![&known]);
        walk.groups(&mut self.groups, &known, folder, &vec![&known]);
    }
}

struct Walk<'a> {
    registry: &'a Registry,
    change: &'a mut dyn FnMut(&str) -> Option<String>,
}

impl Walk<'_> {
    fn groups(
        &mut self,
        groups: &mut BTreeMap<String, Group>,
        known: &BTreeMap<String, Group>,
        folder: &Path,
        scopes: &Scopes<'_>,
    ) {
        for (name, group) in groups {
            let own = group.folder.clone();
            let folder = own.as_deref().unwrap_or(folder);
            let Some(known) = known.get(name) else { continue };
            let scopes: Scopes<'_> = [&known.groups].into_iter().chain(scopes.iter().copied()).collect();
            self.graph(&mut group.interface, &mut group.nodes, folder, &scopes);
            self.groups(&mut group.groups, &known.groups, folder, &scopes);
        }
    }

    fn graph(
        &mut self,
        interface: &mut Interface,
        nodes: &mut BTreeMap<String, NodeEntry>,
        folder: &Path,
        scopes: &Scopes<'_>,
    ) {
        let kinds = Kinds { registry: self.registry };
        for param in interface.params.values_mut() {
            let mut targets = param.targets.iter().filter_map(|target| split_path(target));
            let Some(value) = &mut param.default else { continue };
            if targets.any(|(node, name)| nodes.get(node).is_some_and(|n| kinds.is_file(n, name, scopes))) {
                self.value(value, folder);
            }
        }
        for entry in nodes.values_mut() {
            let names: Vec<String> =
                entry.params.keys().filter(|name| kinds.is_file(entry, name, scopes)).cloned().collect();
            for name in names {
                if let Some(value) = entry.params.get_mut(&name) {
                    self.value(value, folder);
                }
            }
        }
    }

    fn value(&mut self, value: &mut ParamValue, folder: &Path) {
        match value {
            ParamValue::Text(path) if !path.is_empty() && !has_scheme(path) => {
                let seen = join(folder, path);
                // A group that is built in has files that are built in.
                if let Some(new) = if has_scheme(&seen) { Some(seen) } else { (self.change)(&seen) } {
                    *path = new;
                }
            }
            // A zone may take one for each level.
            ParamValue::List(items) => items.iter_mut().for_each(|item| self.value(item, folder)),
            _ => {}
        }
    }
}

struct Kinds<'a> {
    registry: &'a Registry,
}

impl Kinds<'_> {
    /// Whether a parameter of a node is a file, or is handed on to one that is.
    fn is_file(&self, entry: &NodeEntry, param: &str, scopes: &Scopes<'_>) -> bool {
        self.leads_to_file(entry, param, scopes, (0, &mut 0))
    }

    fn leads_to_file(
        &self,
        entry: &NodeEntry,
        param: &str,
        scopes: &Scopes<'_>,
        (depth, steps): (usize, &mut usize),
    ) -> bool {
        *steps += 1;
        let Some(ty) = self.registry.node(&entry.ty).filter(|_| *steps < MAX_STEPS) else { return false };
        if let Some(spec) = ty.spec.params.iter().find(|spec| spec.name == param) {
            return matches!(spec.kind, ParamKind::File { .. });
        }
        let Some(ParamValue::Text(body)) = entry.params.get("body") else { return false };
        if !flow::stands_for_graph(&entry.ty) || depth > MAX_DEPTH {
            return false;
        }
        let found = scopes.iter().enumerate().find_map(|(at, scope)| Some((at, scope.get(body)?)));
        let Some((at, group)) = found else { return false };
        let inner: Scopes<'_> = [&group.groups].into_iter().chain(scopes.iter().skip(at).copied()).collect();
        let targets = group.interface.params.get(param).map_or(&[][..], |param| &param.targets);
        targets.iter().filter_map(|target| split_path(target)).any(|(node, name)| {
            group
                .nodes
                .get(node)
                .is_some_and(|node| self.leads_to_file(node, name, &inner, (depth + 1, steps)))
        })
    }
}
