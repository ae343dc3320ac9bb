//! Setting parameters and inputs of a checked graph.

use std::sync::Arc;

use super::{Graph, Problem, ProblemKind, Problems};
use crate::document::split_path;
use crate::param::Mismatch;
use crate::spec::ParamValue;
use crate::value::Value;

impl Problem {
    pub(super) fn mismatch(node: Option<&str>, item: String, mismatch: Mismatch) -> Self {
        Self {
            suggestion: mismatch.suggestion,
            ..Self::new(ProblemKind::BadValue, node, item, mismatch.found, mismatch.expected)
        }
    }
}

impl Graph {
    /// Sets what `name` stands for: an exposed parameter, or `node.param`.
    ///
    /// # Errors
    /// If there is no such parameter, or it does not take the value.
    pub fn set(&mut self, name: &str, value: &ParamValue) -> Result<(), Problems> {
        match name.split_once('.') {
            Some((node, param)) => self.set_node_param(node, param, value),
            None => self.set_interface(name, value),
        }
    }

    /// Sets an exposed parameter.
    ///
    /// # Errors
    /// If there is no such parameter, or one of its targets does not take the value.
    pub fn set_interface(&mut self, name: &str, value: &ParamValue) -> Result<(), Problems> {
        let Some(param) = self.params.get(name) else {
            let known = self.params.keys().map(String::as_str);
            let kind = ProblemKind::UnknownInterface;
            return Err(Problem::unknown(kind, None, "parameter", name, "exposed parameters", known).alone());
        };
        if let Some(zone) = &param.zone {
            let check = |value: &ParamValue| zone.spec.kind.check(value);
            // A list may give one value for each level; what cannot be is told when the graph is made again.
            let wrong = match value {
                ParamValue::List(items) if check(value).is_err() => {
                    items.iter().find_map(|item| check(item).err())
                }
                value => check(value).err(),
            };
            if let Some(mismatch) = wrong {
                return Err(Problem::mismatch(None, format!("parameter `{name}`"), mismatch).alone());
            }
        }
        if let Some(template) = &self.template {
            let overrides =
                template.targets(name).into_iter().map(|(node, param)| (node, param, value.clone()));
            *self = template.with(overrides).build()?;
            return Ok(());
        }
        let targets = param.targets.clone();
        for (node, index) in targets {
            self.set_param_at(node, index, value, || (None, format!("parameter `{name}`")))?;
        }
        Ok(())
    }

    /// Sets a parameter of a node. Paths are taken as they are, not relative to the document.
    ///
    /// # Errors
    /// If there is no such parameter, or it does not take the value.
    pub fn set_node_param(&mut self, node: &str, param: &str, value: &ParamValue) -> Result<(), Problems> {
        if let Some(template) = &self.template {
            if !template.knows(node, self) {
                return Err(self.unknown_node(node).alone());
            }
            *self = template.with([(node.to_owned(), param.to_owned(), value.clone())]).build()?;
            return Ok(());
        }
        let Some(index) = self.index(node) else { return Err(self.unknown_node(node).alone()) };
        let params = &self.nodes[index].ty.spec.params;
        let Some(at) = params.iter().position(|p| p.name == param) else {
            let known = params.iter().map(|p| p.name);
            let kind = ProblemKind::UnknownParam;
            return Err(Problem::unknown(kind, Some(node), "parameter", param, "parameters", known).alone());
        };
        self.set_param_at(index, at, value, || (Some(node.to_owned()), format!("parameter `{param}`")))
    }

    fn set_param_at(
        &mut self,
        node: usize,
        param: usize,
        value: &ParamValue,
        place: impl Fn() -> (Option<String>, String),
    ) -> Result<(), Problems> {
        let Some(node) = self.nodes.get_mut(node) else { return Ok(()) };
        let Some(spec) = node.ty.spec.params.get(param) else { return Ok(()) };
        match spec.kind.check(value) {
            Ok(value) => {
                node.params.insert(spec.name, value);
                Ok(())
            }
            Err(mismatch) => {
                let (node, item) = place();
                Err(Problem::mismatch(node.as_deref(), item, mismatch).alone())
            }
        }
    }

    /// Gives an input a file.
    ///
    /// # Errors
    /// If there is no such input.
    pub fn set_input(&mut self, name: &str, path: &str) -> Result<(), Problems> {
        let input = self.inputs.get(name).ok_or_else(|| self.unknown_input(name).alone())?.clone();
        let Some(param) = input.param else {
            let (found, item) = (format!("the path `{path}`"), format!("input `{name}`"));
            let expected =
                format!("a ready value of type {}; no node of the graph reads a file for it", input.ty);
            return Err(Problem::new(ProblemKind::TypeMismatch, None, item, found, expected).alone());
        };
        if let Some(template) = &mut self.template {
            let value = ParamValue::Text(path.to_owned());
            Arc::make_mut(template).set_reader(name, param, value);
        }
        if let Some(node) = self.nodes.get_mut(input.node) {
            node.params.insert(param, ParamValue::Text(path.to_owned()));
            node.bound.fill(None);
        }
        Ok(())
    }

    /// Gives an input a ready value in place of a file; its reader does not run.
    ///
    /// # Errors
    /// If there is no such input, or it takes another type.
    pub fn bind_input(&mut self, name: &str, value: Value) -> Result<(), Problems> {
        let input = self.inputs.get(name).ok_or_else(|| self.unknown_input(name).alone())?.clone();
        if input.ty != value.type_name() {
            let found = format!("a value of type {}", value.type_name());
            let item = format!("input `{name}`");
            return Err(Problem::new(ProblemKind::TypeMismatch, None, item, found, input.ty).alone());
        }
        if let Some(template) = &mut self.template {
            Arc::make_mut(template).bind(name, value.clone());
        }
        if let Some(bound) = self.nodes.get_mut(input.node).and_then(|n| n.bound.get_mut(input.output)) {
            *bound = Some(value);
        }
        Ok(())
    }

    /// The node and output that a name stands for: an output of the interface, or `node.socket`.
    pub(crate) fn find_output(&self, name: &str) -> Result<super::Source, Problems> {
        if let Some(output) = self.outputs.get(name) {
            return Ok(super::Source { node: output.node, output: output.output });
        }
        let Some((node, socket)) = split_path(name) else {
            let known = self.outputs.keys().map(String::as_str);
            let kind = ProblemKind::UnknownInterface;
            return Err(Problem::unknown(kind, None, "output", name, "outputs", known).alone());
        };
        let index = self.index(node).ok_or_else(|| self.unknown_node(node).alone())?;
        let sockets = &self.nodes[index].ty.spec.outputs;
        let Some(output) = sockets.iter().position(|s| s.name == socket) else {
            let known = sockets.iter().map(|s| s.name);
            let kind = ProblemKind::UnknownSocket;
            return Err(Problem::unknown(kind, Some(node), "output", socket, "outputs", known).alone());
        };
        match self.passed.get(&(index, output)) {
            None => Ok(super::Source { node: index, output }),
            Some(Ok(source)) => Ok(*source),
            Some(Err(reason)) => {
                let (item, found) = (format!("output `{socket}`"), format!("nothing, since {reason}"));
                let expected = "an output that has a value";
                Err(Problem::new(ProblemKind::Muted, Some(node), item, found, expected).alone())
            }
        }
    }

    fn unknown_node(&self, node: &str) -> Problem {
        let known = self.nodes.iter().map(|n| n.name.as_str());
        Problem::unknown(ProblemKind::UnknownNode, None, "node", node, "nodes", known)
    }

    fn unknown_input(&self, name: &str) -> Problem {
        let known = self.inputs.keys().map(String::as_str);
        Problem::unknown(ProblemKind::UnknownInterface, None, "input", name, "inputs", known)
    }
}
