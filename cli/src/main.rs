//! The `breccia` command.
//!
//! One file a command in [`commands`]; what several of them need stands beside it. Nothing here knows an
//! algorithm: commands, presets and nodes describe themselves.

mod commands;
mod exit;

mod graphs;
mod inputs;
mod interrupt;
mod outputs;
mod progress;
mod sizes;
mod term;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    match commands::Cli::parse().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.report();
            failure.code.into()
        }
    }
}
