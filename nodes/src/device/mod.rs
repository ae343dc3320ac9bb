//! The compute device as the engine sees it.

mod self_test;

use std::any::Any;
use std::sync::Arc;

use breccia_engine::{ComputeDevice, DeviceProfile, OpenDevice};
pub use breccia_shaders::{AdapterKind, AdapterReport, Gpu, GpuSettings, adapters};

pub use self_test::{SelfTest, SelfTestError, Task, self_test};

/// A [`Gpu`] that an engine can hand to nodes.
pub struct GpuDevice(pub Gpu);

/// How to open the device with these settings.
pub fn open_device(settings: GpuSettings) -> OpenDevice {
    Box::new(move || match Gpu::open(settings.clone()) {
        Ok(gpu) => Ok(Arc::new(GpuDevice(gpu))),
        Err(error) => Err(error.to_string()),
    })
}

impl ComputeDevice for GpuDevice {
    fn name(&self) -> String {
        format!("{} ({})", self.0.report().name, self.0.report().backend)
    }

    /// Round numbers of what such machines do: arithmetic and memory of a card against a handful of processor cores, and the
    /// bus between them.
    fn profile(&self) -> DeviceProfile {
        let (speedup, bytes_per_second) = match self.0.report().kind {
            AdapterKind::Software => (0.1, 5e9),
            AdapterKind::Other => (2.0, 2e9),
            AdapterKind::Integrated => (3.0, 10e9),
            AdapterKind::Discrete => (20.0, 8e9),
        };
        DeviceProfile { speedup, start: 2e-3, bytes_per_second }
    }

    fn lost(&self) -> Option<String> {
        self.0.lost()
    }

    fn as_any(&self) -> &dyn Any {
        self
    }
}
