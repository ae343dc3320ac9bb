//! Measures what it is like to use the editor, without a screen but with everything drawn: frames of large graphs, frames while a large
//! volume is synthesised, memory over a long time of edits.
//!
//! ```sh
//! cargo run --release -p breccia-editor --example measure -- frames
//! cargo run --release -p breccia-editor --example measure -- latency
//! cargo run --release -p breccia-editor --example measure -- endurance 600 2048
//! ```

#![allow(clippy::print_stdout, reason = "it prints what it measured")]

use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use breccia_editor::action::{Action, Pin};
use breccia_editor::app::{Picker, Settings, Want};
use breccia_editor::command::Command;
use breccia_editor::window::{Window, wgpu_options};
use breccia_engine::{Document, NodeEntry, ParamValue};
use eframe::egui::{Event, pos2};
use egui_kittest::Harness;

struct Nobody;

impl Picker for Nobody {
    fn ask(&self, _: &Want, _: Option<&std::path::Path>) -> Receiver<Option<std::path::PathBuf>> {
        channel().1
    }
}

/// Mebibytes of memory that the program may take if nothing else is said.
const MEMORY: u64 = 2048;

fn open(graph: Option<&str>, drawn: bool, memory: u64) -> Harness<'static, Window> {
    let settings = Settings { cache: None, state: None, memory: memory << 20, ..Settings::default() };
    let builder = Harness::builder().with_size([1280.0, 720.0]).with_max_steps(8);
    let builder = if drawn { builder.wgpu_setup(wgpu_options().wgpu_setup) } else { builder };
    builder
        .build_eframe(|creation| Window::new(creation, settings, Box::new(Nobody), graph).expect("a window"))
}

fn command(harness: &mut Harness<'_, Window>, command: Command) {
    let ctx = harness.ctx.clone();
    harness.state_mut().0.act(Action::Command(command), &ctx);
}

/// Median, 95th percentile and maximum in milliseconds.
fn told(mut times: Vec<f64>) -> String {
    times.sort_by(f64::total_cmp);
    let at =
        |share: f64| times.get(((times.len() as f64 - 1.0) * share) as usize).copied().unwrap_or(0.0) * 1e3;
    format!(
        "median {:.1} ms, 95 % below {:.1} ms, longest {:.1} ms ({} frames)",
        at(0.5),
        at(0.95),
        at(1.0),
        times.len()
    )
}

/// A graph of many nodes: chains that cross.
fn many(count: usize) -> Document {
    let mut document = Document::default();
    for i in 0..count {
        let ty =
            ["solid.checker", "solid.to_volume", "solid.from_volume", "solid.to_volume", "solid.from_volume"]
                [i % 5];
        document.nodes.insert(format!("node_{i:04}"), NodeEntry::new(ty));
        if i % 5 > 0 {
            let (from, to) = if i % 5 % 2 == 1 { ("solid", "solid") } else { ("volume", "volume") };
            document.links.push(format!("node_{:04}.{from} -> node_{i:04}.{to}", i - 1));
        }
    }
    document
}

fn frames() {
    for count in [50, 200, 500, 1000] {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("many.ron");
        std::fs::write(&path, many(count).to_ron()).expect("a file");
        for (what, fit) in [("all in view", true), ("a part in view", false)] {
            let mut harness = open(path.to_str(), true, MEMORY);
            command(&mut harness, Command::Live);
            command(&mut harness, Command::Arrange);
            harness.run_steps(3);
            command(&mut harness, if fit { Command::FitAll } else { Command::FitSelection });
            if !fit {
                let name = "node_0007".to_owned();
                let ctx = harness.ctx.clone();
                harness.state_mut().0.act(Action::Reveal(name), &ctx);
            }
            harness.run_steps(3);
            let (mut cpu, mut whole) = (Vec::new(), Vec::new());
            for i in 0..60 {
                harness.event(Event::PointerMoved(pos2(300.0 + i as f32, 300.0)));
                let begun = Instant::now();
                harness.step();
                let shapes = harness.output().shapes.clone();
                let triangles = harness.ctx.tessellate(shapes, 1.0);
                cpu.push(begun.elapsed().as_secs_f64());
                drop(triangles);
                harness.render().expect("a picture");
                whole.push(begun.elapsed().as_secs_f64());
            }
            println!("{count} nodes, {what}: {}; with drawing {}", told(cpu), told(whole));
        }
    }
}

fn latency() {
    let mut harness = open(Some("lazy_volume"), true, MEMORY);
    let ctx = harness.ctx.clone();
    let set = |node: &str, param: &str, value| Action::Set {
        node: node.into(),
        param: param.into(),
        value: Some(value),
        dragging: false,
    };
    harness.state_mut().0.act(set("volume", "size", ParamValue::Int(256)), &ctx);
    harness
        .state_mut()
        .0
        .act(Action::Watch(Pin { node: "volume".into(), socket: "volume".into(), output: true }), &ctx);
    let (mut cpu, mut whole) = (Vec::new(), Vec::new());
    let begun = Instant::now();
    let mut i = 0;
    while harness.state().0.is_busy() && begun.elapsed() < Duration::from_secs(60) {
        i += 1;
        harness.event(Event::PointerMoved(pos2(200.0 + (i % 400) as f32, 300.0)));
        let at = Instant::now();
        harness.step();
        cpu.push(at.elapsed().as_secs_f64());
        harness.render().expect("a picture");
        whole.push(at.elapsed().as_secs_f64());
        std::thread::sleep(Duration::from_millis(16));
    }
    println!(
        "while 256³ is synthesised ({:.1} s): input to layout {}; to the finished picture {}",
        begun.elapsed().as_secs_f64(),
        told(cpu),
        told(whole)
    );
}

/// Peak and present memory of the process in megabytes.
fn memory() -> [u64; 2] {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    ["VmHWM:", "VmRSS:"].map(|name| {
        let line = status.lines().find_map(|line| line.strip_prefix(name)).unwrap_or("0");
        line.split_whitespace().next().and_then(|n| n.parse::<u64>().ok()).unwrap_or(0) / 1000
    })
}

fn endurance(seconds: u64, memory_budget: u64) {
    let mut harness = open(Some("lazy_volume"), true, memory_budget);
    let ctx = harness.ctx.clone();
    let set = |node: &str, param: &str, value, dragging| Action::Set {
        node: node.into(),
        param: param.into(),
        value: Some(value),
        dragging,
    };
    harness.state_mut().0.act(set("volume", "size", ParamValue::Int(256), false), &ctx);
    harness
        .state_mut()
        .0
        .act(Action::Watch(Pin { node: "volume".into(), socket: "volume".into(), output: true }), &ctx);
    let begun = Instant::now();
    let (mut edits, mut next, mut reported) = (0_i64, Instant::now(), 0);
    while begun.elapsed() < Duration::from_secs(seconds) {
        harness.step();
        std::thread::sleep(Duration::from_millis(16));
        // An edit as soon as the last one is computed, or after a while.
        if Instant::now() >= next || !harness.state().0.is_busy() {
            edits += 1;
            next = Instant::now() + Duration::from_secs(20);
            let app = &mut harness.state_mut().0;
            let places = [[0, edits * 7], [edits * 3, 0], [edits, edits]];
            let [x, y] = places[(edits % 3) as usize];
            match edits % 6 {
                0 => app.act(Action::Command(Command::Undo), &ctx),
                1 => app.act(set("synthesis", "seed", ParamValue::Int(edits), false), &ctx),
                2 => app.act(Action::Move([edits as i32 % 50, 3]), &ctx),
                _ => {
                    let list = ParamValue::List([x, y, 0].map(ParamValue::Int).to_vec());
                    app.act(set("volume", "origin", list, edits % 2 == 0), &ctx);
                    app.act(Action::EndDrag, &ctx);
                }
            }
            harness.render().expect("a picture");
        }
        let minute = begun.elapsed().as_secs() / 30;
        if minute > reported {
            reported = minute;
            let ([peak, now], (values, bytes)) = (memory(), harness.state().0.memory_usage());
            println!(
                "{:4} s, {edits} edits: {now} MB now, {peak} MB at most; {values} results of {} MB",
                begun.elapsed().as_secs(),
                bytes / 1_000_000
            );
        }
    }
    let [peak, now] = memory();
    println!("{edits} edits of a 256³ graph in {seconds} s: {now} MB now, {peak} MB at most");
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    match arguments.next().as_deref() {
        Some("frames") => frames(),
        Some("latency") => latency(),
        Some("endurance") => {
            let mut number = |other| arguments.next().and_then(|n| n.parse().ok()).unwrap_or(other);
            endurance(number(600), number(MEMORY));
        }
        _ => println!("expected one of: frames, latency, endurance [SECONDS [MEBIBYTES]]"),
    }
}
