//! The document as it is edited: the engine's document, where its nodes lie, and every change by name so that it can be undone.
//!
//! Nothing here knows a window. A change is a plain function on a [`State`]; [`Project`] makes it a step of history.

mod arrange;
mod clipboard;
mod diff;
mod edit;
mod group;
mod history;
mod layout;
mod level;
mod params;
mod project;
mod reach;
mod shape;
mod state;

pub use arrange::{Alignment, align, arrange, arrange_missing};
pub use clipboard::{Parts, copy, duplicate, paste};
pub use edit::{
    Refusal, add_frame, add_node, bend, compatible, connect, delete, disconnect, drop_output, insert_between,
    insert_on_link, move_by, offer_output, rename, set_collapsed, set_mode, set_picture, unique,
};
pub use group::{group, group_at, localise, ungroup};
pub use history::History;
pub use layout::{Frame, Layout, Place, SMALLEST_FRAME};
pub use level::{Address, Crumb, Level, Trail, free_group_name};
pub use params::{Exposure, expose, exposure, link_param, set_param, unexpose};
pub use project::{Project, text_of};
pub use reach::reach;
pub use shape::{ParamShape, Shape, Socket, shape_of};
pub use state::State;

#[cfg(test)]
mod tests;
