//! What tests of several crates need of a device.

use crate::{Gpu, GpuSettings};

/// Set where a missing adapter is to fail tests instead of skipping them.
pub const REQUIRED: &str = "BRECCIA_REQUIRE_DEVICE";

/// The device that tests run on. Where there is none, says that the test is skipped, by its name.
///
/// # Panics
/// Where there is none although [`REQUIRED`] is set.
pub fn gpu(settings: GpuSettings) -> Option<Gpu> {
    match Gpu::open(settings) {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            let thread = std::thread::current();
            let test = thread.name().unwrap_or("a test");
            assert!(std::env::var_os(REQUIRED).is_none(), "{test} needs a compute device: {error}");
            eprintln!("skipped: {test}: {error}");
            None
        }
    }
}
