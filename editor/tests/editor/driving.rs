//! Working with the editor by the names of its controls.

use breccia_editor::action::{Action, Pin};
use breccia_editor::command::Command;
use breccia_editor::model::text_of;
use breccia_editor::run::Fit;
use breccia_nodes::data::Filter;
use eframe::egui::{Key, Modifiers};
use egui_kittest::SnapshotOptions;
use egui_kittest::kittest::{NodeT as _, Queryable};

use super::window::{Desk, command, has_adapter, open};

/// Finds a node type by a word and adds it.
fn add(desk: &mut Desk, word: &str) {
    desk.harness.key_press(Key::Tab);
    desk.frames(3);
    desk.harness.get_by_label("Search").type_text(word);
    desk.frames(3);
    desk.harness.key_press(Key::Enter);
    desk.frames(3);
}

#[test]
fn nodes_are_added_wired_edited_run_undone_saved_and_opened_again() {
    let mut desk = open(None, false);
    desk.harness.key_press(Key::Escape);
    desk.frames(3);
    add(&mut desk, "solid.checker");
    add(&mut desk, "solid.to_volume");
    assert_eq!(
        desk.app().project().state().document.nodes.keys().collect::<Vec<_>>(),
        ["checker", "to_volume"]
    );

    command(&mut desk, Command::SelectAll);
    command(&mut desk, Command::Arrange);
    command(&mut desk, Command::Connect);
    assert_eq!(desk.app().project().state().document.links, ["checker.solid -> to_volume.solid"]);

    // A number, by the name of its control.
    desk.harness.get_by_label_contains("Node checker").click();
    desk.frames(3);
    let field = desk.harness.get_by_label("checker.noise");
    field.focus();
    desk.frames(2);
    desk.harness.key_press(Key::ArrowRight);
    desk.frames(2);
    let noise = |desk: &mut Desk| {
        desk.app().project().state().document.nodes["checker"].params.get("noise").map(ToString::to_string)
    };
    assert_eq!(noise(&mut desk).as_deref(), Some("11"));

    let pin = Pin { node: "to_volume".into(), socket: "volume".into(), output: true };
    let ctx = desk.harness.ctx.clone();
    desk.app().act(Action::Watch(pin.clone()), &ctx);
    desk.app().act(Action::Output(pin), &ctx);
    desk.wait();
    let value = desk.app().results().get("to_volume.volume").expect("a result").clone();
    assert!(!value.stale);
    assert!(value.value.summary().contains("64"), "{}", value.value.summary());

    let path = desk.folder.path().join("made.ron");
    desk.answers.borrow_mut().push_back(path.clone());
    desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    desk.frames(4);
    assert!(!desk.app().project().is_dirty());
    let saved = std::fs::read_to_string(&path).expect("a saved graph");
    assert_eq!(saved, text_of(desk.app().project().state()));

    for _ in 0..20 {
        desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        desk.frames(1);
    }
    assert!(desk.app().project().state().document.nodes.is_empty(), "everything is undone");
    assert!(desk.app().project().is_dirty());

    let mut again = open(path.to_str(), false);
    again.frames(2);
    assert_eq!(text_of(again.app().project().state()), saved);
}

#[test]
fn every_control_has_a_name() {
    let mut desk = open(Some("lazy_mesh"), false);
    command(&mut desk, Command::Live);
    command(&mut desk, Command::Stop);
    command(&mut desk, Command::FitAll);
    for selected in [None, Some("synthesis"), Some("photo"), Some("bake")] {
        command(&mut desk, Command::SelectNone);
        if let Some(node) = selected {
            desk.harness.get_by_label_contains(&format!("Node {node},")).click();
        }
        desk.frames(3);
        let mut nameless = Vec::new();
        let mut open: Vec<_> = desk.harness.root().children().collect();
        while let Some(node) = open.pop() {
            let about = node.accesskit_node();
            let name = about.label().or_else(|| about.value());
            let role = format!("{:?}", about.role());
            let controls = [
                "Button",
                "CheckBox",
                "ComboBox",
                "ColorWell",
                "Link",
                "RadioButton",
                "Slider",
                "SpinButton",
                "TextInput",
            ];
            let is_control = controls.contains(&role.as_str());
            if is_control && name.is_none_or(|name| name.trim().is_empty()) && !about.is_disabled() {
                nameless.push(format!("{role} at {:?}", about.bounding_box()));
            }
            open.extend(node.children());
        }
        assert!(nameless.is_empty(), "{selected:?}: {nameless:#?}");
    }
}

#[test]
fn a_wrong_type_is_refused_and_says_why() {
    let mut desk = open(None, false);
    desk.harness.key_press(Key::Escape);
    desk.frames(2);
    add(&mut desk, "mesh.read");
    add(&mut desk, "solid.to_volume");
    let ctx = desk.harness.ctx.clone();
    let from = Pin { node: "read".into(), socket: "mesh".into(), output: true };
    let to = Pin { node: "to_volume".into(), socket: "solid".into(), output: false };
    desk.app().act(Action::Connect(from, to), &ctx);
    assert!(desk.app().project().state().document.links.is_empty());
    let said = desk.app().said().unwrap_or_default().to_owned();
    assert!(said.contains("mesh") && said.contains("solid"), "{said}");
}

#[test]
fn one_change_computes_only_what_hangs_on_it_and_marks_the_rest_stale() {
    let mut desk = open(Some("cut_mesh"), false);
    command(&mut desk, Command::Live);
    command(&mut desk, Command::Stop);
    let ctx = desk.harness.ctx.clone();
    let document = r#"(format: "breccia-graph", version: 2,
        interface: (outputs: {"volume": (node: "volume", socket: "volume")}),
        nodes: {"checker": (type: "solid.checker"), "volume": (type: "solid.to_volume", params: {"size": [16]}), "cut": (type: "render.cube", params: {"size": [16], "picture": [64]})},
        links: ["checker.solid -> volume.solid", "checker.solid -> cut.solid"])"#;
    let path = desk.folder.path().join("two.ron");
    std::fs::write(&path, document).expect("a file");
    desk.app().open_path(&path);
    desk.app().act(Action::Watch(Pin { node: "volume".into(), socket: "volume".into(), output: true }), &ctx);
    command(&mut desk, Command::Live);
    desk.wait();
    assert_eq!(desk.app().board().get("volume").map(|s| s.phase), Some(breccia_editor::run::Phase::Done));
    assert!(desk.app().board().get("cut").is_none(), "nobody looks at it");
    let set = |value| Action::Set {
        node: "volume".into(),
        param: "size".into(),
        value: Some(value),
        dragging: false,
    };
    desk.app().act(set(breccia_engine::ParamValue::Int(24)), &ctx);
    assert!(desk.app().results()["volume.volume"].stale, "the last good result stays, marked");
    desk.wait();
    assert!(!desk.app().results()["volume.volume"].stale);
    assert!(matches!(
        desk.app().board().get("checker").map(|s| s.phase),
        Some(breccia_editor::run::Phase::Cached(_))
    ));
}

#[test]
fn the_solid_in_a_baked_mesh_comes_with_it_as_it_was_baked() {
    let mut desk = open(None, false);
    let document = r#"(format: "breccia-graph", version: 2,
        nodes: {"shape": (type: "mesh.read", params: {"path": "builtin:spot/spot.glb"}), "checker": (type: "solid.checker"),
            "bake": (type: "mesh.bake", params: {"resolution": 24, "texture_size": 64, "origin": [1, -2, 3]}), "cut": (type: "mesh.cut")},
        links: ["shape.mesh -> bake.mesh", "checker.solid -> bake.solid", "bake.mesh -> cut.mesh"])"#;
    let path = desk.folder.path().join("baked.ron");
    std::fs::write(&path, document).expect("a file");
    desk.app().open_path(&path);
    let ctx = desk.harness.ctx.clone();
    let fit = Fit { resolution: 24, origin: [1, -2, 3], filter: Filter::Trilinear };
    for (node, socket, with) in
        [("bake", "mesh", true), ("cut", "below", true), ("shape", "mesh", false), ("checker", "solid", true)]
    {
        let pin = Pin { node: node.into(), socket: socket.into(), output: true };
        desk.app().act(Action::Watch(pin), &ctx);
        desk.wait();
        let results = desk.app().results();
        assert_eq!(results[&format!("{node}.{socket}")].fit, with.then_some(fit), "{node}");
        assert_eq!(results.contains_key("checker.solid"), with, "{node}");
    }
    // Until the mesh is baked anew, the old one keeps what it was baked with.
    desk.app().act(Action::Watch(Pin { node: "bake".into(), socket: "mesh".into(), output: true }), &ctx);
    desk.wait();
    let value = Some(breccia_engine::ParamValue::Int(48));
    let (node, param) = ("bake".into(), "resolution".into());
    desk.app().act(Action::Set { node, param, value, dragging: false }, &ctx);
    assert_eq!(desk.app().results()["bake.mesh"].fit, Some(fit));
    desk.wait();
    assert_eq!(desk.app().results()["bake.mesh"].fit, Some(Fit { resolution: 48, ..fit }));
}

#[test]
fn an_error_names_the_node_and_the_rest_runs() {
    let mut desk = open(None, false);
    let document = r#"(format: "breccia-graph", version: 2,
        nodes: {"checker": (type: "solid.checker"), "volume": (type: "solid.to_volume", params: {"size": [16]}), "bad": (type: "mesh.bake"), "lost": (type: "future.node")},
        links: ["checker.solid -> volume.solid"])"#;
    let path = desk.folder.path().join("bad.ron");
    std::fs::write(&path, document).expect("a file");
    desk.app().open_path(&path);
    let ctx = desk.harness.ctx.clone();
    desk.app().act(Action::Watch(Pin { node: "volume".into(), socket: "volume".into(), output: true }), &ctx);
    desk.wait();
    assert!(desk.app().results().contains_key("volume.volume"));
    desk.harness.get_by_label_contains("problems").click();
    desk.frames(3);
    let shows: Vec<_> = desk.harness.query_all_by_label("Show bad").collect();
    shows.first().expect("a problem of the node").click_accesskit();
    drop(shows);
    desk.frames(3);
    assert_eq!(desk.app().selection().single().map(String::as_str), Some("bad"));
    desk.app().save_to(&path);
    let text = std::fs::read_to_string(&path).expect("a file");
    assert!(text.contains("future.node"), "a node of an unknown type is written back");
}

#[test]
fn a_group_is_entered_and_left() {
    let mut desk = open(Some("optimize_volume"), false);
    command(&mut desk, Command::Live);
    command(&mut desk, Command::Stop);
    let ctx = desk.harness.ctx.clone();
    desk.app().act(Action::Enter("levels".into()), &ctx);
    desk.frames(3);
    assert_eq!(desk.app().trail().0.len(), 1);
    assert!(desk.harness.query_by_label_contains("Node refine,").is_some());
    desk.app().act(Action::Enter("refine".into()), &ctx);
    desk.frames(3);
    assert!(desk.harness.query_by_label_contains("Node search,").is_some());
    desk.harness.get_by_label("Graph").click();
    desk.frames(3);
    assert!(desk.app().trail().0.is_empty());
}

#[test]
fn a_dropped_picture_becomes_the_exemplar_and_takes_the_built_in_mask_away() {
    let mut desk = open(None, false);
    command(&mut desk, Command::Live);
    let path = desk.folder.path().join("photo.png");
    std::fs::write(&path, breccia_graphs::asset("granite/color_128.png").expect("an asset")).expect("a file");
    let ctx = desk.harness.ctx.clone();
    desk.app().take_file(&path, &ctx);
    desk.frames(2);
    let nodes = &desk.app().project().state().document.nodes;
    assert_eq!(nodes["photo"].params["path"].to_string(), format!("{:?}", path.to_str().expect("a path")));
    assert!(!nodes["mask_image"].params.contains_key("path"));
}

#[test]
fn what_is_not_saved_is_asked_for() {
    let mut desk = open(Some("lazy_slice"), false);
    command(&mut desk, Command::Live);
    command(&mut desk, Command::Stop);
    command(&mut desk, Command::SelectAll);
    command(&mut desk, Command::Delete);
    command(&mut desk, Command::New);
    assert!(desk.harness.query_by_label("Stay").is_some());
    desk.harness.get_by_label("Stay").click();
    desk.frames(2);
    assert_eq!(desk.app().project().name(), "lazy_slice");
    command(&mut desk, Command::New);
    desk.harness.get_by_label("Go on without saving").click();
    desk.frames(2);
    assert_eq!(desk.app().project().name(), "untitled");
}

#[test]
fn the_window_looks_as_it_did() {
    if !has_adapter() {
        return;
    }
    let mut desk = open(None, true);
    command(&mut desk, Command::SelectNone);
    // Nothing runs, so nothing tells times.
    command(&mut desk, Command::Live);
    let ctx = desk.harness.ctx.clone();
    desk.app().act(Action::OpenPreset("hybrid_mesh".into()), &ctx);
    command(&mut desk, Command::FitAll);
    command(&mut desk, Command::Viewport);
    desk.frames(6);
    // Drivers differ in the last bit of edges, fonts do not.
    let options = SnapshotOptions::new().threshold(1.0).max_failed_pixels(400);
    desk.harness.snapshot_options("hybrid_mesh", &options);
}

#[test]
fn a_save_that_fails_changes_nothing() {
    let mut desk = open(None, false);
    command(&mut desk, Command::Live);
    let path = desk.folder.path().join("plain.ron");
    let document = r#"(format: "breccia-graph", version: 2, nodes: {"photo": (type: "io.read_image", params: {"path": "stone.png"})}, links: [])"#;
    std::fs::write(&path, document).expect("a file");
    desk.app().open_path(&path);
    desk.frames(1);
    let before = text_of(desk.app().project().state());
    // A file is no folder.
    assert!(!desk.app().save_to(&path.join("inside.ron")));
    assert_eq!(text_of(desk.app().project().state()), before);
    assert!(!desk.app().project().is_dirty());
    // Elsewhere the same file is meant.
    let elsewhere = desk.folder.path().join("below/plain.ron");
    assert!(desk.app().save_to(&elsewhere));
    let saved = std::fs::read_to_string(&elsewhere).expect("a file");
    let whole = desk.folder.path().join("stone.png");
    assert!(saved.contains(&whole.display().to_string()), "{saved}");
    assert!(!desk.app().project().is_dirty());
}

#[test]
fn looking_at_a_value_out_of_range_leaves_it_alone() {
    let mut desk = open(None, false);
    command(&mut desk, Command::Live);
    command(&mut desk, Command::SelectNone);
    let path = desk.folder.path().join("odd.ron");
    let document = r#"(format: "breccia-graph", version: 2, nodes: {"checker": (type: "solid.checker", params: {"cell": 99999, "noise": -3, "first": (1, 2, 999)})}, links: [])"#;
    std::fs::write(&path, document).expect("a file");
    desk.app().open_path(&path);
    command(&mut desk, Command::SelectAll);
    desk.frames(5);
    assert!(!desk.app().project().is_dirty());
}

#[test]
fn what_is_open_is_open_again() {
    let mut desk = open(Some("lazy_slice"), false);
    for toggled in [Command::Live, Command::Inspector, Command::Legend] {
        command(&mut desk, toggled);
    }
    let habits = desk.app().habits();
    let mut again = open(Some("lazy_slice"), false);
    assert_ne!(again.app().habits(), habits);
    again.app().set_habits(&habits);
    again.frames(2);
    assert_eq!(again.app().habits(), habits);
}
