//! The disk cache: what survives a process, and what damage does.

use std::fs;
use std::path::{Path, PathBuf};

use breccia_engine::{CacheLevel, DiskCache, Engine, Graph};

use crate::support::{build, graph, run, sum};

const NOTHING: [&str; 0] = [];

/// An engine as a new process would have it.
fn fresh(folder: &Path) -> Engine {
    build(Engine::builder().cache_dir(Some(folder.into())))
}

fn files(folder: &Path, kind: &str) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for sub in fs::read_dir(folder.join(kind)).into_iter().flatten().flatten() {
        files.extend(fs::read_dir(sub.path()).unwrap().map(|file| file.unwrap().path()));
    }
    files.sort();
    files
}

/// A constant, wrapped into a type that stays in memory, unwrapped, halved.
fn with_opaque() -> Graph {
    graph(
        r#""a": (type: "test.constant", params: (value: 12)), "wrap": (type: "test.wrap"),
           "unwrap": (type: "test.unwrap"), "half": (type: "test.halve")"#,
        r#""a.out -> wrap.in", "wrap.out -> unwrap.in", "unwrap.out -> half.in""#,
    )
}

#[test]
fn a_new_process_reads_the_final_value_only() {
    let folder = tempfile::tempdir().unwrap();
    run(&fresh(folder.path()), &with_opaque(), &["half.out"]);
    let trace = run(&fresh(folder.path()), &with_opaque(), &["half.out"]);
    assert_eq!(trace.computed(), NOTHING);
    assert_eq!(trace.cached(CacheLevel::Disk), ["half"]);
    assert_eq!(trace.cached(CacheLevel::Digest), ["a", "unwrap", "wrap"]);
    assert_eq!(trace.number("half.out"), 6);
}

#[test]
fn a_value_that_stays_in_memory_is_made_again_when_it_is_needed() {
    let folder = tempfile::tempdir().unwrap();
    run(&fresh(folder.path()), &with_opaque(), &["half.out"]);
    let trace = run(&fresh(folder.path()), &with_opaque(), &["wrap.out"]);
    assert_eq!(trace.computed(), ["wrap"]);
    assert_eq!(trace.cached(CacheLevel::Disk), ["a"]);
}

fn damaged_files_are_made_again(damage: impl Fn(&Path)) {
    for kind in ["objects", "records"] {
        let folder = tempfile::tempdir().unwrap();
        run(&fresh(folder.path()), &sum(), &["half.out"]);
        let before = files(folder.path(), kind);
        assert_eq!(before.len(), 4, "{kind}");
        before.iter().for_each(|file| damage(file));
        let trace = run(&fresh(folder.path()), &sum(), &["half.out"]);
        assert_eq!(trace.number("half.out"), 4);
        assert_eq!(trace.computed(), ["a", "add", "b", "half"], "{kind}");
        assert!(trace.warnings().iter().any(|w| w.contains("damaged")), "{:?}", trace.warnings());
        // And now all is well again.
        let trace = run(&fresh(folder.path()), &sum(), &["half.out"]);
        assert_eq!((trace.computed(), trace.warnings()), (vec![], vec![]), "{kind}");
    }
}

#[test]
fn corrupted_files_are_made_again() {
    damaged_files_are_made_again(|path| {
        let mut bytes = fs::read(path).unwrap();
        *bytes.last_mut().unwrap() ^= 0x40;
        fs::write(path, bytes).unwrap();
    });
}

#[test]
fn truncated_files_are_made_again() {
    damaged_files_are_made_again(|path| {
        let bytes = fs::read(path).unwrap();
        fs::write(path, &bytes[..bytes.len() - 3]).unwrap();
    });
}

#[test]
fn empty_files_are_made_again() {
    damaged_files_are_made_again(|path| fs::write(path, "").unwrap());
}

#[test]
fn two_engines_share_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    let (one, other) = (fresh(folder.path()), fresh(folder.path()));
    assert_eq!(run(&one, &sum(), &["add.sum"]).computed(), ["a", "add", "b"]);
    assert_eq!(run(&other, &sum(), &["half.out"]).computed(), ["half"]);
    assert_eq!(run(&one, &sum(), &["half.out"]).cached(CacheLevel::Disk), ["half"]);
}

#[test]
fn failures_are_not_kept() {
    let folder = tempfile::tempdir().unwrap();
    let graph = graph(r#""f": (type: "test.fail")"#, "");
    for _ in 0..2 {
        assert_eq!(run(&fresh(folder.path()), &graph, &["f.out"]).failed(), ["f"]);
    }
    assert_eq!(DiskCache::new(folder.path(), 0).info().bytes(), 0);
}

#[test]
fn an_unwritable_folder_is_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "no folder").unwrap();
    let trace = run(&fresh(&file.join("cache")), &sum(), &["half.out"]);
    assert_eq!(trace.number("half.out"), 4);
    let warnings = trace.warnings();
    assert!(warnings.len() == 1 && warnings[0].contains("cannot be written"), "{warnings:?}");
}

#[test]
fn the_least_recently_used_files_go_first() {
    let folder = tempfile::tempdir().unwrap();
    let graph_of =
        |value: i64| graph(&format!(r#""a": (type: "test.constant", params: (value: {value}))"#), "");
    let entry = {
        run(&fresh(folder.path()), &graph_of(1), &["a.out"]);
        DiskCache::new(folder.path(), 0).info().bytes()
    };
    // Room for about four results. What is used again stays.
    let limit = entry * 4;
    for value in 2..=10 {
        std::thread::sleep(std::time::Duration::from_millis(5));
        let engine = build(Engine::builder().cache_dir(Some(folder.path().into())).disk_limit(limit));
        run(&engine, &graph_of(1), &["a.out"]);
        run(&engine, &graph_of(value), &["a.out"]);
    }
    assert!(DiskCache::new(folder.path(), limit).info().bytes() <= limit);
    let trace = |value| run(&fresh(folder.path()), &graph_of(value), &["a.out"]).computed().len();
    assert_eq!((trace(1), trace(10), trace(2)), (0, 0, 1));
}

#[test]
fn verify_removes_what_is_damaged_and_clear_removes_all() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("mine.txt"), "not the cache's").unwrap();
    run(&fresh(folder.path()), &sum(), &["half.out"]);
    let cache = DiskCache::new(folder.path(), 1 << 20);
    let whole = cache.verify().unwrap();
    assert_eq!((whole.objects, whole.records, whole.damaged), (4, 4, 0));
    assert_eq!(cache.info(), whole);
    fs::write(&files(folder.path(), "objects")[1], "junk").unwrap();
    let damaged = cache.verify().unwrap();
    assert_eq!((damaged.objects, damaged.records, damaged.damaged), (3, 4, 1));
    assert_eq!(cache.clear().unwrap().objects, 3);
    assert_eq!(cache.info().bytes(), 0);
    assert!(folder.path().join("mine.txt").exists());
    assert_eq!(DiskCache::new(folder.path().join("none"), 0).verify().unwrap().bytes(), 0);
}

#[test]
fn a_second_run_of_a_long_chain_takes_milliseconds() {
    let folder = tempfile::tempdir().unwrap();
    let links: String = (1..40).map(|i| format!(r#""n{}.out -> n{i}.in","#, i - 1)).collect();
    let nodes: String =
        (1..40).map(|i| format!(r#""n{i}": (type: "test.slow", params: (millis: 1)),"#)).collect();
    let graph = graph(&format!(r#""n0": (type: "test.constant", params: (value: 9)), {nodes}"#), &links);
    run(&fresh(folder.path()), &graph, &["n39.out"]);
    let engine = fresh(folder.path());
    let start = std::time::Instant::now();
    assert_eq!(run(&engine, &graph, &["n39.out"]).computed(), NOTHING);
    assert!(start.elapsed() < std::time::Duration::from_millis(100), "{:?}", start.elapsed());
}
