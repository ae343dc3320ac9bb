//! `breccia devices`.

use breccia_nodes::lazy::available_instruction_sets;

use crate::exit::Failure;

/// Say what computations run on.
#[derive(clap::Args)]
pub struct Devices {}

impl Devices {
    /// Prints threads and instruction sets.
    pub fn run(&self) -> Result<(), Failure> {
        let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let sets: Vec<_> = available_instruction_sets().iter().map(|isa| format!("{isa:?}")).collect();
        super::answer(&format!(
            "cpu  {threads} threads; code paths of lazy synthesis that run here: {}\n\
             gpu  no compute device is built into this program\n",
            sets.join(", ")
        ))
    }
}
