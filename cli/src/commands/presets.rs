//! `breccia presets`.

use breccia_engine::{Graph, ParamValue, Registry};

use crate::exit::{Failure, did_you_mean};
use crate::{graphs, outputs};

/// List the built-in graphs, or describe one: its inputs, outputs and parameters.
#[derive(clap::Args)]
pub struct Presets {
    /// The preset to describe
    name: Option<String>,
}

impl Presets {
    /// Prints the list or the description.
    pub fn run(&self) -> Result<(), Failure> {
        let registry = breccia_nodes::registry();
        let Some(name) = &self.name else { return super::answer(&list(&registry)?) };
        if breccia_graphs::preset(name).is_none() {
            let known: Vec<_> = breccia_graphs::presets().iter().map(|preset| preset.name).collect();
            let hint = did_you_mean(name, known.iter().copied());
            let known = known.join(", ");
            return Err(Failure::usage(format!("found no preset `{name}`, expected one of {known}{hint}")));
        }
        super::answer(&describe(name, &graphs::load(name, &registry)?, &registry))
    }
}

fn list(registry: &Registry) -> Result<String, Failure> {
    let presets = breccia_graphs::presets();
    let width = presets.iter().map(|preset| preset.name.len()).max().unwrap_or(0);
    let mut out = String::new();
    for preset in presets {
        let graph = graphs::load(preset.name, registry)?;
        out.push_str(&format!("{:width$}  {}\n", preset.name, graph.title()));
    }
    out.push_str("\n`breccia presets NAME` describes one. Built-in files for --input:\n");
    for asset in breccia_graphs::assets() {
        out.push_str(&format!("  builtin:{}\n", asset.name));
    }
    Ok(out)
}

fn describe(name: &str, graph: &Graph, registry: &Registry) -> String {
    let mut out = format!("{name}: {}\n\n{}\n", graph.title(), graph.docs());
    out.push_str("\nInputs (--input NAME=PATH)\n");
    for input in graph.inputs() {
        let default = if input.path.is_empty() { "none" } else { input.path };
        out.push_str(&format!("  {} ({}, default {default})\n      {}\n", input.name, input.ty, input.docs));
    }
    out.push_str("\nParameters (--set NAME=VALUE)\n");
    for param in graph.params() {
        let mut takes = param.spec.kind.describe();
        if !matches!(param.spec.unit, "" | "1" | "count") {
            takes = format!("{takes}, in {}", param.spec.unit);
        }
        let value = plain(param.value);
        out.push_str(&format!("  {} = {value} ({takes})\n      {}\n", param.name, param.docs));
    }
    out.push_str("\nOutputs (--output NAME=PATH)\n");
    for output in graph.outputs() {
        let formats: Vec<_> = outputs::extensions(registry, output.ty)
            .into_iter()
            .map(|extension| if extension == "/" { "folder/".to_owned() } else { format!(".{extension}") })
            .collect();
        let formats = formats.join(" ");
        out.push_str(&format!("  {} ({}: {formats})\n      {}\n", output.name, output.ty, output.docs));
    }
    out.push_str(
        "\nParameters of the nodes inside can be set as well, as NODE.PARAM; `breccia nodes` describes them:\n",
    );
    for (node, spec) in graph.nodes() {
        out.push_str(&format!("  {node} ({})\n", spec.id));
    }
    out.push_str(&format!("\nExample\n  {}\n", example(name, graph, registry)));
    out
}

/// A command that gives an input, sets what is set most often, and names the picture and what it shows.
fn example(name: &str, graph: &Graph, registry: &Registry) -> String {
    let mut words = vec![format!("breccia run {name}")];
    let first = graph.inputs().next().map_or("", |input| input.name);
    // Inputs such as `exemplar_x` come together.
    let stem = first.trim_end_matches(|c: char| c != '_').trim_end_matches('_');
    for input in graph.inputs() {
        if input.name == first || (!stem.is_empty() && input.name.starts_with(stem)) {
            words.push(format!("--input {0}={0}.png", input.name));
        }
    }
    for param in graph.params().filter(|param| matches!(param.name, "seed" | "size" | "resolution")) {
        words.push(format!("--set {}={}", param.name, quoted(&plain(param.value))));
    }
    // What a graph is for comes as neither picture nor table, if it comes as anything else.
    let results = || graph.outputs().filter(|output| output.name != "preview");
    let result =
        results().find(|output| !matches!(output.ty, "image" | "report")).or_else(|| results().next());
    for output in result.into_iter().chain(graph.outputs().filter(|output| output.name == "preview")) {
        let extension = outputs::extensions(registry, output.ty).into_iter().find(|e| *e != "/");
        if let Some(extension) = extension {
            words.push(format!("--output {0}={0}.{extension}", output.name));
        }
    }
    words.join(" \\\n      ")
}

/// A list of one as the number that may be given in its place.
fn plain(value: &ParamValue) -> String {
    match value {
        ParamValue::List(items) if items.len() == 1 => items.iter().map(ToString::to_string).collect(),
        value => value.to_string(),
    }
}

/// Quotes what a shell would take for syntax.
fn quoted(value: &str) -> String {
    if value.contains(['(', '[', ' ', '"']) { format!("'{value}'") } else { value.to_owned() }
}
