//! Which nodes are there: a node whose file is not given is absent, and so is what cannot do without it.

use super::{Graph, Source};
use crate::spec::{Arity, ParamKind, ParamValue};

/// Why a node is absent.
#[derive(Clone, Debug)]
pub(crate) struct Absence {
    /// The node where the lack is felt: the first that cannot do without, or the reader itself.
    pub node: usize,
    /// What is not given.
    pub message: String,
}

/// What takes part in a run.
pub(crate) struct Presence {
    /// For every node, why it is absent.
    pub absent: Vec<Option<Absence>>,
    /// For every node and every input the links whose values there are.
    pub sources: Vec<Vec<Vec<Source>>>,
}

impl Graph {
    pub(crate) fn presence(&self) -> Presence {
        let mut absent: Vec<Option<Absence>> = vec![None; self.nodes.len()];
        let mut sources = vec![Vec::new(); self.nodes.len()];
        for &index in &self.order {
            let node = &self.nodes[index];
            if node.is_bound() {
                continue;
            }
            absent[index] = self.missing_file(index).map(|message| Absence { node: index, message });
            for (socket, links) in node.ty.spec.inputs.iter().zip(&node.links) {
                let mut present = Vec::new();
                for &source in links {
                    match self.lacks(source, &absent) {
                        None => present.push(source),
                        Some(lack) if socket.arity == Arity::One && absent[index].is_none() => {
                            // The lack is felt where the reader's value was to go.
                            let node = if lack.node == source.node { index } else { lack.node };
                            absent[index] = Some(Absence { node, ..lack });
                        }
                        Some(_) => {}
                    }
                }
                sources[index].push(present);
            }
        }
        Presence { absent, sources }
    }

    /// Why there is no value at this output.
    pub(crate) fn lacks(&self, source: Source, absent: &[Option<Absence>]) -> Option<Absence> {
        let node = &self.nodes[source.node];
        if node.is_bound() {
            let bound = node.bound.get(source.output).is_some_and(Option::is_some);
            let name = node.ty.spec.outputs.get(source.output).map_or("", |o| o.name);
            return (!bound).then(|| Absence {
                node: source.node,
                message: format!("no value is given for output `{name}` of node `{}`", node.name),
            });
        }
        absent.get(source.node).cloned().flatten()
    }

    fn missing_file(&self, index: usize) -> Option<String> {
        let node = &self.nodes[index];
        if node.ty.spec.id == crate::flow::VALUE {
            let input = self.inputs.iter().find(|(_, input)| input.node == index);
            return Some(format!("input `{}` is not given", input.map_or("", |(name, _)| name)));
        }
        let missing = node.ty.spec.params.iter().find(|param| {
            matches!(param.kind, ParamKind::File { .. })
                && matches!(node.params.get(param.name), Some(ParamValue::Text(path)) if path.is_empty())
        })?;
        let input = self.inputs.iter().find(|(_, i)| i.node == index && i.param == Some(missing.name));
        Some(match input {
            Some((name, _)) => format!("input `{name}` is not given"),
            None => format!("no file is given for parameter `{}` of node `{}`", missing.name, node.name),
        })
    }
}
