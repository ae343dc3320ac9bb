//! Finding the graph that a command is about: a preset or a file.

use std::path::Path;

use breccia_engine::{Document, Graph, IncludeError, Registry};

use crate::exit::{Code, Failure, did_you_mean};
use crate::sources::Sources;

/// Reads and checks a graph.
///
/// # Errors
/// Says what is wrong with the name, the file or the graph.
pub fn load(name: &str, registry: &Registry) -> Result<Graph, Failure> {
    if let Some(preset) = breccia_graphs::preset(name) {
        let mut document = Document::parse(preset.ron).map_err(|error| invalid(name, &error.to_string()))?;
        include(&mut document, Path::new("")).map_err(|error| invalid(name, &error.to_string()))?;
        return Graph::new(&document, registry).map_err(|problems| invalid(name, &problems.to_string()));
    }
    let path = Path::new(name);
    let bytes = std::fs::read(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => {
            let known = breccia_graphs::presets().iter().map(|preset| preset.name);
            let hint = did_you_mean(name, known);
            Failure::usage(format!(
                "`{name}` is neither a file nor a preset{hint} (`breccia presets` lists the presets)"
            ))
        }
        _ => Failure::new(Code::Input, format!("cannot read `{name}`: {error}")),
    })?;
    let mut document = Document::parse_bytes(&bytes).map_err(|error| invalid(name, &error.to_string()))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    include(&mut document, folder).map_err(|error| invalid(name, &error.to_string()))?;
    Graph::with_folder(&document, registry, folder).map_err(|problems| invalid(name, &problems.to_string()))
}

/// Reads the groups that stand in files of their own.
fn include(document: &mut Document, folder: &Path) -> Result<(), IncludeError> {
    document.include(folder, &Sources::default())
}

fn invalid(name: &str, problems: &str) -> Failure {
    let lines: Vec<_> = problems.lines().map(|line| format!("{name}: {line}")).collect();
    Failure::new(Code::Graph, lines.join("\n"))
}
