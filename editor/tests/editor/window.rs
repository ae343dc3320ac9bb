//! A window that no screen shows.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use breccia_editor::action::Action;
use breccia_editor::app::{App, Picker, Settings, Want};
use breccia_editor::command::Command;
use breccia_editor::window::{Window, wgpu_options};
use egui_kittest::Harness;

/// Answers to file dialogs, in order.
pub type Answers = Rc<RefCell<VecDeque<PathBuf>>>;

struct Prepared(Answers);

impl Picker for Prepared {
    fn ask(&self, _: &Want, _: Option<&std::path::Path>) -> Receiver<Option<PathBuf>> {
        let (sender, receiver) = channel();
        let _ = sender.send(self.0.borrow_mut().pop_front());
        receiver
    }
}

/// The editor with a graph open, and what it will be told by file dialogs.
pub struct Desk {
    /// The window.
    pub harness: Harness<'static, Window>,
    /// Answers to file dialogs.
    pub answers: Answers,
    /// A folder of its own.
    pub folder: tempfile::TempDir,
}

/// Whether there is an adapter to draw on; where tests must have one there is.
pub fn has_adapter() -> bool {
    breccia_shaders::Gpu::open(Default::default()).is_ok()
        || std::env::var_os("BRECCIA_REQUIRE_DEVICE").is_some()
}

/// Opens the editor; `drawn` with a device to draw on, and so with the viewport.
pub fn open(graph: Option<&str>, drawn: bool) -> Desk {
    let folder = tempfile::tempdir().expect("a folder");
    let answers = Answers::default();
    let settings = Settings {
        threads: 2,
        // Tests that run beside each other in one process share its memory.
        memory: u64::MAX,
        cache: None,
        state: Some(folder.path().join("state")),
        ..Settings::default()
    };
    let picker = Box::new(Prepared(Rc::clone(&answers)));
    let builder = Harness::builder()
        .with_size([1280.0, 720.0])
        .with_max_steps(64)
        .with_theme(eframe::egui::Theme::Dark);
    let builder = if drawn { builder.wgpu_setup(wgpu_options().wgpu_setup) } else { builder };
    let harness =
        builder.build_eframe(|creation| Window::new(creation, settings, picker, graph).expect("a window"));
    Desk { harness, answers, folder }
}

/// Gives a command, and draws what comes of it.
pub fn command(desk: &mut Desk, command: Command) {
    let ctx = desk.harness.ctx.clone();
    desk.app().act(Action::Command(command), &ctx);
    desk.frames(2);
}

impl Desk {
    /// The application.
    pub fn app(&mut self) -> &mut App {
        &mut self.harness.state_mut().0
    }

    /// Draws a few frames.
    pub fn frames(&mut self, count: usize) {
        self.harness.run_steps(count);
    }

    /// Waits until nothing is computed any more.
    pub fn wait(&mut self) {
        let limit = Instant::now() + Duration::from_secs(300);
        self.frames(2);
        while self.app().is_busy() {
            assert!(Instant::now() < limit, "a run that does not end");
            std::thread::sleep(Duration::from_millis(10));
            self.harness.step();
        }
        self.frames(2);
    }
}
