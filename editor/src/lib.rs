//! The visual node editor of Breccia.
//!
//! Everything that is not drawn lives in modules that know no window: [`files`] (what is on disk). Everything
//! that is drawn is rebuilt from it every frame: [`view`] (pictures and objects).

pub mod files;
pub mod view;
