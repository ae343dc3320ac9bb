//! Ctrl-C.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::support::{FAST, Place};

#[cfg(unix)]
#[test]
fn an_interrupted_run_ends_soon_and_leaves_nothing() {
    let place = Place::new();
    let args =
        [&["run", "lazy_volume", "--json", "--set", "size=400"], &FAST[..], &["--output", "volume=v.npy"]];
    let mut child =
        place.command(&args.concat()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let events = child.stdout.take().unwrap();
    for line in std::io::BufRead::lines(std::io::BufReader::new(events)) {
        let event: serde_json::Value = serde_json::from_str(&line.unwrap()).unwrap();
        if event["event"] == "node_started" && event["node"] == "volume" {
            break;
        }
    }
    std::thread::sleep(Duration::from_millis(200));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let start = Instant::now();
    let status = child.wait().unwrap();
    assert!(start.elapsed() < Duration::from_secs(1), "{:?}", start.elapsed());
    assert_eq!(status.code(), Some(130));
    assert_eq!(place.files(), [""; 0]);
}
