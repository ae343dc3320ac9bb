//! What runs and what does not, as `--json` tells it.

use crate::support::Place;

/// The nodes that computed.
fn computed(place: &Place, args: &[&str]) -> Vec<String> {
    let answer = place.run("lazy_volume", &[&["--json", "--output", "volume=v.npy"], args].concat());
    answer.expect(0, &[]);
    let finished = answer.events().into_iter().filter(|event| event["event"] == "node_finished");
    finished.map(|event| event["node"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn a_second_run_computes_nothing() {
    let place = Place::new();
    assert!(computed(&place, &["--set", "size=8"]).contains(&"candidates".to_owned()));
    let first = place.read("v.npy");
    std::fs::remove_file(place.path("v.npy")).unwrap();
    assert_eq!(computed(&place, &["--set", "size=8"]), [""; 0]);
    assert_eq!(place.read("v.npy"), first);
}

#[test]
fn a_seed_recomputes_what_depends_on_it() {
    let place = Place::new();
    computed(&place, &["--set", "size=8"]);
    let again = computed(&place, &["--set", "size=8", "--seed", "2"]);
    assert!(again.contains(&"volume".to_owned()) && again.contains(&"synthesis".to_owned()));
    assert!(!again.contains(&"candidates".to_owned()) && !again.contains(&"descriptors".to_owned()));
}

#[test]
fn without_a_cache_everything_runs_again() {
    let place = Place::new();
    let first = computed(&place, &["--set", "size=8", "--no-cache"]);
    assert_eq!(computed(&place, &["--set", "size=8", "--no-cache"]).len(), first.len());
    assert_eq!(place.files(), ["v.npy"]);
}

#[test]
fn explaining_runs_nothing() {
    let place = Place::new();
    let explain = || place.run("lazy_volume", &["--explain", "--set", "size=8", "--output", "volume=v.npy"]);
    let before = explain();
    before.expect(0, &[]);
    assert!(before.stdout.contains("photo        would run"), "{}", before.stdout);
    // 8³ voxels of three bytes, guessed before anything is known.
    let guess = before.stdout.lines().find(|line| line.starts_with("volume")).expect("the node");
    assert!(guess.contains("~ 1.5 kB"), "{guess}");
    assert_eq!(place.files(), [""; 0]);
    computed(&place, &["--set", "size=8"]);
    assert!(explain().stdout.contains("0 nodes would run"), "{}", explain().stdout);
}

#[test]
fn the_cache_can_be_looked_at_verified_and_cleared() {
    let place = Place::new();
    computed(&place, &["--set", "size=8"]);
    assert!(!place.breccia(&["cache", "info"]).stdout.contains("\n0 values"));
    let object = std::fs::read_dir(place.path("cache/breccia/objects")).unwrap().next().unwrap().unwrap();
    let file = std::fs::read_dir(object.path()).unwrap().next().unwrap().unwrap().path();
    std::fs::write(file, "damage").unwrap();
    let verified = place.breccia(&["cache", "verify"]);
    assert!(verified.expect(0, &[]).stdout.contains("removed 1 damaged"), "{}", verified.stdout);
    place.breccia(&["cache", "clear"]).expect(0, &[]);
    assert!(place.breccia(&["cache", "info"]).stdout.contains("\n0 values"));
}
