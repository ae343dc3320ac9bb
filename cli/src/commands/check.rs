//! `breccia check`.

use crate::exit::{Code, Failure};
use crate::graphs;

/// Check graphs and print every problem, running nothing.
#[derive(clap::Args)]
pub struct Check {
    /// Graph documents or presets
    #[arg(required = true, value_name = "GRAPH")]
    graphs: Vec<String>,
}

impl Check {
    /// Prints the problems of all graphs.
    pub fn run(&self) -> Result<(), Failure> {
        let registry = breccia_nodes::registry();
        let mut valid = String::new();
        let mut failures: Vec<Failure> = Vec::new();
        for name in &self.graphs {
            match graphs::load(name, &registry) {
                Ok(graph) => valid.push_str(&format!("{name}: valid, {} nodes\n", graph.nodes().count())),
                Err(failure) => failures.push(failure),
            }
        }
        super::answer(&valid)?;
        let Some(first) = failures.first() else { return Ok(()) };
        // An invalid graph is what the command looks for; other troubles count where there is none.
        let code = if failures.iter().any(|f| f.code == Code::Graph) { Code::Graph } else { first.code };
        let messages: Vec<_> = failures.into_iter().map(|failure| failure.message).collect();
        Err(Failure::new(code, messages.join("\n")))
    }
}
