//! Reports as JSON, CSV and plain text.

use std::io::{self, Write};

use breccia_engine::{Data, Exporter, Sink, Value};
use serde_json::json;

use super::export::typed;
use crate::data::Report;

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

/// The report as a JSON object `{title, rows: [{name, value, unit}]}`; values that are not finite are `null`.
pub fn report_json(report: &Report) -> String {
    let rows =
        report.rows.iter().map(|(name, value, unit)| json!({ "name": name, "value": value, "unit": unit }));
    format!("{:#}\n", json!({ "title": report.title, "rows": rows.collect::<Vec<_>>() }))
}

/// The report's rows as CSV (RFC 4180) under the header `name,value,unit`.
pub fn report_csv(report: &Report) -> String {
    let quote = |text: &str| {
        if text.contains([',', '"', '\n', '\r']) {
            format!("\"{}\"", text.replace('"', "\"\""))
        } else {
            text.to_owned()
        }
    };
    let rows =
        report.rows.iter().map(|(name, value, unit)| format!("{},{value},{}\r\n", quote(name), quote(unit)));
    std::iter::once("name,value,unit\r\n".to_owned()).chain(rows).collect()
}

/// The report as aligned columns under its title.
pub fn report_text(report: &Report) -> String {
    let width = |text: &str| text.chars().count();
    let names = report.rows.iter().map(|(name, ..)| width(name)).max().unwrap_or(0);
    // Four decimals are enough to read; JSON and CSV have all.
    let short = |value: f64| if value.fract() == 0.0 { value.to_string() } else { format!("{value:.4}") };
    let values = report.rows.iter().map(|&(_, value, _)| width(&short(value))).max().unwrap_or(0);
    let rows = report.rows.iter().map(|(name, value, unit)| {
        let line = format!("{name:names$}  {:>values$}  {unit}", short(*value));
        format!("{}\n", line.trim_end())
    });
    std::iter::once(format!("{}\n", report.title)).chain(rows).collect()
}
