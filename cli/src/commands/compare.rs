//! `breccia compare`.

use std::sync::Arc;

use breccia_engine::{Engine, RunError};
use breccia_nodes::data::Report;
use breccia_nodes::io::{report_json, report_text};

use super::run::failures;
use crate::exit::{self, Code, Failure};
use crate::graphs;
use crate::interrupt::Interrupt;
use crate::sources::Sources;

/// The preset that measures.
const PRESET: &str = "compare_volume";
const OUTPUT: &str = "quality";

/// Measure how well a volume resembles its exemplar.
///
/// Prints the measures of the preset `compare_volume`; `breccia nodes measure.volume` says what each means, what is good,
/// and what it is blind to.
#[derive(clap::Args)]
#[command(after_help = exit::HELP)]
pub struct Compare {
    /// The picture that the volume should resemble, at the size it was synthesised from
    #[arg(long, value_name = "PATH")]
    exemplar: String,

    /// The volume: NPY or NRRD
    volume: String,

    /// Patches across the axes, and as many oblique ones
    #[arg(long, value_name = "N", default_value_t = 2048)]
    samples: i64,

    /// Selects patches and slices
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: i64,

    /// Print a JSON object
    #[arg(long)]
    json: bool,
}

impl Compare {
    /// Measures and prints.
    pub fn run(&self) -> Result<(), Failure> {
        let interrupt = Interrupt::install();
        let registry = Arc::new(breccia_nodes::registry());
        let mut graph = graphs::load(PRESET, &registry)?;
        for (input, path) in [("exemplar", &self.exemplar), ("volume", &self.volume)] {
            graph.set_input(input, path).map_err(Failure::usage)?;
        }
        for (param, value) in [("samples", self.samples), ("seed", self.seed)] {
            graph.set(param, &breccia_engine::ParamValue::Int(value)).map_err(Failure::usage)?;
        }
        let engine = Engine::builder()
            .files(Arc::new(Sources::default()))
            .build(registry)
            .map_err(|error| Failure::new(Code::Node, error.to_string()))?;
        let result = engine.run(&Arc::new(graph), &[OUTPUT], &interrupt.cancel, &|_| {}).map_err(
            |error| match error {
                RunError::Cancelled => interrupt.failure(),
                RunError::Graph(problems) => Failure::usage(problems),
            },
        )?;
        failures(&result, &[])?;
        let report = result.outputs.get(OUTPUT).and_then(|value| value.downcast::<Report>());
        let report =
            report.ok_or_else(|| Failure::new(Code::Node, "the preset gives no report".to_owned()))?;
        super::answer(&if self.json { report_json(&report) } else { report_text(&report) })
    }
}
