//! Everything that can be done without pointing at something: menus, shortcuts, the command search and the shortcut sheet all
//! come from this one table.

use eframe::egui::{Key, KeyboardShortcut, Modifiers};

macro_rules! commands {
    ($($name:ident, $menu:literal, $title:literal, $shortcut:expr, $docs:literal;)*) => {
        /// Something that can be done.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Command {
            $(#[doc = $docs] $name,)*
        }

        impl Command {
            /// All commands, in the order of the menus.
            pub const ALL: &'static [Self] = &[$(Self::$name),*];

            /// The menu that it is in.
            pub fn menu(self) -> &'static str {
                match self { $(Self::$name => $menu),* }
            }

            /// What it is called.
            pub fn title(self) -> &'static str {
                match self { $(Self::$name => $title),* }
            }

            /// The keys that do it.
            pub fn shortcut(self) -> Option<KeyboardShortcut> {
                match self { $(Self::$name => $shortcut),* }
            }

            /// What it does.
            pub fn docs(self) -> &'static str {
                match self { $(Self::$name => $docs),* }
            }
        }
    };
}

const fn key(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::NONE, key))
}

const fn ctrl(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::COMMAND, key))
}

const fn ctrl_shift(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), key))
}

const fn alt(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::ALT, key))
}

commands! {
    New, "File", "New", ctrl(Key::N), "An empty graph.";
    Gallery, "File", "New from preset…", ctrl_shift(Key::N), "Presets with their pictures, to start from.";
    Open, "File", "Open…", ctrl(Key::O), "A graph from a file.";
    Reload, "File", "Reload", None, "Reads the file again. What is not saved can be brought back by undo.";
    Save, "File", "Save", ctrl(Key::S), "Writes the graph to its file.";
    SaveAs, "File", "Save as…", ctrl_shift(Key::S), "Writes the graph to another file.";
    ImportBundle, "File", "Import bundle…", None, "Unpacks a graph that was packed with its files, and opens it.";
    ExportBundle, "File", "Export bundle…", None, "Packs the graph with all files that it reads, to pass it on.";
    ExportOutput, "File", "Export what is shown…", ctrl(Key::E), "Writes the result that is looked at, in the format of the file's extension.";
    Quit, "File", "Quit", ctrl(Key::Q), "Closes the window.";

    Undo, "Edit", "Undo", ctrl(Key::Z), "Takes back the last step.";
    Redo, "Edit", "Redo", ctrl_shift(Key::Z), "Does the last undone step again.";
    Cut, "Edit", "Cut", ctrl(Key::X), "Copies what is selected and deletes it.";
    Copy, "Edit", "Copy", ctrl(Key::C), "Copies the selected nodes as text.";
    Paste, "Edit", "Paste", ctrl(Key::V), "Puts copied nodes where the pointer is.";
    Duplicate, "Edit", "Duplicate", ctrl(Key::D), "Copies the selected nodes to beside themselves, linked to what they were linked to.";
    Delete, "Edit", "Delete", key(Key::Delete), "Deletes what is selected.";
    SelectAll, "Edit", "Select all", ctrl(Key::A), "Selects all nodes and frames.";
    SelectNone, "Edit", "Select nothing", key(Key::Escape), "Selects nothing.";
    SelectNext, "Edit", "Select next node", alt(Key::ArrowRight), "Goes along a link to the next node, or to the first.";
    SelectPrevious, "Edit", "Select previous node", alt(Key::ArrowLeft), "Goes back along a link.";

    AddNode, "Node", "Add node…", key(Key::Tab), "Finds a node by name, family or keyword.";
    Connect, "Node", "Connect selected", key(Key::C), "Links the selected nodes, left to right, by the first sockets that fit.";
    DisconnectAll, "Node", "Disconnect", key(Key::X), "Removes all links of the selected nodes, or the selected links.";
    Rename, "Node", "Rename", key(Key::F2), "Gives the selected node another name.";
    Watch, "Node", "Look at", key(Key::V), "Shows the node's result in the viewport; again for its next output.";
    Mute, "Node", "Mute", key(Key::M), "As if the node were not there; again to let it run.";
    Bypass, "Node", "Bypass", key(Key::B), "Passes its input on unchanged; again to let it run.";
    Collapse, "Node", "Collapse", key(Key::H), "Shows only the heading; again to show all.";
    Picture, "Node", "Show picture", key(Key::P), "Shows a small picture of the node's result; again to hide it.";
    Group, "Node", "Group", ctrl(Key::G), "Makes one node of the selected nodes.";
    Ungroup, "Node", "Ungroup", ctrl_shift(Key::G), "Puts a group's nodes in the place of its node.";
    Enter, "Node", "Enter group", key(Key::Enter), "Goes into the group that the node stands for.";
    Leave, "Node", "Leave group", key(Key::Backspace), "Goes back out of the group.";
    SaveGroup, "Node", "Save group as preset…", None, "Keeps the group, to be found in the node search from now on.";
    LocaliseGroup, "Node", "Make group part of the graph", None, "A group that stands in a file becomes part of the document, so that it can be edited here.";
    Frame, "Node", "Frame", key(Key::J), "Draws a titled frame around the selected nodes.";

    AlignLeft, "Arrange", "Align left", None, "Moves the selected nodes to the leftmost edge.";
    AlignRight, "Arrange", "Align right", None, "Moves the selected nodes to the rightmost edge.";
    AlignTop, "Arrange", "Align top", None, "Moves the selected nodes to the uppermost edge.";
    AlignBottom, "Arrange", "Align bottom", None, "Moves the selected nodes to the lowermost edge.";
    Arrange, "Arrange", "Lay out", key(Key::L), "Lays the selected nodes, or all, out in columns from left to right.";

    Run, "Run", "Run", key(Key::F5), "Computes all outputs of the graph.";
    Stop, "Run", "Stop", Some(KeyboardShortcut::new(Modifiers::SHIFT, Key::F5)), "Stops computing.";
    Live, "Run", "Live", key(Key::F6), "Computes what is looked at after every change.";
    ClearMemory, "Run", "Forget results", None, "Lets go of the results that are kept in memory.";

    FitAll, "View", "Show all", key(Key::Home), "Brings the whole graph into view.";
    FitSelection, "View", "Show selection", key(Key::F), "Brings what is selected into view.";
    ZoomIn, "View", "Zoom in", ctrl(Key::Plus), "Shows the canvas larger.";
    ZoomOut, "View", "Zoom out", ctrl(Key::Minus), "Shows the canvas smaller.";
    Minimap, "View", "Map", None, "Shows the whole graph in a corner.";
    Legend, "View", "Legend of sockets", None, "Tells which colour and shape is which type.";
    Inspector, "View", "Inspector", key(Key::F9), "Shows or hides the parameters.";
    FocusInspector, "View", "Go to the inspector", key(Key::F8), "Gives the keyboard to the first control of the inspector; Tab goes on from there, Escape comes back.";
    Viewport, "View", "Viewport", key(Key::F10), "Shows or hides the viewport.";
    Theme, "View", "Light or dark", None, "Goes from the light to the dark theme and back.";
    Larger, "View", "Larger controls", ctrl(Key::Period), "Makes text and controls larger.";
    Smaller, "View", "Smaller controls", ctrl(Key::Comma), "Makes text and controls smaller.";

    Commands, "Help", "Find command…", ctrl_shift(Key::P), "Finds anything on this sheet by its name.";
    Shortcuts, "Help", "Shortcuts", key(Key::F1), "All commands with their keys.";
    Tour, "Help", "First steps", None, "One page on how it all works.";
}

impl Command {
    /// The menus, in order.
    pub const MENUS: [&'static str; 7] = ["File", "Edit", "Node", "Arrange", "Run", "View", "Help"];

    /// What a node's own menu offers.
    pub const OF_NODE: [Self; 13] = [
        Self::Watch,
        Self::Rename,
        Self::Duplicate,
        Self::Delete,
        Self::DisconnectAll,
        Self::Mute,
        Self::Bypass,
        Self::Collapse,
        Self::Picture,
        Self::Group,
        Self::Ungroup,
        Self::Enter,
        Self::Frame,
    ];

    /// Whether its keys are plain letters that mean something else while text is typed.
    pub fn is_plain(self) -> bool {
        self.shortcut().is_some_and(|shortcut| {
            shortcut.modifiers == Modifiers::NONE
                && !matches!(shortcut.logical_key, Key::F1 | Key::F5 | Key::F6 | Key::F8 | Key::F9 | Key::F10)
        })
    }
}
