//! How the program ends: one code for each sort of failure.

use std::process::ExitCode;

use crate::term;

/// What `--help` says of the exit codes.
pub const HELP: &str = "\
Exit codes:
  0    done
  2    wrong usage: an unknown option, graph, name or value on the command line
  3    the graph is invalid
  4    an input is missing, unreadable or invalid
  5    a node failed
  6    an output cannot be written
  130  cancelled (Ctrl-C)
`edit` ends with the editor's own code, or 2 if there is no editor.";

/// The codes other than 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Code {
    /// The command line is wrong.
    Usage = 2,
    /// The graph is invalid.
    Graph = 3,
    /// An input is missing, unreadable or invalid.
    Input = 4,
    /// A node failed.
    Node = 5,
    /// An output cannot be written.
    Output = 6,
    /// The user stopped it.
    Cancelled = 130,
}

impl From<Code> for ExitCode {
    fn from(code: Code) -> Self {
        Self::from(code as u8)
    }
}

/// Why a command did not do what it should.
#[derive(Debug)]
pub struct Failure {
    /// The sort.
    pub code: Code,
    /// What was found and what was expected; a line for each problem.
    pub message: String,
}

impl Failure {
    /// A failure of this sort.
    pub fn new(code: Code, message: impl Into<String>) -> Self {
        Self { code, message: message.into() }
    }

    /// A wrong command line.
    pub fn usage(message: impl std::fmt::Display) -> Self {
        Self::new(Code::Usage, message.to_string())
    }

    /// Says what went wrong, on the error stream.
    pub fn report(&self) {
        for line in self.message.lines() {
            if self.code == Code::Cancelled {
                term::note(line);
            } else {
                term::note(&format!("error: {line}"));
            }
        }
    }
}

/// ``; did you mean `…`?`` if a known name is close.
pub fn did_you_mean<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    breccia_engine::closest(name, known).map_or(String::new(), |known| format!("; did you mean `{known}`?"))
}
