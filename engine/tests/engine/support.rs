//! Short ways to make graphs and to look at event streams.

use std::cell::RefCell;
use std::sync::Arc;

use breccia_engine::{
    CacheLevel, CancelToken, Document, Engine, EngineBuilder, Event, Graph, RunError, RunResult,
};

use crate::nodes::{Number, registry};

/// A graph of `nodes` and `links`, in RON without the brackets.
pub fn document(interface: &str, nodes: &str, links: &str) -> Document {
    let text = format!(
        "(format: \"breccia-graph\", version: 1, interface: ({interface}), nodes: {{{nodes}}}, links: [{links}])"
    );
    Document::parse(&text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

pub fn graph(nodes: &str, links: &str) -> Graph {
    Graph::new(&document("", nodes, links), &registry()).unwrap_or_else(|problems| panic!("{problems}"))
}

/// Two constants `a` = 2 and `b` = 6, their sum `add`, and its half.
pub fn sum() -> Graph {
    graph(
        r#""a": (type: "test.constant", params: (value: 2)), "b": (type: "test.constant", params: (value: 6)),
           "add": (type: "test.add"), "half": (type: "test.halve")"#,
        r#""a.out -> add.terms", "b.out -> add.terms", "add.sum -> half.in""#,
    )
}

pub fn engine() -> Engine {
    build(Engine::builder())
}

pub fn build(builder: EngineBuilder) -> Engine {
    builder.threads(2).build(Arc::new(registry())).unwrap()
}

/// A finished run and its events.
pub struct Trace {
    pub events: Vec<Event>,
    pub result: RunResult,
}

pub fn run(engine: &Engine, graph: &Graph, outputs: &[&str]) -> Trace {
    let (events, result) = try_run(engine, graph, outputs, &CancelToken::default());
    Trace { events, result: result.unwrap() }
}

pub fn try_run(
    engine: &Engine,
    graph: &Graph,
    outputs: &[&str],
    cancel: &CancelToken,
) -> (Vec<Event>, Result<RunResult, RunError>) {
    let events = RefCell::new(Vec::new());
    let graph = Arc::new(graph.clone());
    let result = engine.run(&graph, outputs, cancel, &|event| events.borrow_mut().push(event.clone()));
    (events.into_inner(), result)
}

impl Trace {
    /// The nodes that computed, by name.
    pub fn computed(&self) -> Vec<&str> {
        self.names(|event| matches!(event, Event::NodeFinished { .. }))
    }

    /// The nodes found in a cache at this level, by name.
    pub fn cached(&self, level: CacheLevel) -> Vec<&str> {
        self.names(|event| matches!(event, Event::NodeCached { from, .. } if *from == level))
    }

    pub fn failed(&self) -> Vec<&str> {
        self.names(|event| matches!(event, Event::NodeFailed { .. }))
    }

    pub fn names(&self, pick: impl Fn(&Event) -> bool) -> Vec<&str> {
        let mut names: Vec<_> = self.events.iter().filter(|e| pick(e)).filter_map(Event::node).collect();
        names.sort_unstable();
        names
    }

    pub fn warnings(&self) -> Vec<&str> {
        let messages = self.events.iter().filter_map(|event| match event {
            Event::Warning { message, .. } => Some(message.as_str()),
            _ => None,
        });
        messages.collect()
    }

    pub fn number(&self, output: &str) -> i64 {
        self.result.outputs[output].downcast::<Number>().unwrap().0
    }
}

/// A number as a parameter's value.
pub fn int(value: i64) -> breccia_engine::ParamValue {
    breccia_engine::ParamValue::Int(value)
}
