//! `breccia cache`.

use std::path::PathBuf;

use breccia_engine::{DiskCache, DiskInfo};

use crate::exit::{Code, Failure};
use crate::sizes::human;

/// The engine's own limit; looking at a cache never makes room in it.
const LIMIT: u64 = 10 << 30;

/// Look at the disk cache, or clear it.
#[derive(clap::Args)]
pub struct Cache {
    /// What to do
    #[arg(value_enum)]
    action: Action,

    /// Folder of the disk cache [default: breccia in the user's cache folder]
    #[arg(long, value_name = "DIR")]
    cache_dir: Option<PathBuf>,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Action {
    /// Say where it is and what it holds
    Info,
    /// Remove everything in it
    Clear,
    /// Read every file and remove the damaged ones
    Verify,
}

impl Cache {
    /// Does it and says what was found.
    pub fn run(&self) -> Result<(), Failure> {
        let folder = self.cache_dir.clone().or_else(breccia_graphs::default_cache).ok_or_else(|| {
            Failure::usage(
                "there is no cache folder: neither XDG_CACHE_HOME nor HOME is set; give --cache-dir",
            )
        })?;
        let cache = DiskCache::new(folder, LIMIT);
        let place = cache.root().display();
        let failed = |error: std::io::Error| {
            Failure::new(Code::Output, format!("cannot change the cache `{place}`: {error}"))
        };
        let text = match self.action {
            Action::Info => format!("{place}\n{}\nlimit {}\n", holds(&cache.info()), human(cache.limit())),
            Action::Clear => format!("removed from {place}: {}\n", holds(&cache.clear().map_err(failed)?)),
            Action::Verify => {
                let info = cache.verify().map_err(failed)?;
                format!("{place}\n{}\nremoved {} damaged files\n", holds(&info), info.damaged)
            }
        };
        super::answer(&text)
    }
}

fn holds(info: &DiskInfo) -> String {
    format!(
        "{} values ({}), {} records ({})",
        info.objects,
        human(info.object_bytes),
        info.records,
        human(info.record_bytes)
    )
}
