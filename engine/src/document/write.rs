//! Canonical text of documents: laid out by hand, so that a change to a graph is a change to few lines.

use std::collections::BTreeMap;

use ron::Value;

use super::{Document, FORMAT, Group, Interface, NodeEntry, VERSION, link};
use crate::param::{float_text, quoted};

pub(super) fn document(document: &Document) -> String {
    let mut out = String::from("(\n");
    out.push_str(&format!("    format: {},\n    version: {VERSION},\n", quoted(FORMAT)));
    out.push_str(&format!("    title: {},\n", quoted(&document.title)));
    out.push_str(&format!("    docs: {},\n", quoted(&document.docs)));
    graph(&mut out, &document.interface, &document.nodes, &document.links);
    groups(&mut out, &document.groups);
    if document.editor != Value::Unit {
        out.push_str("    editor: ");
        match &document.editor {
            Value::Map(map) if !map.is_empty() => {
                out.push_str("{\n");
                for (key, entry) in map.iter() {
                    out.push_str(&format!("        {}: {},\n", value_text(key), value_text(entry)));
                }
                out.push_str("    },\n");
            }
            other => out.push_str(&format!("{},\n", value_text(other))),
        }
    }
    out.push_str(")\n");
    out
}

fn graph(out: &mut String, of: &Interface, nodes: &BTreeMap<String, NodeEntry>, links: &[String]) {
    interface(out, of);
    out.push_str("    nodes: {\n");
    for (name, entry) in nodes {
        node(out, name, entry);
    }
    out.push_str("    },\n    links: [\n");
    let mut links = links.to_vec();
    link::sort(&mut links);
    for link in &links {
        out.push_str(&format!("        {},\n", quoted(link)));
    }
    out.push_str("    ],\n");
}

fn groups(out: &mut String, groups: &BTreeMap<String, Group>) {
    if groups.is_empty() {
        return;
    }
    out.push_str("    groups: {\n");
    for (name, group) in groups {
        out.push_str(&format!("        {}: (\n", quoted(name)));
        if group.file.is_empty() {
            let mut text = format!("    docs: {},\n", quoted(&group.docs));
            graph(&mut text, &group.interface, &group.nodes, &group.links);
            self::groups(&mut text, &group.groups);
            // A quoted text has no line breaks, so every line is one of the layout.
            text.lines().for_each(|line| out.push_str(&format!("        {line}\n")));
        } else {
            out.push_str(&format!("            file: {},\n", quoted(&group.file)));
        }
        out.push_str("        ),\n");
    }
    out.push_str("    },\n");
}

fn interface(out: &mut String, interface: &Interface) {
    out.push_str("    interface: (\n");
    section(out, "inputs", &interface.inputs, |input| {
        let reader = (!input.node.is_empty() || !input.param.is_empty())
            .then(|| format!(", node: {}, param: {}", quoted(&input.node), quoted(&input.param)));
        let targets: Vec<_> = input.targets.iter().map(|target| quoted(target)).collect();
        let targets = (!targets.is_empty()).then(|| format!(", targets: [{}]", targets.join(", ")));
        format!(
            "(type: {}{}{}, docs: {})",
            quoted(&input.ty),
            reader.unwrap_or_default(),
            targets.unwrap_or_default(),
            quoted(&input.docs)
        )
    });
    section(out, "outputs", &interface.outputs, |output| {
        format!(
            "(node: {}, socket: {}, docs: {})",
            quoted(&output.node),
            quoted(&output.socket),
            quoted(&output.docs)
        )
    });
    section(out, "params", &interface.params, |param| {
        let targets: Vec<_> = param.targets.iter().map(|target| quoted(target)).collect();
        let default = param.default.as_ref().map(|value| format!(", default: {value}")).unwrap_or_default();
        format!("(targets: [{}]{default}, docs: {})", targets.join(", "), quoted(&param.docs))
    });
    out.push_str("    ),\n");
}

fn section<T>(out: &mut String, name: &str, map: &BTreeMap<String, T>, write: impl Fn(&T) -> String) {
    if map.is_empty() {
        return;
    }
    out.push_str(&format!("        {name}: {{\n"));
    for (key, entry) in map {
        out.push_str(&format!("            {}: {},\n", quoted(key), write(entry)));
    }
    out.push_str("        },\n");
}

fn node(out: &mut String, name: &str, entry: &NodeEntry) {
    out.push_str(&format!("        {}: (type: {}", quoted(name), quoted(&entry.ty)));
    if entry.mode.is_off() {
        out.push_str(&format!(", mode: {}", quoted(entry.mode.name())));
    }
    let mut params: BTreeMap<&str, String> =
        entry.params.iter().map(|(name, value)| (name.as_str(), value.to_string())).collect();
    params.extend(entry.other_params.iter().map(|(name, value)| (name.as_str(), value_text(value))));
    if !params.is_empty() {
        out.push_str(", params: {\n");
        for (name, value) in &params {
            out.push_str(&format!("            {}: {value},\n", quoted(name)));
        }
        out.push_str("        }");
    }
    // A mode that is known takes the place of one that was not.
    for (field, value) in entry.other_fields.iter().filter(|(f, _)| *f != "mode" || !entry.mode.is_off()) {
        out.push_str(&format!(", {field}: {}", value_text(value)));
    }
    out.push_str("),\n");
}

/// A tree as RON that reads back to the same tree. The `ron` crate writes single-precision numbers with
/// their own shortest digits, which then read back as other numbers.
pub(super) fn value_text(value: &Value) -> String {
    let join = |items: Vec<String>| items.join(", ");
    match value {
        Value::Bool(b) => b.to_string(),
        Value::String(text) => quoted(text),
        Value::Number(ron::Number::F32(x)) => float_text(f64::from(x.get())),
        Value::Number(ron::Number::F64(x)) => float_text(x.get()),
        Value::Option(None) => "None".into(),
        Value::Option(Some(inner)) => format!("Some({})", value_text(inner)),
        Value::Seq(items) => format!("[{}]", join(items.iter().map(value_text).collect())),
        Value::Map(map) => {
            let entries = map.iter().map(|(k, v)| format!("{}: {}", value_text(k), value_text(v)));
            format!("{{{}}}", join(entries.collect()))
        }
        Value::Unit => "()".into(),
        // Writing these to a string cannot fail.
        Value::Char(_) | Value::Bytes(_) | Value::Number(_) => ron::to_string(value).unwrap_or_default(),
    }
}
