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

    /// The compute device for work in floats, whose answers may differ in rounding from the processor's; only where the caller
    /// keeps them apart.
    fn gpu_for_floats(&self) -> Option<&Gpu> {
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
    fn gpu_for_floats(&self) -> Option<&Gpu> {
        self.device_for_floats()?.as_any().downcast_ref::<GpuDevice>().map(|device| &device.0)
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

/// Why a computation that may use a compute device stopped.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Stopped {
    /// The computation was cancelled.
    #[error("cancelled")]
    Cancelled,
    /// The compute device could not do it.
    #[error(transparent)]
    Device(GpuError),
}

impl From<Cancelled> for Stopped {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<GpuError> for Stopped {
    fn from(error: GpuError) -> Self {
        match error {
            GpuError::Cancelled => Self::Cancelled,
            other => Self::Device(other),
        }
    }
}

impl From<Stopped> for breccia_engine::NodeError {
    fn from(stopped: Stopped) -> Self {
        match stopped {
            Stopped::Cancelled => Self::Cancelled,
            other => Self::failed(other),
        }
    }
}

/// What `work` makes on the compute device; `None` if there is none, or it is lost half-way, of which `control` hears: then the
/// work is the processor's.
///
/// # Errors
/// [`Stopped`], if the work was cancelled or the device refuses it.
pub(crate) fn on_device<T>(
    control: &dyn Control,
    work: impl FnOnce(&Gpu) -> Result<T, GpuError>,
) -> Result<Option<T>, Stopped> {
    on_this_device(control.gpu(), control, work)
}

/// As [`on_device`], for work in floats: only where the caller keeps the answers of the device and of the processor apart.
///
/// # Errors
/// As [`on_device`].
pub(crate) fn on_device_in_floats<T>(
    control: &dyn Control,
    work: impl FnOnce(&Gpu) -> Result<T, GpuError>,
) -> Result<Option<T>, Stopped> {
    on_this_device(control.gpu_for_floats(), control, work)
}

fn on_this_device<T>(
    gpu: Option<&Gpu>,
    control: &dyn Control,
    work: impl FnOnce(&Gpu) -> Result<T, GpuError>,
) -> Result<Option<T>, Stopped> {
    let Some(gpu) = gpu else { return Ok(None) };
    match gpu.scope(|| work(gpu)) {
        Ok(made) => Ok(Some(made)),
        Err(error @ GpuError::Lost(_)) => {
            control.device_lost(&error);
            Ok(None)
        }
        Err(error) => Err(error.into()),
    }
}

/// Callers that have a device, for tests.
#[cfg(test)]
pub(crate) mod testing {
    use std::sync::atomic::{AtomicU32, Ordering};

    use breccia_shaders::{Gpu, GpuError, GpuSettings, Kernel, testing};
    use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

    use super::Control;

    /// Whoever asks for work on a device.
    pub struct OnDevice {
        pub gpu: Gpu,
        /// Whether it may be used for floats.
        floats: bool,
        losses: AtomicU32,
        /// Questions that are answered before the work is cancelled.
        patience: AtomicU32,
    }

    impl OnDevice {
        /// On the device that tests run on; `None` if there is none and the test is to be skipped.
        pub fn open(settings: GpuSettings) -> Option<Self> {
            let gpu = testing::gpu(settings)?;
            let patience = AtomicU32::new(u32::MAX);
            Some(Self { gpu, floats: false, losses: AtomicU32::new(0), patience })
        }

        /// The same with a mistake in a kernel: `wrong` where its text has `right`.
        pub fn mistaken(kernel: &Kernel, right: &str, wrong: &str) -> Option<Self> {
            let text = kernel.source.replace(right, wrong);
            assert_ne!(text, kernel.source, "the mistake in {} has no place", kernel.name);
            Self::open(GpuSettings { texts: [(kernel.name, text)].into(), ..Default::default() })
        }

        /// The same, also where answers differ in rounding.
        pub fn in_floats(self) -> Self {
            Self { floats: true, ..self }
        }

        /// The same, cancelling after so many questions whether it does.
        pub fn patient(self, questions: u32) -> Self {
            self.patience.store(questions, Ordering::Relaxed);
            self
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

        fn gpu_for_floats(&self) -> Option<&Gpu> {
            self.floats.then_some(&self.gpu)
        }

        fn device_lost(&self, _: &GpuError) {
            self.losses.fetch_add(1, Ordering::Relaxed);
        }

        fn is_cancelled(&self) -> bool {
            if self.patience.load(Ordering::Relaxed) == u32::MAX {
                return false;
            }
            let left = self.patience.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| n.checked_sub(1));
            left.is_err()
        }
    }

    /// Runs a property on so many cases, always the same.
    pub fn cases(count: u32) -> TestRunner {
        let config = Config { cases: count, failure_persistence: None, ..Default::default() };
        TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha))
    }
}
