//! A coarser graph for the time while something is dragged.

use breccia_engine::{Draft, Graph, ParamValue};

/// The graph with those numbers divided that nodes say may be coarser in a draft.
pub fn draft(graph: &Graph) -> Graph {
    let mut coarse = graph.clone();
    let mut changes = Vec::new();
    for (node, spec) in graph.nodes() {
        let Some(params) = graph.node_params(node) else { continue };
        for &Draft { param, divisor, least } in &spec.draft {
            let smaller = |n: i64| if n > least { (n / divisor).max(least) } else { n };
            let value = match params.get(param) {
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
            changes.push((node.to_owned(), param, value));
        }
    }
    for (node, name, value) in changes {
        // A value that does not fit is left as it was: the draft is then no coarser.
        let _ = coarse.set_node_param(&node, name, &value);
    }
    coarse
}

#[cfg(test)]
mod tests {
    use breccia_engine::Document;

    use super::*;

    #[test]
    fn drafts_of_all_presets_are_smaller_and_otherwise_the_same() {
        let registry = breccia_nodes::registry();
        let mut fewer = 0;
        for preset in breccia_graphs::presets() {
            let mut document = Document::parse(preset.ron).unwrap();
            document.include(std::path::Path::new(""), &breccia_graphs::Sources::default()).unwrap();
            let graph = Graph::new(&document, &registry).unwrap();
            let coarse = draft(&graph);
            for (node, spec) in graph.nodes() {
                let (whole, less) = (graph.node_params(node).unwrap(), coarse.node_params(node).unwrap());
                for (name, value) in whole {
                    if less[name] == *value {
                        continue;
                    }
                    fewer += 1;
                    let rule = spec.draft.iter().find(|rule| rule.param == *name).expect("a rule");
                    let numbers = |value: &ParamValue| match value {
                        ParamValue::List(items) => items.clone(),
                        one => vec![one.clone()],
                    };
                    for (n, m) in numbers(value).iter().zip(numbers(&less[name])) {
                        let (ParamValue::Int(n), ParamValue::Int(m)) = (n, m) else {
                            panic!("{node}.{name}")
                        };
                        assert!(m <= *n && (m == *n || m >= rule.least), "{node}.{name}: {n} to {m}");
                    }
                }
            }
        }
        assert!(fewer > 10, "{fewer}");
    }
}
