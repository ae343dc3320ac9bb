//! Bad command lines and graphs.

use crate::support::Place;

#[test]
fn an_unknown_preset_gets_a_suggestion() {
    let answer = Place::new().run("lazy_mash", &[]);
    answer.expect(2, &["`lazy_mash` is neither a file nor a preset; did you mean `lazy_mesh`?"]);
}

#[test]
fn a_typo_in_a_graph_is_shown_with_its_line() {
    let place = Place::new();
    place.write("typo.ron", "(\n    format: \"breccia-graph\",\n    version: 1,\n    nodes {},\n)");
    place.run("typo.ron", &[]).expect(3, &["typo.ron: line 4"]);
}

#[test]
fn a_graph_of_a_newer_version_is_refused() {
    let place = Place::new();
    place.write("new.ron", "(format: \"breccia-graph\", version: 99, nodes: {})");
    place.run("new.ron", &[]).expect(3, &["version 99", "newer"]);
}

#[test]
fn all_problems_of_a_graph_are_listed() {
    let place = Place::new();
    place.write(
        "wrong.ron",
        r#"(format: "breccia-graph", version: 1, nodes: {
            "a": (type: "lazy.piramid"),
            "b": (type: "render.cube", params: {"corner": 7.0}),
        }, links: ["b.image -> c.image"])"#,
    );
    let answer = place.breccia(&["check", "wrong.ron", "lazy_mesh"]);
    answer.expect(3, &["`lazy.pyramid`", "found 7.0", "`c`", "input `solid`"]);
    assert_eq!(answer.stdout, "lazy_mesh: valid, 14 nodes\n");
}

#[test]
fn unknown_names_get_suggestions() {
    let place = Place::new();
    let usage = |args: &[&str], message: &str| {
        place.run("lazy_volume", args).expect(2, &[message]);
    };
    usage(&["--set", "sized=3"], "did you mean `size`?");
    usage(&["--set", "jiter.amount=0.1"], "did you mean `jitter`?");
    usage(&["--set", "jitter.amont=0.1"], "did you mean `amount`?");
    usage(&["--set", "synthesis.color=means"], "did you mean `mean`?");
    usage(&["--input", "exampler=a.png"], "did you mean `exemplar`?");
    usage(&["--output", "volum=v.npy"], "did you mean `volume`?");
}

#[test]
fn values_out_of_range_say_what_is_expected() {
    let place = Place::new();
    let answer = place.run("lazy_volume", &["--set", "size=0", "--set", "jitter.amount=2", "--seed", "-1"]);
    answer.expect(2, &["found 0", "from 1 to 65536", "found 2, expected a number from 0 to 1", "found -1"]);
}

#[test]
fn unknown_formats_say_what_there_is() {
    let place = Place::new();
    let format = |output: &str, message: &str| {
        place.run("lazy_volume", &["--output", output]).expect(2, &[message]);
    };
    format("volume=v.jpg", "found the extension `jpg` in `v.jpg`, expected one of npy");
    format("volume=v", "found no extension");
    format("preview=p/", "found a folder");
    format("synthesis.solid=s.npy", "cannot be written to files");
}

#[test]
fn outputs_that_cannot_be_written_are_found_before_running() {
    let place = Place::new();
    place.write("file", "");
    std::fs::create_dir(place.path("folder.npy")).unwrap();
    for output in ["volume=file/v.npy", "volume=folder.npy"] {
        let answer = place.run("lazy_volume", &["--json", "--output", output]);
        answer.expect(6, &["output `volume`: cannot write"]);
        assert_eq!(answer.stdout, "");
    }
}

#[test]
fn two_outputs_cannot_share_a_file() {
    let answer = Place::new().run("lazy_volume", &["--output", "preview=a.png", "--output", "sheet=a.png"]);
    answer.expect(2, &["would both go to `a.png`"]);
}

#[test]
fn a_volume_larger_than_memory_is_refused_by_name() {
    let place = Place::new();
    let answer = place.run("lazy_volume", &["--set", "size=60000", "--output", "volume=v.npy"]);
    answer.expect(5, &["node `volume`", "60000"]);
    assert_eq!(place.files(), [""; 0]);
}

#[test]
fn sizes_of_memory_are_checked() {
    Place::new().run("lazy_volume", &["--memory", "much"]).expect(2, &["512M"]);
}
