//! `breccia completions`.

use clap::CommandFactory;
use clap_complete::Shell;

use crate::exit::Failure;

/// Print a completion script for a shell.
#[derive(clap::Args)]
pub struct Completions {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

impl Completions {
    /// Prints the script.
    pub fn run(&self) -> Result<(), Failure> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut super::Cli::command(), "breccia", &mut script);
        super::answer(&String::from_utf8_lossy(&script))
    }
}
