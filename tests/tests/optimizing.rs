//! Texture optimisation as a graph: what runs again, and what is said of bad input.

use std::cell::RefCell;
use std::path::Path;
use std::sync::Arc;

use breccia_engine::{
    CacheLevel, CancelToken, Document, Engine, Event, Graph, RunResult, Value, parse_value,
};
use breccia_graphs::Sources;
use breccia_nodes::data::{Image, Samples};
use breccia_nodes::optimize::Field;

fn preset(name: &str) -> Document {
    breccia_graphs::preset(name).unwrap().document().unwrap()
}

fn graph(settings: &[(&str, &str)]) -> Graph {
    let mut graph = Graph::new(&preset("optimize_volume"), &breccia_nodes::registry()).unwrap();
    let small =
        [("exemplar.max_size", "48"), ("levels", "2"), ("window", "(6, 4)"), ("iterations", "(6, 3)")];
    for (name, value) in small.iter().chain(&[("size", "(16, 20, 12)")]).chain(settings) {
        graph.set(name, &parse_value(value).unwrap()).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
    graph
}

fn engine(folder: Option<&Path>) -> Engine {
    let builder =
        Engine::builder().files(Arc::new(Sources::default())).cache_dir(folder.map(Into::into)).threads(2);
    builder.build(Arc::new(breccia_nodes::registry())).unwrap()
}

fn run(engine: &Engine, graph: &Graph, output: &str) -> (Vec<Event>, RunResult) {
    let events = RefCell::new(Vec::new());
    let graph = Arc::new(graph.clone());
    let result =
        engine.run(&graph, &[output], &CancelToken::default(), &|e| events.borrow_mut().push(e.clone()));
    (events.into_inner(), result.unwrap())
}

fn computed(events: &[Event]) -> Vec<&str> {
    events.iter().filter(|e| matches!(e, Event::NodeFinished { .. })).filter_map(Event::node).collect()
}

/// The one message that a run ends with.
fn failure(graph: &Graph) -> String {
    let (_, result) = run(&engine(None), graph, "volume");
    let first = result.failures.iter().find(|failure| failure.because_of.is_none());
    first.map(|failure| format!("{}: {}", failure.node, failure.message)).unwrap_or_default()
}

#[test]
fn a_run_stopped_in_a_zone_goes_on_from_its_last_iteration() {
    let folder = tempfile::tempdir().unwrap();
    let graph = graph(&[("iterations", "(8, 3)")]);
    let cancel = CancelToken::default();
    let seen = RefCell::new(Vec::new());
    let stopped = engine(Some(folder.path())).run(&Arc::new(graph.clone()), &["volume"], &cancel, &|event| {
        if matches!(event, Event::NodeFinished { node, .. } if node == "levels[1]/refine[6]/solve") {
            cancel.cancel();
        }
        seen.borrow_mut().push(event.clone());
    });
    assert!(stopped.is_err());
    // What was being written when the run was stopped may still be.
    std::thread::sleep(std::time::Duration::from_millis(300));
    let done = seen.into_inner();
    let done = computed(&done);
    let (events, result) = run(&engine(Some(folder.path())), &graph, "volume");
    assert_eq!(result.failures, []);
    let again = computed(&events);
    // Everything up to the solve of iteration 6 is known; the search that was cut off, if any, runs again.
    assert!(!again.iter().any(|node| node.starts_with("levels[1]/refine[6]/")), "{again:?}");
    assert!(again.contains(&"levels[1]/refine[7]/search"), "{again:?}");
    assert!(
        again.iter().filter(|node| node.ends_with("/solve")).all(|node| !done.contains(node)),
        "{again:?}"
    );
    let read = events.iter().filter(|e| matches!(e, Event::NodeCached { from: CacheLevel::Disk, .. }));
    assert!(read.filter_map(Event::node).filter(|node| node.contains("refine")).count() <= 1);

    // The same as in one go.
    let (_, whole) = run(&engine(None), &graph, "volume");
    assert_eq!(whole.outputs["volume"].digest(), result.outputs["volume"].digest());
}

#[test]
fn one_more_iteration_computes_one_more() {
    let engine = engine(None);
    run(&engine, &graph(&[]), "levels[1]/refine[5]/solve.field");
    let (events, _) = run(&engine, &graph(&[("iterations", "(7, 3)")]), "levels[1]/refine[6]/solve.field");
    assert_eq!(computed(&events), ["levels[1]/refine[6]/search", "levels[1]/refine[6]/solve"]);
}

#[test]
fn intermediate_iterations_obey_the_budget() {
    let engine = Engine::builder()
        .files(Arc::new(Sources::default()))
        .memory(200_000)
        .build(Arc::new(breccia_nodes::registry()));
    let engine = engine.unwrap();
    let (_, result) = run(&engine, &graph(&[("size", "32"), ("iterations", "(6, 6)")]), "volume");
    assert_eq!(result.failures, []);
    drop(result);
    // A field alone takes 200 kB; twelve iterations went by.
    assert!(engine.memory_usage().1 <= 200_000, "{:?}", engine.memory_usage());
}

#[test]
fn what_is_painted_stays() {
    let mut graph = Graph::new(&preset("optimize_painted"), &breccia_nodes::registry()).unwrap();
    let small =
        [("exemplar.max_size", "48"), ("levels", "2"), ("window", "(6, 4)"), ("iterations", "(3, 2)")];
    let place = [("size", "24"), ("center", "(12, 12, 12)"), ("radius", "8"), ("shape.shape", "\"ball\"")];
    for (name, value) in small.iter().chain(&place) {
        graph.set(name, &parse_value(value).unwrap()).unwrap();
    }
    let (_, result) = run(&engine(None), &graph, "levels[0]/refine[1]/painted.field");
    let field = result.outputs["levels[0]/refine[1]/painted.field"].downcast::<Field>().unwrap();
    let at = |x: usize, y: usize, z: usize| field.colors[(z * 24 + y) * 24 + x];
    let middle = at(12, 12, 12);
    assert!((5..19).all(|x| at(x, 12, 12) == middle), "the ball has one colour");
    assert!(middle[0] < 90, "and it is the dark one that was asked for: {middle:?}");
}

#[test]
fn a_constant_exemplar_gives_a_constant_solid() {
    let mut graph = graph(&[]);
    graph.bind_input("exemplar", Value::new(Image::from_fn(48, 48, |_, _| [90, 80, 70]))).unwrap();
    graph.set_input("mask", "").unwrap();
    let (_, result) = run(&engine(None), &graph, "levels[0]/refine[2]/solve.field");
    assert_eq!(result.failures, []);
    let field = result.outputs["levels[0]/refine[2]/solve.field"].downcast::<Field>().unwrap();
    assert!(field.colors.iter().all(|color| color[..3] == [90, 80, 70]));
}

#[test]
fn bad_input_is_named() {
    let mut nan = graph(&[]);
    nan.set_input("mask", "").unwrap();
    let samples = (0..48 * 48 * 3).map(|i| if i == 1234 { f32::NAN } else { 0.5 }).collect();
    nan.bind_input("exemplar", Value::new(Image::new(48, 48, 3, Samples::F32(samples)).unwrap())).unwrap();
    let cases = [
        (nan, "finite"),
        (graph(&[("levels/similar.k", "32"), ("exemplar.max_size", "16"), ("window", "(8, 8)")]), "k = 32"),
        (graph(&[("window", "(30, 4)")]), "30 × 30"),
        (graph(&[("levels.levels", "3")]), "level 2"),
        (graph(&[("size", "2048")]), "expected at most a cube"),
        (
            graph(&[
                ("levels/refine/search.x", "false"),
                ("levels/refine/search.y", "false"),
                ("levels/refine/search.z", "false"),
            ]),
            "no direction",
        ),
    ];
    for (graph, expected) in cases {
        let message = failure(&graph);
        assert!(message.contains(expected), "{expected}: {message}");
    }
    let mut graph = graph(&[]);
    let error = graph.set("levels/refine/search.metod", &parse_value("1").unwrap()).unwrap_err().to_string();
    assert!(error.contains("did you mean `method`"), "{error}");
    assert!(graph.set("iterations", &parse_value("5000").unwrap()).unwrap_err().to_string().contains("1000"));
}
