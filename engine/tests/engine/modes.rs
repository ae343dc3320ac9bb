//! Nodes that are muted or bypassed: what those behind them see.

use breccia_engine::{Document, Graph, NodeEntry, NodeMode, ProblemKind};
use proptest::prelude::*;

use crate::nodes::registry;
use crate::support::{document, engine, int, run};

const INTERFACE: &str = r#"outputs: {"y": (node: "half", socket: "out")}"#;

/// Constants 2 and 6 into a sum, its half, and the half's half. `mode` is that of the node `name`.
fn chain(name: &str, mode: &str) -> Document {
    let nodes = r#""a": (type: "test.constant", params: (value: 2)), "b": (type: "test.constant", params: (value: 6)),
        "add": (type: "test.add"), "half": (type: "test.halve"), "pair": (type: "test.pair")"#;
    let links = r#""a.out -> add.terms", "b.out -> add.terms", "add.sum -> half.in", "half.out -> pair.a", "b.out -> pair.b""#;
    let mut document = document("", nodes, links);
    set(&mut document, name, mode);
    document
}

fn set(document: &mut Document, name: &str, mode: &str) {
    document.nodes.get_mut(name).unwrap().mode = NodeMode::from_name(mode).unwrap();
}

fn number(document: &Document, output: &str) -> i64 {
    let graph = Graph::new(document, &registry()).unwrap_or_else(|problems| panic!("{problems}"));
    run(&engine(), &graph, &[output]).number(output)
}

fn problems(document: &Document) -> Vec<(ProblemKind, String)> {
    let found = Graph::new(document, &registry()).unwrap_err();
    found.0.iter().map(|problem| (problem.kind, problem.to_string())).collect()
}

#[test]
fn a_muted_node_is_as_if_it_were_absent() {
    // One link of many fewer, an optional input without a value.
    assert_eq!(number(&chain("a", "mute"), "half.out"), 3);
    assert_eq!(number(&chain("a", "normal"), "pair.list"), 46);
    assert_eq!(
        number(&chain("b", "mute"), "pair.list"),
        9,
        "-1 stands for an optional input that is not given"
    );
}

#[test]
fn what_needs_a_muted_node_says_so() {
    let found = problems(&chain("half", "mute"));
    let [(ProblemKind::MissingInput, text)] = &found[..] else { panic!("{found:?}") };
    assert_eq!(
        text,
        "node `pair`, input `a`: found nothing, since node `half` is muted, expected a link that brings number"
    );
}

#[test]
fn a_muted_node_has_no_problems_of_its_own() {
    let text = r#""h": (type: "test.halve", mode: "mute"), "x": (type: "future.node", mode: "mute"), "a": (type: "test.constant")"#;
    let document = document("", text, r#""x.out -> h.in", "a.out -> x.in""#);
    assert!(Graph::new(&document, &registry()).is_ok());
}

#[test]
fn a_bypassed_node_passes_on_its_first_input_of_the_type() {
    assert_eq!(number(&chain("half", "bypass"), "pair.list"), 86);
    // Of many links the first.
    assert_eq!(number(&chain("add", "bypass"), "half.out"), 1);
    let mut two = chain("add", "bypass");
    set(&mut two, "half", "bypass");
    assert_eq!(number(&two, "pair.list"), 26);
    assert_eq!(number(&two, "half.out"), 2, "an output that is asked for by name follows too");
}

#[test]
fn a_bypassed_node_without_anything_to_pass_on_is_as_if_muted() {
    let document = chain("a", "bypass");
    assert_eq!(number(&document, "half.out"), 3);
    let mut document = chain("half", "bypass");
    document.links.retain(|link| !link.ends_with("half.in"));
    let found = problems(&document);
    let [(ProblemKind::MissingInput, text)] = &found[..] else { panic!("{found:?}") };
    assert!(text.contains("node `half` is bypassed, and nothing goes into its input `in`"), "{text}");
    set(&mut document, "add", "mute");
    document.links.push("add.sum -> half.in".to_owned());
    assert!(problems(&document)[0].1.contains("node `add` is muted"));
}

#[test]
fn a_node_that_is_off_does_not_run() {
    let nodes = r#""a": (type: "test.constant", params: (value: 4)), "fail": (type: "test.fail", mode: "bypass"),
        "half": (type: "test.halve")"#;
    let with = |links: &str| document(INTERFACE, nodes, links);
    let registry = registry();
    let spec = &registry.node("test.fail").unwrap().spec;
    let (input, output) = (spec.inputs.first().map(|s| s.name), spec.outputs.first().map(|s| s.name));
    let (Some(input), Some(output)) = (input, output) else { return };
    let document = with(&format!(r#""a.out -> fail.{input}", "fail.{output} -> half.in""#));
    assert_eq!(number(&document, "y"), 2);
}

#[test]
fn interface_outputs_follow_and_parameters_stay() {
    let interface = r#"outputs: {"y": (node: "half", socket: "out")},
        inputs: {"text": (type: "number", node: "n", param: "path"), "x": (type: "number", targets: ["half.in"])},
        params: {"v": (targets: ["a.value"], default: 5)}"#;
    let nodes = r#""a": (type: "test.constant", mode: "mute"), "n": (type: "test.length", mode: "mute"),
        "half": (type: "test.halve", mode: "bypass")"#;
    let document = document(interface, nodes, "");
    let mut graph = Graph::new(&document, &registry()).unwrap_or_else(|problems| panic!("{problems}"));
    graph.set("v", &int(9)).unwrap();
    graph.set_input("text", "some.txt").unwrap();
    graph.bind_input("x", breccia_engine::Value::new(crate::nodes::Number(7))).unwrap();
    assert_eq!(run(&engine(), &graph, &["y"]).number("y"), 7);
    assert_eq!(graph.params().next().unwrap().value, &int(9));
}

#[test]
fn an_interface_output_of_a_muted_node_is_an_error() {
    let mut with = chain("half", "mute");
    with.links.retain(|link| !link.starts_with("half"));
    with.nodes.remove("pair");
    with.links.retain(|link| !link.contains("pair"));
    assert!(Graph::new(&with, &registry()).is_ok());
    with.interface = document(INTERFACE, "", "").interface;
    let found = problems(&with);
    let [(ProblemKind::Muted, text)] = &found[..] else { panic!("{found:?}") };
    assert!(text.contains("interface output `y`: found nothing, since node `half` is muted"), "{text}");
}

#[test]
fn an_output_of_a_muted_node_cannot_be_asked_for() {
    let graph = Graph::new(&chain("a", "mute"), &registry()).unwrap();
    let (_, result) = crate::support::try_run(&engine(), &graph, &["a.out"], &Default::default());
    let Err(error) = result else { panic!("a value of a node that is absent") };
    assert!(error.to_string().contains("node `a` is muted"), "{error}");
}

#[test]
fn loops_of_bypassed_nodes_end() {
    let nodes = r#""a": (type: "test.halve", mode: "bypass"), "b": (type: "test.halve", mode: "bypass"),
        "c": (type: "test.halve")"#;
    let document = document("", nodes, r#""a.out -> b.in", "b.out -> a.in", "b.out -> c.in""#);
    assert_eq!(problems(&document)[0].0, ProblemKind::MissingInput);
    let nodes = r#""a": (type: "test.halve", mode: "bypass"), "c": (type: "test.halve")"#;
    let document = crate::support::document("", nodes, r#""a.out -> c.in", "c.out -> a.in""#);
    assert_eq!(problems(&document)[0].0, ProblemKind::Cycle);
}

/// x becomes (x + 1) · 2, in a group or zone of which nodes may be off.
fn group(node: &str, add: &str, half: &str) -> Document {
    let text = format!(
        r#"(format: "breccia-graph", version: 2,
        interface: (outputs: {{"y": (node: "half", socket: "out")}}),
        nodes: {{"a": (type: "test.constant", params: (value: 10)), "one": ({node}), "half": (type: "test.halve")}},
        links: ["a.out -> one.x", "one.x -> half.in"],
        groups: {{"step": (
            interface: (
                inputs: {{"x": (type: "number", targets: ["add.terms"])}},
                outputs: {{"x": (node: "twice", socket: "sum")}},
                params: {{"more": (targets: ["more.value"])}},
            ),
            nodes: {{"add": (type: "test.add"{add}), "more": (type: "test.constant", params: (value: 1){half}),
                     "twice": (type: "test.add", params: (scale: 2))}},
            links: ["more.out -> add.terms", "add.sum -> twice.terms"],
        )}})"#
    );
    let document = Document::parse(&text).unwrap_or_else(|error| panic!("{error}: {text}"));
    assert_eq!(Document::parse(&document.to_ron()).unwrap(), document);
    document
}

#[test]
fn nodes_in_groups_and_zones_may_be_off() {
    let (mute, bypass) = (r#", mode: "mute""#, r#", mode: "bypass""#);
    let one = r#"type: "flow.group", params: {"body": "step"}"#;
    let zone = r#"type: "flow.repeat", params: {"body": "step", "iterations": 2}"#;
    assert_eq!(number(&group(one, "", ""), "y"), 11);
    assert_eq!(number(&group(one, "", mute), "y"), 10);
    assert_eq!(number(&group(one, bypass, mute), "y"), 10);
    assert_eq!(number(&group(zone, "", ""), "y"), 23);
    assert_eq!(number(&group(zone, "", mute), "y"), 20);
    // Bypassed, it passes on what stands first among the links, and that is the constant of 1.
    assert_eq!(number(&group(zone, bypass, ""), "y"), 1);
    // What comes from a muted node is as if it were not linked.
    assert_eq!(number(&group(zone, bypass, mute), "y"), 20);
    assert_eq!(number(&group(zone, mute, ""), "y"), 0);
}

#[test]
fn groups_and_zones_themselves_may_be_off() {
    for ty in ["flow.group", "flow.repeat"] {
        let bypassed = format!(r#"type: "{ty}", mode: "bypass", params: {{"body": "step", "more": 3}}"#);
        let mut document = group(&bypassed, "", "");
        assert_eq!(number(&document, "y"), 5, "{ty}");
        set(&mut document, "one", "mute");
        let found = problems(&document);
        let [(ProblemKind::MissingInput, text)] = &found[..] else { panic!("{found:?}") };
        assert!(text.contains("node `one` is muted"), "{text}");
    }
    let unknown = r#"type: "flow.group", mode: "mute", params: {"body": "nothing"}"#;
    let mut document = group(unknown, "", "");
    document.nodes.remove("half");
    document.links.retain(|link| !link.contains("half"));
    document.interface.outputs.clear();
    assert!(Graph::new(&document, &registry()).is_ok(), "what is absent has no problems");
}

#[test]
fn a_way_through_many_bypassed_nodes_is_found_at_once() {
    // Each takes the one before it twice, so that there are 2⁶⁰ ways.
    let mut document = document("", r#""a": (type: "test.constant", params: (value: 8))"#, "");
    for i in 0..60 {
        let mut node = NodeEntry::new("test.add");
        node.mode = NodeMode::Bypass;
        document.nodes.insert(format!("n{i}"), node);
        let before = if i == 0 { "a.out".to_owned() } else { format!("n{}.sum", i - 1) };
        let link = format!("{before} -> n{i}.terms");
        document.links.extend([link.clone(), link]);
    }
    document.nodes.insert("half".to_owned(), NodeEntry::new("test.halve"));
    document.links.push("n59.sum -> half.in".to_owned());
    assert_eq!(number(&document, "half.out"), 4);
}

#[test]
fn modes_are_read_and_written() {
    let text = r#""a": (type: "test.constant", mode: "bypass"), "b": (type: "test.constant", mode: "normal"),
        "c": (type: "test.constant", mode: "mut"), "d": (type: "test.constant", mode: [1])"#;
    let read = document("", text, "");
    assert_eq!([read.nodes["a"].mode, read.nodes["b"].mode], [NodeMode::Bypass, NodeMode::Normal]);
    let written = read.to_ron();
    assert_eq!(Document::parse(&written).unwrap(), read);
    for part in [
        r#""a": (type: "test.constant", mode: "bypass")"#,
        r#""b": (type: "test.constant")"#,
        r#"mode: "mut""#,
        "mode: [1]",
    ] {
        assert!(written.contains(part), "{part} is missing in {written}");
    }
    let found = Graph::new(&read, &registry()).unwrap_err();
    let kinds: Vec<_> = found.0.iter().map(|p| (p.kind, p.suggestion.as_deref())).collect();
    assert_eq!(kinds, [(ProblemKind::BadValue, Some("mute")), (ProblemKind::BadValue, None)], "{found}");
    let mut changed = read;
    set(&mut changed, "c", "bypass");
    assert!(
        Document::parse(&changed.to_ron()).unwrap().nodes["c"].mode.is_off(),
        "a new mode replaces a bad one"
    );
}

/// A node of a random graph: what it is, its mode, and the nodes before it that it takes values from.
#[derive(Clone, Debug)]
struct Any {
    what: usize,
    mode: NodeMode,
    from: Vec<usize>,
}

const TYPES: [(&str, &str, &str); 3] =
    [("test.constant", "", "out"), ("test.add", "terms", "sum"), ("test.pair", "a", "list")];

fn any_nodes() -> impl Strategy<Value = Vec<Any>> {
    let from = prop::collection::vec(any::<prop::sample::Index>(), 0..4);
    let node = (0..TYPES.len(), prop::sample::select(&NodeMode::ALL), from);
    prop::collection::vec(node, 1..10).prop_map(|nodes| {
        let make = |(i, (what, mode, from)): (usize, (usize, NodeMode, Vec<prop::sample::Index>))| {
            // A socket for one value takes one.
            let most = [0, 4, 1][what].min(i * 4);
            Any { what, mode, from: from.iter().take(most).map(|at| at.index(i)).collect() }
        };
        nodes.into_iter().enumerate().map(make).collect()
    })
}

/// What a node of a random graph gives, told without an engine; `Err` if something in it lacks what it needs.
fn told(nodes: &[Any], at: usize) -> Result<Option<i64>, ()> {
    let node = &nodes[at];
    if node.mode == NodeMode::Mute {
        return Ok(None);
    }
    let mut given = Vec::new();
    for &from in &node.from {
        given.extend(told(nodes, from)?);
    }
    match (node.mode, node.what) {
        (NodeMode::Bypass, _) => Ok(given.first().copied()),
        (_, 0) => Ok(Some(at as i64)),
        (_, 1) => Ok(Some(given.iter().sum())),
        _ => given.first().map(|a| Some(a * 10 - 1)).ok_or(()),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_graph_gives_what_it_should(nodes in any_nodes()) {
        let mut document = Document::default();
        for (i, node) in nodes.iter().enumerate() {
            let (ty, input, _) = TYPES[node.what];
            let mut entry = NodeEntry::new(ty);
            entry.mode = node.mode;
            if node.what == 0 {
                entry = entry.with("value", int(i as i64));
            }
            document.nodes.insert(format!("n{i}"), entry);
            for &from in &node.from {
                document.links.push(format!("n{from}.{} -> n{i}.{input}", TYPES[nodes[from].what].2));
            }
        }
        let lacks = |i: usize| nodes[i].mode == NodeMode::Normal && told(&nodes, i).is_err();
        match Graph::new(&document, &registry()) {
            Err(problems) => prop_assert!((0..nodes.len()).any(lacks), "{problems}"),
            Ok(graph) => {
                prop_assert!(!(0..nodes.len()).any(lacks));
                let engine = engine();
                for (i, node) in nodes.iter().enumerate() {
                    let output = format!("n{i}.{}", TYPES[node.what].2);
                    let (_, found) = crate::support::try_run(&engine, &graph, &[&output], &Default::default());
                    let found = found.ok().map(|run| run.outputs[&output].downcast::<crate::nodes::Number>().unwrap().0);
                    prop_assert_eq!(Ok(found), told(&nodes, i), "{}", output);
                }
            }
        }
    }
}
