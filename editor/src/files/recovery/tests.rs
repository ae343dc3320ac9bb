use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Command, Stdio};

use super::*;

fn copy(text: &str) -> Snapshot {
    let time = SystemTime::UNIX_EPOCH + Duration::from_millis(1_234_567_890_123);
    Snapshot::new(Some(Path::new("/some/graph.ron")), "A \"graph\"", time, text.to_owned())
}

fn titles(folder: &Path) -> Vec<String> {
    leftovers(folder).unwrap().leftovers.iter().map(|left| left.copy.text.clone()).collect()
}

/// The names in the folder, but for that of its own lock.
fn names(folder: &Path) -> Vec<String> {
    let entries =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    entries.filter(|name| name != "guard").collect()
}

#[test]
fn copies_are_kept_now_and_then() {
    let folder = tempfile::tempdir().unwrap();
    let start = Instant::now();
    let mut recovery = Recovery::new(folder.path()).unwrap();
    assert!(recovery.keep(start, &copy("one")).unwrap());
    let soon = start + EVERY / 2;
    assert!(!recovery.is_due(soon));
    assert!(!recovery.keep(soon, &copy("two")).unwrap());
    let later = start + EVERY;
    assert!(recovery.keep(later, &copy("three")).unwrap());
    assert!(!recovery.keep(later + EVERY, &copy("three")).unwrap(), "it is kept already");
    // Dropped without being closed, as after a panic.
    drop(recovery);
    let found = leftovers(folder.path()).unwrap();
    assert_eq!(found.leftovers.len(), 1);
    assert_eq!(found.leftovers[0].copy, copy("three"));
}

#[test]
fn nothing_is_left_after_a_save_or_an_orderly_end() {
    let folder = tempfile::tempdir().unwrap();
    let now = Instant::now();
    let mut recovery = Recovery::new(folder.path()).unwrap();
    recovery.keep(now, &copy("one")).unwrap();
    recovery.clear().unwrap();
    recovery.clear().unwrap();
    assert!(recovery.keep(now, &copy("one")).unwrap(), "the next change is kept at once");
    recovery.close().unwrap();
    assert_eq!(names(folder.path()), [""; 0]);
    drop(Recovery::new(folder.path()).unwrap());
    assert_eq!(titles(folder.path()), [""; 0]);
    assert_eq!(names(folder.path()), [""; 0], "the lock of a process that left nothing goes too");
}

#[test]
fn what_lives_is_not_offered() {
    let folder = tempfile::tempdir().unwrap();
    let mut first = Recovery::new(folder.path()).unwrap();
    let mut second = Recovery::new(folder.path()).unwrap();
    first.keep(Instant::now(), &copy("first")).unwrap();
    second.keep(Instant::now(), &copy("second")).unwrap();
    assert_eq!(titles(folder.path()), [""; 0]);
    drop(first);
    let offered = leftovers(folder.path()).unwrap().leftovers;
    assert_eq!(offered.len(), 1);
    assert_eq!(titles(folder.path()), [""; 0], "it is offered to one alone");
    drop(offered);
    assert_eq!(titles(folder.path()), ["first"], "and again if nobody wanted it");
    for leftover in leftovers(folder.path()).unwrap().leftovers {
        leftover.discard().unwrap();
    }
    assert_eq!(titles(folder.path()), [""; 0]);
    second.close().unwrap();
    assert_eq!(names(folder.path()), [""; 0]);
}

#[test]
fn damaged_copies_are_told_of_once() {
    let folder = tempfile::tempdir().unwrap();
    let whole = ron::to_string(&copy("whole")).unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("1-0.ron"), &whole).unwrap();
    std::fs::write(path("2-0.ron"), &whole[..whole.len() / 2]).unwrap();
    std::fs::write(path("3-0.ron"), b"\xff\xfe").unwrap();
    std::fs::write(path("4-0.ron"), whole.replace("version:1", "version:7")).unwrap();
    std::fs::create_dir(path("5-0.ron")).unwrap();
    let found = leftovers(folder.path()).unwrap();
    assert_eq!(found.leftovers.len(), 1);
    assert_eq!(found.messages.len(), 4, "{:?}", found.messages);
    assert!(found.messages.iter().any(|text| text.contains("`breccia-recovery` 7, expected")));
    drop(found);
    let found = leftovers(folder.path()).unwrap();
    assert_eq!((found.leftovers.len(), found.messages.len()), (1, 0));
    assert!(path("2-0.damaged").exists(), "nothing is thrown away");
}

#[test]
fn the_newest_comes_first() {
    let folder = tempfile::tempdir().unwrap();
    for (name, seconds) in [("1-0.ron", 1), ("2-0.ron", 3), ("3-0.ron", 2)] {
        let copy = Snapshot { time: SystemTime::UNIX_EPOCH + Duration::from_secs(seconds), ..copy(name) };
        std::fs::write(folder.path().join(name), ron::to_string(&copy).unwrap()).unwrap();
    }
    assert_eq!(titles(folder.path()), ["2-0.ron", "3-0.ron", "1-0.ron"]);
    assert_eq!(titles(&folder.path().join("not there")), [""; 0]);
}

/// Set for the process that is to be killed: where it keeps its copy.
const CHILD: &str = "BRECCIA_TEST_RECOVERY";

#[test]
fn a_killed_process_leaves_its_copy() {
    if let Some(folder) = std::env::var_os(CHILD) {
        let mut recovery = Recovery::new(Path::new(&folder)).unwrap();
        recovery.keep(Instant::now(), &copy("unsaved")).unwrap();
        io::stdout().write_all(b"\nkept\n").unwrap();
        // Until it is killed, or its parent is gone.
        let _ = io::stdin().read(&mut [0]);
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (_, module) = module_path!().split_once("::").unwrap();
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "--nocapture", &format!("{module}::a_killed_process_leaves_its_copy")])
        .env(CHILD, folder.path())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(lines.any(|line| line.unwrap() == "kept"), "the process ended before it kept anything");
    assert_eq!(titles(folder.path()), [""; 0], "it lives");
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(titles(folder.path()), ["unsaved"]);
}
