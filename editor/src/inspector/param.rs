//! One parameter: name, widget, reset, and how the graph offers it.

use breccia_engine::ParamValue;
use eframe::egui::{Button, RichText, Stroke, Ui, WidgetInfo, WidgetType};

use super::widget;
use crate::action::Action;
use crate::model::{Exposure, ParamShape};

/// All that a parameter's row hangs on.
pub struct Row<'a> {
    /// The node.
    pub node: &'a str,
    /// The parameter.
    pub param: &'a ParamShape,
    /// The value now.
    pub value: &'a ParamValue,
    /// Whether the document sets it.
    pub set: bool,
    /// How the graph offers it.
    pub exposure: Option<&'a Exposure>,
    /// Exposed parameters that it could be linked to.
    pub linkable: &'a [String],
    /// Whether it can be changed.
    pub enabled: bool,
}

impl Row<'_> {
    /// Draws the row.
    pub fn ui(&self, ui: &mut Ui, actions: &mut Vec<Action>) {
        let (node, param) = (self.node, self.param.name.as_str());
        let label = format!("{node}.{param}");
        ui.add_enabled_ui(self.enabled, |ui| {
            ui.horizontal(|ui| {
                let text = RichText::new(param.replace('_', " "));
                let name = ui.label(if self.set { text.strong() } else { text });
                name.on_hover_ui(|ui| {
                    ui.set_max_width(380.0);
                    super::help::markdown(ui, &self.param.docs);
                    ui.weak(format!("{}; default {}", self.param.kind.describe(), self.param.default));
                });
                if self.set {
                    let reset = ui
                        .add(Button::new("↺").small().frame(false))
                        .on_hover_text(format!("Back to the default, {}", self.param.default));
                    reset.widget_info(|| {
                        WidgetInfo::labeled(WidgetType::Button, true, format!("Reset {label}"))
                    });
                    if reset.clicked() {
                        actions.push(set(node, param, None, false));
                        actions.push(Action::EndDrag);
                    }
                }
                self.exposing(ui, &label, actions);
            });
            ui.push_id(&label, |ui| {
                let change = widget::edit(ui, &label, &self.param.kind, self.param.unit, self.value);
                if let Some(value) = change.value {
                    actions.push(set(node, param, Some(value), change.dragging));
                    if !change.dragging || change.released {
                        actions.push(Action::EndDrag);
                    }
                } else if change.released {
                    actions.push(Action::EndDrag);
                }
                if change.pick {
                    actions.push(Action::PickFile { node: node.to_owned(), param: param.to_owned() });
                }
            });
        });
        ui.add_space(3.0);
    }

    fn exposing(&self, ui: &mut Ui, label: &str, actions: &mut Vec<Action>) {
        let (node, param) = (self.node.to_owned(), self.param.name.clone());
        let hint = match self.exposure {
            Some(exposure) => format!("Offered on the graph as `{}`", exposure.name()),
            None => "Offer on the graph, or link to a parameter that is offered".to_owned(),
        };
        let menu = ui.menu_button(RichText::new("   ").small(), |ui| {
            if self.exposure.is_some() {
                if ui.button("Take back from the graph").clicked() {
                    actions.push(Action::Unexpose { node: node.clone(), param: param.clone() });
                    ui.close();
                }
            } else if ui.button("Expose on the graph").clicked() {
                actions.push(Action::Expose { node: node.clone(), param: param.clone() });
                ui.close();
            }
            for to in self.linkable {
                if ui.button(format!("Link to {to}")).clicked() {
                    actions.push(Action::LinkParam {
                        node: node.clone(),
                        param: param.clone(),
                        to: to.clone(),
                    });
                    ui.close();
                }
            }
        });
        menu.response
            .widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, format!("Exposing {label}")));
        let (at, color) = (menu.response.rect.center(), ui.style().interact(&menu.response).text_color());
        ui.painter().circle_stroke(at, 4.0, Stroke::new(1.2, color));
        if self.exposure.is_some() {
            ui.painter().circle_filled(at, 2.2, color);
        }
        menu.response.on_hover_text(hint);
    }
}

fn set(node: &str, param: &str, value: Option<ParamValue>, dragging: bool) -> Action {
    Action::Set { node: node.to_owned(), param: param.to_owned(), value, dragging }
}
