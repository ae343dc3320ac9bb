//! The widget for each kind of parameter.

use breccia_engine::{ParamKind, ParamValue};
use eframe::egui::{
    ComboBox, DragValue, Response, Slider, SliderClamping, TextEdit, Ui, WidgetInfo, WidgetType,
};

/// What a widget did.
#[derive(Default)]
pub struct Change {
    /// The new value.
    pub value: Option<ParamValue>,
    /// Whether more of the same is to come: a slider is held.
    pub dragging: bool,
    /// Whether a drag has just ended.
    pub released: bool,
    /// Whether the user wants to pick a file.
    pub pick: bool,
}

impl Change {
    pub(super) fn note(&mut self, response: &Response) {
        // Where a drag stops the value may have changed once more.
        self.dragging |= response.dragged() || response.drag_stopped();
        self.released |= response.drag_stopped() || response.lost_focus();
    }
}

/// Ranges up to this many steps get a slider.
const SLIDER: f64 = 100_000.0;

/// Shows a parameter's value and lets it be changed. `label` is its accessible name.
pub fn edit(ui: &mut Ui, label: &str, kind: &ParamKind, unit: &str, value: &ParamValue) -> Change {
    let mut change = Change::default();
    let suffix = suffix(unit);
    match (kind, value) {
        (ParamKind::Bool, ParamValue::Bool(on)) => {
            let mut on = *on;
            let text = if on { "yes" } else { "no" };
            let response = named(ui.checkbox(&mut on, text), label, WidgetType::Checkbox);
            if response.changed() {
                change.value = Some(ParamValue::Bool(on));
            }
        }
        (ParamKind::Int { min, max }, ParamValue::Int(number)) => {
            let mut number = *number;
            let response = if label.ends_with("seed") {
                seed(ui, label, &mut number, *min, *max, &mut change)
            } else if ((max - min.max(&-1_000_000_000)) as f64) < SLIDER {
                ui.spacing_mut().slider_width = (ui.available_width() - 96.0).clamp(40.0, 160.0);
                let logarithmic = *min >= 0 && max.saturating_sub(*min) > 1000;
                ui.add(slider(Slider::new(&mut number, *min..=*max)).logarithmic(logarithmic).suffix(suffix))
            } else {
                ui.add(drag(DragValue::new(&mut number)).range(*min..=*max).suffix(suffix))
            };
            let response = named(response, label, WidgetType::Slider);
            change.note(&response);
            if number != as_int(value) {
                change.value = Some(ParamValue::Int(number.clamp(*min, *max)));
            }
        }
        (ParamKind::Float { min, max, step }, ParamValue::Float(_) | ParamValue::Int(_)) => {
            let before = as_float(value);
            let mut number = before;
            let narrow = max - min < SLIDER;
            let response = if narrow {
                ui.spacing_mut().slider_width = (ui.available_width() - 96.0).clamp(40.0, 160.0);
                let logarithmic = *min >= 0.0 && max - min > 100.0;
                ui.add(
                    slider(Slider::new(&mut number, *min..=*max))
                        .logarithmic(logarithmic)
                        .smallest_positive(step.min(0.01))
                        .suffix(suffix),
                )
            } else {
                let speed = step.max(before.abs() * 0.01);
                ui.add(drag(DragValue::new(&mut number)).range(*min..=*max).speed(speed).suffix(suffix))
            };
            let response = named(response, label, WidgetType::Slider);
            change.note(&response);
            if number.to_bits() != before.to_bits() {
                change.value = Some(ParamValue::Float(number));
            }
        }
        (ParamKind::Choice(choices), ParamValue::Text(chosen)) => {
            let combo =
                ComboBox::from_id_salt(label).selected_text(chosen).width(ui.available_width().min(180.0));
            let response = combo.show_ui(ui, |ui| {
                for (name, docs) in *choices {
                    if ui.selectable_label(chosen == name, *name).on_hover_text(*docs).clicked()
                        && chosen != name
                    {
                        change.value = Some(ParamValue::Text((*name).to_owned()));
                    }
                }
            });
            named(response.response, label, WidgetType::ComboBox);
        }
        (ParamKind::File { .. }, ParamValue::Text(path)) => {
            ui.horizontal(|ui| {
                let width = (ui.available_width() - 52.0).max(40.0);
                text(ui, label, path, width, "no file", &mut change);
                let response = ui.button("Pick…").on_hover_text("Picks a file");
                response.widget_info(|| {
                    WidgetInfo::labeled(WidgetType::Button, true, format!("Pick a file for {label}"))
                });
                change.pick = response.clicked();
            });
        }
        (ParamKind::Text, ParamValue::Text(found)) => {
            let width = ui.available_width();
            text(ui, label, found, width, "", &mut change);
        }
        (ParamKind::Ints { min_len, max_len, min, max }, list) => {
            let mut numbers: Vec<i64> = items(list).iter().map(as_int).collect();
            let before = numbers.clone();
            if (*min_len, *max_len) == (3, 3) && (*min, *max) == (0, 255) {
                bytes(ui, label, &mut numbers, &mut change);
            }
            let fresh = numbers.last().copied().unwrap_or(0).clamp(*min, *max);
            row(ui, label, &mut numbers, [*min_len, *max_len], fresh, &mut change, |number, ui| {
                ui.add(drag(DragValue::new(number)).range(*min..=*max).suffix(suffix.as_str()))
            });
            if numbers != before {
                change.value = Some(ParamValue::List(numbers.into_iter().map(ParamValue::Int).collect()));
            }
        }
        (ParamKind::Floats { min_len, max_len, min, max }, list) => {
            let mut numbers: Vec<f64> = items(list).iter().map(as_float).collect();
            let before: Vec<u64> = numbers.iter().map(|n| n.to_bits()).collect();
            if (*min_len, *max_len) == (3, 3) && (*min, *max) == (0.0, 1.0) {
                color(ui, label, &mut numbers, &mut change);
            }
            let fresh = numbers.last().copied().unwrap_or(0.0).clamp(*min, *max);
            let speed = if max - min <= 10.0 { 0.005 } else { 0.1 };
            // A table of many fractions is a curve.
            let is_curve = *max_len > 16 && (*min, *max) == (0.0, 1.0);
            if is_curve && !numbers.is_empty() {
                super::curve::curve(ui, label, &mut numbers, &mut change);
            }
            row(ui, label, &mut numbers, [*min_len, *max_len], fresh, &mut change, |number, ui| {
                ui.add(drag(DragValue::new(number)).range(*min..=*max).speed(speed).suffix(suffix.as_str()))
            });
            if numbers.iter().map(|n| n.to_bits()).ne(before) {
                change.value = Some(ParamValue::List(numbers.into_iter().map(ParamValue::Float).collect()));
            }
        }
        // A zone may take one number for each level.
        (ParamKind::Int { min, max }, ParamValue::List(_)) => {
            let several = ParamKind::Ints { min_len: 1, max_len: 16, min: *min, max: *max };
            return edit(ui, label, &several, unit, value);
        }
        (ParamKind::Float { min, max, .. }, ParamValue::List(_)) => {
            let several = ParamKind::Floats { min_len: 1, max_len: 16, min: *min, max: *max };
            return edit(ui, label, &several, unit, value);
        }
        (_, found) => {
            // A value of another kind than the parameter takes: it is shown as it is, and can be put right as text or reset.
            ui.colored_label(ui.visuals().error_fg_color, format!("{found}"))
                .on_hover_text(format!("Expected {}", kind.describe()));
        }
    }
    change
}

/// A slider that leaves values alone until they are changed, and takes typed ones when they are complete.
fn slider(slider: Slider<'_>) -> Slider<'_> {
    slider.clamping(SliderClamping::Edits).update_while_editing(false)
}

/// A number field that does so.
fn drag(field: DragValue<'_>) -> DragValue<'_> {
    field.clamp_existing_to_range(false).update_while_editing(false)
}

fn suffix(unit: &str) -> String {
    match unit {
        "" | "1" | "count" => String::new(),
        "degrees" => "°".into(),
        unit => format!(" {unit}"),
    }
}

fn named(response: Response, label: &str, ty: WidgetType) -> Response {
    response.widget_info(|| WidgetInfo::labeled(ty, true, label));
    response
}

fn as_int(value: &ParamValue) -> i64 {
    match value {
        ParamValue::Int(number) => *number,
        ParamValue::Float(number) => *number as i64,
        _ => 0,
    }
}

fn as_float(value: &ParamValue) -> f64 {
    match value {
        ParamValue::Int(number) => *number as f64,
        ParamValue::Float(number) => *number,
        _ => 0.0,
    }
}

fn items(value: &ParamValue) -> Vec<ParamValue> {
    match value {
        ParamValue::List(items) => items.clone(),
        other => vec![other.clone()],
    }
}

fn seed(ui: &mut Ui, label: &str, number: &mut i64, min: i64, max: i64, change: &mut Change) -> Response {
    ui.horizontal(|ui| {
        let response = ui.add(drag(DragValue::new(number)).range(min..=max));
        let dice = ui.button("🎲").on_hover_text("Another seed");
        dice.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, format!("Another {label}")));
        if dice.clicked() {
            // Any other number will do; from the last one, so that a series can be had again.
            let mixed = (*number as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 44;
            *number = i64::try_from(mixed).unwrap_or(0).clamp(min, max);
            change.released = true;
        }
        response
    })
    .inner
}

/// A text that counts when it is finished: on return, or when the keyboard goes elsewhere.
fn text(ui: &mut Ui, label: &str, value: &str, width: f32, hint: &str, change: &mut Change) {
    let id = ui.make_persistent_id(("text", label));
    let mut draft = ui.data(|data| data.get_temp::<String>(id)).unwrap_or_else(|| value.to_owned());
    let response =
        ui.add(TextEdit::singleline(&mut draft).id(id.with("field")).desired_width(width).hint_text(hint));
    let response = named(response, label, WidgetType::TextEdit);
    if response.has_focus() {
        ui.data_mut(|data| data.insert_temp(id, draft));
    } else {
        if response.lost_focus() && draft != value {
            change.value = Some(ParamValue::Text(draft));
        }
        ui.data_mut(|data| data.remove::<String>(id));
    }
}

/// Numbers side by side; some more or fewer where their count is free.
fn row<T: Copy>(
    ui: &mut Ui,
    label: &str,
    numbers: &mut Vec<T>,
    [least, most]: [usize; 2],
    fresh: T,
    change: &mut Change,
    mut widget: impl FnMut(&mut T, &mut Ui) -> Response,
) {
    ui.horizontal_wrapped(|ui| {
        for (i, number) in numbers.iter_mut().enumerate() {
            let response = widget(number, ui);
            let response = named(response, &format!("{label} {}", i + 1), WidgetType::DragValue);
            change.note(&response);
        }
        if numbers.len() < most {
            let more = ui.small_button("+").on_hover_text("One number more");
            more.widget_info(|| {
                WidgetInfo::labeled(WidgetType::Button, true, format!("More numbers for {label}"))
            });
            if more.clicked() {
                numbers.push(fresh);
                change.released = true;
            }
        }
        if numbers.len() > least {
            let fewer = ui.small_button("−").on_hover_text("One number less");
            fewer.widget_info(|| {
                WidgetInfo::labeled(WidgetType::Button, true, format!("Fewer numbers for {label}"))
            });
            if fewer.clicked() {
                numbers.pop();
                change.released = true;
            }
        }
    });
}

/// Notes what was done in a colour's own window, of which the button says no more than that something changed.
fn picked(ui: &Ui, response: &Response, change: &mut Change) {
    change.note(response);
    let [held, let_go] = ui.input(|i| [i.pointer.any_down(), i.pointer.any_released()]);
    change.dragging |= response.changed() && (held || let_go);
    // The button is not what was held.
    change.released |= response.changed() && let_go;
}

/// Three fractions may be a colour.
fn color(ui: &mut Ui, label: &str, numbers: &mut [f64], change: &mut Change) {
    let [r, g, b] = numbers else { return };
    let mut rgb = [*r as f32, *g as f32, *b as f32];
    let response =
        named(ui.color_edit_button_rgb(&mut rgb), &format!("{label} as a colour"), WidgetType::ColorButton);
    picked(ui, &response, change);
    if response.changed() {
        (*r, *g, *b) = (f64::from(rgb[0]), f64::from(rgb[1]), f64::from(rgb[2]));
    }
}

/// Three bytes may be a colour.
fn bytes(ui: &mut Ui, label: &str, numbers: &mut [i64], change: &mut Change) {
    let [r, g, b] = numbers else { return };
    let byte = |n: i64| n.clamp(0, 255) as u8;
    let mut rgb = [byte(*r), byte(*g), byte(*b)];
    let response =
        named(ui.color_edit_button_srgb(&mut rgb), &format!("{label} as a colour"), WidgetType::ColorButton);
    picked(ui, &response, change);
    if response.changed() {
        (*r, *g, *b) = (rgb[0].into(), rgb[1].into(), rgb[2].into());
    }
}
