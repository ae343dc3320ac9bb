//! Which nodes run on a compute device, and what a run tells of that.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use breccia_engine::{Device, DeviceChoice, Engine, EngineError, Event, Graph};

use crate::nodes::{Pretended, registry};
use crate::support::{Trace, build, graph, int, run};

fn with_device(choice: DeviceChoice, speedup: f64, loses: bool) -> Engine {
    let open = move || -> Result<Arc<dyn breccia_engine::ComputeDevice>, String> {
        Ok(Arc::new(Pretended { speedup, loses, lost: AtomicBool::new(false) }))
    };
    build(Engine::builder().device(choice).compute(Box::new(open)))
}

/// Nodes with little, much and unknown work, and one that has no choice.
fn nodes() -> Graph {
    graph(
        r#""little": (type: "test.anywhere", params: (value: 1)), "much": (type: "test.anywhere", params: (value: 500)),
           "unknown": (type: "test.anywhere", params: (value: -1)), "fixed": (type: "test.constant")"#,
        "",
    )
}

const ALL: [&str; 4] = ["little.out", "much.out", "unknown.out", "fixed.out"];

fn on_device(trace: &Trace) -> Vec<&str> {
    trace.names(|event| matches!(event, Event::NodeFinished { device: Device::Gpu, .. }))
}

fn told(trace: &Trace) -> Vec<&str> {
    let told = trace.events.iter().filter_map(|event| match event {
        Event::DeviceChosen { message } => Some(message.as_str()),
        _ => None,
    });
    told.collect()
}

#[test]
fn a_choice_goes_by_availability_size_and_transfer() {
    let trace = run(&with_device(DeviceChoice::Auto, 20.0, false), &nodes(), &ALL);
    assert_eq!(on_device(&trace), ["much", "unknown"]);
    assert_eq!(told(&trace), ["compute device pretended"]);
    let trace = run(&with_device(DeviceChoice::Gpu, 0.1, false), &nodes(), &ALL);
    assert_eq!(on_device(&trace), ["little", "much", "unknown"]);
    let trace = run(&with_device(DeviceChoice::Cpu, 20.0, false), &nodes(), &ALL);
    assert!(on_device(&trace).is_empty() && told(&trace).is_empty());
    let slow = run(&with_device(DeviceChoice::Auto, 1.0, false), &nodes(), &ALL);
    assert!(on_device(&slow).is_empty());
    assert!(told(&slow)[0].contains("leaves it aside"), "{:?}", told(&slow));
}

#[test]
fn started_nodes_say_where_they_were_placed() {
    let trace = run(&with_device(DeviceChoice::Auto, 20.0, false), &nodes(), &ALL);
    let placed = trace.names(|event| matches!(event, Event::NodeStarted { device: Device::Gpu, .. }));
    assert_eq!(placed, ["much", "unknown"]);
}

#[test]
fn the_device_makes_no_difference_to_what_is_cached() {
    let engine = with_device(DeviceChoice::Auto, 20.0, false);
    let there = run(&engine, &nodes(), &ALL);
    let folder = tempfile::tempdir().unwrap();
    let disk = || Some(folder.path().to_owned());
    let open = || -> Result<Arc<dyn breccia_engine::ComputeDevice>, String> {
        Ok(Arc::new(Pretended { speedup: 20.0, loses: false, lost: AtomicBool::new(false) }))
    };
    run(&build(Engine::builder().cache_dir(disk()).compute(Box::new(open))), &nodes(), &ALL);
    let here = run(&build(Engine::builder().cache_dir(disk()).device(DeviceChoice::Cpu)), &nodes(), &ALL);
    assert!(here.computed().is_empty());
    assert_eq!(here.number("much.out"), there.number("much.out"));
}

#[test]
fn without_a_device_auto_says_so_once_and_gpu_is_refused() {
    let opened = Arc::new(AtomicU32::new(0));
    let counter = Arc::clone(&opened);
    let open = move || -> Result<Arc<dyn breccia_engine::ComputeDevice>, String> {
        counter.fetch_add(1, Ordering::Relaxed);
        Err("nothing is plugged in".to_owned())
    };
    let engine = build(Engine::builder().compute(Box::new(open)));
    assert_eq!(opened.load(Ordering::Relaxed), 0, "a device is opened before it is needed");
    let trace = run(&engine, &nodes(), &ALL);
    assert_eq!(told(&trace).len(), 1);
    assert!(told(&trace)[0].contains("nothing is plugged in"));
    assert!(on_device(&trace).is_empty() && trace.failed().is_empty());
    assert_eq!(opened.load(Ordering::Relaxed), 1);

    let open = || -> Result<Arc<dyn breccia_engine::ComputeDevice>, String> { Err("nothing".to_owned()) };
    let refused =
        Engine::builder().device(DeviceChoice::Gpu).compute(Box::new(open)).build(Arc::new(registry()));
    assert!(matches!(refused.err(), Some(EngineError::NoDevice(reason)) if reason == "nothing"));
}

#[test]
fn a_lost_device_is_told_and_the_rest_runs_on_the_processor() {
    let engine = with_device(DeviceChoice::Gpu, 20.0, true);
    let first = run(&engine, &nodes(), &["much.out"]);
    assert_eq!(first.warnings(), ["the device was lost, going on without"]);
    let mut later = nodes();
    later.set_node_param("little", "value", &int(7)).unwrap();
    let second = run(&engine, &later, &["little.out"]);
    assert!(on_device(&second).is_empty() && second.number("little.out") == 7);
    assert!(told(&second)[0].contains("unplugged"), "{:?}", told(&second));
}

#[test]
fn a_plan_says_where_nodes_would_run_and_why() {
    let engine = with_device(DeviceChoice::Auto, 20.0, false);
    let plan = engine.explain(&nodes(), &ALL).unwrap();
    let place = |name: &str| plan.nodes.iter().find(|entry| entry.node == name).unwrap().placement.clone();
    assert_eq!(place("fixed"), None);
    let (device, why) = place("much").unwrap();
    assert!(device == Device::Gpu && why.contains("5.000 s on CPU threads"), "{why}");
    assert_eq!(place("little").unwrap().0, Device::Cpu);
    assert_eq!(place("unknown").unwrap(), (Device::Gpu, "its work is not known beforehand".to_owned()));
}

fn rounding() -> Graph {
    graph(r#""round": (type: "test.rounding", params: (value: 40))"#, "")
}

#[test]
fn results_that_differ_on_a_device_are_kept_apart_and_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let engine = |choice| {
        let open = || -> Result<Arc<dyn breccia_engine::ComputeDevice>, String> {
            Ok(Arc::new(Pretended { speedup: 20.0, loses: false, lost: AtomicBool::new(false) }))
        };
        let builder = Engine::builder().cache_dir(Some(folder.path().into())).device(choice);
        build(builder.compute(Box::new(open)))
    };
    let run = |choice| run(&engine(choice), &rounding(), &["round.out"]);
    let there = run(DeviceChoice::Gpu);
    assert_eq!((there.number("round.out"), on_device(&there)), (41, vec!["round"]));
    // What is found in the cache is what would be computed.
    let here = run(DeviceChoice::Cpu);
    assert_eq!((here.number("round.out"), here.computed()), (40, vec!["round"]));
    let auto = run(DeviceChoice::Auto);
    assert_eq!((auto.number("round.out"), auto.computed().len()), (40, 0));
    let again = run(DeviceChoice::Gpu);
    assert_eq!((again.number("round.out"), again.computed().len()), (41, 0));
}

#[test]
fn what_the_processor_made_for_a_lost_device_is_not_kept_as_the_devices() {
    let folder = tempfile::tempdir().unwrap();
    let engine = |loses| {
        let open = move || -> Result<Arc<dyn breccia_engine::ComputeDevice>, String> {
            Ok(Arc::new(Pretended { speedup: 20.0, loses, lost: AtomicBool::new(false) }))
        };
        let builder = Engine::builder().cache_dir(Some(folder.path().into())).device(DeviceChoice::Gpu);
        build(builder.compute(Box::new(open)))
    };
    // The device is lost while the node uses it: the key speaks of the device, the processor does the work.
    let lost = run(&engine(true), &rounding(), &["round.out"]);
    assert_eq!(lost.number("round.out"), 40);
    assert_eq!(run(&engine(false), &rounding(), &["round.out"]).number("round.out"), 41);
    let plain = build(Engine::builder().cache_dir(Some(folder.path().into())).device(DeviceChoice::Cpu));
    assert_eq!(run(&plain, &rounding(), &["round.out"]).computed(), ["round"]);
}
