//! Help texts.

use eframe::egui::{RichText, Ui};

/// The little Markdown that docs use: paragraphs, and code between backquotes.
pub fn markdown(ui: &mut Ui, text: &str) {
    for paragraph in text.split("\n\n").filter(|paragraph| !paragraph.trim().is_empty()) {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 0.0;
            for (i, part) in paragraph.split('`').enumerate() {
                let part = part.split_whitespace().collect::<Vec<_>>().join(" ");
                let padded = if i % 2 == 1 || part.is_empty() { part } else { pad(paragraph, &part, i) };
                if i % 2 == 1 {
                    ui.label(RichText::new(padded).code());
                } else if !padded.is_empty() {
                    ui.label(padded);
                }
            }
        });
        ui.add_space(4.0);
    }
}

/// Spaces that stood at the ends of a part.
fn pad(paragraph: &str, part: &str, index: usize) -> String {
    let raw = paragraph.split('`').nth(index).unwrap_or_default();
    let before = if index > 0 && raw.starts_with(char::is_whitespace) { " " } else { "" };
    let after = if raw.ends_with(char::is_whitespace) { " " } else { "" };
    format!("{before}{part}{after}")
}
