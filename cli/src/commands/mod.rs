//! The commands, one a file.

mod cache;
mod check;
mod compare;
mod completions;
mod devices;
mod edit;
mod man;
mod nodes;
mod presets;
mod run;

use clap::{Parser, Subcommand};

use crate::exit::{self, Code, Failure};
use crate::term;

/// Makes solid textures from pictures: runs graphs of typed nodes, and keeps every result in a cache.
#[derive(Parser)]
#[command(name = "breccia", version, after_help = exit::HELP, propagate_version = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a graph and write its outputs
    Run(run::Run),
    /// Open the visual editor
    Edit(edit::Edit),
    /// List the built-in graphs, or describe one
    Presets(presets::Presets),
    /// List the node types, or describe one
    Nodes(nodes::Nodes),
    /// Check graphs and print every problem
    Check(check::Check),
    /// Measure how well a volume resembles its exemplar
    Compare(compare::Compare),
    /// Look at the disk cache, or clear it
    Cache(cache::Cache),
    /// Say what computations run on
    Devices(devices::Devices),
    /// Print a completion script for a shell
    Completions(completions::Completions),
    /// Print the manual page
    Man(man::Man),
}

impl Cli {
    /// Does what the command line says.
    ///
    /// # Errors
    /// Says what went wrong, with the code to exit with.
    pub fn run(self) -> Result<(), Failure> {
        match self.command {
            Command::Run(run) => run.run(),
            Command::Edit(edit) => edit.run(),
            Command::Presets(presets) => presets.run(),
            Command::Nodes(nodes) => nodes.run(),
            Command::Check(check) => check.run(),
            Command::Compare(compare) => compare.run(),
            Command::Cache(cache) => cache.run(),
            Command::Devices(devices) => devices.run(),
            Command::Completions(completions) => completions.run(),
            Command::Man(man) => man.run(),
        }
    }
}

/// Writes a command's answer to standard output.
fn answer(text: &str) -> Result<(), Failure> {
    term::print(text)
        .map_err(|error| Failure::new(Code::Output, format!("cannot write to standard output: {error}")))
}
