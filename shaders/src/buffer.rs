//! Memory of a device.

use crate::memory::Lease;

/// A buffer on the device. Its bytes count against the device's budget until it is dropped.
#[derive(Debug)]
pub struct Buffer {
    pub(crate) raw: wgpu::Buffer,
    pub(crate) _lease: Lease,
}

impl Buffer {
    /// Its size in bytes.
    pub fn size(&self) -> u64 {
        self.raw.size()
    }
}
