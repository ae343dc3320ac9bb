//! Whether a node takes part: normally, not at all, or by passing on what it is given.

use std::fmt;

/// How a node of a document takes part in a run. In a document it stands as `mode: "mute"` or `mode: "bypass"`; a
/// node without that field takes part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum NodeMode {
    /// It runs.
    #[default]
    Normal,
    /// As if it were absent: what its outputs are linked to is given nothing.
    Mute,
    /// Each output passes on what is linked to the first input of the same type (of several links the first). Where
    /// nothing is, it is as if the node were absent.
    Bypass,
}

impl NodeMode {
    /// All modes.
    pub const ALL: [Self; 3] = [Self::Normal, Self::Mute, Self::Bypass];

    /// The name that stands in documents.
    pub fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Mute => "mute",
            Self::Bypass => "bypass",
        }
    }

    /// The mode of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|mode| mode.name() == name)
    }

    /// Whether the node does not run.
    pub fn is_off(self) -> bool {
        self != Self::Normal
    }
}

impl fmt::Display for NodeMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
