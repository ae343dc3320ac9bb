//! `breccia run`.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use breccia_engine::{
    CacheLevel, Device, DeviceChoice, Engine, EngineError, FailureKind, Forecast, Plan, Registry, RunError,
    RunResult,
};
use breccia_graphs::Sources;
use breccia_nodes::device::{GpuSettings, open_device};
use serde_json::json;

use crate::exit::{self, Code, Failure};
use crate::inputs::{self, Assignment};
use crate::interrupt::Interrupt;
use crate::outputs::{self, Target};
use crate::progress::Progress;
use crate::sizes::{self, human};
use crate::{graphs, term};

/// How long a cancelled run waits for its nodes: Ctrl-C is to work within 100 ms.
const GRACE: Duration = Duration::from_millis(60);

/// Run a graph and write its outputs.
///
/// Without --output and --out-dir every output that a file can hold is written into the current folder, as NAME
/// with the usual extension. Only what the outputs need and the cache lacks is computed.
#[derive(clap::Args)]
#[command(after_help = exit::HELP)]
pub struct Run {
    /// A graph document, or the name of a preset (see `breccia presets`)
    graph: String,

    /// Give an input a file; paths such as builtin:cobbles/color_64.png name built-in files
    #[arg(long = "input", value_name = "NAME=PATH")]
    inputs: Vec<Assignment>,

    /// Set an exposed parameter, or a parameter of a node; values are RON: 128, 0.2, (17, 17, 17)
    #[arg(long = "set", value_name = "NAME=VALUE | NODE.PARAM=VALUE")]
    values: Vec<Assignment>,

    /// Write an output to a file; the extension tells the format, a final slash means a folder
    #[arg(long = "output", value_name = "NAME=PATH")]
    outputs: Vec<Assignment>,

    /// Write every output into this folder, as NAME with the usual extension
    #[arg(long, value_name = "DIR")]
    out_dir: Option<PathBuf>,

    /// Set the parameter `seed`
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    seed: Option<i64>,

    /// Number of threads; 0 means one for each processor
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024))]
    threads: u16,

    /// Where nodes that offer a choice run
    #[arg(long, value_enum, default_value_t = DeviceArg::Auto)]
    device: DeviceArg,

    /// Memory of the compute device that may be used
    #[arg(long, value_name = "SIZE", default_value = "2G", value_parser = sizes::parse)]
    device_memory: u64,

    /// Milliseconds that a compute device may be busy without a break; display drivers reset those that are for seconds
    #[arg(long, value_name = "MS", default_value_t = 50, value_parser = clap::value_parser!(u16).range(1..=10_000))]
    device_slice: u16,

    /// Folder of the disk cache [default: breccia in the user's cache folder]
    #[arg(long, value_name = "DIR")]
    cache_dir: Option<PathBuf>,

    /// Neither read nor write the disk cache
    #[arg(long, conflicts_with = "cache_dir")]
    no_cache: bool,

    /// Memory for results beyond those in use, such as 512M or 4G
    #[arg(long, value_name = "SIZE", default_value = "2G", value_parser = sizes::parse)]
    memory: u64,

    /// Print what would run, what is cached and the known sizes, and run nothing
    #[arg(long)]
    explain: bool,

    /// Print one event a line as JSON on standard output
    #[arg(long)]
    json: bool,

    /// Print warnings and errors alone
    #[arg(short, long)]
    quiet: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum DeviceArg {
    /// On the compute device where there is one and it pays
    Auto,
    /// On CPU threads only
    Cpu,
    /// On the compute device, which must be there
    Gpu,
}

impl Run {
    /// Runs the graph and writes its outputs.
    pub fn run(&self) -> Result<(), Failure> {
        let interrupt = Interrupt::install();
        let registry = Arc::new(breccia_nodes::registry());
        let mut graph = graphs::load(&self.graph, &registry)?;
        let notes = inputs::give(&mut graph, &self.inputs)?;
        inputs::set(&mut graph, &self.values, self.seed)?;
        let targets = outputs::plan(&graph, &registry, &self.outputs, self.out_dir.as_deref())?;
        let names: Vec<&str> = targets.iter().map(|target| target.name.as_str()).collect();
        let engine = self.engine(&registry)?;
        if self.explain {
            let plan = engine.explain(&graph, &names).map_err(Failure::usage)?;
            return super::answer(&if self.json { plan_json(&plan) } else { plan_text(&plan) });
        }
        outputs::check(&targets)?;

        let progress = Progress::new(self.json, self.quiet);
        for note in notes.iter().filter(|_| !self.quiet) {
            progress.note(&format!("note: {note}"));
        }
        let result = engine
            .run(&Arc::new(graph), &names, &interrupt.cancel, &|event| progress.show(event))
            .map_err(|error| match error {
            RunError::Cancelled => interrupt.failure(),
            RunError::Graph(problems) => Failure::usage(problems),
        })?;
        for written in outputs::write(&targets, &result.outputs, &interrupt)? {
            let path = written.path.display().to_string();
            let event = json!({
                "event": "output_written", "output": written.output, "path": path, "bytes": written.bytes,
            });
            progress.tell(&event, &format!("wrote {path} ({})", human(written.bytes)));
        }
        failures(&result, &targets)
    }

    fn engine(&self, registry: &Arc<Registry>) -> Result<Engine, Failure> {
        let cache =
            if self.no_cache { None } else { self.cache_dir.clone().or_else(breccia_graphs::default_cache) };
        let device = match self.device {
            DeviceArg::Auto => DeviceChoice::Auto,
            DeviceArg::Cpu => DeviceChoice::Cpu,
            DeviceArg::Gpu => DeviceChoice::Gpu,
        };
        Engine::builder()
            .threads(usize::from(self.threads))
            .memory(self.memory)
            .cache_dir(cache)
            .files(Arc::new(Sources::default()))
            .device(device)
            .compute(open_device(GpuSettings {
                memory: self.device_memory,
                submission: Duration::from_millis(self.device_slice.into()),
                pipeline_cache: breccia_graphs::default_cache().map(|folder| folder.join("pipelines")),
                ..Default::default()
            }))
            .cancel_grace(GRACE)
            .build(Arc::clone(registry))
            .map_err(|error| match error {
                EngineError::NoDevice(_) => Failure::usage(format!("{error} (`breccia devices` lists them)")),
                EngineError::Threads { .. } => Failure::new(Code::Node, error.to_string()),
            })
    }
}

/// An error if a node failed: the nodes that did, and the outputs that are missing because of them.
pub(super) fn failures(result: &RunResult, targets: &[Target<'_>]) -> Result<(), Failure> {
    let roots: Vec<_> = result.failures.iter().filter(|failure| failure.because_of.is_none()).collect();
    if result.failures.is_empty() {
        return Ok(());
    }
    let mut lines: Vec<_> =
        roots.iter().map(|failure| format!("node `{}`: {}", failure.node, failure.message)).collect();
    let missing: Vec<_> = targets
        .iter()
        .filter(|target| !result.outputs.contains_key(&target.name))
        .map(|target| target.name.as_str())
        .collect();
    if !missing.is_empty() {
        lines.push(format!("not written for that reason: {}", missing.join(", ")));
    }
    let input = roots.iter().any(|failure| failure.kind == FailureKind::Input);
    Err(Failure::new(if input { Code::Input } else { Code::Node }, lines.join("\n")))
}

fn plan_json(plan: &Plan) -> String {
    let line = |entry| serde_json::to_string(entry).unwrap_or_default() + "\n";
    plan.nodes.iter().map(line).collect()
}

fn plan_text(plan: &Plan) -> String {
    let width = plan.nodes.iter().map(|entry| entry.node.len()).max().unwrap_or(0);
    let mut out = String::new();
    for entry in &plan.nodes {
        let forecast = match entry.forecast {
            Forecast::Cached(CacheLevel::Memory) => "in memory",
            Forecast::Cached(CacheLevel::Disk) => "on disk",
            Forecast::Cached(CacheLevel::Digest) => "not needed",
            Forecast::WouldRun => "would run",
            Forecast::Unknown => "unknown",
            Forecast::Fails => "fails",
        };
        let size = match (entry.bytes, entry.estimate) {
            (Some(bytes), _) => human(bytes),
            (None, Some(bytes)) => format!("~ {}", human(bytes)),
            (None, None) => String::new(),
        };
        let summary = entry.summary.as_deref().unwrap_or_default();
        // A failure is told in full, a result in a line.
        let fails = entry.forecast == Forecast::Fails;
        let summary = if fails { summary.to_owned() } else { term::brief(summary) };
        let place = match &entry.placement {
            Some((Device::Gpu, why)) => format!("on the device: {why}"),
            Some((Device::Cpu, why)) => format!("on CPU threads: {why}"),
            None => String::new(),
        };
        let summary = if summary.is_empty() { place } else { summary };
        let line = format!("{:width$}  {forecast:10}  {size:>12}  {summary}", entry.node);
        out.push_str(line.trim_end());
        out.push('\n');
    }
    let count = |wanted: fn(Forecast) -> bool| plan.count(wanted);
    let cached = count(|f| matches!(f, Forecast::Cached(_)));
    let runs = count(|f| f == Forecast::WouldRun);
    let unknown = count(|f| f == Forecast::Unknown);
    let fails = count(|f| f == Forecast::Fails);
    out.push_str(&format!("{runs} nodes would run, {cached} are cached"));
    if unknown > 0 {
        out.push_str(&format!(", {unknown} depend on what those compute"));
    }
    if fails > 0 {
        out.push_str(&format!(", {fails} would fail"));
    }
    let sized = plan.nodes.iter().filter(|entry| entry.bytes.or(entry.estimate).is_some()).count();
    let about = if plan.nodes.iter().any(|entry| entry.estimate.is_some()) { "about " } else { "" };
    out.push_str(&format!(
        "; the {sized} nodes of known size take {about}{} in memory\n",
        human(plan.bytes())
    ));
    out
}
