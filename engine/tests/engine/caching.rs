//! What computes again, and what does not.

use breccia_engine::{CacheLevel, CancelToken, Engine, Event, NodeSpec, ParamValue, Value};

use crate::nodes::{Number, Opaque};
use crate::support::{build, document, engine, graph, int, run, sum};

const NOTHING: [&str; 0] = [];

#[test]
fn a_second_run_computes_nothing() {
    let engine = engine();
    let first = run(&engine, &sum(), &["half.out"]);
    assert_eq!(first.computed(), ["a", "add", "b", "half"]);
    assert_eq!(first.number("half.out"), 4);
    let second = run(&engine, &sum(), &["half.out"]);
    assert_eq!(second.computed(), NOTHING);
    assert_eq!(second.cached(CacheLevel::Memory), ["half"]);
    assert_eq!(second.cached(CacheLevel::Digest), ["a", "add", "b"]);
    assert_eq!(second.number("half.out"), 4);
    assert!(matches!(second.events.first(), Some(Event::RunStarted { .. })));
    assert!(matches!(
        second.events.last(),
        Some(Event::RunFinished { computed: 0, cached: 4, failed: 0, .. })
    ));
}

#[test]
fn a_changed_parameter_recomputes_its_descendants_only() {
    let engine = engine();
    let mut graph = sum();
    run(&engine, &graph, &["half.out"]);
    graph.set_node_param("b", "value", &int(8)).unwrap();
    let trace = run(&engine, &graph, &["half.out"]);
    assert_eq!(trace.computed(), ["add", "b", "half"]);
    assert_eq!(trace.number("half.out"), 5);
}

#[test]
fn an_equal_value_stops_the_recomputation() {
    let engine = engine();
    let mut graph = graph(
        r#""a": (type: "test.constant", params: (value: 4)), "half": (type: "test.halve"),
           "end": (type: "test.halve")"#,
        r#""a.out -> half.in", "half.out -> end.in""#,
    );
    run(&engine, &graph, &["end.out"]);
    graph.set_node_param("a", "value", &int(5)).unwrap();
    let trace = run(&engine, &graph, &["end.out"]);
    assert_eq!(trace.computed(), ["a", "half"]);
    assert_eq!(trace.cached(CacheLevel::Memory), ["end"]);
}

#[test]
fn two_consumers_share_one_computation() {
    let graph = graph(
        r#""a": (type: "test.slow", params: (millis: 20)), "l": (type: "test.halve"), "r": (type: "test.wrap")"#,
        r#""a.out -> l.in", "a.out -> r.in""#,
    );
    let trace = run(&engine(), &graph, &["l.out", "r.out", "a.out"]);
    assert_eq!(trace.computed(), ["a", "l", "r"]);
}

#[test]
fn equal_nodes_compute_once() {
    let graph = graph(
        r#""a": (type: "test.slow", params: (millis: 30)), "b": (type: "test.slow", params: (millis: 30)),
           "add": (type: "test.add")"#,
        r#""a.out -> add.terms", "b.out -> add.terms""#,
    );
    let trace = run(&engine(), &graph, &["add.sum"]);
    assert_eq!(trace.computed().len(), 2, "{:?}", trace.computed());
    assert_eq!(trace.number("add.sum"), 60);
}

#[test]
fn an_output_nobody_asked_for_is_not_computed() {
    let trace = run(&engine(), &sum(), &["a.out"]);
    assert_eq!(trace.computed(), ["a"]);
    assert_eq!(run(&engine(), &sum(), &[]).computed(), NOTHING);
}

#[test]
fn whole_and_real_numbers_share_a_key() {
    let engine = engine();
    let mut graph = sum();
    graph.set_node_param("add", "scale", &int(2)).unwrap();
    run(&engine, &graph, &["add.sum"]);
    graph.set_node_param("add", "scale", &ParamValue::Float(2.0)).unwrap();
    assert_eq!(run(&engine, &graph, &["add.sum"]).computed(), NOTHING);
}

#[test]
fn the_order_of_links_into_one_socket_counts() {
    let order = |links: &str| {
        graph(
            r#""a": (type: "test.constant", params: (value: 1)), "b": (type: "test.constant"),
               "add": (type: "test.add")"#,
            links,
        )
    };
    let engine = engine();
    run(&engine, &order(r#""a.out -> add.terms", "b.out -> add.terms""#), &["add.sum"]);
    let trace = run(&engine, &order(r#""b.out -> add.terms", "a.out -> add.terms""#), &["add.sum"]);
    assert_eq!(trace.computed(), ["add"]);
}

#[test]
fn several_outputs_of_a_node_are_kept_apart() {
    let engine = engine();
    let graph = graph(
        r#""a": (type: "test.constant", params: (value: 42)), "s": (type: "test.split")"#,
        r#""a.out -> s.in""#,
    );
    assert_eq!(run(&engine, &graph, &["s.tens"]).number("s.tens"), 4);
    let trace = run(&engine, &graph, &["s.ones", "s.tens"]);
    assert_eq!((trace.number("s.ones"), trace.number("s.tens")), (2, 4));
    assert_eq!(trace.computed(), NOTHING);
}

#[test]
fn evicted_values_are_computed_again() {
    let engine = build(Engine::builder().memory(250));
    let graph = sum();
    run(&engine, &graph, &["half.out"]);
    let (values, bytes) = engine.memory_usage();
    assert!(values <= 2 && bytes <= 250, "{values} values, {bytes} bytes");
    // `a` was used first, so it is gone; nothing else is needed to make it again.
    assert_eq!(run(&engine, &graph, &["a.out"]).computed(), ["a"]);
}

#[test]
fn values_in_use_are_not_evicted() {
    let engine = build(Engine::builder().memory(0));
    let trace = run(&engine, &sum(), &["half.out", "a.out"]);
    // With no room at all every node still computes only once, as the run holds what it needs.
    assert_eq!(trace.computed(), ["a", "add", "b", "half"]);
    assert_eq!(run(&engine, &sum(), &["a.out"]).cached(CacheLevel::Memory), ["a"]);
    drop(trace);
    assert_eq!(run(&engine, &sum(), &["add.sum"]).computed(), ["a", "add", "b"]);
    run(&engine, &sum(), &[]);
    assert_eq!(engine.memory_usage(), (0, 0));
}

#[test]
fn a_file_counts_by_its_contents() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    std::fs::write(path("a.txt"), "hello").unwrap();
    std::fs::write(path("b.txt"), "hello").unwrap();
    let interface = r#"inputs: {"file": (type: "number", node: "n", param: "path")},
        outputs: {"length": (node: "n", socket: "out")}"#;
    let document = document(interface, r#""n": (type: "test.length")"#, "");
    let mut graph = breccia_engine::Graph::new(&document, &crate::nodes::registry()).unwrap();
    let engine = engine();
    graph.set_input("file", &path("a.txt")).unwrap();
    assert_eq!(run(&engine, &graph, &["length"]).number("length"), 5);
    graph.set_input("file", &path("b.txt")).unwrap();
    assert_eq!(run(&engine, &graph, &["length"]).computed(), NOTHING);
    std::fs::write(path("b.txt"), "hello!").unwrap();
    let trace = run(&engine, &graph, &["length"]);
    assert_eq!((trace.computed(), trace.number("length")), (vec!["n"], 6));
}

#[test]
fn a_ready_value_stands_in_for_a_file() {
    let interface = r#"inputs: {"file": (type: "number", node: "n", param: "path")}"#;
    let document = document(
        interface,
        r#""n": (type: "test.length"), "half": (type: "test.halve")"#,
        r#""n.out -> half.in""#,
    );
    let mut graph = breccia_engine::Graph::new(&document, &crate::nodes::registry()).unwrap();
    graph.bind_input("file", Value::new(Number(8))).unwrap();
    let engine = engine();
    let trace = run(&engine, &graph, &["half.out"]);
    assert_eq!((trace.computed(), trace.number("half.out")), (vec!["half"], 4));
    assert_eq!(run(&engine, &graph, &["half.out"]).computed(), NOTHING);
    assert!(graph.bind_input("file", Value::new(Opaque(8))).is_err());
}

#[test]
fn a_checked_run_finds_nodes_that_are_no_functions() {
    let engine = engine();
    let checked = |graph| {
        engine
            .run_checked(&std::sync::Arc::new(graph), &["out.out"], &CancelToken::default(), &|_| {})
            .unwrap()
    };
    let pure = || graph(r#""out": (type: "test.constant", params: (value: 3))"#, "");
    assert_eq!(checked(pure()).computed, 1);
    run(&engine, &pure(), &["out.out"]);
    let again = checked(pure());
    assert_eq!((again.computed, again.failures.len()), (1, 0));
    let impure = checked(graph(r#""out": (type: "test.impure")"#, ""));
    assert!(impure.failures[0].message.contains("no pure function"), "{:?}", impure.failures);
}

#[test]
fn a_raised_version_is_another_key() {
    struct Versioned(u32);
    impl breccia_engine::Node for Versioned {
        fn spec(&self) -> NodeSpec {
            NodeSpec::new("test.versioned", self.0, "A", "B.").output("out", "number", "It.")
        }
        fn run(&self, context: &mut breccia_engine::Context<'_>) -> Result<(), breccia_engine::NodeError> {
            context.set("out", Number(self.0.into()));
            Ok(())
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let value = |version| {
        let mut registry = crate::nodes::registry();
        registry.add_nodes([Box::new(Versioned(version)) as Box<dyn breccia_engine::Node>]);
        let document = document("", r#""n": (type: "test.versioned")"#, "");
        let graph = breccia_engine::Graph::new(&document, &registry).unwrap();
        let engine = Engine::builder().cache_dir(Some(folder.path().into()));
        run(&engine.build(std::sync::Arc::new(registry)).unwrap(), &graph, &["n.out"]).number("n.out")
    };
    assert_eq!((value(1), value(2), value(1)), (1, 2, 1));
}
