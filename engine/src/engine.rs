//! The engine: node types, caches and threads that runs share.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::cache::{Cache, DiskCache};
use crate::device::{Devices, OpenDevice};
use crate::events::Event;
use crate::files::{FileSource, PlainFiles};
use crate::graph::Graph;
use crate::node::CancelToken;
use crate::registry::Registry;
use crate::run::explain::{Plan, explain};
use crate::run::flight::Flights;
use crate::run::scheduler::{Order, run};
use crate::run::{RunError, RunResult};

/// Where nodes that offer a choice run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DeviceChoice {
    /// On the device where there is one and it pays.
    #[default]
    Auto,
    /// On CPU threads only.
    Cpu,
    /// On the device, which must be there.
    Gpu,
}

/// An engine that cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    /// A device was asked for, and there is none.
    #[error(
        "no compute device is available, expected one for device choice `gpu` ({0}); use `auto` or `cpu`"
    )]
    NoDevice(String),
    /// The threads could not be started.
    #[error("{threads} threads cannot be started: {error}")]
    Threads {
        /// How many were asked for.
        threads: usize,
        /// What went wrong.
        error: rayon::ThreadPoolBuildError,
    },
}

/// Collects the settings of an [`Engine`].
pub struct EngineBuilder {
    threads: usize,
    memory: u64,
    cache_dir: Option<PathBuf>,
    disk_limit: u64,
    files: Arc<dyn FileSource>,
    device: DeviceChoice,
    open_device: Option<OpenDevice>,
    cancel_grace: Duration,
    on_thread_start: Option<Arc<dyn Fn() + Send + Sync>>,
}

impl EngineBuilder {
    /// The number of threads; 0, the default, means one for each processor.
    pub fn threads(mut self, threads: usize) -> Self {
        self.threads = threads;
        self
    }

    /// Bytes of values kept in memory, 2 GiB by default. Values in use count, but stay.
    pub fn memory(mut self, bytes: u64) -> Self {
        self.memory = bytes;
        self
    }

    /// The folder of the disk cache; none by default.
    pub fn cache_dir(mut self, folder: Option<PathBuf>) -> Self {
        self.cache_dir = folder;
        self
    }

    /// Bytes kept in the disk cache; 10 GiB by default.
    pub fn disk_limit(mut self, bytes: u64) -> Self {
        self.disk_limit = bytes;
        self
    }

    /// Where files come from; [`PlainFiles`] by default.
    pub fn files(mut self, files: Arc<dyn FileSource>) -> Self {
        self.files = files;
        self
    }

    /// Where nodes that offer a choice run.
    pub fn device(mut self, device: DeviceChoice) -> Self {
        self.device = device;
        self
    }

    /// How to open the compute device. It is opened when a node could first use it, or at once if it must be there.
    pub fn compute(mut self, open: OpenDevice) -> Self {
        self.open_device = Some(open);
        self
    }

    /// How long a cancelled run waits for its nodes to stop before it leaves them behind; 80 ms by default.
    pub fn cancel_grace(mut self, grace: Duration) -> Self {
        self.cancel_grace = grace;
        self
    }

    /// Something that each thread does first, such as to lower its priority below that of a window.
    pub fn on_thread_start(mut self, start: Arc<dyn Fn() + Send + Sync>) -> Self {
        self.on_thread_start = Some(start);
        self
    }

    /// Starts the threads.
    ///
    /// # Errors
    /// If the threads cannot be started, or a device is asked for and there is none.
    pub fn build(self, registry: Arc<Registry>) -> Result<Engine, EngineError> {
        let devices = Devices::new(self.device, self.open_device);
        if self.device == DeviceChoice::Gpu {
            devices.get().map_err(EngineError::NoDevice)?;
        }
        let start = self.on_thread_start;
        let pool = ThreadPoolBuilder::new()
            .num_threads(self.threads)
            .thread_name(|i| format!("breccia-{i}"))
            .start_handler(move |_| start.iter().for_each(|start| start()))
            .build()
            .map_err(|error| EngineError::Threads { threads: self.threads, error })?;
        let disk = self.cache_dir.map(|root| DiskCache::new(root, self.disk_limit));
        Ok(Engine(Arc::new(Shared {
            registry,
            cache: Cache::new(self.memory, disk),
            flights: Flights::default(),
            files: self.files,
            pool,
            devices,
            cancel_grace: self.cancel_grace,
            slow_stops: Mutex::default(),
        })))
    }
}

/// What all runs share.
pub(crate) struct Shared {
    pub registry: Arc<Registry>,
    pub cache: Cache,
    pub flights: Flights,
    pub files: Arc<dyn FileSource>,
    pool: ThreadPool,
    pub devices: Devices,
    pub cancel_grace: Duration,
    /// Nodes that went on for long after a cancellation, until a run names them.
    slow_stops: Mutex<Vec<String>>,
}

impl Shared {
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    pub fn spawn(&self, task: impl FnOnce() + Send + 'static) {
        self.pool.spawn(task);
    }

    pub fn note_slow_stop(&self, node: &str) {
        self.slow_stops.lock().unwrap_or_else(PoisonError::into_inner).push(node.to_owned());
    }

    pub fn take_slow_stops(&self) -> Vec<String> {
        std::mem::take(&mut *self.slow_stops.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Runs graphs. Any number of runs may go on at the same time; they share caches, threads and
/// computations. Cloning an engine copies a pointer.
#[derive(Clone)]
pub struct Engine(Arc<Shared>);

impl Engine {
    /// The settings to start from.
    pub fn builder() -> EngineBuilder {
        EngineBuilder {
            threads: 0,
            memory: 2 << 30,
            cache_dir: None,
            disk_limit: 10 << 30,
            files: Arc::new(PlainFiles::default()),
            device: DeviceChoice::Auto,
            open_device: None,
            cancel_grace: Duration::from_millis(80),
            on_thread_start: None,
        }
    }

    /// The node types and socket types that it knows.
    pub fn registry(&self) -> &Arc<Registry> {
        &self.0.registry
    }

    /// The number of threads.
    pub fn threads(&self) -> usize {
        self.0.threads()
    }

    /// The disk cache, if there is one.
    pub fn disk_cache(&self) -> Option<&DiskCache> {
        self.0.cache.disk.as_ref()
    }

    /// Number and bytes of the values in memory.
    pub fn memory_usage(&self) -> (usize, u64) {
        self.0.cache.memory_usage()
    }

    /// Keeps values up to another number of bytes in memory from now on. What is too much goes at once, least recently used first;
    /// values in use count, but stay.
    pub fn set_memory(&self, bytes: u64) {
        self.0.cache.set_memory(bytes);
    }

    /// Lets go of everything kept in memory.
    pub fn clear_memory(&self) {
        self.0.cache.clear_memory();
    }

    /// Computes the outputs asked for, by their names in the interface or as `node.socket`. Only what they
    /// need and the caches lack is computed.
    ///
    /// Where a node fails, the outputs that do not depend on it are there all the same: look at
    /// [`RunResult::failures`]. All events come from the calling thread. It must not be one of the
    /// engine's own, so a node must not call this.
    ///
    /// # Errors
    /// If the graph has no such output, or the run was cancelled.
    pub fn run(
        &self,
        graph: &Arc<Graph>,
        outputs: &[&str],
        cancel: &CancelToken,
        on_event: &dyn Fn(&Event),
    ) -> Result<RunResult, RunError> {
        run(&Order { shared: &self.0, graph, outputs, cancel, on_event, checked: false })
    }

    /// Computes everything that the outputs need, whether cached or not, and compares it with the cache; what
    /// is not cached is computed twice. A node that is no pure function of what it declares fails.
    ///
    /// # Errors
    /// If the graph has no such output, or the run was cancelled.
    pub fn run_checked(
        &self,
        graph: &Arc<Graph>,
        outputs: &[&str],
        cancel: &CancelToken,
        on_event: &dyn Fn(&Event),
    ) -> Result<RunResult, RunError> {
        run(&Order { shared: &self.0, graph, outputs, cancel, on_event, checked: true })
    }

    /// What [`Engine::run`] would do now. Reads files, but runs nothing.
    ///
    /// # Errors
    /// If the graph has no such output.
    pub fn explain(&self, graph: &Graph, outputs: &[&str]) -> Result<Plan, RunError> {
        explain(&self.0, graph, outputs)
    }
}
