//! What the viewport shows, and what goes with it.

use std::collections::BTreeSet;

use breccia_engine::{Document, Link, ParamKind, ParamValue};

use super::App;
use crate::action::Pin;

/// Types that are worth looking at, the best first.
const TYPES: [&str; 5] = ["solid", "mesh", "volume", "image", "exemplar"];

impl App {
    /// Looks at an output of the graph that is looked at.
    pub(super) fn watch(&mut self, pin: &Pin) {
        match self.in_run(&pin.node, &pin.socket) {
            Some(output) => {
                if !self.can_run(&output) {
                    self.say(format!("{output} cannot be computed as the graph is wired"));
                }
                self.watched = Some(output);
                self.due = true;
                self.open.viewport = true;
            }
            None => self.say(format!("{} does not run", pin.node)),
        }
    }

    /// Something to look at, where nothing is chosen: a solid that an output of the graph hangs on, or the first output of
    /// another kind.
    pub(super) fn choose_watched(&mut self) {
        let Some(graph) = self.checked.graph.clone() else {
            self.watched = None;
            return;
        };
        let needed: BTreeSet<String> = graph.outputs().flat_map(|o| self.upstream(own(o.node))).collect();
        let last: Vec<String> = graph.outputs().map(|output| own(output.node).to_owned()).collect();
        let choice = TYPES.iter().find_map(|ty| {
            let has = |name: &str| {
                let (_, spec) = graph.nodes().find(|(node, _)| *node == name)?;
                let socket = spec.outputs.iter().find(|output| output.ty == *ty)?;
                Some(format!("{name}.{}", socket.name))
            };
            // A solid may come from any node on the way; of other types it is what comes out at the end.
            let order: Vec<&String> =
                if *ty == "solid" { self.by_depth(&needed) } else { last.iter().collect() };
            order.into_iter().find_map(|name| has(name))
        });
        let any = || {
            let mut nodes: Vec<_> = graph.nodes().collect();
            nodes.reverse();
            nodes.iter().find_map(|(name, spec)| {
                Some(format!("{name}.{}", spec.outputs.iter().find(|o| TYPES.contains(&o.ty))?.name))
            })
        };
        self.watched = choice.or_else(any);
    }

    /// Nodes, those first that most of the others are needed for.
    fn by_depth<'a>(&self, nodes: &'a BTreeSet<String>) -> Vec<&'a String> {
        let mut found: Vec<_> = nodes.iter().map(|node| (self.upstream(node).len(), node)).collect();
        found.sort_by(|a, b| b.cmp(a));
        found.into_iter().map(|(_, node)| node).collect()
    }

    /// A node and all that it needs, nearest first; of the document's own graph.
    fn upstream(&self, node: &str) -> Vec<String> {
        let document: &Document = &self.checked.included;
        let links: Vec<Link> = document.links.iter().filter_map(|link| Link::parse(link)).collect();
        let mut found = vec![node.to_owned()];
        let mut next = 0;
        while let Some(node) = found.get(next).cloned() {
            next += 1;
            for link in links.iter().filter(|link| link.to_node == node) {
                if !found.contains(&link.from_node) {
                    found.push(link.from_node.clone());
                }
            }
        }
        found
    }

    /// What goes with what is looked at: a mesh that it can be shown on, a picture to compare it with.
    pub(super) fn companions(&self) -> [Option<String>; 2] {
        let Some(watched) = self.watched.as_ref().and_then(|output| output.rsplit_once('.')) else {
            return [None, None];
        };
        let document: &Document = &self.checked.included;
        let near = self.upstream(own(watched.0));
        let all: Vec<String> = near.iter().chain(document.nodes.keys()).cloned().collect();
        let output = |node: &String, ty: &str| {
            let spec = &self.registry.node(&document.nodes.get(node)?.ty)?.spec;
            let socket = spec.outputs.iter().find(|output| output.ty == ty)?;
            Some((spec, format!("{node}.{}", socket.name)))
        };
        let is_given = |node: &String, spec: &breccia_engine::NodeSpec| {
            spec.params.iter().filter(|param| matches!(param.kind, ParamKind::File { .. })).any(|param| {
                let value = document.nodes.get(node).and_then(|entry| entry.params.get(param.name));
                matches!(value, Some(ParamValue::Text(path)) if !path.is_empty())
            })
        };
        let reader = |nodes: &[String], ty: &str| {
            nodes.iter().find_map(|node| {
                output(node, ty)
                    .filter(|(spec, output)| is_given(node, spec) && self.can_run(output))
                    .map(|(_, o)| o)
            })
        };
        let named = document.interface.inputs.get("exemplar").map(|input| vec![input.node.clone()]);
        let exemplar = named.and_then(|node| reader(&node, "image")).or_else(|| reader(&near, "image"));
        [reader(&all, "mesh"), exemplar]
    }
}

/// The node of the document's own graph that a node of a run is, or lies in.
fn own(path: &str) -> &str {
    path.split(['/', '[']).next().unwrap_or_default()
}
