//! Starting: settings, threads, the device that window and engine share.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use breccia_engine::EngineError;
use breccia_nodes::device::{AdapterKind, Gpu, GpuSettings};
use eframe::egui_wgpu::RenderState;
use thread_priority::{ThreadPriority, ThreadPriorityValue, set_current_thread_priority};

/// How the application runs.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Number of threads that compute; 0 means one for each processor.
    pub threads: usize,
    /// Bytes of memory that the program may take; results that are kept give way to what else needs it.
    pub memory: u64,
    /// Bytes of the device's memory that may be used.
    pub device_memory: u64,
    /// The folder of the disk cache, shared with the command line.
    pub cache: Option<PathBuf>,
    /// The folder for what is remembered: recent files, recovery, own groups.
    pub state: Option<PathBuf>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            threads: 0,
            memory: 2 << 30,
            device_memory: 1 << 30,
            cache: breccia_graphs::default_cache(),
            state: breccia_graphs::default_state(),
        }
    }
}

/// Why the application cannot start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// The engine cannot.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// The system gives no thread.
    #[error("cannot start a thread: {0}")]
    Thread(#[from] std::io::Error),
}

/// The window's device, for computing too. Portions are short, since the window waits for them.
pub(super) fn share(render: &RenderState, settings: &Settings) -> Arc<Gpu> {
    let settings = GpuSettings {
        memory: settings.device_memory,
        submission: Duration::from_millis(8),
        ..GpuSettings::default()
    };
    breccia_shaders::keep_driver(&render.instance);
    Arc::new(Gpu::from_window(&render.adapter, render.device.clone(), render.queue.clone(), settings))
}

/// Whether a device computes faster than the processor; adapters in software do not.
pub(super) fn is_fast(gpu: &Gpu) -> bool {
    gpu.report().kind != AdapterKind::Software
}

/// How much threads that compute give way, from 0 (to everything) to 99 (to nothing): on Linux a niceness of 5. Enough for the window
/// to come first, and not so much that other programs leave nothing over.
const PRIORITY: u8 = 35;

/// Threads that compute give way to the one that draws.
pub fn yield_to_the_window() {
    let Ok(value) = ThreadPriorityValue::try_from(PRIORITY) else { return };
    // Where the system does not allow it they compete as equals, which is slower to look at and nothing worse.
    let _ = set_current_thread_priority(ThreadPriority::Crossplatform(value));
}
