//! What the viewport shows, and what goes with it.

use std::collections::{BTreeMap, BTreeSet};

use breccia_engine::{Document, ParamKind, ParamValue};

use super::App;
use crate::action::Pin;
use crate::model::reach;

/// Types that are worth looking at, the best first.
const TYPES: [&str; 5] = ["solid", "mesh", "volume", "image", "exemplar"];

/// Outputs that go with what is looked at.
#[derive(Default)]
pub(super) struct Companions {
    /// A mesh that it can be shown on.
    pub mesh: Option<String>,
    /// A picture to compare it with.
    pub exemplar: Option<String>,
    /// The solid in it, if it is a mesh that was baked.
    pub inside: Option<String>,
}

impl Companions {
    /// All that there are.
    pub fn into_all(self) -> impl Iterator<Item = String> {
        [self.mesh, self.exemplar, self.inside].into_iter().flatten()
    }
}

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
        let ends = graph.outputs().map(|output| own(output.node).to_owned());
        let needed: BTreeSet<String> = self.upstream(ends).into_iter().collect();
        let last: Vec<String> = graph.outputs().map(|output| own(output.node).to_owned()).collect();
        let choice = TYPES.iter().find_map(|ty| {
            let has = |name: &str| {
                let (_, spec) = graph.nodes().find(|(node, _)| *node == name)?;
                let socket = spec.outputs.iter().find(|output| output.ty == *ty)?;
                Some(format!("{name}.{}", socket.name))
            };
            // A solid may come from any node on the way; of other types it is what comes out at the end.
            let order: Vec<&String> =
                if *ty == "solid" { self.latest_first(&needed) } else { last.iter().collect() };
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

    /// Nodes, those first that need others of them.
    fn latest_first<'a>(&self, nodes: &'a BTreeSet<String>) -> Vec<&'a String> {
        let needs =
            |node: &String| self.checked.needs.get(node).into_iter().flatten().filter(|n| nodes.contains(*n));
        let mut waiting: BTreeMap<&String, usize> = nodes.iter().map(|node| (node, 0)).collect();
        for needed in nodes.iter().flat_map(&needs) {
            if let Some(count) = waiting.get_mut(needed) {
                *count += 1;
            }
        }
        let mut open: Vec<&String> =
            waiting.iter().filter(|(_, count)| **count == 0).map(|(node, _)| *node).collect();
        let mut next = 0;
        while let Some(node) = open.get(next).copied() {
            next += 1;
            for needed in needs(node) {
                if let Some((needed, count)) = nodes.get(needed).and_then(|n| Some((n, waiting.get_mut(n)?)))
                {
                    *count -= 1;
                    if *count == 0 {
                        open.push(needed);
                    }
                }
            }
        }
        open
    }

    /// Nodes and all that they need, nearest first; of the document's own graph.
    fn upstream(&self, nodes: impl IntoIterator<Item = String>) -> Vec<String> {
        let nodes: Vec<String> = nodes.into_iter().collect();
        let needs = |node| self.checked.needs.get(node).into_iter().flatten().map(String::as_str);
        reach(nodes.iter().map(String::as_str), needs).into_iter().map(str::to_owned).collect()
    }

    /// What goes with what is looked at.
    pub(super) fn companions(&self) -> Companions {
        let Some(watched_output) = self.watched.as_ref() else { return Companions::default() };
        let inside = self.checked.bakes.inside(watched_output).map(|bake| bake.solid.clone());
        let Some(watched) = watched_output.rsplit_once('.') else { return Companions::default() };
        let document: &Document = &self.checked.included;
        let near = self.upstream([own(watched.0).to_owned()]);
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
        // A solid is shown on the mesh that it is baked into, since it is fitted as it is there.
        let baked = self.checked.bakes.mesh_of(watched_output).and_then(|mesh| mesh.rsplit_once('.'));
        let below = baked.map(|(node, _)| self.upstream([own(node).to_owned()])).unwrap_or_default();
        let mesh = reader(&below, "mesh").or_else(|| reader(&all, "mesh"));
        Companions { mesh, exemplar, inside }
    }
}

/// The node of the document's own graph that a node of a run is, or lies in.
fn own(path: &str) -> &str {
    path.split(['/', '[']).next().unwrap_or_default()
}
