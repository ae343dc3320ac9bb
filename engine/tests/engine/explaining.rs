//! Plans agree with what runs do, and run nothing.

use breccia_engine::{CacheLevel, Engine, Forecast, Graph, Plan};

use crate::support::{build, document, engine, int, run, sum};

fn forecasts(plan: &Plan) -> Vec<(&str, Forecast)> {
    let mut forecasts: Vec<_> =
        plan.nodes.iter().map(|entry| (entry.node.as_str(), entry.forecast)).collect();
    forecasts.sort_by_key(|f| f.0);
    forecasts
}

#[test]
fn what_is_known_depends_on_what_ran() {
    let engine = engine();
    let mut graph = sum();
    let before = engine.explain(&graph, &["half.out"]).unwrap();
    assert_eq!(
        forecasts(&before),
        [
            ("a", Forecast::WouldRun),
            ("add", Forecast::Unknown),
            ("b", Forecast::WouldRun),
            ("half", Forecast::Unknown)
        ]
    );
    assert_eq!(engine.memory_usage().0, 0);
    run(&engine, &graph, &["half.out"]);
    let known = Forecast::Cached(CacheLevel::Digest);
    let after = engine.explain(&graph, &["half.out"]).unwrap();
    let in_memory = Forecast::Cached(CacheLevel::Memory);
    assert_eq!(forecasts(&after), [("a", known), ("add", known), ("b", known), ("half", in_memory)]);
    assert_eq!(after.bytes(), 400);
    assert_eq!(after.nodes[after.nodes.len() - 1].summary.as_deref(), Some("number 4"));

    graph.set_node_param("add", "scale", &int(3)).unwrap();
    let changed = engine.explain(&graph, &["half.out"]).unwrap();
    assert_eq!(
        forecasts(&changed),
        [("a", in_memory), ("add", Forecast::WouldRun), ("b", in_memory), ("half", Forecast::Unknown)]
    );
}

#[test]
fn values_on_disk_are_found_there() {
    let folder = tempfile::tempdir().unwrap();
    let fresh = || build(Engine::builder().cache_dir(Some(folder.path().into())));
    run(&fresh(), &sum(), &["half.out"]);
    let plan = fresh().explain(&sum(), &["half.out"]).unwrap();
    assert_eq!(plan.count(|f| f == Forecast::Cached(CacheLevel::Disk)), 1);
    assert_eq!(plan.count(|f| f == Forecast::WouldRun), 0);
}

#[test]
fn a_missing_input_is_foreseen() {
    let document = document(
        r#"inputs: {"text": (type: "number", node: "n", param: "path")}"#,
        r#""n": (type: "test.length"), "half": (type: "test.halve")"#,
        r#""n.out -> half.in""#,
    );
    let mut graph = Graph::new(&document, &crate::nodes::registry()).unwrap();
    let plan = engine().explain(&graph, &["half.out"]).unwrap();
    assert_eq!(plan.nodes[0].forecast, Forecast::Fails);
    assert_eq!(plan.nodes[0].summary.as_deref(), Some("input `text` is not given"));
    graph.set_input("text", "no/such/file.txt").unwrap();
    let plan = engine().explain(&graph, &["half.out"]).unwrap();
    assert_eq!(forecasts(&plan), [("half", Forecast::Fails), ("n", Forecast::Fails)]);
    assert!(engine().explain(&graph, &["haf.out"]).is_err());
}
