//! `breccia man`.

use clap::CommandFactory;

use crate::exit::{Code, Failure};

/// Print the manual page, those of the commands included.
#[derive(clap::Args)]
pub struct Man {}

impl Man {
    /// Prints the page of the program, then that of each command.
    pub fn run(&self) -> Result<(), Failure> {
        let mut command = super::Cli::command();
        command.build();
        let mut page = Vec::new();
        let commands: Vec<_> = command.get_subcommands().cloned().collect();
        for command in std::iter::once(command).chain(commands) {
            let name = command.get_display_name().map(str::to_owned);
            let man = match name {
                Some(name) => clap_mangen::Man::new(command).title(name),
                None => clap_mangen::Man::new(command),
            };
            man.render(&mut page).map_err(|error| Failure::new(Code::Output, error.to_string()))?;
        }
        super::answer(&String::from_utf8_lossy(&page))
    }
}
