//! `breccia compare`.

mod made;
mod page;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use breccia_engine::{Document, Engine, Graph, ParamValue, Registry, RunError, RunResult};
use breccia_graphs::Sources;
use breccia_nodes::data::{Curves, Image, Report};
use breccia_nodes::io::{report_json, report_text};

use super::run::failures;
use crate::exit::{self, Code, Failure};
use crate::inputs::Assignment;
use crate::interrupt::Interrupt;
use crate::{graphs, outputs};
use page::{Figure, Page};

/// The preset that measures.
const PRESET: &str = "compare_volume";
/// Its outputs: measures of likeness, of phases, and what is plotted of both.
const QUALITY: &str = "quality";
const PHASES: &str = "phases";
const CURVES: &str = "curves";
const PHASE_CURVES: &str = "phase_curves";
/// The pictures of a report, as outputs of nodes, and what they show.
const FIGURES: [(&str, &str); 6] = [
    ("cuts.x", "middle slice across x"),
    ("cuts.y", "middle slice across y"),
    ("cuts.z", "middle slice across z"),
    ("cuts.a", "oblique, across (1, 1, 1)"),
    ("cuts.b", "oblique, across (1, −1, 1)"),
    ("cuts.c", "oblique, across (1, 2, −1)"),
];
/// The file of a report.
const FILE: &str = "report.html";

/// Measure how well a volume resembles its exemplar.
///
/// Prints the measures of the preset `compare_volume` on slices across the axes and on oblique cuts, each with what the exemplar
/// itself scores in brackets and the range that is good; ! marks what is outside. `breccia nodes measure.volume` says what each
/// means and what it is blind to, `breccia nodes measure.phases` that of the phases. Flagged measures do not change the exit code.
#[derive(clap::Args)]
#[command(after_help = exit::HELP)]
pub struct Compare {
    /// The picture that the volume should resemble, at the size it was synthesised from
    #[arg(long, value_name = "PATH")]
    exemplar: String,

    /// What slices across y should resemble, if that differs
    #[arg(long, value_name = "PATH")]
    exemplar_y: Option<String>,

    /// What slices across z should resemble, if that differs
    #[arg(long, value_name = "PATH")]
    exemplar_z: Option<String>,

    /// The volume: NPY or NRRD; or a graph or a preset with an output `volume`, which is run and measured
    volume: String,

    /// Give an input of that graph a file; its `exemplar` is --exemplar unless it is given here
    #[arg(long = "input", value_name = "NAME=PATH")]
    inputs: Vec<Assignment>,

    /// Set a parameter of that graph, as `breccia run --set` does
    #[arg(long = "set", value_name = "NAME=VALUE | NODE.PARAM=VALUE")]
    values: Vec<Assignment>,

    /// Measure the bright and the dark phase too, against --exemplar: fractions, correlation, chords, surface, Euler numbers, connectivity
    #[arg(long)]
    phases: bool,

    /// A volume of the same size, colours or labels, whose phases are compared in 3D; implies --phases
    #[arg(long, value_name = "VOLUME")]
    truth: Option<String>,

    /// Patches across the axes, and as many oblique ones
    #[arg(long, value_name = "N", default_value_t = 2048)]
    samples: i64,

    /// Selects patches and slices
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: i64,

    /// Print a JSON object
    #[arg(long)]
    json: bool,

    /// Write report.html into this folder: all pictures, curves and numbers on one page that needs nothing else
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

impl Compare {
    /// Measures, writes and prints.
    pub fn run(&self) -> Result<(), Failure> {
        let interrupt = Interrupt::install();
        let registry = Arc::new(breccia_nodes::registry());
        let target = self.report.as_ref().map(|folder| folder.join(FILE));
        if let Some(path) = &target {
            outputs::writable(path).map_err(|error| unwritable(path, &error))?;
        }
        let made = self.made(&registry, &interrupt)?;
        let made_by = made.as_ref().map(|made| made.document.clone());
        let graph = Arc::new(self.graph(&registry, made.as_ref().map_or(&self.volume, |_| made::HELD))?);
        let names = self.outputs();
        let engine = Engine::builder()
            .files(Arc::new(
                made.map_or_else(Sources::default, |made| Sources::holding(made::HELD, made.npy)),
            ))
            .build(Arc::clone(&registry))
            .map_err(|error| Failure::new(Code::Node, error.to_string()))?;
        let result = engine.run(&graph, &names, &interrupt.cancel, &|_| {}).map_err(|error| match error {
            RunError::Cancelled => interrupt.failure(),
            RunError::Graph(problems) => Failure::usage(problems),
        })?;
        failures(&result, &[])?;
        let mut report = (*output::<Report>(&result, QUALITY)?).clone();
        if self.phases() {
            report.rows.extend(output::<Report>(&result, PHASES)?.rows.iter().cloned());
        }
        if let Some(path) = &target {
            let page = self.page(&graph, &registry, &result, &report, made_by)?;
            publish(path, &page, &interrupt)?;
        }
        super::answer(&if self.json { report_json(&report) } else { report_text(&report) })
    }

    fn phases(&self) -> bool {
        self.phases || self.truth.is_some()
    }

    /// The exemplars that are given, with the inputs and nodes that read them.
    fn exemplars(&self) -> impl Iterator<Item = (&'static str, &'static str, &String)> {
        let given = [
            ("exemplar", "photo.image", Some(&self.exemplar)),
            ("exemplar_y", "photo_y.image", self.exemplar_y.as_ref()),
            ("exemplar_z", "photo_z.image", self.exemplar_z.as_ref()),
        ];
        given.into_iter().filter_map(|(input, output, path)| Some((input, output, path?)))
    }

    /// The preset with what the command line says.
    fn graph(&self, registry: &Registry, volume: &str) -> Result<Graph, Failure> {
        let mut graph = graphs::load(PRESET, registry)?;
        let truth = self.truth.iter().map(|path| ("truth", path));
        let files = self.exemplars().map(|(input, _, path)| (input, path)).chain(truth);
        for (input, path) in files.map(|(input, path)| (input, path.as_str())).chain([("volume", volume)]) {
            graph.set_input(input, path).map_err(Failure::usage)?;
        }
        for (param, value) in [("samples", self.samples), ("seed", self.seed)] {
            graph.set(param, &ParamValue::Int(value)).map_err(Failure::usage)?;
        }
        Ok(graph)
    }

    fn outputs(&self) -> Vec<&'static str> {
        let mut names = vec![QUALITY];
        names.extend(self.phases().then_some(PHASES));
        if self.report.is_some() {
            names.push(CURVES);
            names.extend(self.phases().then_some(PHASE_CURVES));
            names.extend(FIGURES.map(|(output, _)| output));
            names.extend(self.exemplars().map(|(_, output, _)| output));
        }
        names
    }

    fn page(
        &self,
        graph: &Graph,
        registry: &Registry,
        result: &RunResult,
        report: &Report,
        made_by: Option<String>,
    ) -> Result<String, Failure> {
        let exemplars = self.exemplars().map(|(input, output, _)| (output, input));
        let mut figures = Vec::new();
        for (name, caption) in exemplars.chain(FIGURES) {
            figures.push(Figure { caption, image: output::<Image>(result, name)? });
        }
        let mut plots = output::<Curves>(result, CURVES)?.plots.clone();
        let mut meanings = vec!["measure.volume"];
        if self.phases() {
            plots.extend(output::<Curves>(result, PHASE_CURVES)?.plots.iter().cloned());
            meanings.push("measure.phases");
        }
        let docs = |id: &str| registry.node(id).map(|node| node.spec.docs);
        let page = Page {
            volume: &self.volume,
            report,
            figures,
            plots,
            meanings: meanings.into_iter().filter_map(|id| Some((id, docs(id)?))).collect(),
            document: document(graph)?,
            made_by,
            seed: self.seed,
        };
        page.html().map_err(|error| Failure::new(Code::Output, error.to_string()))
    }
}

fn output<T: breccia_engine::Data>(result: &RunResult, name: &str) -> Result<Arc<T>, Failure> {
    let value = result.outputs.get(name).and_then(|value| value.downcast());
    value.ok_or_else(|| Failure::new(Code::Node, format!("the preset gives no `{name}`")))
}

/// The preset as a document with every parameter as it was in this run.
fn document(graph: &Graph) -> Result<String, Failure> {
    let preset = breccia_graphs::preset(PRESET).map(|preset| Document::parse(preset.ron));
    let Some(Ok(mut document)) = preset else {
        return Err(Failure::new(Code::Graph, format!("no preset `{PRESET}`")));
    };
    for (name, node) in &mut document.nodes {
        for (param, value) in graph.node_params(name).into_iter().flatten() {
            node.params.insert((*param).to_owned(), value.clone());
        }
    }
    Ok(document.to_ron())
}

fn unwritable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(Code::Output, format!("cannot write `{}`: {error}", path.display()))
}

/// Writes a file whole or not at all.
fn publish(path: &Path, text: &str, interrupt: &Interrupt) -> Result<(), Failure> {
    interrupt.check()?;
    let folder = path.parent().unwrap_or(Path::new("."));
    let written = || {
        std::fs::create_dir_all(folder)?;
        let stage = interrupt.stage(folder)?;
        let file = stage.path().join(FILE);
        std::fs::write(&file, text)?;
        interrupt.publish(|| std::fs::rename(&file, path))
    };
    written().map_err(|error| unwritable(path, &error))
}
