//! Groups and zones: what they compute, what runs again, and what is said when they are wrong.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::sync::Arc;

use breccia_engine::{
    CacheLevel, CancelToken, Document, Engine, FileSource, Forecast, Graph, ProblemKind, parse_value,
};

use crate::nodes::registry;
use crate::support::{Trace, build, engine, int, run, try_run};

fn document(interface: &str, nodes: &str, links: &str, groups: &str) -> Document {
    let text = format!(
        "(format: \"breccia-graph\", version: 2, interface: ({interface}), nodes: {{{nodes}}}, links: [{links}], \
         groups: {{{groups}}})"
    );
    let document = Document::parse(&text).unwrap_or_else(|error| panic!("{error}: {text}"));
    assert_eq!(
        Document::parse(&document.to_ron()).unwrap(),
        document,
        "groups are written as they were read"
    );
    document
}

fn graph(interface: &str, nodes: &str, links: &str, groups: &str) -> Graph {
    Graph::new(&document(interface, nodes, links, groups), &registry())
        .unwrap_or_else(|error| panic!("{error}"))
}

fn problems(nodes: &str, links: &str, groups: &str) -> Vec<(ProblemKind, String)> {
    let found = Graph::new(&document("", nodes, links, groups), &registry()).unwrap_err();
    found.0.iter().map(|problem| (problem.kind, problem.to_string())).collect()
}

/// x becomes (x + `more`) · `scale`.
const STEP: &str = r#""step": (
    interface: (
        inputs: {"x": (type: "number", targets: ["add.terms"])},
        outputs: {"x": (node: "add", socket: "sum")},
        params: {"scale": (targets: ["add.scale"], default: 2), "more": (targets: ["more.value"])},
    ),
    nodes: {"add": (type: "test.add"), "more": (type: "test.constant", params: {"value": 1})},
    links: ["more.out -> add.terms"],
)"#;

/// x becomes x + iteration, and stops once x is not below the limit any more … that is, once `limit` is above x.
const COUNT: &str = r#""count": (
    interface: (
        inputs: {"x": (type: "number", targets: ["add.terms"])},
        outputs: {"x": (node: "add", socket: "sum"), "stop": (node: "small", socket: "out")},
        params: {"iteration": (targets: ["i.value"]), "limit": (targets: ["small.limit"])},
    ),
    nodes: {"add": (type: "test.add"), "i": (type: "test.constant"), "small": (type: "test.below"),
            "minus": (type: "test.constant", params: {"value": -10})},
    links: ["i.out -> add.terms", "minus.out -> add.terms", "add.sum -> small.in"],
)"#;

fn repeat(iterations: usize) -> Graph {
    graph(
        r#"outputs: {"y": (node: "loop", socket: "x")},
           params: {"n": (targets: ["loop.iterations"]), "more": (targets: ["loop.more"], default: 3)}"#,
        &format!(
            r#""a": (type: "test.constant", params: {{"value": 5}}),
               "loop": (type: "flow.repeat", params: {{"body": "step", "iterations": {iterations}}})"#
        ),
        r#""a.out -> loop.x""#,
        STEP,
    )
}

fn stopping(must_stop: bool, iterations: usize) -> Graph {
    graph(
        r#"outputs: {"y": (node: "loop", socket: "x")}"#,
        &format!(
            r#""a": (type: "test.constant", params: {{"value": 25}}),
               "loop": (type: "flow.repeat", params: {{"body": "count", "iterations": {iterations}, "limit": 4,
                        "must_stop": {must_stop}}})"#
        ),
        r#""a.out -> loop.x""#,
        COUNT,
    )
}

fn iterations(trace: &Trace, node: &str) -> usize {
    trace.computed().iter().filter(|name| name.ends_with(node)).count()
}

#[test]
fn a_group_is_one_node() {
    let nodes = r#""a": (type: "test.constant", params: {"value": 5}),
        "one": (type: "flow.group", params: {"body": "step"}),
        "two": (type: "flow.group", params: {"body": "step", "scale": 3, "more": 10})"#;
    let graph = graph("", nodes, r#""a.out -> one.x", "one.x -> two.x""#, STEP);
    let trace = run(&engine(), &graph, &["two/add.sum"]);
    assert_eq!(trace.number("two/add.sum"), (2 * (5 + 1) + 10) * 3);
    assert_eq!(trace.computed(), ["a", "one/add", "one/more", "two/add", "two/more"]);
}

#[test]
fn a_zone_repeats_its_body() {
    let mut graph = repeat(0);
    for (n, expected) in [(0, 5), (1, 16), (2, 38), (5, 346)] {
        graph.set("n", &int(n)).unwrap();
        assert_eq!(run(&engine(), &graph, &["y"]).number("y"), expected, "{n} iterations");
    }
}

#[test]
fn more_iterations_compute_only_those_and_a_parameter_all() {
    let engine = engine();
    let mut graph = repeat(6);
    assert_eq!(iterations(&run(&engine, &graph, &["y"]), "/add"), 6);
    graph.set("n", &int(8)).unwrap();
    let more = run(&engine, &graph, &["y"]);
    assert_eq!(more.computed(), ["loop[6]/add", "loop[7]/add"]);
    graph.set("n", &int(4)).unwrap();
    assert_eq!(run(&engine, &graph, &["y"]).computed(), Vec::<&str>::new());
    graph.set("loop/more.value", &int(4)).unwrap();
    assert_eq!(iterations(&run(&engine, &graph, &["y"]), "/add"), 4);
    // One iteration by name.
    graph.set("loop[2]/add.scale", &int(1)).unwrap();
    assert_eq!(run(&engine, &graph, &["y"]).computed(), ["loop[2]/add", "loop[3]/add"]);
}

#[test]
fn a_stopped_run_goes_on_from_its_last_iteration() {
    let folder = tempfile::tempdir().unwrap();
    let slow = r#""slow": (
        interface: (inputs: {"x": (type: "number", targets: ["wait.in"])}, outputs: {"x": (node: "add", socket: "sum")}),
        nodes: {"add": (type: "test.add"), "wait": (type: "test.slow", params: {"millis": 20}), "one": (type: "test.constant", params: {"value": 1})},
        links: ["wait.out -> add.terms", "one.out -> add.terms"],
    )"#;
    let nodes = r#""a": (type: "test.constant"), "loop": (type: "flow.repeat", params: {"body": "slow", "iterations": 40})"#;
    let graph = graph(r#"outputs: {"y": (node: "loop", socket: "x")}"#, nodes, r#""a.out -> loop.x""#, slow);
    let fresh = || build(Engine::builder().cache_dir(Some(folder.path().into())));
    let cancel = CancelToken::default();
    let (events, result) = {
        let events = std::cell::RefCell::new(Vec::new());
        let graph = Arc::new(graph.clone());
        let result = fresh().run(&graph, &["y"], &cancel, &|event| {
            if matches!(event, breccia_engine::Event::NodeFinished { node, .. } if node == "loop[6]/add") {
                cancel.cancel();
            }
            events.borrow_mut().push(event.clone());
        });
        (events.into_inner(), result)
    };
    assert!(result.is_err());
    let before = events
        .iter()
        .filter(|e| matches!(e, breccia_engine::Event::NodeFinished { node, .. } if node.ends_with("/add")));
    let before = before.count();
    assert!((7..12).contains(&before), "{before}");
    // What was being written when the run was stopped may still be.
    std::thread::sleep(std::time::Duration::from_millis(300));
    // Another process, with nothing but the folder, computes the rest.
    let after = run(&fresh(), &graph, &["y"]);
    assert_eq!(after.number("y"), 40);
    let waited = iterations(&after, "/wait");
    assert!((28..=35).contains(&waited), "{waited} iterations ran again, {before} had been done");
    let read = after.cached(CacheLevel::Disk);
    assert!(read.len() <= 2, "only the last value and the constant are read: {read:?}");
}

#[test]
fn a_zone_stops_when_its_body_says_so() {
    // 25, 15, 6, -2: below 4 after the third iteration.
    for iterations in [3, 4, 50] {
        let trace = run(&engine(), &stopping(false, iterations), &["y"]);
        assert_eq!(trace.number("y"), 25 - 10 - 9 - 8);
        assert_eq!(self::iterations(&trace, "/add"), 3, "of {iterations}");
        assert!(trace.computed().iter().all(|name| !name.contains('=')), "{:?}", trace.computed());
    }
    assert_eq!(run(&engine(), &stopping(false, 2), &["y"]).number("y"), 6);
}

#[test]
fn a_zone_that_must_stop_fails_if_it_does_not() {
    assert_eq!(run(&engine(), &stopping(true, 3), &["y"]).number("y"), -2);
    let (_, result) = try_run(&engine(), &stopping(true, 2), &["y"], &CancelToken::default());
    let failures = result.unwrap().failures;
    assert_eq!(failures.len(), 1, "{failures:?}");
    assert!(failures[0].node.starts_with("loop/must_stop"), "{failures:?}");
    assert!(failures[0].message.contains("`iterations`"), "{failures:?}");
}

/// Levels that count upwards, each holding a zone.
fn pyramid() -> Graph {
    let level = format!(
        r#"{STEP}, "level": (
        interface: (
            inputs: {{"x": (type: "number", targets: ["first.a"]), "same": (type: "number", targets: ["first.b"])}},
            outputs: {{"x": (node: "refine", socket: "x")}},
            params: {{"level": (targets: ["number.value"]), "iterations": (targets: ["refine.iterations"]),
                      "scale": (targets: ["refine.scale"], default: 1)}},
        ),
        nodes: {{"first": (type: "test.pair"), "number": (type: "test.constant"), "sum": (type: "test.add"),
                 "refine": (type: "flow.repeat", params: {{"body": "step"}})}},
        links: ["first.list -> sum.terms", "number.out -> sum.terms", "sum.sum -> refine.x"],
    )"#
    );
    graph(
        r#"outputs: {"y": (node: "levels", socket: "x")}, params: {"iterations": (targets: ["levels.iterations"])}"#,
        r#""a": (type: "test.constant", params: {"value": 1}), "b": (type: "test.constant", params: {"value": 3}),
           "levels": (type: "flow.levels", params: {"body": "level", "levels": 3, "iterations": [2, 1, 0]})"#,
        r#""a.out -> levels.x", "b.out -> levels.same""#,
        &level,
    )
}

#[test]
fn levels_go_from_coarse_to_fine_each_with_its_own_parameters() {
    let mut graph = pyramid();
    let trace = run(&engine(), &graph, &["y"]);
    // x·10 + 3 + level, then one more for each iteration.
    let coarse = 10 + 3 + 2 + 2;
    let middle = coarse * 10 + 3 + 1 + 1;
    assert_eq!(trace.number("y"), middle * 10 + 3);
    assert!(trace.computed().contains(&"levels[2]/refine[1]/add"), "{:?}", trace.computed());
    assert_eq!(graph.params().next().unwrap().value.to_string(), "(2, 1, 0)");
    graph.set("iterations", &int(0)).unwrap();
    assert_eq!(run(&engine(), &graph, &["y"]).number("y"), ((10 + 3 + 2) * 10 + 3 + 1) * 10 + 3);
    graph.set("iterations", &parse_value("[1, 0]").unwrap()).unwrap();
    assert_eq!(run(&engine(), &graph, &["y"]).number("y"), ((10 + 3 + 2 + 1) * 10 + 3 + 1) * 10 + 3);
    let error = graph.set("iterations", &parse_value("[1, -2]").unwrap()).unwrap_err().to_string();
    assert!(error.contains("`iterations`") && error.contains("-2"), "{error}");
    assert_eq!(run(&engine(), &graph, &["y"]).number("y"), ((10 + 3 + 2 + 1) * 10 + 3 + 1) * 10 + 3);
}

#[test]
fn checked_runs_and_plans_see_into_zones() {
    let engine = engine();
    let graph = Arc::new(stopping(false, 5));
    let plan = engine.explain(&graph, &["y"]).unwrap();
    assert!(
        plan.nodes.iter().any(|entry| entry.node == "loop[4]/add" && entry.forecast == Forecast::Unknown)
    );
    assert!(plan.nodes.iter().all(|entry| !entry.node.contains('=')));
    let result = engine.run_checked(&graph, &["y"], &CancelToken::default(), &|_| {}).unwrap();
    assert_eq!(result.failures, []);
    let impure = STEP.replace("\"test.constant\", params: {\"value\": 1}", "\"test.impure\"");
    let nodes = r#""a": (type: "test.constant"), "loop": (type: "flow.repeat", params: {"body": "step", "iterations": 3})"#;
    let graph =
        self::graph(r#"outputs: {"y": (node: "loop", socket: "x")}"#, nodes, r#""a.out -> loop.x""#, &impure);
    let result = engine.run_checked(&Arc::new(graph), &["y"], &CancelToken::default(), &|_| {}).unwrap();
    assert!(result.failures.iter().any(|f| f.node.starts_with("loop[") && f.message.contains("pure")));
}

#[test]
fn failures_in_a_zone_carry_the_way_to_them() {
    let failing = STEP
        .replace("\"test.constant\", params: {\"value\": 1}", "\"test.fail\"")
        .replace(", \"more\": (targets: [\"more.value\"])", "");
    let nodes = r#""a": (type: "test.constant"), "loop": (type: "flow.repeat", params: {"body": "step", "iterations": 3})"#;
    let graph =
        graph(r#"outputs: {"y": (node: "loop", socket: "x")}"#, nodes, r#""a.out -> loop.x""#, &failing);
    let (_, result) = try_run(&engine(), &graph, &["y"], &CancelToken::default());
    let failures = result.unwrap().failures;
    // Iterations that need nothing of each other run side by side, so any of them may be the first to fail.
    let failed = |node: &str| failures.iter().any(|f| f.node == node && f.message == "does not converge");
    let culprit = failures.iter().find(|f| f.node == "loop[2]/add").and_then(|f| f.because_of.clone());
    let culprit = culprit.unwrap_or_else(|| panic!("{failures:?}"));
    assert!(culprit.starts_with("loop[") && culprit.ends_with("]/more") && failed(&culprit), "{failures:?}");
}

#[test]
fn problems_of_a_body_are_said_once() {
    let bad = STEP
        .replace("\"value\": 1", "\"value\": 5000")
        .replace("more.out -> add.terms", "more.oud -> add.terms");
    let nodes = r#""a": (type: "test.constant"), "loop": (type: "flow.repeat", params: {"body": "step", "iterations": 3})"#;
    let found = problems(nodes, r#""a.out -> loop.x""#, &bad);
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(
        found.iter().any(|(kind, text)| *kind == ProblemKind::BadValue && text.contains("`loop/more`")),
        "{found:?}"
    );
    let unknown = found.iter().find(|(kind, _)| *kind == ProblemKind::UnknownSocket).unwrap();
    assert!(unknown.1.contains("did you mean `out`"), "{found:?}");
}

#[test]
fn what_is_wrong_with_a_zone_is_said() {
    let a = r#""a": (type: "test.constant")"#;
    let zone = |params: &str| format!(r#"{a}, "loop": (type: "flow.repeat", params: {{{params}}})"#);
    let cases = [
        (zone(r#""body": "stop""#), "a.out -> loop.x", "did you mean `step`"),
        (zone(r#""body": "step", "iterations": 5000"#), "a.out -> loop.x", "1000"),
        (zone(r#""body": "step", "scail": 3"#), "a.out -> loop.x", "did you mean `scale`"),
        (zone(r#""body": "step""#), "a.out -> loop.y", "`loop`, input: found `y`"),
        (zone(r#""body": "step", "must_stop": true"#), "a.out -> loop.x", "output `stop`"),
        (zone(r#""body": "step", "scale": "big""#), "a.out -> loop.x", "`loop/add`"),
    ];
    for (nodes, link, expected) in cases {
        let found = problems(&nodes, &format!("\"{link}\""), STEP);
        assert!(found.iter().any(|(_, text)| text.contains(expected)), "{expected}: {found:?}");
    }
    let within = r#""self": (nodes: {"again": (type: "flow.group", params: {"body": "self"})})"#;
    let found = problems(r#""g": (type: "flow.group", params: {"body": "self"})"#, "", within);
    assert!(found.iter().any(|(kind, _)| *kind == ProblemKind::Cycle), "{found:?}");
    let deep = r#""deep": (nodes: {"a": (type: "flow.repeat", params: {"body": "deeper", "iterations": 1000})}),
        "deeper": (nodes: {"b": (type: "flow.repeat", params: {"body": "step", "iterations": 1000})}),"#;
    let found = problems(
        r#""g": (type: "flow.repeat", params: {"body": "deep", "iterations": 1000})"#,
        "",
        &format!("{deep} {STEP}"),
    );
    assert_eq!(found[0].0, ProblemKind::TooLarge, "{found:?}");
}

struct Shelf(BTreeMap<&'static str, String>);

impl FileSource for Shelf {
    fn read(&self, path: &str) -> io::Result<Arc<Vec<u8>>> {
        self.0.get(path).map(|text| Arc::new(text.clone().into_bytes())).ok_or(io::ErrorKind::NotFound.into())
    }
}

#[test]
fn documents_share_groups_in_files() {
    let shared = document(
        r#"inputs: {"x": (type: "number", node: "file", param: "path")}, outputs: {"y": (node: "half", socket: "out")}"#,
        r#""file": (type: "test.length", params: {"path": "four.txt"}), "half": (type: "test.halve")"#,
        r#""file.out -> half.in""#,
        "",
    );
    let nodes = r#""a": (type: "test.constant", params: {"value": 12}),
        "linked": (type: "flow.group", params: {"body": "half"}), "alone": (type: "flow.group", params: {"body": "half"})"#;
    let mut document = document("", nodes, r#""a.out -> linked.x""#, r#""half": (file: "lib/half.ron")"#);
    let shelf =
        Shelf([("graphs/lib/half.ron", shared.to_ron()), ("graphs/lib/four.txt", "four".into())].into());
    document.include(Path::new("graphs"), &shelf).unwrap();
    let graph = Graph::with_folder(&document, &registry(), Path::new("graphs")).unwrap();
    let engine = build(Engine::builder().files(Arc::new(shelf)));
    let trace = run(&engine, &graph, &["linked/half.out", "alone/half.out"]);
    assert_eq!(
        trace.number("linked/half.out"),
        6,
        "what is linked takes the place of the group's own reader"
    );
    assert_eq!(trace.number("alone/half.out"), 2, "an input that is not linked reads its own file");

    let circle = r#"(format: "breccia-graph", version: 2, nodes: {}, groups: {"g": (file: "a.ron")})"#;
    let mut document = Document::parse(circle).unwrap();
    let shelf = Shelf([("a.ron", circle.to_owned())].into());
    assert!(document.include(Path::new(""), &shelf).unwrap_err().to_string().contains("a.ron -> a.ron"));
    let error = Document::parse(circle).unwrap().include(Path::new(""), &Shelf(BTreeMap::new())).unwrap_err();
    assert!(error.to_string().contains("group `g`: cannot read `a.ron`"), "{error}");
}

#[test]
fn values_from_outside_go_to_sockets() {
    let mut graph = graph(
        r#"inputs: {"x": (type: "number", targets: ["half.in"])}, outputs: {"y": (node: "half", socket: "out")}"#,
        r#""half": (type: "test.halve")"#,
        "",
        "",
    );
    let (_, result) = try_run(&engine(), &graph, &["y"], &CancelToken::default());
    assert!(result.unwrap().failures[0].message.contains("input `x` is not given"));
    assert!(graph.set_input("x", "file.txt").unwrap_err().to_string().contains("ready value"));
    graph.bind_input("x", breccia_engine::Value::new(crate::nodes::Number(9))).unwrap();
    assert_eq!(run(&engine(), &graph, &["y"]).number("y"), 4);
}

#[test]
fn paths_that_groups_hand_on_are_seen_from_the_document() {
    let read = r#""read": (
        interface: (outputs: {"y": (node: "file", socket: "out")}, params: {"text": (targets: ["file.path"])}),
        nodes: {"file": (type: "test.length", params: {"path": "own.txt"})},
    )"#;
    let nodes = r#""own": (type: "flow.group", params: {"body": "read"}),
        "given": (type: "flow.group", params: {"body": "read", "text": "four.txt"}),
        "built_in": (type: "flow.group", params: {"body": "read", "text": "builtin:one.txt"})"#;
    let interface = r#"params: {"text": (targets: ["plain.path"], default: "six.txt")}"#;
    let plain = format!(r#"{nodes}, "plain": (type: "test.length")"#);
    let document = document(interface, &plain, "", read);
    let files = [
        ("some/own.txt", "123"),
        ("some/four.txt", "1234"),
        ("builtin:one.txt", "1"),
        ("some/six.txt", "123456"),
    ];
    let shelf = Shelf(files.map(|(name, text)| (name, text.to_owned())).into());
    let graph = Graph::with_folder(&document, &registry(), Path::new("some")).unwrap();
    let outputs = ["own/file.out", "given/file.out", "built_in/file.out", "plain.out"];
    let trace = run(&build(Engine::builder().files(Arc::new(shelf))), &graph, &outputs);
    assert_eq!(outputs.map(|output| trace.number(output)), [3, 4, 1, 6]);

    let mut changed = document.clone();
    let mut seen = Vec::new();
    changed.change_paths(&registry(), Path::new("some"), &mut |path| {
        seen.push(path.to_owned());
        Some("new.txt".to_owned())
    });
    seen.sort();
    assert_eq!(seen, ["some/four.txt", "some/own.txt", "some/six.txt"]);
    assert_eq!(changed.nodes["given"].params["text"], parse_value("\"new.txt\"").unwrap());
    assert_eq!(changed.nodes["built_in"], document.nodes["built_in"]);
}

#[test]
fn groups_that_hold_themselves_are_looked_through_in_no_time() {
    let itself = r#""a": (
        interface: (params: {"x": (targets: ["g.x", "h.x"])}),
        nodes: {"g": (type: "flow.group", params: {"body": "a"}), "h": (type: "flow.group", params: {"body": "a"})},
    )"#;
    let interface = r#"params: {"x": (targets: ["g.x"])}"#;
    for (ty, x) in [("flow.group", r#""text""#), ("flow.levels", "[1, 2]")] {
        let nodes = format!(r#""g": (type: "{ty}", params: {{"body": "a", "x": {x}}})"#);
        let document = document(interface, &nodes, "", itself);
        assert!(Graph::with_folder(&document, &registry(), Path::new("some")).is_err());
    }
}
