//! How a long computation hears of cancellation and of a compute device, and reports progress, without knowing who asks.

use breccia_shaders::{Gpu, GpuError};

use crate::device::GpuDevice;

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
    fn gpu(&self) -> Option<&Gpu> {
        self.device()?.as_any().downcast_ref::<GpuDevice>().map(|device| &device.0)
    }
    fn device_lost(&self, error: &GpuError) {
        self.warn(format!("{error}; the work goes on with CPU threads"));
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
