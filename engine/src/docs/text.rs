//! Reference pages as Markdown and as plain text.

use super::{NodeDoc, ParamDoc, SocketDoc, describe};
use crate::spec::NodeSpec;

/// The reference page of a node type in Markdown.
pub fn markdown(spec: &NodeSpec) -> String {
    let doc = describe(spec);
    let mut out = format!("## `{}`\n\n{}.\n\n{}\n", doc.id, doc.summary, doc.docs.trim());
    if let Some(paper) = doc.paper {
        out.push_str(&format!("\nPaper: {paper}\n"));
    }
    sockets(&mut out, "Inputs", &doc.inputs);
    sockets(&mut out, "Outputs", &doc.outputs);
    if !doc.params.is_empty() {
        out.push_str("\n| Parameter | Takes | Default | |\n|---|---|---|---|\n");
        for param in &doc.params {
            out.push_str(&format!(
                "| `{}` | {} | `{}` | {} |\n",
                param.name,
                cell(&takes(param)),
                cell(&param.default.to_string()),
                cell(&with_choices(param, "<br>", "`"))
            ));
        }
    }
    out.push_str(&format!("\nVersion {}, runs on {}.\n", doc.version, doc.placement));
    out
}

fn sockets(out: &mut String, heading: &str, sockets: &[SocketDoc]) {
    if sockets.is_empty() {
        return;
    }
    out.push_str(&format!("\n| {heading} | Type | |\n|---|---|---|\n"));
    for socket in sockets {
        out.push_str(&format!("| `{}` | {} | {} |\n", socket.name, socket_type(socket), cell(socket.docs)));
    }
}

/// The reference page of a node type for a terminal.
pub fn plain(spec: &NodeSpec) -> String {
    let doc: NodeDoc = describe(spec);
    let mut out = format!("{}  {}\n\n{}\n", doc.id, doc.summary, doc.docs.trim());
    if let Some(paper) = doc.paper {
        out.push_str(&format!("\nPaper: {paper}\n"));
    }
    for (heading, sockets) in [("Inputs", &doc.inputs), ("Outputs", &doc.outputs)] {
        if !sockets.is_empty() {
            out.push_str(&format!("\n{heading}\n"));
        }
        for socket in sockets {
            out.push_str(&format!("  {}: {}\n      {}\n", socket.name, socket_type(socket), socket.docs));
        }
    }
    if !doc.params.is_empty() {
        out.push_str("\nParameters\n");
    }
    for param in &doc.params {
        let docs = with_choices(param, "\n      ", "");
        out.push_str(&format!("  {} = {}  ({})\n      {docs}\n", param.name, param.default, takes(param)));
    }
    out.push_str(&format!("\nVersion {}, runs on {}.\n", doc.version, doc.placement));
    out
}

fn socket_type(socket: &SocketDoc) -> String {
    match socket.links {
        "one" => socket.ty.to_owned(),
        links => format!("{}, {links}", socket.ty),
    }
}

fn takes(param: &ParamDoc) -> String {
    match param.unit {
        "" | "1" => param.takes.clone(),
        unit => format!("{}, in {unit}", param.takes),
    }
}

fn with_choices(param: &ParamDoc, line: &str, quote: &str) -> String {
    let choices = param.choices.iter().map(|c| format!("{line}{quote}{}{quote}: {}", c.name, c.docs));
    std::iter::once(param.docs.to_owned()).chain(choices).collect()
}

/// A text that fits into a cell of a Markdown table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}
