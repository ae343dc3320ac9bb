//! What the binary says of itself.

use std::io::Read;
use std::process::Stdio;

use crate::support::Place;

#[test]
fn presets_are_described_with_all_that_they_expose() {
    let place = Place::new();
    let list = place.breccia(&["presets"]).stdout;
    for preset in [
        "lazy_volume",
        "lazy_mesh",
        "lazy_slice",
        "pbr_mesh",
        "wood_views",
        "cut_mesh",
        "compare_volume",
        "optimize_volume",
        "optimize_painted",
        "optimize_ablations",
        "kopf_volume",
        "particles_volume",
        "hybrid_mesh",
        "hybrid_slice",
        "brick_wall",
        "recolour",
        "bent_bar",
    ] {
        assert!(list.contains(preset), "{list}");
        let text = place.breccia(&["presets", preset]).stdout;
        for part in ["Inputs", "Parameters", "Outputs", "  seed = 1 (", "  preview (image:", "Example"] {
            assert!(text.contains(part), "{part} is missing in:\n{text}");
        }
    }
    place.breccia(&["presets", "wood_view"]).expect(2, &["did you mean `wood_views`?"]);
}

#[test]
fn nodes_are_described_in_three_ways() {
    let place = Place::new();
    assert!(place.breccia(&["nodes"]).stdout.contains("lazy.jitter"));
    assert!(place.breccia(&["nodes", "lazy.jitter"]).stdout.contains("amount = 0.1"));
    assert!(place.breccia(&["nodes", "lazy.jitter", "--markdown"]).stdout.starts_with("## `lazy.jitter`"));
    let json = place.breccia(&["nodes", "lazy.jitter", "--json"]).stdout;
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["params"][0]["name"], "amount");
    place.breccia(&["nodes", "lazy.jiter"]).expect(2, &["did you mean `lazy.jitter`?"]);
}

#[test]
fn the_committed_node_reference_is_current() {
    let reference = Place::new().breccia(&["nodes", "--markdown"]).stdout;
    let committed =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/nodes.md")).unwrap();
    assert!(
        reference == committed.replace("\r\n", "\n"),
        "docs/nodes.md is out of date: breccia nodes --markdown > docs/nodes.md"
    );
}

#[test]
fn help_tells_the_exit_codes() {
    let help = Place::new().breccia(&["run", "--help"]).stdout;
    for code in ["0 ", "2 ", "3 ", "4 ", "5 ", "6 ", "130 "] {
        assert!(help.contains(&format!("\n  {code}")), "{help}");
    }
}

#[test]
fn completions_and_manual_are_made() {
    let place = Place::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        assert!(place.breccia(&["completions", shell]).stdout.contains("out-dir"), "{shell}");
    }
    let manual = place.breccia(&["man"]).stdout;
    assert!(manual.contains(".TH") && manual.contains("explain"), "{manual}");
}

#[test]
fn a_reader_that_leaves_early_is_no_error() {
    let place = Place::new();
    let mut child = place
        .command(&["nodes", "--markdown"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let mut stderr = String::new();
    child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
    assert_eq!((child.wait().unwrap().code(), stderr.as_str()), (Some(0), ""));
}
