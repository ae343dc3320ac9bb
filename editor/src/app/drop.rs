//! Files that are dropped on the window: pictures and meshes become inputs, graphs are opened.

use std::collections::BTreeSet;
use std::path::Path;

use breccia_engine::{Document, ParamKind, ParamValue};
use breccia_graphs::set_of;
use eframe::egui::{self, Context};

use super::{After, App};
use crate::action::Action;
use crate::files::relative;
use crate::model;

/// What an empty graph becomes when a picture is dropped on it.
const FIRST: &str = "lazy_mesh";

/// How far nodes that are made together lie apart, in units of the canvas.
const STEP: i32 = 40;

/// Of how many files it is told what would become of them.
const SHOWN: usize = 4;

/// What becomes of a file that is dropped.
enum Fate {
    /// A graph is opened.
    Open,
    /// A bundle is unpacked and opened.
    Import,
    /// The node that is selected reads it, with this parameter.
    Selected(String, String),
    /// The graph takes it.
    Input(Input),
    /// A graph begins with it.
    Start,
    /// A new node of this type reads it, with this parameter.
    Node(String, String),
    /// Nothing, and why.
    Nothing(String),
}

/// An input of a graph that takes a file.
#[derive(Clone)]
struct Input {
    name: String,
    node: String,
    param: String,
    /// What it reads now.
    path: String,
}

impl App {
    /// Takes in dropped files.
    pub(super) fn dropped(&mut self, ctx: &Context) -> Vec<Action> {
        let files = ctx.input(|i| i.raw.dropped_files.clone());
        let mut given = BTreeSet::new();
        for (i, file) in files.iter().enumerate() {
            self.take(file.path(), i == 0, &mut given, ctx);
        }
        Vec::new()
    }

    /// Takes in one file: a graph or bundle is opened, anything else goes to what can read it.
    pub fn take_file(&mut self, path: &Path, ctx: &Context) {
        self.take(path, true, &mut BTreeSet::new(), ctx);
    }

    /// Takes in one file of several. Only the first goes to the selected node, which may be one that was made for it; inputs that were
    /// `given` a file take no other.
    fn take(&mut self, path: &Path, first: bool, given: &mut BTreeSet<String>, ctx: &Context) {
        self.refresh();
        // Where the program was started is not where the graph will lie.
        let path = &std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        match self.fate(path, first, given) {
            Fate::Open => self.leave_document(After::Open(path.to_owned()), ctx),
            Fate::Import => self.leave_document(After::Import(path.to_owned()), ctx),
            Fate::Selected(node, param) => self.set_file(&node, &param, path, ctx),
            Fate::Input(input) => {
                self.give(&input, path);
                given.insert(input.name);
            }
            Fate::Start => given.extend(self.start_with(path)),
            Fate::Node(ty, param) => self.as_node(ty, &param, path, ctx),
            Fate::Nothing(why) => self.say(why),
        }
    }

    /// What would become of a file.
    fn fate(&self, path: &Path, first: bool, given: &BTreeSet<String>) -> Fate {
        let extension = extension_of(path);
        if path.is_dir() {
            return Fate::Nothing("Folders cannot be taken, only files".to_owned());
        }
        match extension.as_str() {
            "ron" => return Fate::Open,
            "zip" => return Fate::Import,
            _ => {}
        }
        if let Some((node, param)) = self.selected_reader(&extension).filter(|_| first) {
            return Fate::Selected(node, param);
        }
        let document = &self.project.state().document;
        let mut readers = self.readers(document, &extension);
        readers.retain(|input| !given.contains(&input.name));
        if let Some(input) = preferred(&readers) {
            return Fate::Input(input.clone());
        }
        if document.nodes.is_empty() && image(&extension) && breccia_graphs::preset(FIRST).is_some() {
            return Fate::Start;
        }
        let node = self.registry.nodes().find_map(|ty| {
            let param = ty.spec.params.iter().find(|param| reads(&param.kind, &extension))?;
            Some((ty.spec.id.to_owned(), param.name.to_owned()))
        });
        match node {
            Some((ty, param)) => Fate::Node(ty, param),
            None if extension.is_empty() => {
                Fate::Nothing("No node reads files whose names have no ending".to_owned())
            }
            None => Fate::Nothing(format!("No node reads files that end in .{extension}")),
        }
    }

    /// The node that is selected, if it reads such files, and the parameter that names them.
    fn selected_reader(&self, extension: &str) -> Option<(String, String)> {
        let node = self.selection.single()?;
        let param = self.shapes.get(node)?.params.iter().find(|p| reads(&p.kind, extension))?;
        Some((node.clone(), param.name.clone()))
    }

    /// The inputs of a graph that read such files.
    fn readers(&self, document: &Document, extension: &str) -> Vec<Input> {
        let reader = |(name, input): (&String, &breccia_engine::InterfaceInput)| {
            let entry = document.nodes.get(&input.node)?;
            let spec = &self.registry.node(&entry.ty)?.spec;
            let param = spec.params.iter().find(|param| param.name == input.param)?;
            let path = match entry.params.get(param.name) {
                Some(ParamValue::Text(path)) => path.clone(),
                _ => String::new(),
            };
            reads(&param.kind, extension).then(|| Input {
                name: name.clone(),
                node: input.node.clone(),
                param: input.param.clone(),
                path,
            })
        };
        document.interface.inputs.iter().filter_map(reader).collect()
    }

    /// An input of the graph takes a file. Built-in files that belong to the one that goes are taken away.
    fn give(&mut self, input: &Input, path: &Path) {
        let text = relative(path, self.project.folder());
        let set = set_of(&input.path);
        let extension = extension_of(path);
        let mut orphans = self.readers(&self.project.state().document, &extension);
        orphans.retain(|other| other.name != input.name && set.is_some() && set_of(&other.path) == set);
        let at = model::Address::default();
        self.project.edit(&format!("Give {}", input.name), None, |state| {
            model::set_param(state, &at, &input.node, &input.param, Some(ParamValue::Text(text)));
            for orphan in &orphans {
                model::set_param(state, &at, &orphan.node, &orphan.param, None);
            }
        });
        let left_out = if orphans.is_empty() {
            String::new()
        } else {
            format!(
                "; left out what belonged to the built-in one: {}",
                orphans.iter().map(|orphan| orphan.name.as_str()).collect::<Vec<_>>().join(", ")
            )
        };
        self.say(format!("{} is the {} now{left_out}", name_of(path), input.name));
    }

    /// A picture is dropped where nothing is. Returns the input that it is given to.
    fn start_with(&mut self, path: &Path) -> Option<String> {
        let document = breccia_graphs::preset(FIRST).and_then(|preset| Document::parse(preset.ron).ok())?;
        // A step of its own: what was there before can be brought back.
        self.project.edit("Start with a picture", None, |state| *state = model::State::new(document));
        self.refresh();
        self.canvas.arrive();
        self.open.gallery = false;
        let Fate::Input(input) = self.fate(path, false, &BTreeSet::new()) else { return None };
        self.give(&input, path);
        Some(input.name)
    }

    /// A new node reads the file.
    fn as_node(&mut self, ty: String, param: &str, path: &Path, ctx: &Context) {
        let before = self.project.content();
        let at = self.free_place();
        self.perform(Action::Add { kind: crate::action::Kind::Type(ty), at, joint: None }, ctx);
        self.refresh();
        // A group in a file of its own takes no nodes; what is selected there is none of this.
        let added = self.project.content() != before;
        if let Some(node) = self.selection.single().filter(|_| added).cloned() {
            self.set_file(&node, param, path, ctx);
        }
    }

    /// Sets a file parameter to a file that was dropped.
    fn set_file(&mut self, node: &str, param: &str, path: &Path, ctx: &Context) {
        let text = relative(path, self.project.folder());
        let value = Some(ParamValue::Text(text));
        let action = Action::Set { node: node.to_owned(), param: param.to_owned(), value, dragging: false };
        self.perform(action, ctx);
    }

    /// A place for a node where none begins: several files make several nodes at once.
    fn free_place(&self) -> [i32; 2] {
        let mut at = self.canvas.place_for_new();
        let layout = self.project.state().layout(&self.address());
        while layout.is_some_and(|layout| layout.nodes.values().any(|place| place.at == at)) {
            at = at.map(|x| x.wrapping_add(STEP));
        }
        at
    }

    /// Says over the window what dropping would do.
    pub(super) fn hint(&self, ctx: &Context) {
        let hovering = ctx.input(|i| i.raw.hovered_files.clone());
        if hovering.is_empty() {
            return;
        }
        let area = egui::Area::new(egui::Id::new("drop hint"))
            .anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0])
            .order(egui::Order::Foreground);
        area.show(ctx, |ui| {
            egui::Frame::popup(ui.style()).show(ui, |ui| {
                let mut given = BTreeSet::new();
                for (i, file) in hovering.iter().take(SHOWN).enumerate() {
                    match &file.path {
                        Some(path) => ui.heading(self.told(path, i == 0, &mut given)),
                        // Not every system tells before the drop what it is about.
                        None => ui.heading("Drop a picture, a mesh, a graph or a bundle"),
                    };
                }
                if hovering.len() > SHOWN {
                    ui.label(format!("and {} more", hovering.len() - SHOWN));
                }
            });
        });
    }

    /// What dropping a file would do, in words.
    fn told(&self, path: &Path, first: bool, given: &mut BTreeSet<String>) -> String {
        let name = name_of(path);
        let fate = self.fate(path, first, given);
        if let Fate::Input(input) = &fate {
            given.insert(input.name.clone());
        }
        match fate {
            // What the graph that is begun by the first can take shows once it is there.
            Fate::Start if !first => format!("and {name}"),
            Fate::Open => format!("Drop to open the graph {name}"),
            Fate::Import => format!("Drop to unpack and open {name}"),
            Fate::Selected(node, _) => format!("Drop to let {node} read {name}"),
            Fate::Input(input) => format!("Drop to make {name} the {}", input.name),
            Fate::Start => format!("Drop to start a graph with {name}"),
            Fate::Node(..) => format!("Drop to add a node that reads {name}"),
            Fate::Nothing(why) => why,
        }
    }
}

/// The input that a file is given to, if none is said.
fn preferred(readers: &[Input]) -> Option<&Input> {
    let named =
        ["exemplar", "mesh"].iter().find_map(|wanted| readers.iter().find(|input| input.name == *wanted));
    named.or(readers.first())
}

fn extension_of(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn reads(kind: &ParamKind, extension: &str) -> bool {
    matches!(kind, ParamKind::File { extensions } if extensions.contains(&extension))
}

fn image(extension: &str) -> bool {
    matches!(extension, "png" | "jpg" | "jpeg" | "tif" | "tiff" | "bmp" | "webp" | "exr")
}
