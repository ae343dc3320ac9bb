//! Finding the graph that a command is about: a preset or a file.

use std::path::Path;

use breccia_engine::{Graph, Registry};
use breccia_graphs::ReadError;

use crate::exit::{Code, Failure, did_you_mean};

/// Reads and checks a graph.
///
/// # Errors
/// Says what is wrong with the name, the file or the graph.
pub fn load(name: &str, registry: &Registry) -> Result<Graph, Failure> {
    if let Some(preset) = breccia_graphs::preset(name) {
        let document = preset.document().map_err(|error| invalid(name, &error.to_string()))?;
        return Graph::new(&document, registry).map_err(|problems| invalid(name, &problems.to_string()));
    }
    let (document, folder) = breccia_graphs::read(Path::new(name)).map_err(|error| match error {
        ReadError::Missing => unknown(name),
        ReadError::Unreadable(error) => Failure::new(Code::Input, format!("cannot read `{name}`: {error}")),
        error => invalid(name, &error.to_string()),
    })?;
    Graph::with_folder(&document, registry, &folder).map_err(|problems| invalid(name, &problems.to_string()))
}

/// Neither a preset nor a file.
pub fn unknown(name: &str) -> Failure {
    let known = breccia_graphs::presets().iter().map(|preset| preset.name);
    let hint = did_you_mean(name, known);
    Failure::usage(format!(
        "`{name}` is neither a file nor a preset{hint} (`breccia presets` lists the presets)"
    ))
}

fn invalid(name: &str, problems: &str) -> Failure {
    let lines: Vec<_> = problems.lines().map(|line| format!("{name}: {line}")).collect();
    Failure::new(Code::Graph, lines.join("\n"))
}
