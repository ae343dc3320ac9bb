//! What can be wrong with a graph, said all at once.

use std::fmt;

use serde::Serialize;

use crate::document::{NodeEntry, NodeMode};

/// The sort of a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ProblemKind {
    /// A node of a type that nobody registered.
    UnknownType,
    /// A node that is not there.
    UnknownNode,
    /// A socket that the node does not have.
    UnknownSocket,
    /// A parameter that the node does not have.
    UnknownParam,
    /// A field of a node that means nothing.
    UnknownField,
    /// A name that the graph's interface does not have.
    UnknownInterface,
    /// A name that links could not refer to.
    BadName,
    /// A link or a target that is no `node.name`.
    BadLink,
    /// A link between sockets of different types, or a value of another type.
    TypeMismatch,
    /// A required input without a link or a value.
    MissingInput,
    /// More than one link into a socket that takes one.
    TooManyLinks,
    /// A parameter's value that is out of range or of the wrong type.
    BadValue,
    /// An output of the interface that hangs on a node which is muted, or bypassed with nothing to pass on.
    Muted,
    /// Nodes that wait for each other, or groups that hold themselves.
    Cycle,
    /// More nodes than a graph may have.
    TooLarge,
}

/// One problem: where it is, what was found and what was expected.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Problem {
    /// Its sort.
    pub kind: ProblemKind,
    /// The node it is at, if any.
    pub node: Option<String>,
    /// What of the node or the graph it is about: ``parameter `size` ``, ``input `image` ``.
    pub item: String,
    /// What was found.
    pub found: String,
    /// What was expected.
    pub expected: String,
    /// A known name that may have been meant.
    pub suggestion: Option<String>,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(node) = &self.node {
            write!(f, "node `{node}`")?;
            if !self.item.is_empty() {
                f.write_str(", ")?;
            }
        }
        write!(f, "{}: found {}, expected {}", self.item, self.found, self.expected)?;
        match &self.suggestion {
            Some(suggestion) => write!(f, "; did you mean `{suggestion}`?"),
            None => Ok(()),
        }
    }
}

/// All problems of a graph, at least one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, thiserror::Error)]
#[error("{}", lines(.0))]
pub struct Problems(pub Vec<Problem>);

fn lines(problems: &[Problem]) -> String {
    problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

impl Problem {
    pub(super) fn new(
        kind: ProblemKind,
        node: Option<&str>,
        item: impl Into<String>,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Self {
            kind,
            node: node.map(str::to_owned),
            item: item.into(),
            found: found.into(),
            expected: expected.into(),
            suggestion: None,
        }
    }

    /// A name that is not among the known ones; `of` says what the known ones are.
    pub(super) fn unknown<'a>(
        kind: ProblemKind,
        node: Option<&str>,
        item: impl Into<String>,
        name: &str,
        of: &str,
        known: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        let known: Vec<_> = known.into_iter().collect();
        let expected = match known.as_slice() {
            [] => format!("none, there are no {of}"),
            few if few.len() <= 8 => format!("one of the {of} {}", names(&known)),
            _ => format!("one of the {} {of}", known.len()),
        };
        let suggestion = crate::suggest::closest(name, known);
        Self { suggestion, ..Self::new(kind, node, item, format!("`{name}`"), expected) }
    }

    /// The fields of a node that mean nothing, and a mode that is none.
    pub(super) fn fields(node: &str, entry: &NodeEntry) -> Vec<Self> {
        let problem = |(field, value): (&String, &ron::Value)| match (field.as_str(), value) {
            ("mode", ron::Value::String(name)) => {
                let known = NodeMode::ALL.iter().map(|mode| mode.name());
                Self::unknown(ProblemKind::BadValue, Some(node), "field `mode`", name, "modes", known)
            }
            ("mode", _) => {
                let expected = "one of the modes \"normal\", \"mute\", \"bypass\"";
                Self::new(ProblemKind::BadValue, Some(node), "field `mode`", "something else", expected)
            }
            _ => {
                let known = ["type", "mode", "params"];
                Self::unknown(ProblemKind::UnknownField, Some(node), "field", field, "fields", known)
            }
        };
        entry.other_fields.iter().map(problem).collect()
    }

    pub(super) fn alone(self) -> Problems {
        Problems(vec![self])
    }
}

fn names(known: &[&str]) -> String {
    known.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}
