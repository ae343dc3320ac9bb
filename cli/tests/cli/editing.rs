//! `breccia edit`, with scripts in place of the editor.
#![cfg(unix)]

use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use crate::support::{Answer, Place, text};

/// A script that says by which name it was started, and with what.
fn editor(place: &Place, folder: &str, code: &str) {
    std::fs::create_dir_all(place.path(folder)).unwrap();
    let script = format!("#!/bin/sh\necho \"{folder} $*\"\n{code}\n");
    let path = place.write(&format!("{folder}/breccia-editor"), script);
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
}

/// Runs a copy of the program in a folder of its own, so that no editor lies beside it unless a test puts it there.
fn edit(place: &Place, args: &[&str]) -> Answer {
    let program = place.path("bin/breccia");
    std::fs::create_dir_all(place.path("bin")).unwrap();
    if !program.exists() {
        let built = Path::new(env!("CARGO_BIN_EXE_breccia"));
        std::fs::hard_link(built, &program).or_else(|_| std::fs::copy(built, &program).map(drop)).unwrap();
    }
    let mut command = std::process::Command::new(program);
    let path = format!("{}:/usr/bin:/bin", text(&place.path("path")));
    command.arg("edit").args(args).current_dir(place.path("")).env("PATH", path);
    Answer::from(command.output().unwrap())
}

#[test]
fn the_editor_is_found_on_path_and_gets_the_graph() {
    let place = Place::new();
    editor(&place, "path", "");
    assert_eq!(edit(&place, &[]).expect(0, &[]).stdout, "path \n");
    assert_eq!(edit(&place, &["lazy_mesh"]).expect(0, &[]).stdout, "path -- lazy_mesh\n");
    place.write("my graph.ron", "");
    assert_eq!(edit(&place, &["my graph.ron"]).expect(0, &[]).stdout, "path -- my graph.ron\n");
}

#[test]
fn the_editor_beside_the_program_comes_first() {
    let place = Place::new();
    editor(&place, "path", "");
    editor(&place, "bin", "");
    assert_eq!(edit(&place, &[]).expect(0, &[]).stdout, "bin \n");
}

#[test]
fn the_exit_code_is_the_editors() {
    let place = Place::new();
    editor(&place, "path", "exit 42");
    edit(&place, &[]).expect(42, &[]);
    editor(&place, "path", "kill -TERM $$");
    edit(&place, &[]).expect(143, &[]);
}

#[test]
fn without_an_editor_there_is_advice() {
    edit(&Place::new(), &[])
        .expect(2, &["cargo install --path editor", "cargo run --release -p breccia-editor"]);
}

#[test]
fn a_graph_that_is_not_there_is_not_opened() {
    let place = Place::new();
    editor(&place, "path", "");
    let answer = edit(&place, &["lazy_mash"]);
    assert_eq!(answer.expect(2, &["did you mean `lazy_mesh`?"]).stdout, "");
}
