//! What is wrong with a document, and what of it can run all the same.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use breccia_engine::{Document, FileSource, Graph, Link, Problem, Problems, Registry};

use super::Bakes;

/// How often nodes with problems are taken away before giving up.
const ROUNDS: usize = 8;

/// A document that has been looked over.
pub struct Checked {
    /// The document with the groups that stand in files.
    pub included: Arc<Document>,
    /// What is wrong with a group's file.
    pub include_error: Option<String>,
    /// All that is wrong.
    pub problems: Vec<Problem>,
    /// The nodes of the document that cannot run: those with problems, and those that need them.
    pub broken: BTreeSet<String>,
    /// What can run.
    pub graph: Option<Arc<Graph>>,
    /// What is baked in it.
    pub bakes: Arc<Bakes>,
    /// For each node of the document those that it needs.
    pub needs: BTreeMap<String, BTreeSet<String>>,
}

/// Looks over a document. One node that is not wired yet must not keep the others from running, so nodes with problems are
/// left out, and those that need them.
pub fn check(
    document: &Document,
    registry: &Registry,
    folder: Option<&Path>,
    files: &dyn FileSource,
) -> Checked {
    let mut included = document.clone();
    let folder = folder.unwrap_or(Path::new(""));
    let include_error = included.include(folder, files).err().map(|error| error.to_string());
    let included = Arc::new(included);
    let mut checked = Checked {
        included: Arc::clone(&included),
        include_error,
        problems: Vec::new(),
        broken: BTreeSet::new(),
        graph: None,
        bakes: Arc::default(),
        needs: BTreeMap::new(),
    };
    for link in included.links.iter().filter_map(|link| Link::parse(link)) {
        checked.needs.entry(link.to_node).or_default().insert(link.from_node);
    }
    let mut part = (*included).clone();
    part.editor = ron::Value::Unit;
    for round in 0..ROUNDS {
        match Graph::with_folder(&part, registry, folder) {
            Ok(graph) => {
                checked.bakes = Arc::new(Bakes::of(&graph));
                checked.graph = Some(Arc::new(graph));
                break;
            }
            Err(Problems(problems)) => {
                let bad = culprits(&part, &problems);
                if round == 0 {
                    checked.problems = problems;
                }
                let gone = with_descendants(&part, bad);
                // Problems of the interface alone: it goes, the nodes stay.
                if gone.is_empty() {
                    part.interface = breccia_engine::Interface::default();
                }
                remove(&mut part, &gone);
                checked.broken.extend(gone);
            }
        }
    }
    checked
}

/// The document's own nodes that problems are at.
fn culprits(document: &Document, problems: &[Problem]) -> BTreeSet<String> {
    let own = |path: &str| path.split(['/', '[']).next().unwrap_or_default().to_owned();
    let named = problems.iter().filter_map(|problem| Some(own(problem.node.as_deref()?)));
    let mut found: BTreeSet<String> = named.filter(|node| document.nodes.contains_key(node)).collect();
    // Where a problem names no node it may be about a link or a group: whatever it quotes.
    for problem in problems.iter().filter(|problem| problem.node.is_none()) {
        let quoted = |text: &str| text.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>();
        for text in quoted(&problem.item).into_iter().chain(quoted(&problem.found)) {
            if let Some(link) = Link::parse(&text) {
                found.extend([link.to_node].into_iter().filter(|node| document.nodes.contains_key(node)));
            } else if document.nodes.contains_key(&text) && !problem.item.starts_with("output") {
                found.insert(text);
            }
        }
    }
    found
}

fn with_descendants(document: &Document, nodes: BTreeSet<String>) -> BTreeSet<String> {
    let mut next: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for link in document.links.iter().filter_map(|link| Link::parse(link)) {
        next.entry(link.from_node).or_default().push(link.to_node);
    }
    let (mut all, mut open) = (BTreeSet::new(), Vec::from_iter(nodes));
    while let Some(node) = open.pop() {
        if all.insert(node.clone()) {
            open.extend(next.get(&node).into_iter().flatten().cloned());
        }
    }
    all
}

fn remove(document: &mut Document, gone: &BTreeSet<String>) {
    document.nodes.retain(|name, _| !gone.contains(name));
    let nodes = &document.nodes;
    let there = |node: &str| nodes.contains_key(node);
    document
        .links
        .retain(|link| Link::parse(link).is_some_and(|link| there(&link.from_node) && there(&link.to_node)));
    let target = |target: &String| target.split_once('.').is_some_and(|(node, _)| there(node));
    let interface = &mut document.interface;
    interface.outputs.retain(|_, output| there(&output.node));
    interface.params.values_mut().for_each(|param| param.targets.retain(target));
    interface.params.retain(|_, param| !param.targets.is_empty());
    interface.inputs.values_mut().for_each(|input| input.targets.retain(target));
    interface.inputs.retain(|_, input| there(&input.node) || !input.targets.is_empty());
}
