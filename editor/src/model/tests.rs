//! Properties of changes to documents.

use std::collections::{BTreeMap, BTreeSet};

use breccia_engine::{Arity, Document, Graph, Link, NodeEntry, NodeMode, ParamValue, Registry};

use super::*;

mod groups;

fn registry() -> Registry {
    breccia_nodes::registry()
}

fn preset(name: &str) -> State {
    let preset = breccia_graphs::preset(name).expect("a preset");
    State::new(Document::parse(preset.ron).expect("a document"))
}

fn root() -> Address {
    Address::default()
}

fn link(text: &str) -> Link {
    Link::parse(text).expect("a link")
}

fn shapes(state: &State, at: &Address) -> BTreeMap<String, Shape> {
    let registry = registry();
    let level = state.level(at).expect("a graph");
    let shape = |(name, entry): (&String, &NodeEntry)| {
        (name.clone(), shape_of(&state.document, &registry, at, name, entry))
    };
    level.nodes.iter().map(shape).collect()
}

fn names(names: &[&str]) -> BTreeSet<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

#[test]
fn a_layout_is_written_and_read_back() {
    let mut state = preset("lazy_mesh");
    arrange_missing(&mut state, &root(), &|_| [184, 120]);
    set_collapsed(&mut state, &root(), &names(&["slab"]), true);
    bend(&mut state, &root(), "slab.initial -> jitter.initial", vec![[3, -4]]);
    add_frame(&mut state, &root(), Frame { at: [-1, 2], size: [300, 200], title: "all \"of\" it".into() });
    let text = text_of(&state);
    let read = State::new(Document::parse(&text).expect("what was written"));
    assert_eq!(read, state);
    assert_eq!(text_of(&read), text);
}

#[test]
fn what_other_editors_keep_in_a_document_stays() {
    let text = r#"(format: "breccia-graph", version: 1, nodes: {}, editor: {"zoom": 2, "layouts": {"": {"nodes": {"a": {"at": [1, 2]}}}, "bad": 7}})"#;
    let state = State::new(Document::parse(text).expect("a document"));
    assert_eq!(state.layouts[""].nodes["a"].at, [1, 2]);
    assert!(text_of(&state).contains("\"zoom\": 2"));
}

#[test]
fn undo_goes_back_byte_for_byte_and_redo_forward() {
    let mut project = Project::new(preset("hybrid_mesh"), None, None);
    let first = text_of(project.state());
    let at = root();
    project.edit("Add", None, |state| add_node(state, &at, NodeEntry::new("solid.checker"), [5, 6]));
    project.edit("Delete", None, |state| delete(state, &at, &names(&["fill", "synthesis"])));
    project.edit("Rename", None, |state| rename(state, &at, "pack", "packing"));
    project.edit("Mute", None, |state| set_mode(state, &at, &names(&["repel"]), NodeMode::Mute));
    let last = text_of(project.state());
    assert!(project.is_dirty());
    while project.undo().is_some() {}
    assert_eq!(text_of(project.state()), first);
    assert!(!project.is_dirty(), "the saved state is reached again");
    while project.redo().is_some() {}
    assert_eq!(text_of(project.state()), last);
}

#[test]
fn a_drag_is_one_step() {
    let mut project = Project::new(preset("lazy_mesh"), None, None);
    let at = root();
    project.settle(|state| arrange_missing(state, &at, &|_| [184, 120]));
    let first = text_of(project.state());
    for _ in 0..50 {
        project.edit("Move", Some("move"), |state| {
            move_by(state, &at, &names(&["slab"]), &BTreeSet::new(), [1, 0])
        });
    }
    project.seal();
    project
        .edit("Move", Some("move"), |state| move_by(state, &at, &names(&["slab"]), &BTreeSet::new(), [1, 0]));
    project.undo();
    project.undo();
    assert_eq!(text_of(project.state()), first);
    assert!(project.undo().is_none());
}

#[test]
fn a_link_takes_the_place_of_another_unless_the_socket_takes_many() {
    let mut state = State::default();
    for ty in ["solid.constant", "solid.checker", "solid.to_volume"] {
        add_node(&mut state, &root(), NodeEntry::new(ty), [0, 0]);
    }
    connect(&mut state, &root(), &link("constant.solid -> to_volume.solid"), Arity::One).expect("a link");
    connect(&mut state, &root(), &link("checker.solid -> to_volume.solid"), Arity::One).expect("a link");
    assert_eq!(state.document.links, ["checker.solid -> to_volume.solid"]);
    connect(&mut state, &root(), &link("constant.solid -> to_volume.solid"), Arity::Many).expect("a link");
    assert_eq!(state.document.links.len(), 2);
}

#[test]
fn a_link_that_closes_a_circle_is_refused() {
    let mut state = State::default();
    state.document.nodes = ["a", "b", "c"].map(|name| (name.to_owned(), NodeEntry::new("x.y"))).into();
    connect(&mut state, &root(), &link("a.o -> b.i"), Arity::One).expect("a link");
    connect(&mut state, &root(), &link("b.o -> c.i"), Arity::One).expect("a link");
    let before = state.clone();
    assert!(connect(&mut state, &root(), &link("c.o -> a.i"), Arity::One).is_err());
    assert!(connect(&mut state, &root(), &link("a.o -> a.i"), Arity::One).is_err());
    assert_eq!(state, before);
}

#[test]
fn types_that_do_not_fit_are_refused_with_what_converts_them() {
    let registry = registry();
    let socket =
        |ty: &str| Socket { name: "s".into(), ty: ty.into(), arity: Arity::One, docs: String::new() };
    assert!(compatible(&registry, &socket("mesh"), &socket("mesh")).is_ok());
    let refusal = compatible(&registry, &socket("volume"), &socket("solid")).expect_err("different types");
    assert!(refusal.reason.contains("volume") && refusal.reason.contains("solid"));
    assert!(
        refusal.conversions.iter().any(|(ty, ..)| ty == "solid.from_volume"),
        "{:?}",
        refusal.conversions
    );
}

#[test]
fn renaming_reaches_links_and_the_interface() {
    let registry = registry();
    let mut state = preset("lazy_mesh");
    arrange_missing(&mut state, &root(), &|_| [184, 120]);
    assert_eq!(
        rename(&mut state, &root(), "bake", "picture").as_deref(),
        Some("picture_2"),
        "taken names give way"
    );
    rename(&mut state, &root(), "photo", "stones");
    assert!(Graph::new(&state.to_document(), &registry).is_ok());
    assert_eq!(state.document.interface.outputs["mesh"].node, "picture_2");
    assert_eq!(state.document.interface.inputs["exemplar"].node, "stones");
    assert!(state.layouts[""].nodes.contains_key("stones"));
}

#[test]
fn deleting_leaves_no_word_of_a_node() {
    let mut state = preset("lazy_mesh");
    delete(&mut state, &root(), &names(&["bake"]));
    // Docs may speak of baking.
    let (links, interface) = (&state.document.links, &state.document.interface);
    assert!(!links.iter().any(|link| link.contains("bake.")), "{links:?}");
    assert!(!interface.outputs.values().any(|output| output.node == "bake"), "{interface:?}");
    assert!(
        !interface.params.values().flat_map(|param| &param.targets).any(|t| t.starts_with("bake.")),
        "{interface:?}"
    );
}

#[test]
fn copies_are_linked_as_the_originals_were() {
    let mut state = preset("lazy_mesh");
    let parts = |list: &[&str]| Parts { nodes: names(list), ..Parts::default() };
    let text = copy(&state, &root(), &parts(&["slab", "jitter"])).expect("nodes");
    let pasted = paste(&mut state, &root(), &text, [0, 0]).expect("nodes");
    assert_eq!(pasted, parts(&["slab_2", "jitter_2"]));
    assert!(state.document.links.contains(&"slab_2.initial -> jitter_2.initial".to_owned()));
    assert!(!state.document.links.iter().any(|link| link.ends_with("slab_2.pyramid")));
    let doubled = duplicate(&mut state, &root(), &parts(&["slab"]), [30, 30]);
    assert_eq!(doubled, Ok(parts(&["slab_3"])));
    assert!(state.document.links.contains(&"pyramid.pyramid -> slab_3.pyramid".to_owned()));
}

#[test]
fn bends_and_frames_are_copied_with_the_nodes() {
    let mut state = preset("lazy_mesh");
    let at = root();
    arrange_missing(&mut state, &at, &|_| [184, 120]);
    let link = "slab.initial -> jitter.initial";
    bend(&mut state, &at, link, vec![[500, 40], [520, -8]]);
    bend(&mut state, &at, "pyramid.pyramid -> slab.pyramid", vec![[1, 2]]);
    let frame = Frame { at: [-100, -50], size: [900, 400], title: "Start".into() };
    let id = add_frame(&mut state, &at, frame.clone());
    let parts = Parts { nodes: names(&["slab", "jitter"]), frames: [id].into() };
    let before = state.layout(&at).cloned().expect("a layout");
    let made = duplicate(&mut state, &at, &parts, [30, 20]).expect("copies");
    let after = state.layout(&at).cloned().expect("a layout");
    let shift = |[x, y]: [i32; 2]| [x + 30, y + 20];
    for (old, new) in [("slab", "slab_2"), ("jitter", "jitter_2")] {
        assert_eq!(after.nodes[new].at, shift(before.nodes[old].at));
    }
    assert_eq!(after.bends["slab_2.initial -> jitter_2.initial"], [[530, 60], [550, 12]]);
    assert_eq!(after.bends.len(), 3, "the bends of links from elsewhere stay with the originals");
    let new = made.frames.first().expect("a frame");
    assert_eq!(after.frames[new], Frame { at: shift(frame.at), ..frame });
    assert_ne!(*new, id);
    // Frames alone can be copied, and come back from text.
    let text = copy(&state, &at, &Parts { frames: [id].into(), ..Parts::default() }).expect("a frame");
    let pasted = paste(&mut State::default(), &at, &text, [0, 0]);
    assert_eq!(pasted, Ok(Parts { frames: [0].into(), ..Parts::default() }));
    assert_eq!(copy(&state, &at, &Parts::default()), None);
}

#[test]
fn a_change_of_all_steps_leaves_their_names_and_what_they_did() {
    let mut project = Project::new(preset("lazy_mesh"), None, None);
    let at = root();
    let path = |state: &State| state.document.nodes["photo"].params.get("path").cloned();
    let text = |text: &str| ParamValue::Text(text.to_owned());
    let set = |state: &mut State, value: &str| {
        set_param(state, &root(), "photo", "path", Some(ParamValue::Text(value.to_owned())));
    };
    project.edit("One", None, |state| set(state, "a.png"));
    project.edit("Seed", None, |state| {
        set_param(state, &at, "jitter", "seed", Some(ParamValue::Int(5)));
    });
    project.edit("Two", None, |state| set(state, "b.png"));
    project.undo();
    // Every path is seen from elsewhere now.
    project.rewrite_files(|state| {
        if let Some(ParamValue::Text(path)) =
            state.document.nodes.get_mut("photo").unwrap().params.get_mut("path")
            && !path.contains(':')
        {
            *path = format!("../{path}");
        }
    });
    assert_eq!(path(project.state()), Some(text("../a.png")));
    assert_eq!(project.redo().as_deref(), Some("Two"));
    assert_eq!(path(project.state()), Some(text("../b.png")));
    assert_eq!(project.undo().as_deref(), Some("Two"));
    assert_eq!(path(project.state()), Some(text("../a.png")));
    assert_eq!(project.undo().as_deref(), Some("Seed"));
    assert_eq!(project.undo().as_deref(), Some("One"));
    assert_eq!(text_of(project.state()), text_of(&preset("lazy_mesh")));
}

#[test]
fn files_are_renamed_in_every_state_whatever_else_the_steps_do() {
    let (at, one) = (root(), |name: &str| names(&[name]));
    let mut first = preset("lazy_mesh");
    arrange_missing(&mut first, &at, &|_| [184, 120]);
    let mut project = Project::new(first, None, None);
    let links = project.state().document.links[..2].to_vec();
    let steps: [&dyn Fn(&mut State); 9] = [
        &|state| move_by(state, &at, &one("slab"), &BTreeSet::new(), [7, 0]),
        &|state| set_param(state, &at, "photo", "path", Some(ParamValue::Text("a.png".into()))),
        &|state| set_param(state, &at, "jitter", "seed", Some(ParamValue::Int(5))),
        &|state| delete(state, &at, &one("photo")),
        &|state| drop(add_node(state, &at, NodeEntry::new("io.read_image"), [5, 5])),
        &|state| set_param(state, &at, "read_image", "path", Some(ParamValue::Text("b.png".into()))),
        &|state| disconnect(state, &at, &links),
        &|state| drop(rename(state, &at, "read_image", "photograph")),
        &|state| move_by(state, &at, &one("photograph"), &BTreeSet::new(), [0, 9]),
    ];
    let mut states = vec![project.state().clone()];
    for step in steps {
        project.edit("Step", None, step);
        assert_ne!(Some(project.state()), states.last());
        states.push(project.state().clone());
    }
    (0..4).for_each(|_| drop(project.undo()));
    let registry = registry();
    let moved = |state: &mut State| {
        let rename = &mut |path: &str| Some(format!("../{path}"));
        state.document.change_paths(&registry, std::path::Path::new(""), rename);
    };
    states.iter_mut().for_each(moved);
    project.rewrite_files(moved);
    while project.redo().is_some() {}
    for expected in states.iter().rev() {
        assert_eq!(project.state(), expected);
        project.undo();
    }
}

#[test]
fn a_change_of_all_steps_keeps_places_that_are_no_step() {
    let mut project = Project::new(State::default(), None, None);
    let at = root();
    let node = |state: &mut State| {
        add_node(state, &root(), NodeEntry::new("solid.checker"), [5, 5]);
    };
    project.edit("Add", None, node);
    // All is replaced by a document without places, which are found as no step of their own.
    project.edit("Start", None, |state| *state = preset("lazy_mesh"));
    project.settle(|state| arrange_missing(state, &at, &|_| [184, 120]));
    let settled = project.state().clone();
    let both = |name: &str| names(&[name]);
    project.edit("Move", None, |state| move_by(state, &at, &both("slab"), &BTreeSet::new(), [7, 0]));
    project.edit("Move", None, |state| move_by(state, &at, &both("jitter"), &BTreeSet::new(), [0, 7]));
    let last = project.state().clone();
    project.rewrite_files(|_| ());
    project.undo();
    project.undo();
    assert_eq!(*project.state(), settled);
    project.redo();
    project.redo();
    assert_eq!(*project.state(), last);
}

#[test]
fn what_is_pasted_must_be_a_graph() {
    let mut state = State::default();
    assert!(paste(&mut state, &root(), "hello", [0, 0]).is_err());
    assert_eq!(state, State::default());
}

#[test]
fn exposing_and_linking_parameters() {
    let registry = registry();
    let mut state = preset("lazy_mesh");
    let at = root();
    assert_eq!(exposure(&state, &at, "photo", "path"), Some(Exposure::Input("exemplar".into())));
    let name = expose(&mut state, &at, "slab", "start", None, "Where it starts.").expect("a name");
    set_param(&mut state, &at, "slab", "start", Some(ParamValue::Text("random".into())));
    assert_eq!(state.document.nodes["slab"].params["start"], ParamValue::Text("random".into()));
    link_param(&mut state, &at, "candidates", "strips", "seed", &ParamValue::Int(1));
    set_param(&mut state, &at, "candidates", "strips", Some(ParamValue::Int(8)));
    assert_eq!(
        state.document.interface.params["seed"].default,
        Some(ParamValue::Int(8)),
        "linked parameters are one"
    );
    assert!(Graph::new(&state.to_document(), &registry).is_ok());
    unexpose(&mut state, &at, "slab", "start");
    assert!(!state.document.interface.params.contains_key(&name));
}

#[test]
fn nodes_are_laid_out_from_left_to_right_without_overlap() {
    for preset in breccia_graphs::presets() {
        let mut state = State::new(Document::parse(preset.ron).expect("a document"));
        let size = |_: &str| [184, 140];
        arrange_missing(&mut state, &root(), &size);
        let layout = &state.layouts[""];
        let places: Vec<_> = layout.nodes.values().map(|place| place.at).collect();
        for (i, a) in places.iter().enumerate() {
            for b in &places[i + 1..] {
                assert!(
                    (a[0] - b[0]).abs() >= 184 || (a[1] - b[1]).abs() >= 140,
                    "{}: {a:?} {b:?}",
                    preset.name
                );
            }
        }
        for link in state.document.links.iter().filter_map(|link| Link::parse(link)) {
            assert!(
                layout.nodes[&link.from_node].at[0] < layout.nodes[&link.to_node].at[0],
                "{}: {link}",
                preset.name
            );
        }
    }
}

#[test]
fn aligned_nodes_share_an_edge() {
    let mut state = preset("lazy_mesh");
    let size = |name: &str| [100 + name.len() as i32, 80];
    arrange_missing(&mut state, &root(), &size);
    let nodes = names(&["photo", "slab", "bake"]);
    align(&mut state, &root(), &nodes, Alignment::Right, &size);
    let edges: BTreeSet<i32> = nodes.iter().map(|n| state.layouts[""].nodes[n].at[0] + size(n)[0]).collect();
    assert_eq!(edges.len(), 1);
}

#[test]
fn unknown_nodes_are_placeholders_with_the_sockets_that_links_name() {
    let text = r#"(format: "breccia-graph", version: 2, nodes: {"a": (type: "future.node", params: {"x": 1}), "b": (type: "solid.to_volume")}, links: ["a.stuff -> b.solid"])"#;
    let state = State::new(Document::parse(text).expect("a document"));
    let shapes = shapes(&state, &root());
    assert!(!shapes["a"].known);
    assert!(shapes["a"].output("stuff").is_some());
}
