//! WGSL kernels, and the compute device that they run on. The only crate that names wgpu, an editor's window aside.
//!
//! A [`Gpu`] is one adapter with its queue, its pipelines and a budget of memory. Work is a [`Batch`] of dispatches of
//! [`Kernel`]s on [`Buffer`]s. Every kernel is one file of `kernels/`, names the CPU function that it mirrors, and
//! imports what several share from `kernels/modules/`.
//!
//! Only Vulkan, Metal and DX12 are used: on GL, three-dimensional storage reads back as zeros without an error.
#![doc = include_str!("../kernels/README.md")]

mod adapters;
mod batch;
mod buffer;
mod compose;
mod error;
mod gpu;
mod kernel;
pub mod kernels;
mod memory;
mod pipelines;
mod resident;
pub mod testing;
#[cfg(test)]
mod tests;

pub use adapters::{AdapterKind, AdapterReport, adapters, keep_driver};
pub use batch::{Batch, Groups};
pub use buffer::Buffer;
pub use compose::{Composed, compose};
pub use error::GpuError;
pub use gpu::{Gpu, GpuSettings, Traffic};
pub use kernel::{Access, Binding, Kernel};
/// The device's own interface, for a window that shares it.
pub use wgpu;
