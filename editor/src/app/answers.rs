//! What is done with a path that was asked for.

use std::path::{Path, PathBuf};
use std::sync::mpsc::TryRecvError;
use std::time::{Duration, Instant};

use breccia_engine::ParamValue;
use eframe::egui::Context;

use super::documents::Done;
use super::paths::{NO_DIALOG, PathSheet};
use super::{After, App, Picked, Question, Want};
use crate::files::relative;
use crate::model;

/// A dialog that was asked for so long ago may be lost: it is asked for again.
const LOST: Duration = Duration::from_secs(60);

impl App {
    /// Asks for a file.
    pub(super) fn want(&mut self, want: Want) {
        // A desktop may take its time, and a dialog may lie behind the window: pressing the key again must not bring a second one.
        if self.picking.iter().any(|picked| picked.want == want && picked.asked.elapsed() < LOST) {
            self.say("The dialog for that is open already, perhaps behind this window");
            return;
        }
        let answer = self.picker.ask(&want, self.project.folder());
        self.picking.push(Picked { want, answer, asked: Instant::now() });
    }

    /// What was asked for about a document that is not open any more is not done to the next one.
    pub(super) fn forget_asked(&mut self) {
        self.picking.retain(|picked| !picked.want.is_about_the_document());
        self.path_sheets.retain(|sheet| !sheet.want().is_about_the_document());
        self.replacing = None;
        self.question = None;
        self.then = None;
    }

    /// Asks what is to become of changes that are not saved; a question that stood before is answered by no.
    pub(super) fn ask_to_save(&mut self, after: After) {
        self.replacing = None;
        self.then = None;
        self.question = Some(Question::Unsaved(after));
    }

    /// Takes in the answers of dialogs and of files that were being written. What would ask something waits while another question stands.
    pub(super) fn take_answers(&mut self, ctx: &Context) {
        while !self.is_asking() {
            let Some((want, path, after)) = self.next_answer() else { break };
            match path {
                // The dialog asked whether this file may be replaced, not the one that its name stands for, nor those in a folder.
                Some(path) if want.complete(&path) != path || want.several().is_some() => {
                    self.answer_carefully(want, &path, ctx)
                }
                Some(path) => self.answer(want, path, ctx),
                // One path at a time: what stands there already is typed first.
                None if after < NO_DIALOG => {
                    if self.path_sheets.iter().all(|sheet| *sheet.want() != want) {
                        self.path_sheets.push_back(PathSheet::new(want, self.project.folder()));
                    }
                }
                None => self.not_answered(&want),
            }
        }
        let done = &mut self.done;
        self.working.retain(|receiver| match receiver.try_recv() {
            Ok(found) => {
                done.push(found);
                false
            }
            Err(error) => error == TryRecvError::Empty,
        });
        for done in std::mem::take(&mut self.done) {
            match done {
                Done::Say(text) => self.say(text),
                Done::Open(..) if self.question.is_some() => self.done.push(done),
                Done::Open(path, version) if version == self.version() => self.open_path(&path),
                // Somebody went on working meanwhile.
                Done::Open(path, _) => self.leave_document(After::Open(path), ctx),
            }
        }
        if !self.picking.is_empty() || !self.working.is_empty() {
            ctx.request_repaint_after(Duration::from_millis(100));
        }
    }

    /// Whether the user is being asked something that another question must not take the place of.
    pub(super) fn is_asking(&self) -> bool {
        self.question.as_ref().is_some_and(|question| *question != Question::Changed)
    }

    /// The next answer of a dialog, with how long it took.
    fn next_answer(&mut self) -> Option<(Want, Option<PathBuf>, Duration)> {
        let (at, path, after) =
            self.picking.iter().enumerate().find_map(|(at, picked)| match picked.answer.try_recv() {
                Ok(path) => Some((at, path, picked.asked.elapsed())),
                Err(TryRecvError::Empty) => None,
                Err(TryRecvError::Disconnected) => Some((at, None, Duration::ZERO)),
            })?;
        Some((self.picking.remove(at).want, path, after))
    }

    /// The user picked no path.
    pub(super) fn not_answered(&mut self, want: &Want) {
        if matches!(want, Want::Save(_)) {
            // What was to come after saving would lose work.
            self.then = None;
        }
    }

    /// Does what a path was asked for, after a question if that would replace a file and nobody was asked yet.
    pub(super) fn answer_carefully(&mut self, want: Want, path: &Path, ctx: &Context) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let path = want.complete(&path);
        let own = matches!(want, Want::Save(_)) && self.project.path.as_ref() == Some(&path);
        let there = match want.several() {
            Some(mut names) => names.find_map(|name| Some(path.join(name)).filter(|path| path.is_file())),
            None => Some(path.clone()).filter(|path| want.writes() && path.is_file() && !own),
        };
        if let Some(there) = there {
            self.question = Some(Question::Replace(there));
            self.replacing = Some((want, path));
        } else {
            self.answer(want, path, ctx);
        }
    }

    /// Does what a path was asked for.
    pub(super) fn answer(&mut self, want: Want, path: PathBuf, ctx: &Context) {
        match want {
            Want::Open => self.leave_document(After::Open(path), ctx),
            Want::Save(_) => {
                let saved = self.save_to(&path);
                if let (true, Some(after)) = (saved, self.then.take()) {
                    self.go_on(after, ctx);
                }
            }
            Want::Import => self.leave_document(After::Import(path), ctx),
            Want::Export(_) => self.export(&path),
            Want::Param { at, node, param, .. } => {
                // Another graph of the document may be looked at by now.
                let value = Some(ParamValue::Text(relative(&path, self.project.folder())));
                self.project.edit(&format!("Change {}", param.replace('_', " ")), None, |state| {
                    model::set_param(state, &at, &node, &param, value)
                });
            }
            Want::Output(output, _) => self.write_result(&output, path),
            Want::Made(files) => self.write_made(&path, files),
        }
    }
}
