//! A data-flow node graph engine that knows no texture.
//!
//! Node types describe themselves ([`NodeSpec`]) and compute ([`Node::run`]); values flow between them
//! type-erased ([`Value`]). A [`Registry`] holds the types, a [`Document`] is a graph as it stands in a file,
//! a [`Graph`] is one that has been checked, and an [`Engine`] runs it:
//!
//! ```
//! use std::sync::Arc;
//! use breccia_engine::{
//!     CancelToken, Context, Data, Digest, Document, Engine, Graph, Node, NodeError, NodeSpec, Registry, TypeInfo,
//! };
//!
//! struct Number(i64);
//!
//! impl Data for Number {
//!     const TYPE: &'static str = "number";
//!     const DOCS: &'static str = "A whole number.";
//!     fn byte_size(&self) -> u64 { 8 }
//!     fn summary(&self) -> String { self.0.to_string() }
//!     fn digest(&self) -> Digest { Digest::of(&self.0.to_le_bytes()) }
//! }
//!
//! struct Constant;
//!
//! impl Node for Constant {
//!     fn spec(&self) -> NodeSpec {
//!         NodeSpec::new("math.constant", 1, "A number", "Gives the number that it is set to.")
//!             .int("value", -1000..=1000, 0, "1", "The number.")
//!             .output("value", "number", "The number.")
//!     }
//!     fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
//!         context.set("value", Number(context.int("value")?));
//!         Ok(())
//!     }
//! }
//!
//! struct Add;
//!
//! impl Node for Add {
//!     fn spec(&self) -> NodeSpec {
//!         NodeSpec::new("math.add", 1, "A sum", "Adds numbers.")
//!             .many("terms", "number", "The numbers to add.")
//!             .output("sum", "number", "Their sum.")
//!     }
//!     fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
//!         let terms = context.many::<Number>("terms")?;
//!         context.set("sum", Number(terms.iter().map(|term| term.0).sum()));
//!         Ok(())
//!     }
//! }
//!
//! let mut registry = Registry::default();
//! registry.add_types([TypeInfo::of::<Number>()]);
//! registry.add_nodes([Box::new(Constant) as Box<dyn Node>, Box::new(Add)]);
//!
//! let document = Document::parse(r#"(
//!     format: "breccia-graph", version: 1, title: "Five",
//!     interface: (outputs: { "sum": (node: "add", socket: "sum", docs: "The sum.") }),
//!     nodes: {
//!         "two": (type: "math.constant", params: { "value": 2 }),
//!         "three": (type: "math.constant", params: { "value": 3 }),
//!         "add": (type: "math.add"),
//!     },
//!     links: ["two.value -> add.terms", "three.value -> add.terms"],
//! )"#)?;
//! let graph = Arc::new(Graph::new(&document, &registry)?);
//! let engine = Engine::builder().threads(2).build(Arc::new(registry))?;
//! let result = engine.run(&graph, &["sum"], &CancelToken::default(), &|event| eprintln!("{event:?}"))?;
//! assert_eq!(result.outputs["sum"].downcast::<Number>().map(|number| number.0), Some(5));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # How a run works
//!
//! The key of a node is a hash of its type and version, its parameters, the contents of its files, and the
//! digests of the values linked to it. What a key's outputs are, without the outputs themselves, is recorded
//! in memory and on disk. So a run first finds all keys that it can without computing anything; then computes
//! only those nodes that the outputs asked for need and the caches lack, each once, independent ones in
//! parallel. A node that computes something equal to before changes no key after it. The scheduler of a run
//! works on the caller's thread; nodes work in the engine's thread pool, where their own rayon loops
//! run as well. While a node waits for such a loop its thread may start another node, so a node
//! must hold no lock across one that another node could want.
//!
//! # Errors and panics
//!
//! Nothing that comes from outside makes the engine panic: documents, files, cache folders and parameters give
//! errors that say what was found and what was expected. Problems of a graph come all at once ([`Problems`]).
//! A node that fails, or panics, fails alone: the nodes that need it are skipped by name, and the outputs that
//! do not are there ([`RunResult`]). Failures are never cached. Trouble with the disk cache is a warning; damaged
//! files in it are made again.

mod cache;
mod device;
mod docs;
mod document;
mod engine;
mod estimate;
mod events;
mod export;
mod files;
pub mod flow;
mod graph;
mod keys;
mod node;
mod param;
mod registry;
mod run;
mod spec;
mod suggest;
mod value;

pub use cache::{DiskCache, DiskInfo};
pub use device::{ComputeDevice, DeviceProfile, OpenDevice};
pub use docs::{ChoiceDoc, NodeDoc, ParamDoc, SocketDoc, describe, lint, markdown, plain};
pub use document::{
    Document, DocumentError, FORMAT, Group, IncludeError, Interface, InterfaceInput, InterfaceOutput,
    InterfaceParam, Link, NodeEntry, NodeMode, VERSION,
};
pub use engine::{DeviceChoice, Engine, EngineBuilder, EngineError};
pub use estimate::{Sizing, Work};
pub use events::{CacheLevel, Device, Event, FailureKind};
pub use export::{Exporter, Sink};
pub use files::{FileSource, PlainFiles};
pub use graph::{Graph, InputInfo, OutputInfo, ParamInfo, Problem, ProblemKind, Problems};
pub use node::{CancelToken, Context, Node, NodeError};
pub use param::{ValueError, parse_value};
pub use registry::{NodeType, Registry};
pub use run::explain::{Forecast, Plan, PlanEntry};
pub use run::{Failure, RunError, RunResult};
pub use spec::{Arity, Draft, NodeSpec, ParamKind, ParamSpec, ParamValue, Placement, SocketSpec};
pub use suggest::closest;
pub use value::{Data, Digest, TypeInfo, Value};
