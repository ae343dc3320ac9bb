//! A compute device beside the CPU threads, and which nodes run there.
//!
//! The rule of `auto`: a node runs on the device if it says that it can, if there is a device that is faster than the CPU threads,
//! and if its work there, with starting it and moving its data, takes less time than here. Nodes that cannot tell how much
//! work they have run on the device. Nodes whose results differ there run there only if it is asked for, under keys of their own.

use std::any::Any;
use std::sync::{Arc, OnceLock};

use crate::engine::DeviceChoice;
use crate::estimate::{Sizing, Work};
use crate::events::Device;
use crate::graph::GraphNode;
use crate::spec::Placement;

/// A machine that nodes can compute on beside the CPU threads. Nodes that know its type find it by
/// [`crate::Context::device`].
pub trait ComputeDevice: Any + Send + Sync {
    /// Its name.
    fn name(&self) -> String;

    /// How fast it is.
    fn profile(&self) -> DeviceProfile;

    /// Why it cannot be used any more, if it is lost.
    fn lost(&self) -> Option<String>;

    /// Itself, for nodes that know its type.
    fn as_any(&self) -> &dyn Any;
}

/// What `auto` goes by. Rough numbers do: they only decide where something runs, never what comes out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviceProfile {
    /// How many times faster than all CPU threads together it does a node's work. At most 1 means that `auto` leaves it aside.
    pub speedup: f64,
    /// Seconds before it begins.
    pub start: f64,
    /// Bytes a second between its memory and the host's.
    pub bytes_per_second: f64,
}

/// Opens the device when it is first needed, or says why there is none.
pub type OpenDevice = Box<dyn Fn() -> Result<Arc<dyn ComputeDevice>, String> + Send + Sync>;

/// Where a node runs, and why.
#[derive(Clone)]
pub(crate) struct Placed {
    pub device: Option<Arc<dyn ComputeDevice>>,
    pub why: String,
}

impl Placed {
    pub fn device(&self) -> Device {
        if self.device.is_some() { Device::Gpu } else { Device::Cpu }
    }
}

/// The device of an engine, opened at most once.
pub(crate) struct Devices {
    choice: DeviceChoice,
    open: Option<OpenDevice>,
    opened: OnceLock<Result<Arc<dyn ComputeDevice>, String>>,
}

impl Devices {
    pub fn new(choice: DeviceChoice, open: Option<OpenDevice>) -> Self {
        Self { choice, open, opened: OnceLock::new() }
    }

    /// The device, if there is one and it may be used.
    pub fn get(&self) -> Result<Arc<dyn ComputeDevice>, String> {
        if self.choice == DeviceChoice::Cpu {
            return Err("CPU threads were asked for".to_owned());
        }
        let open = || match &self.open {
            Some(open) => open(),
            None => Err("this program has no code for one".to_owned()),
        };
        let device = self.opened.get_or_init(open).clone()?;
        match device.lost() {
            Some(reason) => Err(format!("it was lost: {reason}")),
            None => Ok(device),
        }
    }

    /// The device that nodes run on whose results differ there.
    pub fn apart(&self) -> Option<String> {
        if self.choice != DeviceChoice::Gpu {
            return None;
        }
        self.get().ok().map(|device| device.name())
    }

    /// In words what nodes with a choice run on.
    pub fn describe(&self) -> String {
        match self.get() {
            Ok(device) if self.aside(&device) => format!(
                "{} is no faster than CPU threads, so `auto` leaves it aside; running on those",
                device.name()
            ),
            Ok(device) => format!("compute device {}", device.name()),
            Err(reason) if self.choice == DeviceChoice::Cpu => reason,
            Err(reason) => format!("no compute device, running on CPU threads: {reason}"),
        }
    }

    fn aside(&self, device: &Arc<dyn ComputeDevice>) -> bool {
        self.choice == DeviceChoice::Auto && device.profile().speedup <= 1.0
    }

    /// Whether it matters which device there is.
    pub fn asked(&self, node: &GraphNode) -> bool {
        self.choice != DeviceChoice::Cpu && node.ty.spec.placement != Placement::Cpu
    }

    /// Where a node runs.
    pub fn place(&self, node: &GraphNode, sizing: &Sizing<'_>) -> Placed {
        let cpu = |why: &str| Placed { device: None, why: why.to_owned() };
        if node.ty.spec.placement == Placement::Cpu {
            return cpu("it has no code for a compute device");
        }
        let device = match self.get() {
            Ok(device) => device,
            Err(reason) => return cpu(&reason),
        };
        if self.choice == DeviceChoice::Gpu {
            return Placed { device: Some(device), why: "a compute device was asked for".to_owned() };
        }
        if node.ty.spec.placement == Placement::Apart {
            return cpu("it rounds otherwise on a compute device, which has to be asked for");
        }
        if self.aside(&device) {
            return cpu("the compute device is no faster than CPU threads");
        }
        let Some(Work { seconds, bytes }) = node.ty.node.work(sizing) else {
            return Placed { device: Some(device), why: "its work is not known beforehand".to_owned() };
        };
        let profile = device.profile();
        let there = profile.start + bytes as f64 / profile.bytes_per_second + seconds / profile.speedup;
        let why = format!("about {there:.3} s there, {seconds:.3} s on CPU threads");
        Placed { device: (there < seconds).then_some(device), why }
    }
}
