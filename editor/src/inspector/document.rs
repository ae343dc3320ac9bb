//! The graph itself: what it is for, what it takes and gives.

use breccia_engine::ParamValue;
use eframe::egui::{CollapsingHeader, TextEdit, Ui, WidgetInfo, WidgetType};

use super::param::Row;
use crate::action::Action;
use crate::model::{Address, Exposure, Shape, State};

/// Shows what the graph offers.
pub fn document(
    ui: &mut Ui,
    state: &State,
    at: &Address,
    shapes: &std::collections::BTreeMap<String, Shape>,
    editable: bool,
    actions: &mut Vec<Action>,
) {
    let Some(level) = state.level(at) else { return };
    if at.0.is_empty() {
        title(ui, state, actions);
    } else {
        ui.heading(format!("Group {}", at.0.join(" / ")));
    }
    let interface = level.interface;
    if !interface.inputs.is_empty() {
        ui.separator();
        ui.strong("Files and values to give");
    }
    for (name, input) in &interface.inputs {
        let shape = shapes.get(&input.node).and_then(|shape| shape.param(&input.param));
        let (Some(shape), Some(entry)) = (shape, level.nodes.get(&input.node)) else {
            ui.horizontal(|ui| {
                ui.label(name).on_hover_text(&input.docs);
                ui.weak(&input.ty);
            });
            continue;
        };
        let value = entry.params.get(&input.param).cloned().unwrap_or_else(|| shape.default.clone());
        let mut shown = shape.clone();
        shown.docs = if input.docs.is_empty() { shape.docs.clone() } else { input.docs.clone() };
        ui.weak(format!("{name} ({})", input.ty));
        let exposure = Exposure::Input(name.clone());
        Row {
            node: &input.node,
            param: &shown,
            value: &value,
            set: entry.params.contains_key(&input.param),
            exposure: Some(&exposure),
            linkable: &[],
            enabled: editable,
        }
        .ui(ui, actions);
    }
    if !interface.params.is_empty() {
        ui.separator();
        ui.strong("Parameters");
    }
    for (name, param) in &interface.params {
        let first =
            param.targets.iter().filter_map(|target| target.split_once('.')).find_map(|(node, inner)| {
                let shape = shapes.get(node)?.param(inner)?;
                let own = level.nodes.get(node)?.params.get(inner).cloned();
                Some((node, inner, shape, own))
            });
        let Some((node, _, shape, own)) = first else { continue };
        let mut shown = shape.clone();
        shown.docs = format!(
            "{}\n\nSets {}.",
            if param.docs.is_empty() { &shape.docs } else { &param.docs },
            param.targets.iter().map(|t| format!("`{t}`")).collect::<Vec<_>>().join(", ")
        );
        let set = param.default.is_some() || own.is_some();
        let value = param.default.clone().or(own).unwrap_or_else(|| shape.default.clone());
        let value = match (&value, &shape.default) {
            (ParamValue::Int(_) | ParamValue::Float(_), ParamValue::List(_)) => ParamValue::List(vec![value]),
            _ => value,
        };
        if *name != shape.name {
            ui.weak(name);
        }
        let exposure = Exposure::Param(name.clone());
        Row {
            node,
            param: &shown,
            value: &value,
            set,
            exposure: Some(&exposure),
            linkable: &[],
            enabled: editable,
        }
        .ui(ui, actions);
    }
    if !interface.outputs.is_empty() {
        ui.separator();
        ui.strong("Outputs");
    }
    for (name, output) in &interface.outputs {
        ui.horizontal(|ui| {
            let pin =
                crate::action::Pin { node: output.node.clone(), socket: output.socket.clone(), output: true };
            let look = ui.small_button("Look at");
            look.widget_info(|| {
                WidgetInfo::labeled(WidgetType::Button, true, format!("Look at output {name}"))
            });
            if look.clicked() {
                actions.push(Action::Watch(pin));
            }
            ui.label(name).on_hover_text(&output.docs);
            ui.weak(format!("{}.{}", output.node, output.socket));
        });
    }
    if level.nodes.is_empty() {
        ui.separator();
        ui.weak(
            "An empty graph. Press Tab for a node, drop a picture on the window, or start from a preset.",
        );
    }
}

fn title(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let mut title = state.document.title.clone();
    let response = ui.add(
        TextEdit::singleline(&mut title)
            .id(eframe::egui::Id::new("graph title"))
            .hint_text("Title")
            .desired_width(f32::INFINITY),
    );
    response.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, "Title of the graph"));
    if response.changed() {
        actions.push(Action::Title(title));
    }
    if response.lost_focus() {
        actions.push(Action::EndDrag);
    }
    CollapsingHeader::new("About").default_open(state.document.nodes.len() < 40).show(ui, |ui| {
        let mut docs = state.document.docs.clone();
        let response = ui.add(
            TextEdit::multiline(&mut docs)
                .desired_rows(3)
                .desired_width(f32::INFINITY)
                .hint_text("What the graph does"),
        );
        response.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, "What the graph does"));
        if response.changed() {
            actions.push(Action::Docs(docs));
        }
        if response.lost_focus() {
            actions.push(Action::EndDrag);
        }
    });
}
