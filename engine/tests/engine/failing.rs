//! Failures: of nodes, of files, of what depends on them.

use breccia_engine::{DeviceChoice, Engine, EngineError, Event, FailureKind, Graph, PlainFiles, RunError};

use crate::support::{Trace, build, document, engine, graph, run, try_run};

/// `good` works; `bad` fails, and with it `next` and `last`.
fn half_bad(how: &str) -> Graph {
    graph(
        &format!(
            r#""a": (type: "test.constant", params: (value: 8)), "good": (type: "test.halve"),
               "bad": (type: "test.fail", params: (how: "{how}")), "next": (type: "test.pair"),
               "last": (type: "test.halve")"#
        ),
        r#""a.out -> good.in", "a.out -> bad.in", "bad.out -> next.a", "a.out -> next.b", "next.list -> last.in""#,
    )
}

fn skipped(trace: &Trace) -> Vec<(&str, &str)> {
    let skips = trace.events.iter().filter_map(|event| match event {
        Event::NodeSkipped { node, because_of } => Some((node.as_str(), because_of.as_str())),
        _ => None,
    });
    skips.collect()
}

#[test]
fn a_failing_node_fails_its_dependants_by_name_and_leaves_the_rest() {
    let trace = run(&engine(), &half_bad("failed"), &["last.out", "good.out"]);
    assert_eq!(trace.failed(), ["bad"]);
    assert_eq!(skipped(&trace), [("next", "bad"), ("last", "bad")]);
    assert_eq!(trace.computed(), ["a", "good"]);
    assert_eq!(trace.number("good.out"), 4);
    assert!(!trace.result.outputs.contains_key("last.out"));
    let failures: Vec<_> =
        trace.result.failures.iter().map(|f| (f.node.as_str(), f.because_of.as_deref())).collect();
    assert_eq!(failures, [("bad", None), ("next", Some("bad")), ("last", Some("bad"))]);
    assert_eq!(trace.result.failures[0].message, "does not converge");
}

#[test]
fn every_way_of_failing_is_reported() {
    for (how, kind, part) in [
        ("failed", FailureKind::Failed, "does not converge"),
        ("input", FailureKind::Input, "bad bytes"),
        ("panic", FailureKind::Failed, "panicked: on purpose"),
        ("unset", FailureKind::Failed, "did not set its output `out`"),
        ("wrong", FailureKind::Failed, "of type opaque, it declares number"),
        ("cancelled", FailureKind::Failed, "nobody asked"),
    ] {
        let trace = run(&engine(), &half_bad(how), &["last.out"]);
        let failures = &trace.result.failures;
        assert!(failures[0].message.contains(part), "{how}: {failures:?}");
        assert!(failures.iter().all(|failure| failure.kind == kind), "{how}: {failures:?}");
    }
}

#[test]
fn a_failed_node_is_tried_again() {
    let engine = engine();
    for _ in 0..2 {
        assert_eq!(run(&engine, &half_bad("panic"), &["last.out"]).failed(), ["bad"]);
    }
}

fn with_file(interface: &str) -> Graph {
    let nodes = r#""n": (type: "test.length"), "one": (type: "test.constant", params: (value: 1)),
        "half": (type: "test.halve"), "pair": (type: "test.pair"), "add": (type: "test.add")"#;
    let links = r#""n.out -> half.in", "one.out -> pair.a", "half.out -> pair.b", "n.out -> add.terms",
        "one.out -> add.terms""#;
    Graph::new(&document(interface, nodes, links), &crate::nodes::registry()).unwrap()
}

const FILE: &str = r#"inputs: {"text": (type: "number", docs: "Any text.", node: "n", param: "path")}"#;

#[test]
fn an_input_that_is_not_given_is_named() {
    let trace = run(&engine(), &with_file(FILE), &["half.out"]);
    assert_eq!(trace.result.failures.len(), 1);
    let failure = &trace.result.failures[0];
    assert_eq!((failure.node.as_str(), failure.kind), ("half", FailureKind::Input));
    assert_eq!(failure.message, "input `text` is not given");
    let trace = run(&engine(), &with_file(""), &["n.out"]);
    assert_eq!(trace.result.failures[0].message, "no file is given for parameter `path` of node `n`");
}

#[test]
fn what_can_do_without_an_absent_node_does() {
    let trace = run(&engine(), &with_file(FILE), &["pair.list", "add.sum"]);
    assert_eq!((trace.number("pair.list"), trace.number("add.sum")), (9, 1));
    assert_eq!(trace.computed(), ["add", "one", "pair"]);
}

#[test]
fn an_unreadable_file_is_named() {
    let mut graph = with_file(FILE);
    graph.set_input("text", "no/such/file.txt").unwrap();
    let trace = run(&engine(), &graph, &["half.out", "one.out"]);
    assert_eq!(trace.failed(), ["n"]);
    assert_eq!(skipped(&trace), [("half", "n")]);
    let failure = &trace.result.failures[0];
    assert_eq!(failure.kind, FailureKind::Input);
    assert!(failure.message.contains("`no/such/file.txt`"), "{}", failure.message);
    assert_eq!(trace.number("one.out"), 1);
}

#[test]
fn a_file_that_is_too_large_is_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    std::fs::write(&path, "hello").unwrap();
    let mut graph = with_file(FILE);
    graph.set_input("text", &path.to_string_lossy()).unwrap();
    let engine = build(Engine::builder().files(std::sync::Arc::new(PlainFiles { limit: 4 })));
    let trace = run(&engine, &graph, &["half.out"]);
    let message = &trace.result.failures[0].message;
    assert!(message.contains("5 bytes") && message.contains("4 bytes"), "{message}");
    graph.set_input("text", &folder.path().to_string_lossy()).unwrap();
    assert!(run(&engine, &graph, &["half.out"]).result.failures[0].message.contains("folder"));
}

#[test]
fn an_unknown_output_is_an_error_with_a_suggestion() {
    let outcome = try_run(&engine(), &with_file(FILE), &["halv.out", "pair.lst"], &Default::default());
    let Err(RunError::Graph(problems)) = outcome.1 else { panic!() };
    let suggestions: Vec<_> = problems.0.iter().map(|p| p.suggestion.as_deref()).collect();
    assert_eq!(suggestions, [Some("half"), Some("list")]);
    assert!(outcome.0.is_empty());
}

#[test]
fn there_is_no_gpu() {
    let registry = std::sync::Arc::new(crate::nodes::registry());
    let result = Engine::builder().device(DeviceChoice::Gpu).build(registry);
    assert!(matches!(result, Err(EngineError::NoDevice(_))));
}
