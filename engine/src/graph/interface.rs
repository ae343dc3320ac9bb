//! The names that a graph offers to somebody who runs it.

use super::Graph;
use super::expand::ZoneParam;
use crate::spec::{ParamKind, ParamSpec, ParamValue};

#[derive(Clone)]
pub(crate) struct Input {
    pub ty: String,
    pub docs: String,
    pub node: usize,
    /// The file parameter; none where only a value can be given.
    pub param: Option<&'static str>,
    /// The output of the node that a ready value stands in for.
    pub output: usize,
}

#[derive(Clone)]
pub(crate) struct Output {
    pub docs: String,
    pub node: usize,
    pub output: usize,
}

#[derive(Clone)]
pub(crate) struct Param {
    pub docs: String,
    /// Node and index of its parameter; at least one, unless a group or zone takes it.
    pub targets: Vec<(usize, usize)>,
    /// What it takes, if a group or zone takes it.
    pub zone: Option<ZoneParam>,
}

/// An input that a graph takes.
#[derive(Clone, Copy, Debug)]
pub struct InputInfo<'a> {
    /// Its name.
    pub name: &'a str,
    /// The socket type of what the file holds.
    pub ty: &'a str,
    /// What to give.
    pub docs: &'a str,
    /// Extensions that can be read; none where only a ready value can be given.
    pub extensions: &'static [&'static str],
    /// The path as it is set now; empty if none.
    pub path: &'a str,
}

/// An output that a graph gives.
#[derive(Clone, Copy, Debug)]
pub struct OutputInfo<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its socket type.
    pub ty: &'static str,
    /// What it is.
    pub docs: &'a str,
    /// The node that makes it.
    pub node: &'a str,
    /// That node's output socket.
    pub socket: &'static str,
}

/// A parameter that a graph exposes.
#[derive(Clone, Copy, Debug)]
pub struct ParamInfo<'a> {
    /// Its name.
    pub name: &'a str,
    /// What it does; the target's docs if the graph says nothing itself.
    pub docs: &'a str,
    /// What it takes: kind, unit and range are those of its first target.
    pub spec: &'a ParamSpec,
    /// The value as it is set now.
    pub value: &'a ParamValue,
}

impl Graph {
    /// The inputs, by name.
    pub fn inputs(&self) -> impl Iterator<Item = InputInfo<'_>> {
        self.inputs.iter().filter_map(|(name, input)| {
            let node = self.nodes.get(input.node)?;
            let Some(param) = input.param else {
                return Some(InputInfo { name, ty: &input.ty, docs: &input.docs, extensions: &[], path: "" });
            };
            let spec = node.ty.spec.params.iter().find(|p| p.name == param)?;
            let ParamKind::File { extensions } = spec.kind else { return None };
            let path = match node.params.get(param) {
                Some(ParamValue::Text(path)) => path.as_str(),
                _ => "",
            };
            Some(InputInfo { name, ty: &input.ty, docs: &input.docs, extensions, path })
        })
    }

    /// The outputs, by name.
    pub fn outputs(&self) -> impl Iterator<Item = OutputInfo<'_>> {
        self.outputs.iter().filter_map(|(name, output)| {
            let node = self.nodes.get(output.node)?;
            let socket = node.ty.spec.outputs.get(output.output)?;
            Some(OutputInfo {
                name,
                ty: socket.ty,
                docs: if output.docs.is_empty() { socket.docs } else { &output.docs },
                node: &node.name,
                socket: socket.name,
            })
        })
    }

    /// The exposed parameters, by name.
    pub fn params(&self) -> impl Iterator<Item = ParamInfo<'_>> {
        self.params.iter().filter_map(|(name, param)| {
            if let Some(ZoneParam { spec, value }) = &param.zone {
                let docs = if param.docs.is_empty() { spec.docs } else { &param.docs };
                return Some(ParamInfo { name, docs, spec, value });
            }
            let &(node, index) = param.targets.first()?;
            let node = self.nodes.get(node)?;
            let spec = node.ty.spec.params.get(index)?;
            let value = node.params.get(spec.name)?;
            Some(ParamInfo {
                name,
                docs: if param.docs.is_empty() { spec.docs } else { &param.docs },
                spec,
                value,
            })
        })
    }
}
