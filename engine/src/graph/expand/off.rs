//! Nodes that are muted or bypassed: what goes on behind them. The links of the flat graph lead past them, so whoever
//! checks and runs it need not know of them.

use std::collections::BTreeMap;

use super::instance::{MAX_DEPTH, Tree};
use crate::document::{Group, NodeEntry};
use crate::flow;
use crate::spec::ParamValue;

/// What is to be known of the nodes of the flat graph that are off.
#[derive(Default)]
pub(crate) struct Off {
    /// For an input (node and socket) whose link came to nothing, why.
    pub lost: BTreeMap<(String, String), String>,
    /// For an output (node and socket) of a node that is off the output that it passes on, or why there is none.
    pub passed: BTreeMap<(String, String), Result<(String, String), String>>,
}

type Scopes<'a> = Vec<&'a BTreeMap<String, Group>>;

impl<'a> Tree<'a> {
    /// The input that a bypassed node passes on at an output: the first of the same type.
    pub(super) fn passing(&self, instance: usize, node: &str, socket: &str) -> Option<String> {
        let entry = self.instances[instance].entries.get(node)?;
        if !flow::stands_for_graph(&entry.ty) {
            let spec = &self.registry.node(&entry.ty)?.spec;
            let ty = spec.outputs.iter().find(|output| output.name == socket)?.ty;
            return spec.inputs.iter().find(|input| input.ty == ty).map(|input| input.name.to_owned());
        }
        let params = self.params(instance, node);
        let Some(ParamValue::Text(body)) = params.get("body") else { return None };
        let (group, scopes) = self.group(instance, body)?;
        let output = group.interface.outputs.get(socket)?;
        let ty = self.output_type(&group.nodes, &scopes, &output.node, &output.socket, 0)?;
        let mut inputs = group.interface.inputs.iter();
        inputs.find(|(_, input)| input.ty == ty).map(|(name, _)| name.clone())
    }

    /// The type of an output of a graph, which may be that of a group in it.
    fn output_type(
        &self,
        nodes: &'a BTreeMap<String, NodeEntry>,
        scopes: &Scopes<'a>,
        node: &str,
        socket: &str,
        depth: usize,
    ) -> Option<&'static str> {
        let entry = nodes.get(node).filter(|_| depth <= MAX_DEPTH)?;
        if !flow::stands_for_graph(&entry.ty) {
            let outputs = &self.registry.node(&entry.ty)?.spec.outputs;
            return outputs.iter().find(|output| output.name == socket).map(|output| output.ty);
        }
        let Some(ParamValue::Text(body)) = entry.params.get("body") else { return None };
        let group = scopes.iter().find_map(|scope| scope.get(body))?;
        let scopes = [&group.groups].into_iter().chain(scopes.iter().copied()).collect();
        let output = group.interface.outputs.get(socket)?;
        self.output_type(&group.nodes, &scopes, &output.node, &output.socket, depth + 1)
    }
}
