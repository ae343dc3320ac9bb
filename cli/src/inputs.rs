//! Giving a graph its files and parameters from the command line.

use std::collections::BTreeSet;

use breccia_engine::{Graph, parse_value};
use breccia_graphs::set_of;

use crate::exit::Failure;

/// `NAME=VALUE` on the command line.
#[derive(Clone, Debug)]
pub struct Assignment {
    /// What stands before the first `=`.
    pub name: String,
    /// What stands after it.
    pub value: String,
}

impl std::str::FromStr for Assignment {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((name, value)) if !name.trim().is_empty() => {
                Ok(Self { name: name.trim().to_owned(), value: value.to_owned() })
            }
            _ => Err("expected a name, `=` and a value".to_owned()),
        }
    }
}

/// Gives inputs their files. Built-in files of one set belong together: where one of them is replaced, the others
/// would not fit (the mask of another picture), so they are taken away unless they are given too. Returns what
/// was taken away, for people to read.
///
/// # Errors
/// If there is no such input.
pub fn give(graph: &mut Graph, files: &[Assignment]) -> Result<Vec<String>, Failure> {
    let mut replaced = BTreeSet::new();
    for file in files {
        let before = graph.inputs().find(|input| input.name == file.name).map(|input| input.path.to_owned());
        graph.set_input(&file.name, &file.value).map_err(Failure::usage)?;
        if let Some(set) = before.as_deref().and_then(set_of) {
            replaced.insert(set.to_owned());
        }
    }
    let given: BTreeSet<_> = files.iter().map(|file| file.name.as_str()).collect();
    let orphans: Vec<_> = graph
        .inputs()
        .filter(|input| !given.contains(input.name))
        .filter(|input| set_of(input.path).is_some_and(|set| replaced.contains(set)))
        .map(|input| (input.name.to_owned(), input.path.to_owned()))
        .collect();
    let mut notes = Vec::new();
    for (name, path) in orphans {
        graph.set_input(&name, "").map_err(Failure::usage)?;
        notes.push(format!(
            "input `{name}` is left out: `{path}` belongs to what was replaced (--input {name}=… gives one)"
        ));
    }
    Ok(notes)
}

/// Sets parameters, named as the graph exposes them or as `NODE.PARAM`.
///
/// # Errors
/// All that cannot be set, each with what was expected.
pub fn set(graph: &mut Graph, values: &[Assignment], seed: Option<i64>) -> Result<(), Failure> {
    let seed = seed.map(|seed| Assignment { name: "seed".to_owned(), value: seed.to_string() });
    let mut problems = Vec::new();
    for Assignment { name, value } in values.iter().chain(&seed) {
        let result = parse_value(value)
            .map_err(|error| format!("--set {name}: {error}"))
            .and_then(|value| graph.set(name, &value).map_err(|problems| problems.to_string()));
        problems.extend(result.err());
    }
    if problems.is_empty() { Ok(()) } else { Err(Failure::usage(problems.join("\n"))) }
}
