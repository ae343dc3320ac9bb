//! The visual node editor of Breccia.
//!
//! What can be edited, and how, is in [`model`]; what runs, and what is known of it, in [`run`]; what is on disk in [`files`]. None
//! of these knows a window. What is drawn is drawn anew every frame from them: [`canvas`], [`inspector`], [`view`]. These say what
//! the user asks for ([`action`]), and [`app`] does it.

pub mod action;
pub mod app;
pub mod canvas;
pub mod command;
pub mod files;
pub mod inspector;
pub mod model;
pub mod palette;
pub mod run;
pub mod theme;
pub mod view;
pub mod window;
