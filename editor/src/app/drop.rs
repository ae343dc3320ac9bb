//! Files that are dropped on the window: pictures and meshes become inputs, graphs are opened.

use std::path::Path;

use breccia_engine::{ParamKind, ParamValue};
use breccia_graphs::set_of;
use eframe::egui::{self, Context};

use super::{After, App};
use crate::action::Action;
use crate::model;

/// What an empty graph becomes when a picture is dropped on it.
const FIRST: &str = "lazy_mesh";

impl App {
    /// Takes in dropped files.
    pub(super) fn dropped(&mut self, ctx: &Context) -> Vec<Action> {
        let files = ctx.input(|i| i.raw.dropped_files.clone());
        for file in files {
            self.take_file(file.path(), ctx);
        }
        Vec::new()
    }

    /// Takes in one file: a graph or bundle is opened, anything else goes to what can read it.
    pub fn take_file(&mut self, path: &Path, ctx: &Context) {
        self.refresh();
        // Where the program was started is not where the graph will lie.
        let path = &std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        match extension.as_str() {
            "ron" => return self.leave_document(After::Open(path.to_owned()), ctx),
            "zip" => return self.leave_document(After::Import(path.to_owned()), ctx),
            _ => {}
        }
        if self.onto_selected(path, &extension, ctx) || self.onto_input(path, &extension) {
            return;
        }
        if self.project.state().document.nodes.is_empty() && image(&extension) {
            let preset = breccia_graphs::preset(FIRST)
                .and_then(|preset| breccia_engine::Document::parse(preset.ron).ok());
            if let Some(document) = preset {
                // A step of its own: what was there before can be brought back.
                self.project.edit("Start with a picture", None, |state| *state = model::State::new(document));
                self.refresh();
                self.canvas.arrive();
                self.open.gallery = false;
                self.onto_input(path, &extension);
                return;
            }
        }
        self.as_node(path, &extension, ctx);
    }

    /// A reader that is selected takes the file.
    fn onto_selected(&mut self, path: &Path, extension: &str, ctx: &Context) -> bool {
        let Some(node) = self.selection.single().cloned() else { return false };
        let Some(param) =
            self.shapes.get(&node).and_then(|shape| shape.params.iter().find(|p| reads(&p.kind, extension)))
        else {
            return false;
        };
        let name = param.name.clone();
        self.set_file(&node, &name, path, ctx);
        true
    }

    /// The graph's first input that can read the file takes it. Built-in files that belong to the one that goes are taken away.
    fn onto_input(&mut self, path: &Path, extension: &str) -> bool {
        let document = &self.project.state().document;
        let reader = |(name, input): (&String, &breccia_engine::InterfaceInput)| {
            let entry = document.nodes.get(&input.node)?;
            let spec = &self.registry.node(&entry.ty)?.spec;
            let param = spec.params.iter().find(|param| param.name == input.param)?;
            let before = match entry.params.get(param.name) {
                Some(ParamValue::Text(path)) => path.clone(),
                _ => String::new(),
            };
            reads(&param.kind, extension)
                .then(|| (name.clone(), input.node.clone(), input.param.clone(), before))
        };
        let readers: Vec<_> = document.interface.inputs.iter().filter_map(reader).collect();
        let named =
            ["exemplar", "mesh"].iter().find_map(|wanted| readers.iter().find(|(name, ..)| name == wanted));
        let Some((input, node, param, before)) = named.or(readers.first()).cloned() else { return false };
        let text = crate::files::relative(path, self.project.folder());
        let set = set_of(&before).map(str::to_owned);
        let orphans: Vec<_> = readers
            .iter()
            .filter(|(name, ..)| *name != input)
            .filter(|(.., path)| set.is_some() && set_of(path) == set.as_deref())
            .map(|(_, node, param, _)| (node.clone(), param.clone()))
            .collect();
        let at = model::Address::default();
        self.project.edit(&format!("Give {input}"), None, |state| {
            model::set_param(state, &at, &node, &param, Some(ParamValue::Text(text)));
            for (node, param) in &orphans {
                model::set_param(state, &at, node, param, None);
            }
        });
        let left_out = if orphans.is_empty() {
            String::new()
        } else {
            format!(
                "; left out what belonged to the built-in one: {}",
                orphans.iter().map(|(n, _)| n.as_str()).collect::<Vec<_>>().join(", ")
            )
        };
        self.say(format!(
            "{} is the {input} now{left_out}",
            path.file_name().unwrap_or_default().to_string_lossy()
        ));
        true
    }

    /// A new node reads the file.
    fn as_node(&mut self, path: &Path, extension: &str, ctx: &Context) {
        let reader = self.registry.nodes().find_map(|ty| {
            let param = ty.spec.params.iter().find(|param| reads(&param.kind, extension))?;
            let ParamKind::File { extensions } = param.kind else { return None };
            (!extensions.is_empty()).then(|| (ty.spec.id.to_owned(), param.name.to_owned()))
        });
        match reader {
            Some((ty, param)) => {
                let at = self.canvas.place_for_new();
                self.perform(Action::Add { kind: crate::action::Kind::Type(ty), at, joint: None }, ctx);
                self.refresh();
                if let Some(node) = self.selection.single().cloned() {
                    self.set_file(&node, &param, path, ctx);
                }
            }
            None => self.say(format!("No node reads files that end in .{extension}")),
        }
    }
}

fn reads(kind: &ParamKind, extension: &str) -> bool {
    matches!(kind, ParamKind::File { extensions } if extensions.contains(&extension))
}

fn image(extension: &str) -> bool {
    matches!(extension, "png" | "jpg" | "jpeg" | "tif" | "tiff" | "bmp" | "webp" | "exr")
}

/// Says over the window what dropping would do.
pub(super) fn hint(ctx: &Context) {
    let hovering = ctx.input(|i| i.raw.hovered_files.len());
    if hovering > 0 {
        let area = egui::Area::new(egui::Id::new("drop hint"))
            .anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0])
            .order(egui::Order::Foreground);
        area.show(ctx, |ui| {
            egui::Frame::popup(ui.style())
                .show(ui, |ui| ui.heading("Drop a picture, a mesh, a graph or a bundle"));
        });
    }
}
