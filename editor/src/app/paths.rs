//! A path typed by hand, where the system has no dialog to pick one with.

use std::path::Path;
use std::time::Duration;

use eframe::egui::{self, Align2, Context, Key, TextEdit, WidgetInfo, WidgetType};

use super::{App, Want};

/// Nobody closes a dialog so soon: there was none.
pub(super) const NO_DIALOG: Duration = Duration::from_millis(500);

/// A path that is asked for.
pub(super) struct PathSheet {
    want: Want,
    text: String,
    fresh: bool,
}

impl PathSheet {
    /// Asks for a path, beginning with a folder and a name that suggest themselves.
    pub fn new(want: Want, folder: Option<&Path>) -> Self {
        let folder = folder.map(Path::to_owned).or_else(|| std::env::current_dir().ok()).unwrap_or_default();
        let name = match &want {
            Want::Save(name) | Want::Export(name) => name.clone(),
            Want::Output(output, extensions) => Want::name_of_result(output, extensions),
            Want::Made(files) => match files.as_slice() {
                [(name, _)] => name.clone(),
                _ => "turntable".to_owned(),
            },
            Want::Open | Want::Import | Want::Param { .. } => String::new(),
        };
        Self { want, text: folder.join(name).to_string_lossy().into_owned(), fresh: true }
    }

    /// What it is asked for.
    pub fn want(&self) -> &Want {
        &self.want
    }

    fn title(&self) -> &'static str {
        match self.want {
            Want::Open => "Open a graph",
            Want::Save(_) => "Save the graph",
            Want::Import => "Import a bundle",
            Want::Export(_) => "Export a bundle",
            Want::Param { .. } => "Pick a file",
            Want::Output(..) => "Export a result",
            Want::Made(_) => "Save what the viewport shows",
        }
    }
}

impl App {
    /// Draws the question for a path, if there is one.
    pub(super) fn path_sheet(&mut self, ctx: &Context) {
        // One question after the other: the last path may have to be asked about first.
        let asking = self.is_asking();
        let Some(sheet) = self.path_sheets.front_mut().filter(|_| !asking) else { return };
        let (mut open, mut done, mut cancelled) = (true, false, false);
        let window =
            egui::Window::new(sheet.title()).id(egui::Id::new("path")).collapsible(false).resizable(false);
        window.anchor(Align2::CENTER_TOP, [0.0, 90.0]).open(&mut open).show(ctx, |ui| {
            ui.label("This system offers no file dialog: type the path.");
            let field = ui.add(TextEdit::singleline(&mut sheet.text).desired_width(520.0));
            field.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, "Path"));
            if std::mem::take(&mut sheet.fresh) {
                field.request_focus();
            }
            done = field.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
            ui.horizontal(|ui| {
                done |= ui.button("OK").clicked();
                cancelled = ui.button("Cancel").clicked();
            });
        });
        if done {
            if let Some(sheet) = self.path_sheets.pop_front() {
                self.answer_carefully(sheet.want, Path::new(&sheet.text), ctx);
            }
        } else if !open || cancelled {
            self.give_up_path();
        }
    }

    /// The user thought better of it.
    pub(super) fn give_up_path(&mut self) {
        if let Some(sheet) = self.path_sheets.pop_front() {
            self.not_answered(&sheet.want);
        }
    }
}
