//! The folder of the disk cache.

use std::ffi::OsString;
use std::path::PathBuf;

/// Where results are kept unless `--cache-dir` says otherwise; `None` if the user has no home.
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
