//! What the pointer is doing.

use eframe::egui::Pos2;

use crate::action::Pin;

/// A drag that goes on.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Gesture {
    /// None.
    #[default]
    None,
    /// What is selected moves.
    Move,
    /// A rectangle is drawn around what is to be selected; from here, in points of the canvas.
    Box(Pos2),
    /// A link is drawn from a socket. `picked` is the link that it was, if it was picked up at its end.
    Wire {
        /// The end that stays.
        from: Pin,
        /// The link that was picked up.
        picked: Option<String>,
    },
    /// A bend of a link is moved.
    Bend {
        /// The link.
        link: String,
        /// Which of its bends.
        index: usize,
    },
    /// A frame's lower right corner is moved.
    Size(u32),
}
