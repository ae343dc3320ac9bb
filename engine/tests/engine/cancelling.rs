//! Cancellation, from another thread and before the start.

use std::sync::Arc;
use std::time::{Duration, Instant};

use breccia_engine::{CancelToken, Engine, Event, Graph, RunError, RunResult};

use crate::support::{build, engine, graph, run, try_run};

fn slow(stubborn: bool) -> Graph {
    graph(
        &format!(
            r#""s": (type: "test.slow", params: (millis: 20000, stubborn: {stubborn})), "half": (type: "test.halve")"#
        ),
        r#""s.out -> half.in""#,
    )
}

/// Cancels as soon as the node computes; says how long the run then took to return.
fn cancel_at_progress(engine: &Engine, graph: Graph) -> (Vec<Event>, Result<RunResult, RunError>, Duration) {
    let cancel = CancelToken::default();
    let at = std::cell::Cell::new(None);
    let events = std::cell::RefCell::new(Vec::new());
    let result = engine.run(&Arc::new(graph), &["half.out"], &cancel, &|event| {
        if matches!(event, Event::NodeProgress { .. }) && at.get().is_none() {
            at.set(Some(Instant::now()));
            cancel.cancel();
        }
        events.borrow_mut().push(event.clone());
    });
    let took = at.get().map_or(Duration::ZERO, |at| at.elapsed());
    (events.into_inner(), result, took)
}

#[test]
fn a_cooperative_node_stops_within_100_ms() {
    let (events, result, took) = cancel_at_progress(&engine(), slow(false));
    assert!(matches!(result, Err(RunError::Cancelled)));
    assert!(took < Duration::from_millis(100), "{took:?}");
    assert!(matches!(events.last(), Some(Event::RunFinished { cancelled: true, computed: 0, .. })));
    assert!(!events.iter().any(|e| matches!(e, Event::Warning { .. } | Event::NodeFailed { .. })));
}

#[test]
fn a_stubborn_node_is_named_and_left_behind() {
    let engine = build(Engine::builder().cancel_grace(Duration::from_millis(30)));
    let graph = graph(
        r#""s": (type: "test.slow", params: (millis: 1500, stubborn: true)), "half": (type: "test.halve")"#,
        r#""s.out -> half.in""#,
    );
    let (events, result, took) = cancel_at_progress(&engine, graph);
    assert!(matches!(result, Err(RunError::Cancelled)));
    assert!(took < Duration::from_millis(100), "{took:?}");
    let named = |events: &[Event], part: &str| {
        events.iter().any(|event| {
            matches!(event, Event::Warning { node: Some(node), message } if node == "s" && message.contains(part))
        })
    };
    assert!(named(&events, "has not stopped"), "{events:?}");
    // The next run hears that it took more than a second.
    std::thread::sleep(Duration::from_millis(1600));
    assert!(named(&run(&engine, &slow(false), &[]).events, "over a second"));
}

#[test]
fn a_run_cancelled_before_its_start_does_nothing() {
    let cancel = CancelToken::default();
    cancel.cancel();
    let (events, result) = try_run(&engine(), &slow(false), &["half.out"], &cancel);
    assert!(matches!(result, Err(RunError::Cancelled)));
    assert_eq!(events.len(), 2);
}

#[test]
fn a_cancelled_run_leaves_nothing_on_disk() {
    let folder = tempfile::tempdir().unwrap();
    let engine = build(Engine::builder().cache_dir(Some(folder.path().into())));
    let (_, result, _) = cancel_at_progress(&engine, slow(false));
    assert!(matches!(result, Err(RunError::Cancelled)));
    assert_eq!(engine.disk_cache().unwrap().info(), breccia_engine::DiskInfo::default());
}
