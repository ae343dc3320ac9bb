//! Tests of the real binary.

mod bad_files;
mod bad_usage;
mod caching;
mod cancelling;
mod comparing;
mod describing;
mod determinism;
mod devices;
mod edited;
mod editing;
mod support;
mod writing;
