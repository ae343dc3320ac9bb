//! The reference of node types, made from their descriptions.

mod lint;
mod text;

use serde::Serialize;

use crate::spec::{Arity, NodeSpec, ParamKind, ParamValue, Placement};
pub use lint::lint;
pub use text::{markdown, plain};

/// Everything there is to know of a node type, to be written in any format.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NodeDoc {
    /// Its id.
    pub id: &'static str,
    /// Its version.
    pub version: u32,
    /// Its heading in palettes.
    pub category: &'static str,
    /// One line.
    pub summary: &'static str,
    /// Markdown.
    pub docs: &'static str,
    /// The paper and section it implements.
    pub paper: Option<&'static str>,
    /// In words where it runs.
    pub placement: &'static str,
    /// Its inputs.
    pub inputs: Vec<SocketDoc>,
    /// Its outputs.
    pub outputs: Vec<SocketDoc>,
    /// Its parameters.
    pub params: Vec<ParamDoc>,
}

/// A socket of a node type.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SocketDoc {
    /// Its name.
    pub name: &'static str,
    /// Its type.
    #[serde(rename = "type")]
    pub ty: &'static str,
    /// `one`, `optional` or `many`.
    pub links: &'static str,
    /// What flows through it.
    pub docs: &'static str,
}

/// A parameter of a node type.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParamDoc {
    /// Its name.
    pub name: &'static str,
    /// What it takes, in words.
    pub takes: String,
    /// Its unit, or nothing.
    pub unit: &'static str,
    /// The value used where none is given.
    pub default: ParamValue,
    /// For choices their names and docs.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub choices: Vec<ChoiceDoc>,
    /// What it does.
    pub docs: &'static str,
}

/// One name of a choice.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChoiceDoc {
    /// The name.
    pub name: &'static str,
    /// What it means.
    pub docs: &'static str,
}

/// Collects what there is to know of a node type.
pub fn describe(spec: &NodeSpec) -> NodeDoc {
    let sockets = |sockets: &[crate::spec::SocketSpec]| {
        sockets
            .iter()
            .map(|socket| SocketDoc {
                name: socket.name,
                ty: socket.ty,
                links: match socket.arity {
                    Arity::One => "one",
                    Arity::Optional => "optional",
                    Arity::Many => "many",
                },
                docs: socket.docs,
            })
            .collect()
    };
    NodeDoc {
        id: spec.id,
        version: spec.version,
        category: spec.category,
        summary: spec.summary,
        docs: spec.docs,
        paper: spec.paper,
        placement: match spec.placement {
            Placement::Cpu => "cpu",
            Placement::CpuOrGpu => "cpu or gpu",
            Placement::Apart => "cpu, or gpu with another rounding if that is asked for",
        },
        inputs: sockets(&spec.inputs),
        outputs: sockets(&spec.outputs),
        params: spec
            .params
            .iter()
            .map(|param| ParamDoc {
                name: param.name,
                takes: param.kind.describe(),
                unit: param.unit,
                default: param.default.clone(),
                choices: match param.kind {
                    ParamKind::Choice(choices) => {
                        choices.iter().map(|&(name, docs)| ChoiceDoc { name, docs }).collect()
                    }
                    _ => Vec::new(),
                },
                docs: param.docs,
            })
            .collect(),
    }
}
