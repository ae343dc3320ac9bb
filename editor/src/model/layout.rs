//! Where the nodes of one graph lie, and what else of it only an editor knows.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Where a node lies, and how it is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Place {
    /// Its left upper corner in points of the canvas, x to the right, y down.
    pub at: [i32; 2],
    /// Whether only its heading is shown.
    #[serde(default, skip_serializing_if = "is_default")]
    pub collapsed: bool,
    /// Whether a small picture of its result is shown.
    #[serde(default, skip_serializing_if = "is_default")]
    pub picture: bool,
}

/// Frames are drawn at least this wide and high.
pub const SMALLEST_FRAME: i32 = 40;

/// A titled rectangle behind nodes.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Frame {
    /// Its left upper corner.
    pub at: [i32; 2],
    /// Its width and height.
    pub size: [i32; 2],
    /// What stands in its heading.
    pub title: String,
}

/// Places, frames and bends of one graph.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Layout {
    /// By node.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub nodes: BTreeMap<String, Place>,
    /// By number.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub frames: BTreeMap<u32, Frame>,
    /// Points that a link runs through, by the link's text.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub bends: BTreeMap<String, Vec<[i32; 2]>>,
}

impl Layout {
    /// Whether there is nothing to keep.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty() && self.frames.is_empty() && self.bends.is_empty()
    }
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
