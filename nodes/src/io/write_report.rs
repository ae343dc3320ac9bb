//! Reports as JSON, CSV and plain text.

use std::io::{self, Write};

use breccia_engine::{Data, Exporter, Sink, Value};
use serde_json::json;

use super::export::typed;
use crate::data::{Report, Row};

/// Exporters of reports.
pub(super) const EXPORTERS: &[Exporter] = &[
    Exporter {
        ty: Report::TYPE,
        extensions: &["json"],
        docs: "object with the title and rows of name, value (null if not finite) and unit",
        write: |value, sink| write_file(value, sink, report_json),
    },
    Exporter {
        ty: Report::TYPE,
        extensions: &["csv"],
        docs: "table of name, value and unit with a header line",
        write: |value, sink| write_file(value, sink, report_csv),
    },
    Exporter {
        ty: Report::TYPE,
        extensions: &["txt"],
        docs: "aligned columns for reading",
        write: |value, sink| write_file(value, sink, report_text),
    },
];

fn write_file(value: &Value, sink: &mut Sink, text: fn(&Report) -> String) -> io::Result<()> {
    let report = typed::<Report>(value)?;
    let mut out = sink.main()?;
    out.write_all(text(&report).as_bytes())?;
    out.flush()
}

/// The report as a JSON object `{title, rows: [{name, value, unit}]}`; values that are not finite are `null`. Rows with a
/// reference say it; those with a good range say `good: [low, high]` (`null` for no bound) and whether they are `flagged`.
pub fn report_json(report: &Report) -> String {
    let row = |row: &Row| {
        let mut object = json!({ "name": row.name, "value": row.value, "unit": row.unit });
        if let Some(reference) = row.reference {
            object["reference"] = json!(reference);
        }
        if let Some(good) = row.good {
            object["good"] = json!(good);
            object["flagged"] = json!(row.flagged());
        }
        object
    };
    let rows: Vec<_> = report.rows.iter().map(row).collect();
    format!("{:#}\n", json!({ "title": report.title, "rows": rows }))
}

/// The report's rows as CSV (RFC 4180) under the header `name,value,unit,reference,low,high`, the last three empty where a row
/// has none.
pub fn report_csv(report: &Report) -> String {
    let quote = |text: &str| {
        if text.contains([',', '"', '\n', '\r']) {
            format!("\"{}\"", text.replace('"', "\"\""))
        } else {
            text.to_owned()
        }
    };
    let number = |value: Option<f64>| value.map(|v| v.to_string()).unwrap_or_default();
    let rows = report.rows.iter().map(|row| {
        let [low, high] = [0, 1].map(|i| number(row.good.map(|good| good[i])));
        let (value, reference) = (row.value, number(row.reference));
        format!("{},{value},{},{reference},{low},{high}\r\n", quote(&row.name), quote(&row.unit))
    });
    std::iter::once("name,value,unit,reference,low,high\r\n".to_owned()).chain(rows).collect()
}

/// A number to be read: four decimals are enough, JSON and CSV have all.
pub fn short_number(value: f64) -> String {
    if value.fract() == 0.0 { value.to_string() } else { format!("{value:.4}") }
}

/// A range to be read.
pub fn range_text([low, high]: [f64; 2]) -> String {
    // Two digits that say something are enough.
    let digits = if [low, high].iter().any(|v| v.is_finite() && v.abs() >= 0.1) { 2 } else { 4 };
    let bound = |value: f64| {
        let text = format!("{value:.digits$}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        if text == "-0" { "0".to_owned() } else { text.to_owned() }
    };
    match (low != 0.0, high.is_finite()) {
        (false, true) => format!("up to {}", bound(high)),
        (true, false) => format!("from {}", bound(low)),
        _ => format!("{} to {}", bound(low), bound(high)),
    }
}

/// The report as aligned columns under its title: name, value, and where rows have them the reference and the good range,
/// unit. Values outside of what is good have an exclamation mark.
pub fn report_text(report: &Report) -> String {
    let cells = |row: &Row| {
        let good = row.good.map(|good| format!("good {}", range_text(good)));
        let reference = row.reference.map(|reference| format!("({})", short_number(reference)));
        let value = short_number(row.value);
        [row.name.clone(), value, reference.unwrap_or_default(), good.unwrap_or_default()]
    };
    let rows: Vec<_> = report.rows.iter().map(|row| (cells(row), row)).collect();
    let width =
        |column: usize| rows.iter().map(|(cells, _)| cells[column].chars().count()).max().unwrap_or(0);
    let [names, values, references, ranges] = [0, 1, 2, 3].map(width);
    let flags = rows.iter().any(|(_, row)| row.flagged());
    let mut text = format!("{}\n", report.title);
    for ([name, value, reference, good], row) in &rows {
        let mut line = format!("{name:names$}  {value:>values$}");
        if flags {
            line += if row.flagged() { " !" } else { "  " };
        }
        for (cell, width) in [(reference, references), (good, ranges)] {
            if width > 0 {
                line += &format!("  {cell:width$}");
            }
        }
        text += format!("{line}  {}", row.unit).trim_end();
        text.push('\n');
    }
    text
}
