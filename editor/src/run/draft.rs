//! A coarser graph for the time while something is dragged.

use std::collections::BTreeSet;

use breccia_engine::{Draft, Graph, ParamValue};

use crate::model::reach;

/// The graph with those numbers divided that nodes say may be coarser in a draft: of nodes that differ from those in the graph that was
/// computed in full last, and of those that hang on them. All others have their results already, which a draft would throw away.
pub fn draft(graph: &Graph, last: Option<&Graph>) -> Graph {
    let touched = last.map(|last| touched(graph, last));
    let mut coarse = graph.clone();
    let mut changes = Vec::new();
    for (node, spec) in graph.nodes() {
        if touched.as_ref().is_some_and(|touched| !touched.contains(node)) {
            continue;
        }
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

/// The nodes whose parameters differ, and all that need them.
fn touched<'a>(graph: &'a Graph, last: &Graph) -> BTreeSet<&'a str> {
    let nodes = graph.nodes().map(|(node, _)| node);
    let differ = nodes.filter(|node| graph.node_params(node) != last.node_params(node));
    reach(differ, |node| graph.consumers(node)).into_iter().collect()
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
            let coarse = draft(&graph, None);
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

    #[test]
    fn only_what_hangs_on_a_change_is_coarser() {
        let registry = breccia_nodes::registry();
        let document = Document::parse(breccia_graphs::preset("lazy_mesh").unwrap().ron).unwrap();
        let last = Graph::new(&document, &registry).unwrap();
        let int = |graph: &Graph, node: &str, param: &str| graph.node_params(node).unwrap()[param].clone();
        let both = |graph: &Graph| (int(graph, "usage", "size"), int(graph, "bake", "texture_size"));
        let (size, texels) = both(&last);
        assert_eq!(both(&draft(&last, Some(&last))), (size.clone(), texels.clone()), "nothing changed");
        let mut graph = last.clone();
        graph.set_node_param("synthesis", "seed", &ParamValue::Int(7)).unwrap();
        let (downstream, coarser) = both(&draft(&graph, Some(&last)));
        assert!(downstream == size && coarser != texels);
        let mut graph = last.clone();
        graph.set_node_param("usage", "rounds", &ParamValue::Int(2)).unwrap();
        let (own, coarser) = both(&draft(&graph, Some(&last)));
        assert!(own != size && coarser != texels);
    }
}
