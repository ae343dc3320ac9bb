//! Folders of the user.

use std::ffi::OsString;
use std::path::PathBuf;

/// Where results are kept unless somebody says otherwise; `None` if the user has no home.
pub fn default_cache() -> Option<PathBuf> {
    let folder =
        |name: &str| std::env::var_os(name).filter(|value: &OsString| !value.is_empty()).map(PathBuf::from);
    let base = match folder("XDG_CACHE_HOME").filter(|path| path.is_absolute()) {
        Some(base) => Some(base),
        None if cfg!(windows) => folder("LOCALAPPDATA"),
        None if cfg!(target_os = "macos") => folder("HOME").map(|home| home.join("Library/Caches")),
        None => folder("HOME").map(|home| home.join(".cache")),
    };
    base.map(|base| base.join("breccia"))
}

/// Where what a program remembers from one run to the next is kept; `None` if the user has no home.
pub fn default_state() -> Option<PathBuf> {
    let folder =
        |name: &str| std::env::var_os(name).filter(|value: &OsString| !value.is_empty()).map(PathBuf::from);
    let base = match folder("XDG_STATE_HOME").filter(|path| path.is_absolute()) {
        Some(base) => Some(base),
        None if cfg!(windows) => folder("LOCALAPPDATA"),
        None if cfg!(target_os = "macos") => {
            folder("HOME").map(|home| home.join("Library/Application Support"))
        }
        None => folder("HOME").map(|home| home.join(".local/state")),
    };
    base.map(|base| base.join("breccia"))
}
