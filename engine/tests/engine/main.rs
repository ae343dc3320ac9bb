//! Tests of the engine from outside, on its event stream.

mod caching;
mod cancelling;
mod describing;
mod disk;
mod documents;
mod explaining;
mod failing;
mod modes;
mod nodes;
mod placing;
mod processes;
mod sharing;
mod support;
mod validating;
mod zones;
