//! Reading what the editor remembers from one start to the next.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// The largest file of the state folder that is read, in bytes.
const LIMIT: u64 = 64 << 20;

/// Reads a text of moderate size.
pub(super) fn read_text(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    let file = File::open(path)?;
    if !file.metadata()?.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is no file"));
    }
    let read = file.take(LIMIT + 1).read_to_string(&mut text)?;
    if read as u64 > LIMIT {
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, format!("it has more than {LIMIT} bytes")));
    }
    Ok(text)
}
