//! `breccia edit`.

use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus};

use crate::exit::{Code, Failure};
use crate::graphs;

/// The program that shows graphs.
const EDITOR: &str = "breccia-editor";

/// Open the visual editor, which ends with an exit code of its own.
///
/// The editor is the program `breccia-editor`, found beside this one or else on PATH.
#[derive(clap::Args)]
pub struct Edit {
    /// A graph document, or the name of a preset; without it the editor shows what there is
    graph: Option<PathBuf>,
}

impl Edit {
    /// Starts the editor, waits for it, and ends as it ends.
    pub fn run(&self) -> Result<(), Failure> {
        if let Some(graph) = &self.graph {
            let is_preset = graph.to_str().and_then(breccia_graphs::preset).is_some();
            if !is_preset && !graph.exists() {
                return Err(graphs::unknown(&graph.to_string_lossy()));
            }
        }
        let status = start(self.graph.as_deref()).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => Failure::usage(format!(
                "found no program `{EDITOR}` beside this one or on PATH; `cargo install --path editor` installs it, \
                 and in the sources `cargo run --release -p {EDITOR}` starts it"
            )),
            _ => Failure::usage(format!("cannot start `{EDITOR}`: {error}")),
        })?;
        match code(status) {
            0 => Ok(()),
            code => std::process::exit(code),
        }
    }
}

fn start(graph: Option<&Path>) -> io::Result<ExitStatus> {
    let name = format!("{EDITOR}{}", std::env::consts::EXE_SUFFIX);
    let beside = std::env::current_exe().ok().and_then(|own| own.parent().map(|folder| folder.join(&name)));
    let program = beside.filter(|path| path.is_file()).unwrap_or_else(|| PathBuf::from(name));
    let mut command = Command::new(program);
    if let Some(graph) = graph {
        // A file whose name looks like an option stays a file.
        command.arg("--").arg(graph);
    }
    command.status()
}

/// The code that a program ended with; for one that a signal ended, the one that shells give it.
fn code(status: ExitStatus) -> i32 {
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        return 128 + signal;
    }
    status.code().unwrap_or(Code::Node as i32)
}
