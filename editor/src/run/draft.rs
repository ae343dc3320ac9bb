//! A coarser graph for the time while something is dragged.

use breccia_engine::{Graph, ParamValue};

/// The graph with those numbers divided that nodes say may be coarser in a draft.
pub fn draft(graph: &Graph) -> Graph {
    let mut coarse = graph.clone();
    let mut changes = Vec::new();
    for (node, spec) in graph.nodes() {
        let Some(params) = graph.node_params(node) else { continue };
        for (name, divisor) in &spec.draft {
            let least = 16;
            let smaller = |n: i64| if n > least { (n / divisor).max(least) } else { n };
            let value = match params.get(name) {
                Some(ParamValue::Int(n)) => ParamValue::Int(smaller(*n)),
                Some(ParamValue::List(items)) => ParamValue::List(
                    items
                        .iter()
                        .map(|item| {
                            if let ParamValue::Int(n) = item {
                                ParamValue::Int(smaller(*n))
                            } else {
                                item.clone()
                            }
                        })
                        .collect(),
                ),
                _ => continue,
            };
            changes.push((node.to_owned(), (*name).to_owned(), value));
        }
    }
    for (node, name, value) in changes {
        // A value that does not fit is left as it was: the draft is then no coarser.
        let _ = coarse.set_node_param(&node, &name, &value);
    }
    coarse
}
