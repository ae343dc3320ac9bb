//! How a long computation hears of cancellation and of a compute device, and reports progress, without knowing who asks.

use breccia_shaders::{Gpu, GpuError};

/// Cancellation and progress of a long computation. `()` never cancels and reports to nobody.
pub trait Control: Sync {
    /// Whether the computation should stop; asked at least every 50 ms of work.
    fn is_cancelled(&self) -> bool {
        false
    }

    /// Reports the fraction done, 0 to 1.
    fn progress(&self, fraction: f32) {
        let _ = fraction;
    }

    /// The compute device that the computation may use, where it has the choice.
    fn gpu(&self) -> Option<&Gpu> {
        None
    }

    /// Hears that the device is gone, and that the computation goes on without it.
    fn device_lost(&self, error: &GpuError) {
        let _ = error;
    }
}

impl Control for () {}

impl Control for breccia_engine::Context<'_> {
    fn is_cancelled(&self) -> bool {
        breccia_engine::Context::is_cancelled(self)
    }
    fn progress(&self, fraction: f32) {
        breccia_engine::Context::progress(self, fraction);
    }
}

/// The computation was cancelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

impl From<Cancelled> for breccia_engine::NodeError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// Stops with [`Cancelled`] if `control` asks for it.
///
/// # Errors
/// [`Cancelled`].
pub fn check(control: &dyn Control) -> Result<(), Cancelled> {
    if control.is_cancelled() { Err(Cancelled) } else { Ok(()) }
}

/// What tests of several families need of a compute device.
#[cfg(test)]
pub(crate) mod testing {
    use std::sync::atomic::{AtomicU32, Ordering};

    use breccia_shaders::{Gpu, GpuError, GpuSettings};

    use super::Control;

    /// Whoever asks for work on a device.
    pub(crate) struct OnDevice {
        pub gpu: Gpu,
        losses: AtomicU32,
    }

    impl OnDevice {
        pub fn open(settings: GpuSettings) -> Option<Self> {
            Some(Self { gpu: breccia_shaders::testing::gpu(settings)?, losses: AtomicU32::new(0) })
        }

        /// How often the device was lost.
        pub fn losses(&self) -> u32 {
            self.losses.load(Ordering::Relaxed)
        }
    }

    impl Control for OnDevice {
        fn gpu(&self) -> Option<&Gpu> {
            Some(&self.gpu)
        }

        fn device_lost(&self, _: &GpuError) {
            self.losses.fetch_add(1, Ordering::Relaxed);
        }
    }
}
