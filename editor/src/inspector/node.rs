//! A node: what it is, how it is, its parameters and outputs.

use std::collections::BTreeMap;

use breccia_engine::{Device, NodeEntry, NodeMode, ParamValue};
use eframe::egui::{CollapsingHeader, RichText, TextEdit, Ui, WidgetInfo, WidgetType};

use super::param::Row;
use crate::action::{Action, Pin};
use crate::model::{Address, Exposure, Shape, State, exposure};
use crate::run::{NodeStatus, Phase};

/// All that the inspector of a node hangs on.
pub struct Subject<'a> {
    /// The document.
    pub state: &'a State,
    /// The graph that the node is in.
    pub at: &'a Address,
    /// The node.
    pub name: &'a str,
    /// The node as the document has it.
    pub entry: &'a NodeEntry,
    /// What nodes of the graph look like.
    pub shapes: &'a BTreeMap<String, Shape>,
    /// What it looks like.
    pub shape: &'a Shape,
    /// What is known of it.
    pub status: Option<&'a NodeStatus>,
    /// Problems of it.
    pub problems: &'a [String],
    /// Whether it can be changed.
    pub editable: bool,
}

/// Shows a node.
pub fn node(ui: &mut Ui, subject: &Subject<'_>, actions: &mut Vec<Action>) {
    let Subject { name, shape, .. } = *subject;
    heading(ui, subject, actions);
    for problem in subject.problems {
        ui.colored_label(ui.visuals().error_fg_color, problem);
    }
    if let Some(status) = subject.status {
        state(ui, status);
    }
    ui.separator();
    if shape.params.is_empty() {
        ui.weak("No parameters.");
    }
    let interface = subject.state.level(subject.at).map(|level| level.interface);
    for param in &shape.params {
        let exposure = exposure(subject.state, subject.at, name, &param.name);
        let shared = match (&exposure, interface) {
            (Some(Exposure::Param(name)), Some(interface)) => {
                interface.params.get(name).and_then(|p| p.default.clone())
            }
            _ => None,
        };
        let own = subject.entry.params.get(&param.name).cloned();
        let set = shared.is_some() || own.is_some();
        let value = shared.or(own).unwrap_or_else(|| param.default.clone());
        Row {
            node: name,
            param,
            value: &listed(value, &param.default),
            set,
            exposure: exposure.as_ref(),
            linkable: &linkable(subject, param),
            enabled: subject.editable,
        }
        .ui(ui, actions);
    }
    for (param, value) in unknown_params(subject) {
        ui.horizontal(|ui| {
            ui.colored_label(ui.visuals().warn_fg_color, format!("{param}: {value}"));
            ui.weak("not known here, kept as it is");
        });
    }
    outputs(ui, subject, actions);
    CollapsingHeader::new("Help").id_salt("help").default_open(false).show(ui, |ui| {
        super::help::markdown(ui, &shape.docs);
        if let Some(paper) = shape.paper {
            ui.label(RichText::new(paper).italics());
        }
        for (title, sockets) in [("Inputs", &shape.inputs), ("Outputs", &shape.outputs)] {
            if !sockets.is_empty() {
                ui.strong(title);
            }
            for socket in sockets {
                super::help::markdown(ui, &format!("`{}` ({}) {}", socket.name, socket.ty, socket.docs));
            }
        }
    });
}

/// One number where the parameter is a list is a list of one.
fn listed(value: ParamValue, default: &ParamValue) -> ParamValue {
    match (&value, default) {
        (ParamValue::Int(_) | ParamValue::Float(_), ParamValue::List(_)) => ParamValue::List(vec![value]),
        _ => value,
    }
}

fn heading(ui: &mut Ui, subject: &Subject<'_>, actions: &mut Vec<Action>) {
    let name = subject.name;
    ui.horizontal(|ui| {
        let id = ui.make_persistent_id("node name");
        let mut draft = ui.data(|data| data.get_temp::<String>(id)).unwrap_or_else(|| name.to_owned());
        let field = TextEdit::singleline(&mut draft)
            .id(eframe::egui::Id::new("node name field"))
            .desired_width(190.0);
        let response = ui.add_enabled(subject.editable, field.font(eframe::egui::TextStyle::Heading));
        response.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, "Name of the node"));
        if response.has_focus() {
            ui.data_mut(|data| data.insert_temp(id, draft));
        } else {
            if response.lost_focus() && draft != name {
                actions.push(Action::Rename(name.to_owned(), draft));
            }
            ui.data_mut(|data| data.remove::<String>(id));
        }
        match subject.entry.mode {
            NodeMode::Normal => {}
            NodeMode::Mute => {
                ui.colored_label(ui.visuals().warn_fg_color, "muted");
            }
            NodeMode::Bypass => {
                ui.colored_label(ui.visuals().warn_fg_color, "bypassed");
            }
        }
    });
    ui.weak(&subject.shape.ty);
    ui.label(&subject.shape.summary);
}

fn state(ui: &mut Ui, status: &NodeStatus) {
    let place = match status.device {
        Some(Device::Gpu) => " on the compute device",
        Some(Device::Cpu) => " on CPU threads",
        None => "",
    };
    let text = match status.phase {
        Phase::Idle => String::new(),
        Phase::Running => format!("Computing{place}, {:.0} %", status.fraction * 100.0),
        Phase::Done => format!("Computed in {}{place}", crate::canvas::seconds(status.seconds)),
        Phase::Cached(_) => "Found in the cache".into(),
        Phase::Failed | Phase::Skipped => String::new(),
    };
    if !text.is_empty() {
        ui.weak(text);
    }
    if !status.summary.is_empty() {
        let stale = if status.stale { " (stale)" } else { "" };
        ui.weak(format!("{}, {}{stale}", status.summary, crate::canvas::bytes(status.bytes)));
    }
    if let Some(error) = &status.error {
        ui.colored_label(ui.visuals().error_fg_color, error);
    }
    for warning in &status.warnings {
        ui.colored_label(ui.visuals().warn_fg_color, warning);
    }
}

/// Exposed parameters that take the same kind of values.
fn linkable(subject: &Subject<'_>, param: &crate::model::ParamShape) -> Vec<String> {
    let Some(level) = subject.state.level(subject.at) else { return Vec::new() };
    let kind = |target: &str| {
        let (node, name) = target.split_once('.')?;
        Some(std::mem::discriminant(&subject.shapes.get(node)?.param(name)?.kind))
    };
    let own = format!("{}.{}", subject.name, param.name);
    let fits = |targets: &Vec<String>| {
        !targets.contains(&own)
            && targets
                .iter()
                .filter_map(|t| kind(t))
                .all(|found| found == std::mem::discriminant(&param.kind))
    };
    level
        .interface
        .params
        .iter()
        .filter(|(_, exposed)| fits(&exposed.targets))
        .map(|(name, _)| name.clone())
        .collect()
}

fn unknown_params(subject: &Subject<'_>) -> Vec<(String, String)> {
    let unknown = subject.entry.params.iter().filter(|(name, _)| subject.shape.param(name).is_none());
    unknown.map(|(name, value)| (name.clone(), value.to_string())).collect()
}

fn outputs(ui: &mut Ui, subject: &Subject<'_>, actions: &mut Vec<Action>) {
    let offered = |socket: &str| {
        let level = subject.state.level(subject.at)?;
        let found =
            level.interface.outputs.iter().find(|(_, o)| o.node == subject.name && o.socket == socket);
        found.map(|(name, _)| name.clone())
    };
    if !subject.shape.outputs.is_empty() {
        ui.separator();
    }
    for socket in &subject.shape.outputs {
        let pin = Pin { node: subject.name.to_owned(), socket: socket.name.clone(), output: true };
        ui.horizontal(|ui| {
            ui.label(&socket.name).on_hover_text(&socket.docs);
            ui.weak(&socket.ty);
            let look = ui.small_button("Look at");
            look.widget_info(|| {
                WidgetInfo::labeled(WidgetType::Button, true, format!("Look at {}", socket.name))
            });
            if look.clicked() {
                actions.push(Action::Watch(pin.clone()));
            }
            let name = offered(&socket.name);
            let mut on = name.is_some();
            let hint = name.map_or("Offer as an output of the graph".into(), |name| {
                format!("An output of the graph, `{name}`")
            });
            let response = ui
                .add_enabled(subject.editable, eframe::egui::Checkbox::new(&mut on, "output"))
                .on_hover_text(hint);
            response.widget_info(|| {
                WidgetInfo::selected(WidgetType::Checkbox, true, on, format!("{} is an output", socket.name))
            });
            if response.changed() {
                actions.push(Action::Output(pin));
            }
        });
    }
}
