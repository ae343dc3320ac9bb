//! What happens: the line below, the list of problems, and questions.

use std::time::Duration;

use eframe::egui::{
    self, Align, Context, Layout, Panel, Response, RichText, ScrollArea, Ui, WidgetInfo, WidgetType,
};

use super::{App, Appearing, Question};
use crate::action::Action;
use crate::command::Command;

impl App {
    /// The line below: what was said last, what runs, how many problems.
    pub(super) fn line(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        ui.horizontal(|ui| {
            let count = self.checked.problems.len()
                + self.board.failures().count()
                + usize::from(self.checked.include_error.is_some());
            let text = if count == 0 {
                "No problems".to_owned()
            } else if count == 1 {
                "1 problem".to_owned()
            } else {
                format!("{count} problems")
            };
            // Red is not readable on the ground of what is chosen.
            let text = match (count, self.open.problems) {
                (_, true) => RichText::new(text),
                (0, false) => RichText::new(text).weak(),
                (_, false) => RichText::new(text).color(ui.visuals().error_fg_color),
            };
            let button = ui
                .selectable_label(self.open.problems, text)
                .on_hover_text("Shows or hides the list of problems");
            if button.clicked() {
                self.open.problems = !self.open.problems;
            }
            ui.separator();
            let running: Vec<_> = self
                .board
                .running()
                .filter(|(name, _)| !name.contains('/'))
                .map(|(name, done)| (name.to_owned(), done))
                .collect();
            if let Some((name, done)) = running.first() {
                let elapsed = self.board.started.map_or(0.0, |started| started.elapsed().as_secs_f64());
                let more = if running.len() > 1 {
                    format!(" and {} more", running.len() - 1)
                } else {
                    String::new()
                };
                ui.label(format!("{name} {:.0} %{more}, {}", done * 100.0, crate::canvas::seconds(elapsed)));
                if ui.small_button("Stop").clicked() {
                    actions.push(Action::Command(Command::Stop));
                }
            } else if let Some((seconds, computed, cached)) = self.board.last {
                ui.weak(format!("{computed} computed, {cached} cached, {}", crate::canvas::seconds(seconds)));
            }
            if let Some((text, since)) = &self.said {
                ui.separator();
                let label = if since.elapsed() < Duration::from_secs(8) {
                    RichText::new(text)
                } else {
                    RichText::new(text).weak()
                };
                ui.add(egui::Label::new(label).truncate()).on_hover_text(text);
            }
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let (values, bytes) = self.runner.engine().memory_usage();
                ui.weak(format!("{values} results, {}", crate::canvas::bytes(bytes)))
                    .on_hover_ui(|ui| drop(ui.label(self.told_of_memory())));
                if let Some(device) = &self.board.device {
                    ui.weak("device").on_hover_text(device);
                }
            });
        });
    }

    /// What of memory the program takes, and results may take.
    fn told_of_memory(&self) -> String {
        let [resident, total] = self.budget.usage();
        let total = crate::canvas::bytes(total);
        let now = if resident > 0 {
            format!("; now it takes {} in all", crate::canvas::bytes(resident))
        } else {
            String::new()
        };
        format!(
            "Results that are kept in memory: they have what the rest of the program leaves of {total}{now}"
        )
    }

    /// Questions. They stand above the canvas and keep nobody from going on.
    pub(super) fn notices(&mut self, ui: &mut Ui, actions: &mut Vec<Action>, ctx: &Context) {
        // A file that changes by itself takes the keyboard from nobody, and no question from who is typing.
        let asking = self.is_asking();
        let fresh = self.open.appears(Appearing::Question, asking) && !ctx.text_edit_focused();
        let Some(question) = self.question.clone() else { return };
        // The answer that the keyboard goes to first does nothing: a key that is held a little too long, or meant for something else, does no harm.
        let harmless = |response: Response| {
            if fresh {
                response.request_focus();
            }
            response.clicked()
        };
        Panel::top("question").show(ui, |ui| {
            ui.horizontal_wrapped(|ui| match question {
                Question::Unsaved(after) => {
                    ui.strong(format!("{} has changes that are not saved.", self.project.name()));
                    if ui.button("Save and go on").clicked() {
                        self.question = None;
                        match self.project.path.clone() {
                            Some(path) => {
                                if self.save_to(&path) {
                                    self.go_on(after.clone(), ctx);
                                }
                            }
                            None => {
                                self.then = Some(after.clone());
                                self.save_as();
                            }
                        }
                    }
                    if ui.button("Go on without saving").clicked() {
                        self.question = None;
                        self.go_on(after, ctx);
                    }
                    if harmless(ui.button("Stay")) {
                        self.stay();
                    }
                }
                Question::Replace(path) => {
                    let name = path.file_name().unwrap_or_default().to_string_lossy();
                    ui.strong(format!("There is a file {name} already."))
                        .on_hover_text(path.display().to_string());
                    if ui.button("Replace it").clicked() {
                        self.question = None;
                        if let Some((want, path)) = self.replacing.take() {
                            self.answer(want, path, ctx);
                        }
                    }
                    if harmless(ui.button("Leave it")) {
                        self.stay();
                    }
                }
                Question::Changed => {
                    ui.strong(format!("{} was changed by another program.", self.project.name()));
                    if ui.button("Reload").clicked() {
                        self.question = None;
                        actions.push(Action::Command(Command::Reload));
                    }
                    if ui.button("Keep what is here").clicked() {
                        self.question = None;
                        self.memory.accept();
                    }
                }
            });
        });
    }

    /// Does nothing of what a question is about.
    pub(super) fn stay(&mut self) {
        self.question = self.question.take().filter(|question| *question == Question::Changed);
        if let Some((want, _)) = self.replacing.take() {
            self.not_answered(&want);
        }
    }

    pub(super) fn problems(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            let mut row = |ui: &mut Ui, node: Option<String>, text: &str| {
                ui.horizontal(|ui| {
                    if let Some(node) = node {
                        let show = ui.small_button("Show me");
                        show.widget_info(|| {
                            WidgetInfo::labeled(WidgetType::Button, true, format!("Show {node}"))
                        });
                        if show.clicked() {
                            actions.push(Action::Reveal(node));
                        }
                    }
                    ui.add(egui::Label::new(text).wrap());
                });
            };
            if let Some(error) = &self.checked.include_error {
                row(ui, None, error);
            }
            for problem in &self.checked.problems {
                row(ui, problem.node.clone(), &problem.to_string());
            }
            for (node, status) in self.board.failures() {
                row(
                    ui,
                    Some(node.to_owned()),
                    &format!("{node}: {}", status.error.as_deref().unwrap_or("failed")),
                );
            }
            for warning in &self.board.warnings {
                row(ui, None, warning);
            }
        });
    }
}
