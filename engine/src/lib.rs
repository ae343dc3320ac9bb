//! A data-flow node graph engine that knows no texture.
//!
//! Node types describe themselves ([`NodeSpec`]) and compute ([`Node::run`]); values flow between them
//! type-erased ([`Value`]).

mod document;
mod export;
mod node;
mod param;
mod registry;
mod spec;
mod suggest;
mod value;

pub use document::{
    Document, DocumentError, FORMAT, Interface, InterfaceInput, InterfaceOutput, InterfaceParam, Link,
    NodeEntry, VERSION,
};
pub use export::{Exporter, Sink};
pub use node::{CancelToken, Context, Node, NodeError};
pub use param::{ValueError, parse_value};
pub use registry::{NodeType, Registry};
pub use spec::{Arity, NodeSpec, ParamKind, ParamSpec, ParamValue, Placement, SocketSpec};
pub use value::{Data, Digest, TypeInfo, Value};
