//! What the user asks for: the panels say it, the application does it.

use std::collections::BTreeSet;

use breccia_engine::ParamValue;

use crate::model::Alignment;

/// A socket of a node.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Pin {
    /// The node.
    pub node: String,
    /// The socket.
    pub socket: String,
    /// Whether something comes out of it.
    pub output: bool,
}

/// What is selected.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Nodes by name.
    pub nodes: BTreeSet<String>,
    /// Links by text.
    pub links: BTreeSet<String>,
    /// Frames by number.
    pub frames: BTreeSet<u32>,
}

impl Selection {
    /// One node.
    pub fn node(name: impl Into<String>) -> Self {
        Self { nodes: BTreeSet::from([name.into()]), ..Self::default() }
    }

    /// Whether nothing is selected.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty() && self.links.is_empty() && self.frames.is_empty()
    }

    /// The node, if it is just one.
    pub fn single(&self) -> Option<&String> {
        if self.nodes.len() == 1 { self.nodes.first() } else { None }
    }
}

/// What a new node shall be joined to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Joint {
    /// A socket whose link was dropped.
    Pin(Pin),
    /// Two sockets of different types, with the node between them.
    Between {
        /// The output.
        from: Pin,
        /// The input.
        to: Pin,
        /// The link that this comes in the place of.
        instead: Option<String>,
    },
    /// A link, by its text.
    Link(String),
}

/// What a new node is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A node of a type, by id.
    Type(String),
    /// A node that stands for a group of the document, by the group's name.
    Group(String),
    /// A node that stands for a group kept as a preset, by the preset's name.
    Preset(String),
}

/// What the user asks for.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Add a node.
    Add {
        /// What it is.
        kind: Kind,
        /// Where.
        at: [i32; 2],
        /// What it is joined to.
        joint: Option<Joint>,
    },
    /// Make a link.
    Connect(Pin, Pin),
    /// Remove links.
    Disconnect(Vec<String>),
    /// Put one end of a link elsewhere.
    Reconnect {
        /// The link as it was.
        link: String,
        /// Where it comes from.
        from: Pin,
        /// Where it goes now.
        to: Pin,
    },
    /// Select these, and nothing else.
    Select(Selection),
    /// Move what is selected.
    Move([i32; 2]),
    /// A drag is over.
    EndDrag,
    /// Put a node into a link.
    DropOnLink {
        /// The node.
        node: String,
        /// The link.
        link: String,
    },
    /// Put the points that a link runs through.
    Bend(String, Vec<[i32; 2]>),
    /// Give a frame another size.
    SizeFrame(u32, [i32; 2]),
    /// Give a frame another title.
    TitleFrame(u32, String),
    /// Go into a node's group.
    Enter(String),
    /// Go back to a graph: how many steps of the way in remain.
    Leave(usize),
    /// Look at a node's output.
    Watch(Pin),
    /// Set a parameter, or put it back to its default.
    Set {
        /// The node.
        node: String,
        /// The parameter.
        param: String,
        /// The value.
        value: Option<ParamValue>,
        /// Whether more of the same is to come.
        dragging: bool,
    },
    /// Offer a parameter on the graph.
    Expose {
        /// The node.
        node: String,
        /// The parameter.
        param: String,
    },
    /// Take a parameter back from the graph.
    Unexpose {
        /// The node.
        node: String,
        /// The parameter.
        param: String,
    },
    /// Let an exposed parameter set this one too.
    LinkParam {
        /// The node.
        node: String,
        /// The parameter.
        param: String,
        /// The exposed parameter.
        to: String,
    },
    /// Pick a file for a parameter.
    PickFile {
        /// The node.
        node: String,
        /// The parameter.
        param: String,
    },
    /// Give a node another name.
    Rename(String, String),
    /// Give the document another title.
    Title(String),
    /// Say what the document does.
    Docs(String),
    /// Offer a node's output on the graph, or take it back.
    Output(Pin),
    /// Bring nodes to a common line.
    Align(Alignment),
    /// Show a node: from the list of problems, say.
    Reveal(String),
    /// Open the palette at a place of the canvas.
    Palette {
        /// Where on the canvas.
        at: [i32; 2],
        /// What the new node is joined to.
        joint: Option<Joint>,
    },
    /// Open a file.
    OpenPath(std::path::PathBuf),
    /// Open a preset.
    OpenPreset(String),
    /// Say something in the line below.
    Say(String),
    /// One of the commands.
    Command(crate::command::Command),
}
