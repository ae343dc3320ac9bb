//! What is one step for the user is one for undo, and nothing that is looked at or asked goes away by itself.

use breccia_editor::action::{Action, Pin, Selection};
use breccia_editor::command::Command;
use breccia_editor::model::text_of;
use eframe::egui::{Event, Key, Modifiers, PointerButton, Pos2, vec2};
use egui_kittest::kittest::Queryable;

use super::window::{Desk, command, open};

/// A graph of three nodes, looked at its volume, with nothing running but what is asked for.
fn three(desk: &mut Desk) {
    let document = r#"(format: "breccia-graph", version: 2,
        nodes: {"checker": (type: "solid.checker"), "volume": (type: "solid.to_volume", params: {"size": [8]}), "other": (type: "solid.to_volume", params: {"size": [8]})},
        links: ["checker.solid -> volume.solid"])"#;
    let path = desk.folder.path().join("three.ron");
    std::fs::write(&path, document).expect("a file");
    desk.app().open_path(&path);
    // Nothing lies over the canvas.
    command(desk, Command::SelectNone);
    desk.frames(2);
}

fn button(pos: Pos2, pressed: bool) -> Event {
    Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
}

fn pin(node: &str, socket: &str, output: bool) -> Pin {
    Pin { node: node.into(), socket: socket.into(), output }
}

#[test]
fn a_link_that_is_put_elsewhere_is_one_step_and_stays_where_it_does_not_fit() {
    let mut desk = open(None, false);
    three(&mut desk);
    let ctx = desk.harness.ctx.clone();
    let link = "checker.solid -> volume.solid".to_owned();
    let (from, to) = (pin("checker", "solid", true), pin("other", "solid", false));
    desk.app().act(Action::Reconnect { link: link.clone(), from: from.clone(), to }, &ctx);
    assert_eq!(desk.app().project().state().document.links, ["checker.solid -> other.solid"]);
    command(&mut desk, Command::Undo);
    assert_eq!(desk.app().project().state().document.links, [link.as_str()]);
    assert!(!desk.app().project().is_dirty());

    let to = pin("volume", "volume", true);
    desk.app().act(Action::Reconnect { link: link.clone(), from, to }, &ctx);
    assert_eq!(desk.app().project().state().document.links, [link]);
    assert!(!desk.app().project().is_dirty());
}

#[test]
fn what_is_looked_at_stays_while_the_graph_cannot_run() {
    let mut desk = open(None, false);
    three(&mut desk);
    let ctx = desk.harness.ctx.clone();
    desk.app().act(Action::Watch(pin("volume", "volume", true)), &ctx);
    desk.wait();
    let before = desk.app().results()["volume.volume"].value.digest();
    desk.app().act(Action::Disconnect(vec!["checker.solid -> volume.solid".into()]), &ctx);
    desk.wait();
    assert_eq!(desk.app().watched(), Some("volume.volume"));
    let last = &desk.app().results()["volume.volume"];
    assert!(last.stale && last.value.digest() == before);
    command(&mut desk, Command::Undo);
    desk.wait();
    assert!(!desk.app().results()["volume.volume"].stale);
    // A node that is gone is not looked at any more.
    desk.app().act(Action::Select(Selection::node("volume")), &ctx);
    command(&mut desk, Command::Delete);
    desk.wait();
    assert_ne!(desk.app().watched(), Some("volume.volume"));
}

#[test]
fn a_drag_is_one_step_though_the_pointer_moves_as_the_button_is_let_go_of() {
    let mut desk = open(None, false);
    command(&mut desk, Command::Live);
    three(&mut desk);
    let ctx = desk.harness.ctx.clone();
    desk.app().act(Action::Select(Selection::node("checker")), &ctx);
    desk.frames(3);
    let before = text_of(desk.app().project().state());
    let at = desk.harness.get_by_label("checker.noise").rect().center();
    let moved = |by: f32| Event::PointerMoved(at + vec2(by, 0.0));
    desk.harness.event(moved(0.0));
    desk.harness.event(button(at, true));
    desk.harness.step();
    for by in [10.0, 20.0, 30.0] {
        desk.harness.event(moved(by));
        desk.harness.step();
    }
    let held = text_of(desk.app().project().state());
    assert_ne!(held, before);
    desk.harness.event(moved(55.0));
    desk.harness.event(button(at, false));
    desk.frames(3);
    assert_ne!(text_of(desk.app().project().state()), held, "the last move counts");
    command(&mut desk, Command::Undo);
    assert_eq!(text_of(desk.app().project().state()), before);
}

#[test]
fn a_drag_in_the_window_of_a_colour_is_one_step() {
    let mut desk = open(None, false);
    command(&mut desk, Command::Live);
    three(&mut desk);
    let ctx = desk.harness.ctx.clone();
    desk.app().act(Action::Select(Selection::node("checker")), &ctx);
    desk.frames(3);
    let before = text_of(desk.app().project().state());
    let swatch = desk.harness.get_by_label("checker.first as a colour");
    let at = swatch.rect().center();
    swatch.click();
    desk.frames(3);
    // The square of saturation and value lies in the window that the swatch opens.
    let from = at + vec2(-60.0, 120.0);
    desk.harness.event(Event::PointerMoved(from));
    desk.harness.event(button(from, true));
    desk.harness.step();
    for i in 1..8 {
        desk.harness.event(Event::PointerMoved(from + vec2(i as f32 * 5.0, i as f32 * 4.0)));
        desk.harness.step();
    }
    desk.harness.event(button(from, false));
    desk.frames(3);
    assert_ne!(text_of(desk.app().project().state()), before);
    command(&mut desk, Command::Undo);
    assert_eq!(text_of(desk.app().project().state()), before);
}

#[test]
fn questions_and_presets_are_answered_by_keys() {
    let mut desk = open(None, false);
    // The first steps lead to the presets, of which the first is ready to be opened.
    for _ in 0..2 {
        desk.frames(3);
        desk.harness.key_press(Key::Enter);
    }
    desk.frames(3);
    assert_eq!(desk.app().project().name(), breccia_graphs::presets()[0].name);
    command(&mut desk, Command::Live);
    command(&mut desk, Command::SelectAll);
    command(&mut desk, Command::Delete);
    command(&mut desk, Command::New);
    desk.harness.key_press(Key::Escape);
    desk.frames(3);
    assert!(desk.harness.query_by_label("Save and go on").is_none(), "Escape stays");
    assert!(desk.app().project().is_dirty());
    command(&mut desk, Command::New);
    desk.harness.key_press(Key::Enter);
    desk.frames(3);
    assert!(desk.app().project().is_dirty(), "the first answer does nothing");
    command(&mut desk, Command::New);
    desk.harness.key_press_modifiers(Modifiers::SHIFT, Key::Tab);
    desk.frames(2);
    desk.harness.key_press(Key::Enter);
    desk.frames(3);
    assert_eq!(desk.app().project().name(), "untitled");
}

#[test]
fn plus_makes_the_canvas_larger_and_not_the_controls() {
    let mut desk = open(Some("lazy_slice"), false);
    command(&mut desk, Command::Live);
    let zoom = desk.app().canvas().zoom();
    for key in [Key::Plus, Key::Equals] {
        desk.harness.key_press_modifiers(Modifiers::COMMAND, key);
        desk.frames(3);
    }
    let larger = desk.app().canvas().zoom();
    assert!(larger > zoom * 1.2, "{zoom} {larger}");
    assert_eq!(desk.harness.ctx.zoom_factor(), 1.0);
    desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::Period);
    desk.frames(3);
    assert!(desk.harness.ctx.zoom_factor() > 1.0);
}

#[test]
fn taking_a_group_apart_that_nobody_looked_into_is_undone_byte_for_byte() {
    let mut desk = open(None, false);
    command(&mut desk, Command::Live);
    let document = r#"(format: "breccia-graph", version: 2,
        nodes: {"both": (type: "flow.group", params: {"body": "two"})},
        links: [],
        groups: {"two": (nodes: {"checker": (type: "solid.checker"), "volume": (type: "solid.to_volume")}, links: ["checker.solid -> volume.solid"])})"#;
    let path = desk.folder.path().join("group.ron");
    std::fs::write(&path, document).expect("a file");
    desk.app().open_path(&path);
    desk.frames(2);
    let before = text_of(desk.app().project().state());
    let ctx = desk.harness.ctx.clone();
    desk.app().act(Action::Select(Selection::node("both")), &ctx);
    command(&mut desk, Command::Ungroup);
    assert_eq!(desk.app().project().state().document.nodes.len(), 2);
    command(&mut desk, Command::Undo);
    assert_eq!(text_of(desk.app().project().state()), before);
}
