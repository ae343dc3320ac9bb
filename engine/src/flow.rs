//! Nodes that stand for other graphs: groups and zones. A graph is expanded before it runs, so these never run
//! themselves; what does are the nodes of the graphs they stand for, and the small ones at the end of this file.

use crate::node::{Context, Node, NodeError};
use crate::spec::{NodeSpec, ParamKind, ParamValue};
use crate::value::{Data, Digest, TypeInfo};

/// The node type that stands for a group.
pub(crate) const GROUP: &str = "flow.group";
/// The node type that runs a group again and again.
pub(crate) const REPEAT: &str = "flow.repeat";
/// The node type that runs a group for every level, from coarse to fine.
pub(crate) const LEVELS: &str = "flow.levels";
/// A value from outside.
pub(crate) const VALUE: &str = "flow.value";
/// One of two values; only the one that is taken is computed.
pub(crate) const GATE: &str = "flow.gate";
/// A value that is there only if a zone stopped.
pub(crate) const REQUIRE: &str = "flow.require";

/// Whether nodes of this type stand for a graph.
pub(crate) fn stands_for_graph(id: &str) -> bool {
    [GROUP, REPEAT, LEVELS].contains(&id)
}

/// Yes or no, such as whether a zone shall stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flag(pub bool);

impl Data for Flag {
    const TYPE: &'static str = "flag";
    const DOCS: &'static str = "Yes or no, such as whether a zone shall stop.";

    fn byte_size(&self) -> u64 {
        1
    }
    fn summary(&self) -> String {
        if self.0 { "yes" } else { "no" }.to_owned()
    }
    fn digest(&self) -> Digest {
        Digest::of(&[u8::from(self.0)])
    }
    fn encode(&self) -> Option<Vec<u8>> {
        Some(vec![u8::from(self.0)])
    }
    fn decode(bytes: &[u8]) -> Result<Self, String> {
        match bytes {
            [0] => Ok(Self(false)),
            [1] => Ok(Self(true)),
            _ => Err("found something else than the byte 0 or 1".into()),
        }
    }
}

/// The types of values that the engine itself brings.
pub fn types() -> Vec<TypeInfo> {
    vec![TypeInfo::of::<Flag>()]
}

/// The nodes that the engine itself brings.
pub fn nodes() -> Vec<Box<dyn Node>> {
    vec![Box::new(Expanded(group)), Box::new(Expanded(repeat)), Box::new(Expanded(levels))]
}

/// A node that is replaced by other nodes before a graph runs.
struct Expanded(fn() -> NodeSpec);

impl Node for Expanded {
    fn spec(&self) -> NodeSpec {
        (self.0)()
    }
    fn run(&self, _: &mut Context<'_>) -> Result<(), NodeError> {
        Err(NodeError::Failed("the node was not replaced by what it stands for".into()))
    }
}

fn body(spec: NodeSpec, docs: &'static str) -> NodeSpec {
    spec.param("body", ParamKind::Text, ParamValue::Text(String::new()), "", docs)
}

const BODY: &str = "The group's name, as it stands in the document's section `groups`.";

fn group() -> NodeSpec {
    let spec = NodeSpec::new(
        GROUP,
        1,
        "A graph as one node",
        "Stands for a group of the document. Its inputs, outputs and parameters are those of the group's interface. \
         A group may hold groups and zones in turn, may be used more than once, and may stand in a file of its own \
         (`file: \"…\"` in the section `groups`), so that documents can share it. In a run its nodes \
         appear as `node/inner`.",
    );
    body(spec, BODY)
}

fn repeat() -> NodeSpec {
    let spec = NodeSpec::new(
        REPEAT,
        1,
        "A group run again and again",
        "Runs a group `iterations` times. What is both an input and an output of the group is carried from one \
         iteration to the next; other inputs are the same in each, other outputs are those of the last. A parameter \
         `iteration` of the group is set to 0, 1, 2 and so on. If the group has an output `stop` of type \
         `flag`, the zone ends with the first iteration where it says yes, and no later one is computed. Every iteration \
         is cached as its nodes are, so a run that was stopped goes on from where it was, and one that asks for \
         more iterations computes only those. In a run the nodes appear as `node[3]/inner`.",
    );
    let spec = spec.int("iterations", 0..=1000, 4, "count", "How often the group runs at most.").flag(
        "must_stop",
        false,
        "Fail if the group's output `stop` has not said yes by the last iteration; otherwise that one's values are taken.",
    );
    body(spec, BODY)
}

fn levels() -> NodeSpec {
    let spec = NodeSpec::new(
        LEVELS,
        1,
        "A group run for every level, coarse to fine",
        "Runs a group for each of `levels` levels of a pyramid, the coarsest first. What is both an input and an output \
         of the group is carried from level to level; other inputs are the same in each, other outputs are those \
         of the finest. A parameter `level` of the group is set to the level's number: 0 is the finest. Each \
         of the group's other parameters may be given as a list, one value for each level from coarse to fine; the last value \
         stands for all further levels. In a run the nodes appear as `node[0]/inner` (the finest level), \
         `node[1]/inner` and so on.",
    );
    let spec = spec.int("levels", 1..=16, 3, "count", "How many levels there are.");
    body(spec, BODY)
}

/// A node of a zone's machinery, for values of one type.
struct Passing(NodeSpec);

impl Node for Passing {
    fn spec(&self) -> NodeSpec {
        self.0.clone()
    }
    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        if self.0.id == REQUIRE && !context.input::<Flag>("stop")?.0 {
            return Err(NodeError::Failed(
                "the zone's last iteration is done, and its output `stop` says no; expected yes by then. \
                 More `iterations`, or `must_stop: false`, let it go on"
                    .into(),
            ));
        }
        let links = |name| context.inputs.get(name).and_then(|values| values.first()).cloned();
        let value = links("kept").or_else(|| links("next"));
        let value = value.ok_or_else(|| NodeError::Failed("there is no value to pass on".into()))?;
        context.outputs.insert("value", value);
        Ok(())
    }
}

/// A value of this type from outside.
pub(crate) fn value(ty: &'static str) -> Box<dyn Node> {
    let spec = NodeSpec::new(VALUE, 1, "A value from outside", "Has a value only if one is given.");
    Box::new(Passing(spec.memory_only().output("value", ty, "The value.")))
}

/// What a zone gives after an iteration: what it gave before if it had stopped, else what is next.
pub(crate) fn gate(ty: &'static str) -> Box<dyn Node> {
    let spec = NodeSpec::new(GATE, 1, "One of two values", "Only the value that is taken is computed.");
    let spec = spec
        .optional("stop", Flag::TYPE, "Whether the zone had stopped before.")
        .optional("kept", ty, "The value if so.")
        .optional("next", ty, "The value if not.");
    Box::new(Passing(spec.memory_only().output("value", ty, "The one or the other.")))
}

/// Passes a value on if the zone has stopped.
pub(crate) fn require(ty: &'static str) -> Box<dyn Node> {
    let spec = NodeSpec::new(REQUIRE, 1, "A zone that must stop", "Fails unless the zone stopped.");
    let spec = spec.input("stop", Flag::TYPE, "Whether it stopped.").input("next", ty, "The value.");
    Box::new(Passing(spec.memory_only().output("value", ty, "The value.")))
}
