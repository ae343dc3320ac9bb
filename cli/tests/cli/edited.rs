//! What is made in the editor is made again by the command line, byte for byte.

use std::process::Command;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use breccia_editor::action::{Action, Kind, Pin};
use breccia_editor::app::{App, Picker, Settings, Want};
use breccia_engine::{ParamValue, Sink};
use eframe::egui::Context;

/// Nobody is asked for a file.
struct Nobody;

impl Picker for Nobody {
    fn ask(&self, _: &Want, _: Option<&std::path::Path>) -> Receiver<Option<std::path::PathBuf>> {
        channel().1
    }
}

#[test]
fn a_graph_made_in_the_editor_gives_the_same_bytes_on_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let ctx = Context::default();
    let settings = Settings { cache: None, state: None, ..Settings::default() };
    let mut app = App::new(&ctx, None, settings, Box::new(Nobody)).unwrap();
    // A preset, changed as a user would: another size, a muted mask, a node more.
    app.open_preset("lazy_volume");
    let set = |node: &str, param: &str, value| Action::Set {
        node: node.into(),
        param: param.into(),
        value: Some(value),
        dragging: false,
    };
    app.act(set("exemplar", "max_size", ParamValue::Int(32)), &ctx);
    app.act(set("volume", "size", ParamValue::Int(24)), &ctx);
    app.act(set("synthesis", "period", ParamValue::List(vec![ParamValue::Int(24)])), &ctx);
    app.act(Action::Add { kind: Kind::Type("solid.slice".into()), at: [0, 0], joint: None }, &ctx);
    let pin = |node: &str, socket: &str, output| Pin { node: node.into(), socket: socket.into(), output };
    app.act(Action::Connect(pin("synthesis", "solid", true), pin("slice", "solid", false)), &ctx);
    app.act(set("slice", "size", ParamValue::Int(40)), &ctx);
    app.act(Action::Output(pin("slice", "image", true)), &ctx);
    app.act(Action::Watch(pin("slice", "image", true)), &ctx);
    let path = folder.path().join("edited.ron");
    assert!(app.save_to(&path), "{:?}", app.said());

    let limit = Instant::now() + Duration::from_secs(300);
    while app.results().get("slice.image").is_none_or(|subject| subject.stale) {
        assert!(Instant::now() < limit, "{:?}", app.said());
        let mut output = ctx.run_ui(Default::default(), |ui| app.ui(ui));
        // Nothing is drawn.
        output.textures_delta.clear();
        std::thread::sleep(Duration::from_millis(10));
    }
    let value = &app.results()["slice.image"].value;
    let registry = breccia_nodes::registry();
    let exporter =
        registry.exporters().iter().find(|e| e.ty == "image" && e.extensions.contains(&"png")).unwrap();
    let ours = folder.path().join("editor.png");
    let mut sink = Sink::new(&ours).unwrap();
    (exporter.write)(value, &mut sink).unwrap();
    sink.commit().unwrap();

    let theirs = folder.path().join("line.png");
    let status = Command::new(env!("CARGO_BIN_EXE_breccia"))
        .args(["run", "--no-cache", "-q"])
        .arg(&path)
        .arg(format!("--output=image={}", theirs.display()))
        .status()
        .unwrap();
    assert!(status.success());
    assert!(std::fs::read(&ours).unwrap() == std::fs::read(&theirs).unwrap(), "different bytes");
}
