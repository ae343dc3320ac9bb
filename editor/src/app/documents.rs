//! Opening, saving, and never losing work.

use std::path::{Path, PathBuf};

use breccia_engine::{Document, Exporter, Sink, Value};
use eframe::egui::Context;

use super::{After, App, Question, Want};
use crate::files::{rebase, write_whole};
use crate::model::{Project, State, text_of};

/// A document in one of its states.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Version {
    /// How many documents were opened before.
    document: u64,
    revision: u64,
}

/// What came of work on files.
pub(super) enum Done {
    /// Something to say.
    Say(String),
    /// A graph to open, and what was open when it was asked for.
    Open(PathBuf, Version),
}

impl App {
    /// Leaves the open document, after asking if something would be lost.
    pub(super) fn leave_document(&mut self, after: After, ctx: &Context) {
        if self.project.is_dirty() && after != After::Pick {
            self.ask_to_save(after);
        } else {
            self.go_on(after, ctx);
        }
    }

    /// Does what was asked for before a question came between.
    pub(super) fn go_on(&mut self, after: After, ctx: &Context) {
        match after {
            After::New => self.show(Project::new(State::default(), None, None)),
            After::Pick => self.want(Want::Open),
            After::Open(path) => self.open_path(&path),
            After::Preset(name) => self.open_preset(&name),
            After::Import(path) => self.import(&path),
            After::Recover(path) => self.recover(&path),
            After::Quit => {
                self.quitting = true;
                self.stop();
                ctx.send_viewport_cmd(eframe::egui::ViewportCommand::Close);
            }
        }
    }

    /// Shows another document.
    fn show(&mut self, project: Project) {
        self.stop();
        self.memory.closed();
        self.documents += 1;
        self.project = project;
        self.trail = Default::default();
        self.selection = Default::default();
        self.shapes_for = None;
        self.watched = None;
        self.results.clear();
        self.pictures.clear();
        self.board.clear();
        self.palette = None;
        self.open.gallery = false;
        self.dragging = false;
        self.full = None;
        self.forget_asked();
        self.canvas.release();
        self.canvas.arrive();
        self.recheck();
        self.due = true;
    }

    /// Opens a graph from a file; a bundle is unpacked first.
    pub fn open_path(&mut self, path: &Path) {
        let is_bundle = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("zip"));
        if is_bundle {
            return self.import(path);
        }
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let read = std::fs::read(&path).map_err(|error| error.to_string());
        match read
            .and_then(|bytes| Ok((Document::parse_bytes(&bytes).map_err(|error| error.to_string())?, bytes)))
        {
            Ok((document, bytes)) => {
                self.show(Project::new(State::new(document), Some(path.clone()), None));
                self.remember(&path, &bytes);
            }
            Err(reason) => self.say(format!("{} cannot be opened: {reason}", path.display())),
        }
    }

    /// Opens a copy of a preset.
    pub fn open_preset(&mut self, name: &str) {
        let document = breccia_graphs::preset(name).map(|preset| Document::parse(preset.ron));
        match document {
            Some(Ok(document)) => self.show(Project::new(State::new(document), None, Some(name.to_owned()))),
            Some(Err(error)) => self.say(format!("The preset {name} cannot be read: {error}")),
            None => self.say(format!("There is no preset {name}")),
        }
    }

    /// Opens a preset by name, or takes a file as if it were dropped on the window.
    ///
    /// # Errors
    /// If it is neither.
    pub fn open_named(&mut self, name: &str, ctx: &Context) -> Result<(), String> {
        if breccia_graphs::preset(name).is_some() {
            self.open_preset(name);
        } else if Path::new(name).exists() {
            self.take_file(Path::new(name), ctx);
        } else {
            let known = breccia_graphs::presets().iter().map(|preset| preset.name);
            let hint = breccia_engine::closest(name, known).map(|found| format!("; did you mean `{found}`?"));
            return Err(format!("`{name}` is neither a file nor a preset{}", hint.unwrap_or_default()));
        }
        Ok(())
    }

    /// Reads the file again, as a step that can be undone.
    pub(super) fn reload(&mut self) {
        let Some(path) = self.project.path.clone() else {
            self.say("The graph has no file yet");
            return;
        };
        let read = std::fs::read(&path).map_err(|error| error.to_string());
        match read
            .and_then(|bytes| Ok((Document::parse_bytes(&bytes).map_err(|error| error.to_string())?, bytes)))
        {
            Ok((document, bytes)) => {
                let read = State::new(document);
                self.project.edit("Reload", None, |state| *state = read);
                self.project.saved(&path);
                self.remember(&path, &bytes);
                self.say("Read again");
            }
            Err(reason) => self.say(format!("{} cannot be read: {reason}", path.display())),
        }
    }

    /// Writes the graph to its file, or asks for one.
    pub(super) fn save(&mut self) {
        match self.project.path.clone() {
            Some(path) => {
                self.save_to(&path);
            }
            None => self.save_as(),
        }
    }

    pub(super) fn save_as(&mut self) {
        self.want(Want::Save(format!("{}.ron", self.stem())));
    }

    /// What a file of the graph would be called.
    pub(super) fn stem(&self) -> String {
        let name = self.project.name();
        name.strip_suffix(".ron").unwrap_or(&name).to_owned()
    }

    /// Writes the graph to a file. Paths in it are kept so that they still name the same files. Returns whether it is written.
    pub fn save_to(&mut self, path: &Path) -> bool {
        let path = match path.extension() {
            Some(_) => path.to_owned(),
            None => path.with_extension("ron"),
        };
        let path = std::path::absolute(&path).unwrap_or(path);
        // What is written must name the same files from its new place; only if it could be written the paths here change as well.
        let (from, to) = (self.project.folder().map(Path::to_owned), path.parent());
        let registry = std::sync::Arc::clone(&self.registry);
        let rebased = |state: &mut State| rebase(&mut state.document, &registry, from.as_deref(), to);
        let mut moved = self.project.state().clone();
        rebased(&mut moved);
        let text = text_of(&moved);
        match write_whole(&path, text.as_bytes()) {
            Ok(()) => {
                if from.as_deref() != to {
                    self.project.rewrite_files(rebased);
                }
                self.project.saved(&path);
                self.memory.saved();
                self.checked_for = u64::MAX;
                self.remember(&path, text.as_bytes());
                self.say(format!("Saved {}", path.display()));
                true
            }
            Err(error) => {
                self.say(format!("{} cannot be written: {error}", path.display()));
                false
            }
        }
    }

    /// Writes what is looked at, in the format of the file's extension.
    pub(super) fn export_watched(&mut self) {
        let Some(subject) = self.watched.as_ref().and_then(|output| self.results.get(output)) else {
            self.say("Nothing is looked at that is computed");
            return;
        };
        let extensions: Vec<String> = exporters(&self.registry, &subject.value)
            .flat_map(|e| e.extensions.iter())
            .filter(|e| **e != "/")
            .map(|e| (*e).to_owned())
            .collect();
        if extensions.is_empty() {
            let ty = subject.value.type_name();
            self.say(format!("Values of type {ty} cannot be written to files"));
            return;
        }
        if subject.stale {
            self.say("What is shown is not up to date yet: it is written once it is");
            return;
        }
        let output = subject.label.clone();
        self.want(Want::Output(output, extensions));
    }

    /// Writes a result to a file, in the background.
    pub(super) fn write_result(&mut self, output: &str, path: PathBuf) {
        // A dialog may stand open while the graph is changed.
        let Some(subject) = self.results.get(output).filter(|subject| !subject.stale) else {
            self.say(format!("{output} is not up to date any more: nothing is written"));
            return;
        };
        let value = subject.value.clone();
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        let registry = std::sync::Arc::clone(&self.registry);
        self.work(move || {
            let exporter = exporters(&registry, &value)
                .find(|exporter| exporter.extensions.contains(&extension.as_str()));
            let result = match exporter {
                Some(exporter) => Sink::new(&path).and_then(|mut sink| {
                    (exporter.write)(&value, &mut sink)?;
                    sink.commit()
                }),
                None => {
                    let ty = value.type_name();
                    Err(std::io::Error::other(format!("values of type {ty} are not written as .{extension}")))
                }
            };
            Done::Say(match result {
                Ok(_) => format!("Wrote {}", path.display()),
                Err(error) => format!("{} cannot be written: {error}", path.display()),
            })
        });
    }

    /// Does something with files that may take its time, and takes in what comes of it with a later frame.
    fn work(&mut self, work: impl FnOnce() -> Done + Send + 'static) {
        let (sender, receiver) = std::sync::mpsc::channel();
        std::thread::spawn(move || {
            // The window may be closed by now.
            let _ = sender.send(work());
        });
        self.working.push(receiver);
    }

    /// What is open, to be compared with what is open later.
    pub(super) fn version(&self) -> Version {
        Version { document: self.documents, revision: self.project.revision() }
    }

    fn import(&mut self, path: &Path) {
        let path = path.to_owned();
        let version = self.version();
        self.say(format!("Unpacking {}", path.display()));
        self.work(move || {
            let read = std::fs::read(&path).map_err(|error| error.to_string());
            let into = path.with_extension("");
            match read.and_then(|bytes| {
                crate::files::bundle::import(&bytes, &into).map_err(|error| error.to_string())
            }) {
                Ok(graph) => Done::Open(graph, version),
                Err(reason) => Done::Say(format!("{} cannot be unpacked: {reason}", path.display())),
            }
        });
    }

    pub(super) fn export(&mut self, path: &Path) {
        let document = self.project.state().to_document();
        let folder = self.project.folder().unwrap_or(Path::new("")).to_owned();
        let (registry, files) = (std::sync::Arc::clone(&self.registry), std::sync::Arc::clone(&self.files));
        let path = path.to_owned();
        self.work(move || {
            let packed = crate::files::bundle::export(&document, &folder, &registry, &*files);
            let written = packed
                .map_err(|error| error.to_string())
                .and_then(|bytes| write_whole(&path, &bytes).map_err(|error| error.to_string()));
            Done::Say(match written {
                Ok(()) => format!("Packed into {}", path.display()),
                Err(reason) => format!("The bundle cannot be made: {reason}"),
            })
        });
    }

    /// Goes on where a document was that another run of the program did not save.
    fn recover(&mut self, path: &Path) {
        match self.memory.recovered(path) {
            Some((text, original)) => match Document::parse(&text) {
                Ok(document) => {
                    self.show(Project::new(State::new(document), original, Some("recovered".into())));
                    self.project.unsaved();
                    self.memory.take_over(path);
                    self.say("Recovered; save it to keep it");
                }
                Err(error) => self.say(format!("What was kept cannot be read: {error}")),
            },
            None => self.say("What was kept is not there any more"),
        }
    }

    /// Notes that a file is open: for the list of recent files, and to see when somebody else changes it.
    fn remember(&mut self, path: &Path, contents: &[u8]) {
        self.memory.opened(path, contents);
        self.question = self.question.take().filter(|question| *question != Question::Changed);
    }

    pub(super) fn write_made(&mut self, path: &Path, files: Vec<(String, Vec<u8>)>) {
        let path = path.to_owned();
        self.work(move || {
            let result = match files.as_slice() {
                [(_, contents)] => write_whole(&path, contents),
                many => many.iter().try_for_each(|(name, contents)| write_whole(&path.join(name), contents)),
            };
            Done::Say(match result {
                Ok(()) => format!("Wrote {}", path.display()),
                Err(error) => format!("{} cannot be written: {error}", path.display()),
            })
        });
    }
}

fn exporters<'a>(
    registry: &'a breccia_engine::Registry,
    value: &Value,
) -> impl Iterator<Item = &'a Exporter> {
    let ty = value.type_name();
    registry.exporters().iter().filter(move |exporter| exporter.ty == ty)
}
