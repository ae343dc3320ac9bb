//! A comparison as one page that needs nothing else: no script, no font, no file beside it.

use std::io;
use std::sync::Arc;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use breccia_nodes::data::{Image, Plot, Report, Row};
use breccia_nodes::io::{escape, plot_svg, range_text, short_number, write_image_png};

const STYLE: &str = "\
body{font:15px/1.45 system-ui,sans-serif;color:#1c1c1c;background:#fff;max-width:1180px;margin:2em auto;padding:0 1.2em}
h1{font-size:1.5em;margin-bottom:.2em}h2{font-size:1.15em;margin:1.8em 0 .5em}
.verdict{padding:.5em .8em;border-left:4px solid #2e7d32;background:#eef6ee}.verdict.flagged{border-color:#b3261e;background:#fbecea}
.row{display:flex;flex-wrap:wrap;gap:14px}figure{margin:0}figcaption{font-size:.85em;color:#555}
figure img{display:block;width:208px;image-rendering:pixelated;border:1px solid #ccc}
.tables{display:flex;flex-wrap:wrap;gap:28px;align-items:flex-start}
table{border-collapse:collapse;font-size:.88em}caption{text-align:left;font-weight:600;padding:.3em 0}
th,td{padding:.16em .6em;text-align:left;border-bottom:1px solid #e6e6e6}th{font-weight:600;color:#555}
td.n{text-align:right;font-variant-numeric:tabular-nums}tr.flagged td{background:#fbecea}tr.flagged td.n:nth-child(2){font-weight:700;color:#b3261e}
pre{font-size:.8em;background:#f6f6f6;padding:.8em;white-space:pre-wrap;overflow-wrap:anywhere}
svg{max-width:100%;height:auto;font-family:system-ui,sans-serif}
@media print{details{display:none}.row,tr{break-inside:avoid}}";

/// A picture with what it shows.
pub struct Figure {
    pub caption: &'static str,
    pub image: Arc<Image>,
}

/// What a page tells.
pub struct Page<'a> {
    pub volume: &'a str,
    pub report: &'a Report,
    pub figures: Vec<Figure>,
    pub plots: Vec<Plot>,
    /// Nodes and what they say of their measures.
    pub meanings: Vec<(&'a str, &'a str)>,
    pub document: String,
    /// The document of the graph that made the volume, if one did.
    pub made_by: Option<String>,
    pub seed: i64,
}

/// How rows are grouped: the start of their names, a title, and what the reference is.
const FAMILIES: [(&str, &str, &str); 5] = [
    ("axis_", "Slices across the axes", "exemplar's own"),
    ("oblique_", "Oblique cuts", "exemplar's own"),
    ("slice_", "Phases on slices", "exemplar"),
    ("solid_", "Phases in 3D", "truth"),
    ("", "Further numbers", "reference"),
];

impl Page<'_> {
    /// The page.
    ///
    /// # Errors
    /// If a picture has no PNG form.
    pub fn html(&self) -> io::Result<String> {
        let volume = escape(self.volume);
        let rows = &self.report.rows;
        let flagged: Vec<_> = rows.iter().filter(|row| row.flagged()).map(|row| row.name.as_str()).collect();
        let judged = rows.iter().filter(|row| row.good.is_some()).count();
        let verdict = match flagged.as_slice() {
            [] => format!("<p class=\"verdict\">All {judged} measures are within their good ranges.</p>"),
            names => format!(
                "<p class=\"verdict flagged\">{} of {judged} measures are outside of their good ranges: {}.</p>",
                names.len(),
                escape(&names.join(", "))
            ),
        };
        let figures = self.figures.iter().map(figure).collect::<io::Result<Vec<_>>>()?.concat();
        let tables: String = FAMILIES.iter().enumerate().map(|(i, family)| table(i, family, rows)).collect();
        let plots: String = self.plots.iter().map(plot_svg).collect();
        let meaning = |(id, docs): &(&str, &str)| {
            let (id, docs) = (escape(id), escape(docs));
            format!("<details><summary>What the numbers of {id} mean</summary><pre>{docs}</pre></details>\n")
        };
        let meanings: String = self.meanings.iter().map(meaning).collect();
        let (document, command, seed) = (escape(&self.document), escape(&command()), self.seed);
        let made_by = self.made_by.as_ref().map_or_else(String::new, |document| {
            format!("<h2>The graph that made the volume</h2><pre>{}</pre>\n", escape(document))
        });
        let version = env!("CARGO_PKG_VERSION");
        Ok(format!(
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
             <meta name=\"viewport\" content=\"width=device-width\"><title>{volume}</title>\n<style>\n{STYLE}\n</style></head><body>\n\
             <h1>How well {volume} resembles its exemplar</h1>\n{verdict}\n\
             <h2>Pictures</h2><div class=\"row\">{figures}</div>\n\
             <h2>Measures</h2><p>Each is blind to something: read them together, and look at the pictures too.</p>\
             <div class=\"tables\">{tables}</div>\n{meanings}\
             <h2>Curves</h2><div class=\"row\">{plots}</div>\n\
             <h2>How it was made</h2><p>breccia {version}, seed {seed}.</p><pre>{command}</pre>\n<pre>{document}</pre>\n{made_by}\
             </body></html>\n"
        ))
    }
}

fn figure(figure: &Figure) -> io::Result<String> {
    let mut png = Vec::new();
    write_image_png(&figure.image, &mut png)?;
    let (caption, [width, height]) = (escape(figure.caption), [figure.image.width(), figure.image.height()]);
    Ok(format!(
        "<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{}\"><figcaption>{caption}, {width} × {height}</figcaption></figure>\n",
        STANDARD.encode(png)
    ))
}

/// The rows of a family; nothing if there are none.
fn table(index: usize, (prefix, title, reference): &(&str, &str, &str), rows: &[Row]) -> String {
    let family = |row: &Row| FAMILIES.iter().position(|(prefix, ..)| row.name.starts_with(prefix));
    let line = |row: &Row| {
        let class = if row.flagged() { " class=\"flagged\"" } else { "" };
        let name = escape(row.name.strip_prefix(prefix).unwrap_or(&row.name));
        let number = |value: Option<f64>| value.map(short_number).unwrap_or_default();
        let good = row.good.map(range_text).unwrap_or_default();
        format!(
            "<tr{class}><td>{name}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td>{good}</td><td>{}</td></tr>\n",
            number(Some(row.value)),
            number(row.reference),
            escape(&row.unit)
        )
    };
    let lines: String = rows.iter().filter(|row| family(row) == Some(index)).map(line).collect();
    if lines.is_empty() {
        return lines;
    }
    format!(
        "<table><caption>{title}</caption><tr><th>measure</th><th>value</th><th>{reference}</th><th>good</th><th>unit</th></tr>\n\
         {lines}</table>\n"
    )
}

/// The command line as a shell takes it.
fn command() -> String {
    let quote = |word: String| {
        let plain = |c: char| c.is_alphanumeric() || "-_./=:+,@%".contains(c);
        if !word.is_empty() && word.chars().all(plain) {
            word
        } else {
            format!("'{}'", word.replace('\'', "'\\''"))
        }
    };
    let words = std::env::args_os().skip(1).map(|word| quote(word.to_string_lossy().into_owned()));
    std::iter::once("breccia".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}
