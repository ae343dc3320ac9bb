//! Several nodes as one, and back.

use super::*;

/// The keys of a graph's nodes hang on types, parameters and links alone: graphs that give the same keep their plans.
fn same_results(a: &State, b: &State) {
    let registry = registry();
    let run = |state: &State| {
        let graph = Graph::new(&state.to_document(), &registry).expect("a valid graph");
        let engine =
            breccia_engine::Engine::builder().threads(1).build(registry.clone().into()).expect("an engine");
        let graph = std::sync::Arc::new(graph);
        let result =
            engine.run(&graph, &["volume"], &breccia_engine::CancelToken::default(), &|_| {}).expect("a run");
        assert!(result.failures.is_empty(), "{:?}", result.failures);
        result.outputs["volume"].digest()
    };
    assert_eq!(run(a), run(b));
}

fn checkers() -> State {
    let text = r#"(format: "breccia-graph", version: 2,
        interface: (outputs: {"volume": (node: "volume", socket: "volume")}, params: {"size": (targets: ["volume.size"], default: 8)}),
        nodes: {"checker": (type: "solid.checker", params: {"cell": 3}), "volume": (type: "solid.to_volume"), "solid": (type: "solid.from_volume")},
        links: ["checker.solid -> volume.solid", "volume.volume -> solid.volume"])"#;
    State::new(Document::parse(text).expect("a document"))
}

#[test]
fn grouping_and_ungrouping_change_no_result() {
    let plain = checkers();
    let mut state = plain.clone();
    arrange_missing(&mut state, &root(), &|_| [184, 120]);
    let known = shapes(&state, &root());
    let made =
        group(&mut state, &root(), &names(&["checker", "volume"]), &|name| known.get(name).cloned(), &|_| {
            [184, 120]
        })
        .expect("a group");
    assert_eq!(state.document.nodes.len(), 2);
    let seen = shapes(&state, &root());
    assert_eq!(seen[&made].outputs.iter().map(|o| o.ty.as_str()).collect::<Vec<_>>(), ["volume"]);
    assert!(seen[&made].param("size").is_some(), "an exposed parameter goes through the group");
    same_results(&plain, &state);
    ungroup(&mut state, &root(), &made).expect("a group");
    assert!(state.document.groups.is_empty());
    assert_eq!(state.document.nodes.len(), 3);
    same_results(&plain, &state);
}

#[test]
fn bends_frames_and_what_is_off_go_into_a_group_and_come_back_where_it_was_moved() {
    let mut state = checkers();
    let at = root();
    arrange_missing(&mut state, &at, &|_| [184, 120]);
    let (within, across) = ("checker.solid -> volume.solid", "volume.volume -> solid.volume");
    bend(&mut state, &at, within, vec![[30, 40], [31, 41]]);
    bend(&mut state, &at, across, vec![[50, 60]]);
    let place = state.layouts[""].nodes["checker"].at;
    // It holds the middle of a node, not all of it.
    let around = Frame { at: [place[0] + 10, place[1] - 20], size: [100, 100], title: "around".into() };
    let elsewhere = Frame { at: [-9000, 0], size: [50, 50], title: "elsewhere".into() };
    add_frame(&mut state, &at, around.clone());
    add_frame(&mut state, &at, elsewhere.clone());
    let before = state.clone();
    let known = shapes(&state, &at);
    let made =
        group(&mut state, &at, &names(&["checker", "volume"]), &|name| known.get(name).cloned(), &|_| {
            [184, 120]
        })
        .expect("a group");
    let outer = &state.layouts[""];
    assert_eq!(outer.bends[&format!("{made}.volume -> solid.volume")], [[50, 60]]);
    assert_eq!(outer.frames.values().collect::<Vec<_>>(), [&elsewhere]);
    let body = state.layouts.values().find(|layout| layout.nodes.contains_key("checker")).expect("a body");
    assert_eq!(body.bends[within], [[30, 40], [31, 41]]);
    assert_eq!(body.frames.values().collect::<Vec<_>>(), [&around]);

    let mut back = state.clone();
    ungroup(&mut back, &at, &made).expect("a group");
    assert_eq!(back.layouts[""].nodes, before.layouts[""].nodes);
    assert_eq!(back.layouts[""].bends, before.layouts[""].bends);

    move_by(&mut state, &at, &names(&[&made]), &BTreeSet::new(), [70, -30]);
    set_mode(&mut state, &at, &names(&[&made]), NodeMode::Mute);
    ungroup(&mut state, &at, &made).expect("a group");
    let after = &state.layouts[""];
    assert_eq!(after.nodes["checker"].at, [place[0] + 70, place[1] - 30]);
    assert_eq!(after.bends[within], [[100, 10], [101, 11]]);
    assert!(after.frames.values().any(|frame| frame.at == [around.at[0] + 70, around.at[1] - 30]));
    let mode = |name: &str| state.document.nodes[name].mode;
    assert_eq!(
        [mode("checker"), mode("volume"), mode("solid")],
        [NodeMode::Mute, NodeMode::Mute, NodeMode::Normal]
    );
}

#[test]
fn a_bypassed_group_is_not_taken_apart() {
    let mut state = checkers();
    let known = shapes(&state, &root());
    let made =
        group(&mut state, &root(), &names(&["checker", "volume"]), &|name| known.get(name).cloned(), &|_| {
            [184, 120]
        })
        .expect("a group");
    set_mode(&mut state, &root(), &names(&[&made]), NodeMode::Bypass);
    let before = state.clone();
    assert!(ungroup(&mut state, &root(), &made).is_err());
    assert_eq!(state, before);
}

#[test]
fn what_lies_between_grouped_nodes_comes_along() {
    let mut state = checkers();
    let known = shapes(&state, &root());
    let made =
        group(&mut state, &root(), &names(&["checker", "solid"]), &|name| known.get(name).cloned(), &|_| {
            [184, 120]
        })
        .expect("a group");
    assert_eq!(state.document.nodes.keys().collect::<Vec<_>>(), [&made]);
    assert!(Graph::new(&state.to_document(), &registry()).is_ok());
}

#[test]
fn a_group_in_a_file_becomes_part_of_the_document() {
    let mut state = preset("optimize_volume");
    let mut included = state.document.clone();
    included.include(std::path::Path::new(""), &breccia_graphs::Sources::default()).expect("built-in groups");
    let at = root().within("level");
    assert!(state.foreign(&at).is_some());
    localise(&mut state, &included, &at).expect("a group");
    assert!(state.foreign(&at).is_none());
    let registry = registry();
    assert!(Graph::new(&state.to_document(), &registry).is_ok());
    let read = Document::parse(&text_of(&state)).expect("a document");
    assert!(read.groups["level"].groups.contains_key("iteration"));
}
