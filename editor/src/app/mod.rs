//! The application: what is open and what goes on. Panels draw it and say what the user asks for; it does that.

mod answers;
mod below;
mod commands;
mod documents;
mod drop;
mod ears;
mod level;
mod memory;
mod panels;
mod paths;
mod perform;
mod picker;
mod running;
mod selected;
mod sheets;
mod start;
mod watch;

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use breccia_engine::{DeviceChoice, Engine, Registry};
use breccia_graphs::Sources;
use breccia_nodes::device::{Gpu, GpuDevice};
use eframe::egui::{self, Context, TextureHandle};
use eframe::egui_wgpu::RenderState;

use crate::action::{Action, Selection};
use crate::canvas::Canvas;
use crate::model::{Project, Shape, Trail};
use crate::palette::Palette;
use crate::run::{Bakes, Board, Checked, MemoryBudget, Runner};
use crate::view::{Subject, Viewport};

pub use picker::{NativePicker, Picked, Picker, Want};
pub use start::{Settings, StartError, yield_to_the_window};

/// A question that waits for an answer. It never keeps the user from doing anything else.
#[derive(Clone, Debug, PartialEq)]
enum Question {
    /// What is not saved would be lost by this.
    Unsaved(After),
    /// The file changed on disk.
    Changed,
    /// This file would be replaced.
    Replace(PathBuf),
}

/// What was asked for before a question came between.
#[derive(Clone, Debug, PartialEq)]
enum After {
    New,
    Open(PathBuf),
    Pick,
    Preset(String),
    Import(PathBuf),
    Recover(PathBuf),
    Quit,
}

/// Windows that can be open.
#[derive(Clone, Copy, Debug, Default)]
struct Open {
    gallery: bool,
    shortcuts: bool,
    tour: bool,
    problems: bool,
    inspector: bool,
    viewport: bool,
    /// What can be recovered is left for later.
    later: bool,
    /// For how many frames what takes the keyboard has been there, up to [`FOCUS`].
    there: [u8; 4],
}

/// What takes the keyboard when it appears, so that no mouse is needed to answer it.
#[derive(Clone, Copy)]
enum Appearing {
    Question,
    Gallery,
    Recovery,
    Tour,
}

/// In how many frames something that appears takes the keyboard: the first one of a window only finds out its size.
const FOCUS: u8 = 2;

impl Open {
    /// Notes whether something is there. Returns whether it has just appeared.
    fn appears(&mut self, what: Appearing, is_there: bool) -> bool {
        let frames = &mut self.there[what as usize];
        let is_fresh = is_there && *frames < FOCUS;
        *frames = if is_there { FOCUS.min(*frames + 1) } else { 0 };
        is_fresh
    }
}

/// The application.
pub struct App {
    registry: Arc<Registry>,
    files: Arc<Sources>,
    runner: Runner,
    budget: MemoryBudget,
    project: Project,
    /// How many documents were opened before this one.
    documents: u64,
    trail: Trail,
    selection: Selection,

    /// The document looked over, and which state of it that was.
    checked: Checked,
    checked_for: u64,
    /// What the nodes that are looked at are like, and for which state.
    shapes: BTreeMap<String, Shape>,
    shapes_for: Option<(u64, Trail)>,
    /// What is wrong with nodes, by name in a run.
    problems: BTreeMap<String, Vec<String>>,
    /// Nodes of the graph looked at that cannot run, by name in a run.
    broken: BTreeSet<String>,

    canvas: Canvas,
    viewport: Option<Viewport>,
    palette: Option<Palette>,
    open: Open,
    question: Option<Question>,
    picker: Box<dyn Picker>,
    picking: Vec<Picked>,
    path_sheets: VecDeque<paths::PathSheet>,
    /// What is written once it may replace the file that is there.
    replacing: Option<(Want, PathBuf)>,

    board: Board,
    live: bool,
    /// Whether something is being dragged, so that drafts do.
    dragging: bool,
    /// Whether what was computed last was a draft.
    drafted: bool,
    /// Whether something changed since the last run was asked for.
    due: bool,
    /// What is baked in the graph that was asked for last.
    asked: Arc<Bakes>,
    /// The graph that was asked for in full last; none of this document yet.
    full: Option<Arc<breccia_engine::Graph>>,
    /// Whether all outputs were asked for.
    ran_all: bool,
    /// Whether a run goes on, by lane.
    busy: [bool; 2],
    watched: Option<String>,
    results: BTreeMap<String, Subject>,
    pictures: BTreeMap<String, TextureHandle>,

    /// What stands in the line below, and since when.
    said: Option<(String, Instant)>,
    /// Text that was copied, for where there is no clipboard.
    copied: Option<String>,
    library: crate::files::Library,
    memory: memory::Memory,
    /// What came of work on files and waits for a question to be answered.
    done: Vec<documents::Done>,
    /// Work on files that goes on, and what comes of it.
    working: Vec<std::sync::mpsc::Receiver<documents::Done>>,
    /// What was asked for before the document is saved.
    then: Option<After>,
    title: String,
    quitting: bool,
    /// How long the last frames took to draw, in seconds.
    frames: Vec<f32>,
}

impl App {
    /// An application with an empty graph. `render` draws objects; without it there is no viewport, as in tests of everything else.
    ///
    /// # Errors
    /// If threads cannot be started.
    pub fn new(
        ctx: &Context,
        render: Option<&RenderState>,
        settings: Settings,
        picker: Box<dyn Picker>,
    ) -> Result<Self, StartError> {
        crate::theme::install(ctx);
        // Plus and minus are the canvas's; controls have keys of their own.
        ctx.options_mut(|options| options.zoom_with_keyboard = false);
        let registry = Arc::new(breccia_nodes::registry());
        let files = Arc::new(Sources::default());
        let gpu = render.map(|render| start::share(render, &settings));
        let mut builder = Engine::builder()
            .threads(settings.threads)
            .memory(MemoryBudget::at_first(settings.memory))
            .cache_dir(settings.cache.clone())
            .files(Arc::clone(&files) as _)
            .device(DeviceChoice::Auto)
            .on_thread_start(Arc::new(yield_to_the_window));
        if let Some(gpu) = gpu.clone() {
            builder = builder.compute(Box::new(move || Ok(Arc::new(GpuDevice(Gpu::clone(&gpu))))));
        }
        let engine = builder.build(Arc::clone(&registry))?;
        let budget = MemoryBudget::new(settings.memory, engine.clone())?;
        let waker = ctx.clone();
        let runner = Runner::new(engine, Arc::new(move || waker.request_repaint()));
        let project = Project::new(Default::default(), None, None);
        let checked = crate::run::check(&project.state().document, &registry, None, &*files);
        let library = crate::files::Library::new(settings.state.clone());
        let memory = memory::Memory::new(settings.state.clone());
        Ok(Self {
            viewport: render
                .map(|render| Viewport::new(render.clone(), gpu.filter(|gpu| start::is_fast(gpu)))),
            open: Open { inspector: true, viewport: true, ..Open::default() },
            live: true,
            registry,
            files,
            runner,
            budget,
            project,
            documents: 0,
            trail: Trail::default(),
            selection: Selection::default(),
            checked,
            checked_for: 0,
            shapes: BTreeMap::new(),
            shapes_for: None,
            problems: BTreeMap::new(),
            broken: BTreeSet::new(),
            canvas: Canvas::default(),
            palette: None,
            question: None,
            picker,
            picking: Vec::new(),
            path_sheets: VecDeque::new(),
            replacing: None,
            board: Board::default(),
            dragging: false,
            drafted: false,
            due: true,
            asked: Arc::default(),
            full: None,
            ran_all: false,
            busy: [false; 2],
            watched: None,
            results: BTreeMap::new(),
            pictures: BTreeMap::new(),
            said: None,
            copied: None,
            library,
            memory,
            done: Vec::new(),
            working: Vec::new(),
            then: None,
            title: String::new(),
            quitting: false,
            frames: Vec::new(),
        })
    }

    /// One frame: takes in what happened, draws everything, does what the user asks for.
    pub fn ui(&mut self, ui: &mut egui::Ui) {
        let begun = Instant::now();
        let ctx = ui.ctx().clone();
        self.before(&ctx);
        let mut actions = self.shortcuts(&ctx);
        actions.extend(self.dropped(&ctx));
        self.refresh();
        self.draw(ui, &mut actions);
        for action in actions {
            self.perform(action, &ctx);
        }
        self.end_drag(&ctx);
        self.refresh();
        self.run_if_due(&ctx);
        self.after(&ctx);
        self.frames.push(begun.elapsed().as_secs_f32());
        if self.frames.len() > 240 {
            self.frames.remove(0);
        }
    }

    /// Says something in the line below.
    fn say(&mut self, text: impl Into<String>) {
        self.said = Some((text.into(), Instant::now()));
    }

    /// What is open, for tests and tools.
    pub fn project(&self) -> &Project {
        &self.project
    }

    /// The way to the graph that is looked at.
    pub fn trail(&self) -> &Trail {
        &self.trail
    }

    /// What is selected.
    pub fn selection(&self) -> &Selection {
        &self.selection
    }

    /// The canvas.
    pub fn canvas(&self) -> &Canvas {
        &self.canvas
    }

    /// What is known of the nodes.
    pub fn board(&self) -> &Board {
        &self.board
    }

    /// The last good results by output.
    pub fn results(&self) -> &BTreeMap<String, Subject> {
        &self.results
    }

    /// What stands in the line below.
    pub fn said(&self) -> Option<&str> {
        self.said.as_ref().map(|(text, _)| text.as_str())
    }

    /// Whether something is being computed.
    pub fn is_busy(&self) -> bool {
        self.busy.contains(&true) || self.due && self.live
    }

    /// Whether the window is to be closed.
    pub fn is_quitting(&self) -> bool {
        self.quitting
    }

    /// The output that the viewport shows.
    pub fn watched(&self) -> Option<&str> {
        self.watched.as_deref()
    }

    /// Seconds that the last frames took to draw, without the time that the device takes.
    pub fn frame_times(&self) -> &[f32] {
        &self.frames
    }

    /// Number and bytes of the results that are kept in memory.
    pub fn memory_usage(&self) -> (usize, u64) {
        self.runner.engine().memory_usage()
    }

    /// Does what the user could ask for.
    pub fn act(&mut self, action: Action, ctx: &Context) {
        self.refresh();
        self.perform(action, ctx);
        self.refresh();
    }
}
