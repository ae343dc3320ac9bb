//! Files that are dropped on the window, and files that dialogs were asked for.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use breccia_editor::action::{Action, Selection};
use breccia_editor::command::Command;
use breccia_editor::model::Address;
use breccia_graphs::asset;
use eframe::egui::{DroppedFile, HoveredFile, Key, Modifiers};
use egui_kittest::kittest::Queryable;

use super::window::{Desk, command, open};

fn act(desk: &mut Desk, action: Action) {
    let ctx = desk.harness.ctx.clone();
    desk.app().act(action, &ctx);
}

/// The editor with a graph that nothing is computed of.
fn still(graph: Option<&str>) -> Desk {
    let mut desk = open(graph, false);
    command(&mut desk, Command::Live);
    command(&mut desk, Command::Stop);
    desk
}

fn file(desk: &Desk, name: &str, contents: &[u8]) -> PathBuf {
    let path = desk.folder.path().join(name);
    std::fs::write(&path, contents).expect("a file");
    path
}

/// Holds a file over the window, looks for words, and takes it away again.
fn hover(desk: &mut Desk, path: &Path, expected: &str) {
    let hovered = HoveredFile { path: Some(path.to_owned()), ..HoveredFile::default() };
    desk.harness.input_mut().hovered_files = vec![hovered];
    desk.frames(2);
    assert!(desk.harness.query_by_label(expected).is_some(), "{expected}");
    desk.harness.input_mut().hovered_files.clear();
    desk.frames(2);
    assert!(desk.harness.query_by_label(expected).is_none(), "{expected}");
}

#[test]
fn a_file_over_the_window_is_told_what_dropping_it_does() {
    let mut desk = still(None);
    let picture = file(&desk, "mein Stein ähnlich.png", asset("granite/color_128.png").expect("an asset"));
    let text = file(&desk, "lies mich.txt", b"nothing");
    let bare = file(&desk, "nothing", b"nothing");
    let mesh = desk.folder.path().join("Kuh ö.glb");
    let folder = desk.folder.path().to_owned();
    command(&mut desk, Command::SelectNone);
    hover(&mut desk, &picture, "Drop to start a graph with mein Stein ähnlich.png");
    hover(&mut desk, &mesh, "Drop to add a node that reads Kuh ö.glb");
    hover(&mut desk, &folder.join("x.ron"), "Drop to open the graph x.ron");
    hover(&mut desk, &folder.join("x.ZIP"), "Drop to unpack and open x.ZIP");
    hover(&mut desk, &text, "No node reads files that end in .txt");
    hover(&mut desk, &bare, "No node reads files whose names have no ending");
    hover(&mut desk, &folder, "Folders cannot be taken, only files");

    let ctx = desk.harness.ctx.clone();
    desk.app().take_file(&picture, &ctx);
    desk.frames(2);
    hover(&mut desk, &picture, "Drop to make mein Stein ähnlich.png the exemplar");
    hover(&mut desk, &mesh, "Drop to make Kuh ö.glb the mesh");
    act(&mut desk, Action::Select(Selection::node("mask_image")));
    desk.frames(2);
    hover(&mut desk, &picture, "Drop to let mask_image read mein Stein ähnlich.png");
}

/// A file as the window system gives it.
#[derive(Debug)]
struct Dropped(PathBuf);

impl DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

#[test]
fn of_several_files_each_gets_a_node_of_its_own() {
    let mut desk = still(None);
    let paths = ["a ä.glb", "b.glb", "c.txt"].map(|name| desk.folder.path().join(name));
    for path in &paths {
        desk.harness.input_mut().dropped_files.push(Arc::new(Dropped(path.clone())));
    }
    desk.frames(2);
    let nodes = &desk.app().project().state().document.nodes;
    let read: Vec<_> = nodes.values().map(|node| node.params["path"].to_string()).collect();
    assert_eq!(
        read,
        paths[..2].iter().map(|path| format!("{:?}", path.to_str().expect("a path"))).collect::<Vec<_>>()
    );
    let layout = desk.app().project().state().layout(&Address::default()).expect("a layout").clone();
    let places: BTreeSet<_> = layout.nodes.values().map(|place| place.at).collect();
    assert_eq!(places.len(), 2);
}

#[test]
fn of_several_pictures_none_takes_the_place_of_another() {
    let mut desk = still(None);
    let png = asset("granite/color_128.png").expect("a picture");
    let paths = ["one.png", "two.png"].map(|name| file(&desk, name, png));
    for path in &paths {
        desk.harness.input_mut().dropped_files.push(Arc::new(Dropped(path.clone())));
    }
    desk.frames(2);
    let text = desk.app().project().state().document.to_ron();
    for path in &paths {
        assert!(text.contains(path.to_str().expect("a path")), "{path:?} is read by no node: {text}");
    }
}

#[test]
fn a_dialog_that_leaves_the_ending_out_replaces_nothing_unasked() {
    let mut desk = still(Some("lazy_slice"));
    let there = file(&desk, "there.ron", b"of somebody");
    let bare = there.with_extension("");
    desk.answers.borrow_mut().push_back(bare.clone());
    command(&mut desk, Command::SaveAs);
    desk.frames(2);
    desk.harness.get_by_label("Leave it").click();
    desk.frames(2);
    assert_eq!(std::fs::read(&there).expect("a file"), b"of somebody");
    assert_eq!(desk.app().project().path, None);

    desk.answers.borrow_mut().push_back(bare.clone());
    command(&mut desk, Command::SaveAs);
    desk.frames(2);
    desk.harness.get_by_label("Replace it").click();
    desk.frames(2);
    assert_eq!(desk.app().project().path.as_ref(), Some(&there));
    assert_ne!(std::fs::read(&there).expect("a file"), b"of somebody");

    // It is the graph's own file now.
    desk.answers.borrow_mut().push_back(bare);
    command(&mut desk, Command::SaveAs);
    desk.frames(2);
    assert!(desk.harness.query_by_label("Replace it").is_none());
}

#[test]
fn an_answer_is_not_given_to_the_next_document() {
    let mut desk = still(Some("lazy_mesh"));
    let photo = || Action::PickFile { node: "photo".into(), param: "path".into() };
    let read =
        |desk: &mut Desk| desk.app().project().state().document.nodes["photo"].params["path"].to_string();
    let path = desk.folder.path().join("photo.png");
    desk.answers.borrow_mut().push_back(path.clone());
    act(&mut desk, photo());
    desk.app().open_preset("lazy_slice");
    desk.frames(3);
    assert!(read(&mut desk).contains("builtin:"));

    desk.answers.borrow_mut().push_back(path);
    act(&mut desk, photo());
    desk.frames(3);
    assert!(read(&mut desk).contains("photo.png"));
}

#[test]
fn a_file_goes_to_the_graph_that_it_was_picked_for() {
    let mut desk = still(Some("optimize_volume"));
    let before = desk.app().project().state().document.nodes.clone();
    let (node, param) = before
        .iter()
        .find_map(|(name, entry)| {
            entry.params.contains_key("path").then(|| (name.clone(), "path".to_owned()))
        })
        .expect("a reader");
    let path = desk.folder.path().join("photo.png");
    desk.answers.borrow_mut().push_back(path);
    act(&mut desk, Action::PickFile { node: node.clone(), param });
    act(&mut desk, Action::Enter("levels".into()));
    desk.frames(3);
    assert_eq!(desk.app().trail().0.len(), 1);
    let text = desk.app().project().state().document.nodes[&node].params["path"].to_string();
    assert!(text.contains("photo.png"), "{text}");
}

#[test]
fn a_typed_path_replaces_nothing_unasked_and_escape_gives_it_up() {
    let mut desk = still(Some("lazy_slice"));
    // No answer, and at once: there is no dialog.
    command(&mut desk, Command::SaveAs);
    desk.frames(2);
    assert!(desk.harness.query_by_label("Path").is_some());
    desk.harness.key_press(Key::Escape);
    desk.frames(2);
    assert!(desk.harness.query_by_label("Path").is_none());

    let there = file(&desk, "there.ron", b"of somebody");
    command(&mut desk, Command::SaveAs);
    desk.frames(2);
    desk.harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    desk.harness.get_by_label("Path").type_text(there.to_str().expect("a path"));
    desk.frames(2);
    desk.harness.key_press(Key::Enter);
    desk.frames(3);
    assert!(desk.harness.query_by_label("Replace it").is_some());
    assert_eq!(std::fs::read(&there).expect("a file"), b"of somebody");
}

#[test]
fn typed_paths_are_asked_for_one_after_the_other() {
    let mut desk = still(Some("lazy_slice"));
    command(&mut desk, Command::SaveAs);
    command(&mut desk, Command::ExportBundle);
    desk.frames(2);
    assert!(desk.harness.query_by_label("Save the graph").is_some());
    assert!(desk.harness.query_by_label("Export a bundle").is_none());
    desk.harness.key_press(Key::Escape);
    desk.frames(3);
    assert!(desk.harness.query_by_label("Save the graph").is_none());
    assert!(desk.harness.query_by_label("Export a bundle").is_some());
}

#[test]
fn work_that_is_done_while_a_bundle_is_unpacked_is_asked_about() {
    let mut desk = still(Some("lazy_slice"));
    let bundle = desk.folder.path().join("bundle.zip");
    desk.answers.borrow_mut().push_back(bundle.clone());
    command(&mut desk, Command::ExportBundle);
    let limit = std::time::Instant::now() + std::time::Duration::from_secs(60);
    while !bundle.exists() {
        assert!(std::time::Instant::now() < limit, "no bundle");
        desk.frames(1);
    }
    act(&mut desk, Action::OpenPath(bundle));
    act(&mut desk, Action::Title("work".into()));
    let asked = |desk: &Desk| desk.harness.query_by_label("Go on without saving").is_some();
    while !asked(&desk) {
        assert!(std::time::Instant::now() < limit, "nobody asks");
        desk.frames(1);
    }
    assert_eq!(desk.app().project().state().document.title, "work");
    desk.harness.get_by_label("Go on without saving").click();
    desk.frames(3);
    assert_ne!(desk.app().project().state().document.title, "work");
}
