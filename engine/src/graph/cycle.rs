//! Finding a loop that can be named.

use petgraph::algo::tarjan_scc;
use petgraph::graph::{DiGraph, NodeIndex};

/// For every set of nodes that wait for each other, one loop in it, from its first node on.
pub(super) fn loops(topology: &DiGraph<usize, ()>) -> Vec<Vec<usize>> {
    let mut found: Vec<Vec<usize>> = tarjan_scc(topology)
        .into_iter()
        .filter(|part| part.len() > 1 || part.iter().any(|&n| topology.contains_edge(n, n)))
        .map(|part| shortest_loop(topology, &part))
        .collect();
    found.sort();
    found
}

/// The shortest loop through the first node of a strongly connected part, by breadth-first search.
fn shortest_loop(topology: &DiGraph<usize, ()>, part: &[NodeIndex]) -> Vec<usize> {
    let Some(&start) = part.iter().min() else { return Vec::new() };
    let mut came_from = vec![None; topology.node_count()];
    let mut queue = std::collections::VecDeque::from([start]);
    while let Some(node) = queue.pop_front() {
        let mut next: Vec<_> = topology.neighbors(node).filter(|n| part.contains(n)).collect();
        next.sort_unstable();
        for n in next {
            if n == start {
                let mut path = vec![node.index()];
                let mut at = node;
                while let Some(Some(previous)) = came_from.get(at.index()).copied() {
                    at = previous;
                    path.push(at.index());
                }
                path.reverse();
                return path;
            }
            if came_from[n.index()].is_none() {
                came_from[n.index()] = Some(node);
                queue.push_back(n);
            }
        }
    }
    vec![start.index()]
}
