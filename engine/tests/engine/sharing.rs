//! Several runs, several threads.

use std::sync::Arc;
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use breccia_engine::{CancelToken, Event};

use crate::support::{engine, graph, run};

#[test]
fn two_runs_at_once_share_one_computation() {
    let engine = engine();
    let graph = graph(r#""s": (type: "test.slow", params: (millis: 150))"#, "");
    let (one, other) = std::thread::scope(|scope| {
        let spawn = || scope.spawn(|| run(&engine, &graph, &["s.out"]));
        let (one, other) = (spawn(), spawn());
        (one.join().unwrap(), other.join().unwrap())
    });
    assert_eq!(one.computed().len() + other.computed().len(), 1);
    assert_eq!((one.number("s.out"), other.number("s.out")), (150, 150));
}

#[test]
fn what_another_run_wants_too_goes_on_when_one_is_cancelled() {
    let engine = engine();
    let graph = graph(r#""s": (type: "test.slow", params: (millis: 1200))"#, "");
    let cancel = CancelToken::default();
    let (started, first_started) = channel();
    let (cancelled, trace) = std::thread::scope(|scope| {
        let (engine, graph, cancel) = (&engine, &graph, &cancel);
        let first = scope.spawn(move || {
            let tell = |event: &Event| {
                if matches!(event, Event::NodeStarted { .. }) {
                    started.send(()).unwrap();
                }
            };
            let begun = Instant::now();
            let result = engine.run(&Arc::new(graph.clone()), &["s.out"], cancel, &tell);
            (result.is_err(), begun.elapsed())
        });
        first_started.recv().unwrap();
        let second = scope.spawn(move || run(engine, graph, &["s.out"]));
        std::thread::sleep(Duration::from_millis(500));
        cancel.cancel();
        (first.join().unwrap(), second.join().unwrap())
    });
    assert!(
        cancelled.0 && cancelled.1 < Duration::from_millis(1100),
        "who cancels does not wait: {cancelled:?}"
    );
    assert_eq!((trace.computed(), trace.number("s.out")), (vec![], 1200));
    assert!(run(&engine, &graph, &["s.out"]).warnings().is_empty(), "nothing went on too long");
}

#[test]
fn what_all_runs_cancelled_stops() {
    let engine = engine();
    let graph = graph(r#""s": (type: "test.slow", params: (millis: 60000))"#, "");
    let cancels = [CancelToken::default(), CancelToken::default()];
    std::thread::scope(|scope| {
        for cancel in &cancels {
            scope.spawn(|| assert!(crate::support::try_run(&engine, &graph, &["s.out"], cancel).1.is_err()));
        }
        std::thread::sleep(Duration::from_millis(100));
        cancels.iter().for_each(CancelToken::cancel);
    });
}

#[test]
fn independent_nodes_run_at_the_same_time() {
    let graph = graph(
        r#""a": (type: "test.slow", params: (millis: 200)), "b": (type: "test.slow", params: (millis: 201)),
           "add": (type: "test.add")"#,
        r#""a.out -> add.terms", "b.out -> add.terms""#,
    );
    let start = Instant::now();
    run(&engine(), &graph, &["add.sum"]);
    assert!(start.elapsed() < Duration::from_millis(390), "{:?}", start.elapsed());
}

#[test]
fn a_wide_graph_gives_the_same_on_any_number_of_threads() {
    let nodes: String = (0..60)
        .map(|i| {
            format!(r#""c{i}": (type: "test.constant", params: (value: {i})), "h{i}": (type: "test.halve"),"#)
        })
        .collect();
    let links: String =
        (0..60).map(|i| format!(r#""c{i}.out -> h{i}.in", "h{i}.out -> add.terms","#)).collect();
    let graph = graph(&format!(r#"{nodes} "add": (type: "test.add")"#), &links);
    for threads in [1, 2, 5] {
        let registry = Arc::new(crate::nodes::registry());
        let engine = breccia_engine::Engine::builder().threads(threads).build(registry).unwrap();
        let trace = run(&engine, &graph, &["add.sum"]);
        assert_eq!(trace.number("add.sum"), (0..60).map(|i| i / 2).sum::<i64>());
        assert_eq!(trace.computed().len(), 121);
    }
}
