//! The editor as it is used: driven by the accessible names of its controls, drawn on a software adapter.

mod driving;
mod files;
mod monkey;
mod steps;
mod window;
