//! Searching: for a node to add, or for a command. A text field and what fits, best first.

use breccia_engine::{Group, Registry};
use eframe::egui::{
    self, Align2, Context, Id, Key, Modifiers, RichText, ScrollArea, TextEdit, WidgetInfo, WidgetType,
};
use nucleo_matcher::pattern::{CaseMatching, Normalization, Pattern};
use nucleo_matcher::{Config, Matcher, Utf32Str};

use crate::action::{Action, Joint, Kind, Pin};
use crate::command::Command;
use crate::model::{Shape, Socket};
use crate::theme;

/// Most that are shown at a time.
const SHOWN: usize = 60;

/// One thing that can be picked.
#[derive(Clone)]
pub struct Entry {
    /// What it is called.
    pub title: String,
    /// One line more.
    pub detail: String,
    /// What else it may be found by.
    pub keywords: String,
    /// Its family, for its colour.
    pub category: String,
    /// What picking it does.
    pub pick: Pick,
}

/// What picking an entry does.
#[derive(Clone)]
pub enum Pick {
    /// Adds a node.
    Node(Kind),
    /// Does a command.
    Command(Command),
}

/// A search that is open.
pub struct Palette {
    query: String,
    entries: Vec<Entry>,
    chosen: usize,
    at: [i32; 2],
    joint: Option<Joint>,
    title: String,
    /// Whether the text field has had the keyboard yet.
    fresh: bool,
}

/// What nodes there are to add: types, groups of the document, groups kept as presets.
pub fn nodes<'a>(
    registry: &Registry,
    groups: impl Iterator<Item = (&'a String, &'a Group)>,
    presets: &[(String, String)],
) -> Vec<Entry> {
    let types = registry.nodes().map(|ty| {
        let spec = &ty.spec;
        let sockets = spec.inputs.iter().chain(&spec.outputs).map(|socket| socket.ty);
        let params = spec.params.iter().map(|param| param.name);
        let words: Vec<&str> = sockets.chain(params).chain(spec.paper).collect();
        Entry {
            title: spec.id.to_owned(),
            detail: spec.summary.to_owned(),
            keywords: format!("{} {}", spec.category, words.join(" ")),
            category: spec.category.to_owned(),
            pick: Pick::Node(Kind::Type(spec.id.to_owned())),
        }
    });
    let groups = groups.map(|(name, group)| Entry {
        title: name.clone(),
        detail: first_line(&group.docs, "A group of this graph"),
        keywords: "group".into(),
        category: "flow".into(),
        pick: Pick::Node(Kind::Group(name.clone())),
    });
    let presets = presets.iter().map(|(name, docs)| Entry {
        title: name.clone(),
        detail: first_line(docs, "A group of yours"),
        keywords: "group preset own".into(),
        category: "flow".into(),
        pick: Pick::Node(Kind::Preset(name.clone())),
    });
    types.chain(groups).chain(presets).collect()
}

/// All commands.
pub fn commands() -> Vec<Entry> {
    let entry = |command: &Command| Entry {
        title: command.title().trim_end_matches('…').to_owned(),
        detail: command.docs().to_owned(),
        keywords: command.menu().to_owned(),
        category: String::new(),
        pick: Pick::Command(*command),
    };
    Command::ALL.iter().map(entry).collect()
}

fn first_line(docs: &str, otherwise: &str) -> String {
    docs.lines().find(|line| !line.is_empty()).unwrap_or(otherwise).to_owned()
}

/// Leaves only the nodes that can be joined. `socket` tells what a socket of the graph is.
pub fn fitting(
    entries: Vec<Entry>,
    joint: &Joint,
    socket: &dyn Fn(&Pin) -> Option<Socket>,
    shape: &dyn Fn(&Kind) -> Option<Shape>,
) -> Vec<Entry> {
    let fits = |shape: &Shape| match joint {
        Joint::Pin(pin) => socket(pin).is_some_and(|from| {
            let sockets = if pin.output { &shape.inputs } else { &shape.outputs };
            from.ty.is_empty() || sockets.iter().any(|to| to.ty == from.ty)
        }),
        Joint::Between { from, to, .. } => socket(from).zip(socket(to)).is_some_and(|(from, to)| {
            shape.inputs.iter().any(|s| s.ty == from.ty) && shape.outputs.iter().any(|s| s.ty == to.ty)
        }),
        Joint::Link(_) => true,
    };
    entries
        .into_iter()
        .filter(|entry| match &entry.pick {
            Pick::Node(kind) => shape(kind).is_some_and(|shape| fits(&shape)),
            Pick::Command(_) => false,
        })
        .collect()
}

/// The entries that a text finds, best first; all of them for an empty text.
pub fn found(entries: &[Entry], query: &str) -> Vec<usize> {
    let pattern = Pattern::parse(query, CaseMatching::Ignore, Normalization::Smart);
    let mut matcher = Matcher::new(Config::DEFAULT);
    let mut buffer = Vec::new();
    let mut score = |text: &str| pattern.score(Utf32Str::new(text, &mut buffer), &mut matcher).unwrap_or(0);
    let mut scored: Vec<(u32, usize)> = entries
        .iter()
        .enumerate()
        .map(|(i, entry)| {
            let title = score(&entry.title).saturating_mul(4);
            let detail = score(&entry.detail).saturating_mul(2);
            (title.max(detail).max(score(&entry.keywords)), i)
        })
        .filter(|(score, _)| *score > 0 || query.trim().is_empty())
        .collect();
    scored.sort_by_key(|&(score, i)| (std::cmp::Reverse(score), i));
    scored.into_iter().map(|(_, i)| i).collect()
}

impl Palette {
    /// Opens a search.
    pub fn new(title: impl Into<String>, entries: Vec<Entry>, at: [i32; 2], joint: Option<Joint>) -> Self {
        Self { query: String::new(), entries, chosen: 0, at, joint, title: title.into(), fresh: true }
    }

    /// Draws it. Returns whether it stays open, and what was picked.
    pub fn ui(&mut self, ctx: &Context) -> (bool, Option<Action>) {
        let hits = found(&self.entries, &self.query);
        let shown = hits.len().min(SHOWN);
        let (up, down, enter, escape) = ctx.input_mut(|i| {
            (
                i.consume_key(Modifiers::NONE, Key::ArrowUp),
                i.consume_key(Modifiers::NONE, Key::ArrowDown)
                    || i.consume_key(Modifiers::NONE, Key::Tab) && !self.fresh,
                i.consume_key(Modifiers::NONE, Key::Enter),
                i.consume_key(Modifiers::NONE, Key::Escape),
            )
        });
        if shown > 0 {
            self.chosen = if up {
                (self.chosen + shown - 1) % shown
            } else if down {
                (self.chosen + 1) % shown
            } else {
                self.chosen.min(shown - 1)
            };
        }
        let mut picked = enter.then(|| hits.get(self.chosen).copied()).flatten();
        let mut open = !escape;
        let window = egui::Window::new(self.title.as_str())
            .id(Id::new("search"))
            .anchor(Align2::CENTER_TOP, [0.0, 70.0])
            .collapsible(false)
            .resizable(false)
            .default_width(460.0)
            .open(&mut open)
            .show(ctx, |ui| {
                ui.set_width(460.0);
                let field = TextEdit::singleline(&mut self.query)
                    .hint_text("Name, family or keyword")
                    .desired_width(f32::INFINITY);
                let field = ui.add(field.id(Id::new("search text")));
                field.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, "Search"));
                if self.fresh {
                    self.fresh = false;
                    field.request_focus();
                }
                if field.changed() {
                    self.chosen = 0;
                }
                ui.separator();
                if hits.is_empty() {
                    ui.label(if self.entries.is_empty() {
                        "No node fits there."
                    } else {
                        "Nothing is called that."
                    });
                }
                ScrollArea::vertical().max_height(380.0).auto_shrink([false, true]).show(ui, |ui| {
                    for (row, &hit) in hits.iter().take(SHOWN).enumerate() {
                        let entry = &self.entries[hit];
                        let response = ui
                            .horizontal(|ui| {
                                let (rect, _) =
                                    ui.allocate_exact_size(egui::vec2(6.0, 18.0), egui::Sense::hover());
                                if !entry.category.is_empty() {
                                    ui.painter().rect_filled(rect, 2, theme::category(&entry.category));
                                }
                                let response = ui.selectable_label(row == self.chosen, &entry.title);
                                let weak = ui.add(
                                    egui::Label::new(RichText::new(&entry.detail).weak().small()).truncate(),
                                );
                                weak.on_hover_text(&entry.detail);
                                response
                            })
                            .inner;
                        if (up || down) && row == self.chosen {
                            response.scroll_to_me(None);
                        }
                        if response.clicked() {
                            picked = Some(hit);
                        }
                    }
                });
            });
        // A click elsewhere closes it.
        let elsewhere = window.is_some_and(|window| window.response.clicked_elsewhere()) && !self.fresh;
        let action = picked.and_then(|hit| self.entries.get(hit)).map(|entry| match &entry.pick {
            Pick::Node(kind) => Action::Add { kind: kind.clone(), at: self.at, joint: self.joint.clone() },
            Pick::Command(command) => Action::Command(*command),
        });
        (open && action.is_none() && !elsewhere, action)
    }
}
