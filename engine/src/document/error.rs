//! What can be wrong with the text of a document.

/// A document that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DocumentError {
    /// The text is no UTF-8.
    #[error("the document is not UTF-8 text: byte {0} begins no character")]
    Utf8(usize),
    /// The text is no RON, or a field is missing, unknown or of the wrong type.
    #[error("line {line}, column {column}: {message}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong there.
        message: String,
    },
    /// Not a graph document.
    #[error("not a graph document: found {0}, expected format: \"breccia-graph\"")]
    Format(String),
    /// No usable version.
    #[error("found {0}, expected a version from 0 to {max}", max = super::VERSION)]
    Version(String),
    /// Written by a newer program.
    #[error(
        "the document has version {found}, this program reads versions up to {supported}: a newer program is needed"
    )]
    Newer {
        /// The document's version.
        found: u32,
        /// The newest that can be read.
        supported: u32,
    },
    /// An old document that cannot be brought to the current form.
    #[error("the document has version {version}, and cannot be brought to version {current}: {message}", current = super::VERSION)]
    Structure {
        /// The document's version.
        version: u32,
        /// What is wrong.
        message: String,
    },
}

impl DocumentError {
    pub(super) fn syntax(error: ron::error::SpannedError) -> Self {
        Self::Syntax {
            line: error.span.start.line,
            column: error.span.start.col,
            message: error.code.to_string(),
        }
    }
}
