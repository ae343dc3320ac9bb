//! How long the editor takes for what it does in every frame and after every change.

use breccia_editor::model::{Address, Project, State, arrange, move_by, text_of};
use breccia_editor::run::check;
use breccia_engine::{Document, NodeEntry};

fn main() {
    divan::main();
}

/// A graph of many nodes.
fn many(count: usize) -> State {
    let mut document = Document::default();
    for i in 0..count {
        let ty =
            ["solid.checker", "solid.to_volume", "solid.from_volume", "solid.to_volume", "solid.from_volume"]
                [i % 5];
        document.nodes.insert(format!("node_{i:04}"), NodeEntry::new(ty));
        if i % 5 > 0 {
            let socket = if i % 5 % 2 == 1 { "solid" } else { "volume" };
            document.links.push(format!("node_{:04}.{socket} -> node_{i:04}.{socket}", i - 1));
        }
    }
    State::new(document)
}

#[divan::bench(args = [100, 500])]
fn looking_a_document_over(bencher: divan::Bencher<'_, '_>, nodes: usize) {
    let (state, registry) = (many(nodes), breccia_nodes::registry());
    let files = breccia_graphs::Sources::default();
    bencher.bench(|| check(&state.document, &registry, None, &files));
}

#[divan::bench(args = [100, 500])]
fn one_step_of_a_drag(bencher: divan::Bencher<'_, '_>, nodes: usize) {
    let mut project = Project::new(many(nodes), None, None);
    let one = ["node_0001".to_owned()].into();
    bencher.bench_local(|| {
        project.edit("Move", Some("move"), |state| {
            move_by(state, &Address::default(), &one, &Default::default(), [1, 0])
        });
    });
}

#[divan::bench(args = [100, 500])]
fn laying_out(bencher: divan::Bencher<'_, '_>, nodes: usize) {
    let state = many(nodes);
    let all = state.document.nodes.keys().cloned().collect();
    bencher.with_inputs(|| state.clone()).bench_values(|mut state| {
        arrange(&mut state, &Address::default(), &all, &|_| [184, 120]);
        state
    });
}

#[divan::bench(args = [100, 500])]
fn writing(bencher: divan::Bencher<'_, '_>, nodes: usize) {
    let state = many(nodes);
    bencher.bench(|| text_of(&state));
}
