//! A data-flow node graph engine that knows no texture.
//!
//! Node types describe themselves ([`NodeSpec`]) and compute ([`Node::run`]); values flow between them
//! type-erased ([`Value`]).

mod cache;
mod document;
mod engine;
mod events;
mod export;
mod files;
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
pub use document::{
    Document, DocumentError, FORMAT, Interface, InterfaceInput, InterfaceOutput, InterfaceParam, Link,
    NodeEntry, VERSION,
};
pub use engine::{DeviceChoice, Engine, EngineBuilder, EngineError};
pub use events::{CacheLevel, Device, Event, FailureKind};
pub use export::{Exporter, Sink};
pub use files::{FileSource, PlainFiles};
pub use graph::{Graph, InputInfo, OutputInfo, ParamInfo, Problem, ProblemKind, Problems};
pub use node::{CancelToken, Context, Node, NodeError};
pub use param::{ValueError, parse_value};
pub use registry::{NodeType, Registry};
pub use run::explain::{Forecast, Plan, PlanEntry};
pub use run::{Failure, RunError, RunResult};
pub use spec::{Arity, NodeSpec, ParamKind, ParamSpec, ParamValue, Placement, SocketSpec};
pub use value::{Data, Digest, TypeInfo, Value};
