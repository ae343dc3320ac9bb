//! Several processes on one disk cache: the test binary starts itself.

use std::path::Path;
use std::process::Command;

use breccia_engine::{DiskCache, Engine, Graph};

use crate::support::{build, graph, run};

const FOLDER: &str = "BRECCIA_TEST_CACHE_FOLDER";

fn chain() -> Graph {
    graph(
        r#""a": (type: "test.constant", params: (value: 800)), "b": (type: "test.halve"),
           "c": (type: "test.halve"), "d": (type: "test.halve"), "e": (type: "test.halve")"#,
        r#""a.out -> b.in", "b.out -> c.in", "c.out -> d.in", "d.out -> e.in""#,
    )
}

fn compute(folder: &Path) -> usize {
    let engine = build(Engine::builder().cache_dir(Some(folder.into())));
    let trace = run(&engine, &chain(), &["e.out"]);
    assert_eq!((trace.number("e.out"), trace.warnings()), (50, vec![]));
    trace.computed().len()
}

/// What the processes started below do; does nothing otherwise.
#[test]
fn child() {
    if let Some(folder) = std::env::var_os(FOLDER) {
        compute(Path::new(&folder));
    }
}

#[test]
fn processes_share_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    let binary = std::env::current_exe().unwrap();
    let children: Vec<_> = (0..4)
        .map(|_| {
            let mut command = Command::new(&binary);
            command.args(["processes::child", "--exact"]).env(FOLDER, folder.path());
            command.stdout(std::process::Stdio::null()).spawn().unwrap()
        })
        .collect();
    for mut child in children {
        assert!(child.wait().unwrap().success());
    }
    assert_eq!(DiskCache::new(folder.path(), 1 << 20).verify().unwrap().damaged, 0);
    assert_eq!(compute(folder.path()), 0);
}
