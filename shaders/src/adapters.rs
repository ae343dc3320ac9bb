//! The adapters of a machine, and which of them is used.

use std::sync::OnceLock;

use wgpu::{Adapter, Backend, Backends, DeviceType, Instance, InstanceDescriptor};

use crate::GpuError;

/// Backends that compute as they should.
const BACKENDS: Backends = Backends::VULKAN.union(Backends::METAL).union(Backends::DX12);

/// What kind of machine an adapter is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum AdapterKind {
    /// A program that draws on the processor: for checking that answers are right, not for speed.
    Software,
    /// Unknown, or handed through by a virtual machine.
    Other,
    /// On the processor's chip, with the processor's memory.
    Integrated,
    /// A card with memory of its own.
    Discrete,
}

/// What an adapter says of itself.
#[derive(Clone, Debug, PartialEq)]
pub struct AdapterReport {
    /// Its name.
    pub name: String,
    /// The interface it is reached through: vulkan, metal or dx12.
    pub backend: String,
    /// The driver's name and version.
    pub driver: String,
    /// What kind of machine it is.
    pub kind: AdapterKind,
    /// The largest buffer that a kernel can be given, in bytes.
    pub largest_binding: u64,
    /// The largest buffer, in bytes.
    pub largest_buffer: u64,
    /// Memory that a workgroup shares, in bytes.
    pub workgroup_memory: u32,
    /// Threads of a workgroup at most.
    pub workgroup_threads: u32,
    /// Threads that run in step, fewest and most.
    pub subgroup: [u32; 2],
    /// Buffers that a kernel can be given.
    pub bindings: u32,
    /// Features that matter here, by name, and whether it has them.
    pub features: Vec<(&'static str, bool)>,
}

pub(crate) fn instance() -> Instance {
    let mut descriptor = InstanceDescriptor::new_without_display_handle();
    descriptor.backends = BACKENDS;
    let instance = Instance::new(descriptor);
    keep_driver(&instance);
    instance
}

/// Keeps the drivers that an instance has loaded until the program has ended. A driver leaves functions to be called at the end of the
/// program; with its last instance it is unloaded, and calling them is a crash after all work is done.
pub fn keep_driver(instance: &Instance) {
    static KEPT: OnceLock<Instance> = OnceLock::new();
    KEPT.get_or_init(|| instance.clone());
}

pub(crate) fn list(instance: &Instance) -> Vec<Adapter> {
    let mut adapters = pollster::block_on(instance.enumerate_adapters(BACKENDS));
    // The best first; of equals the first that the system names.
    adapters.sort_by_key(|adapter| std::cmp::Reverse(kind(adapter.get_info().device_type)));
    adapters
}

/// The adapters that can compute, the best first.
pub fn adapters() -> Vec<AdapterReport> {
    list(&instance()).iter().map(report).collect()
}

pub(crate) fn choose(instance: &Instance, name: Option<&str>) -> Result<Adapter, GpuError> {
    let adapters = list(instance);
    let found: Vec<String> = adapters.iter().map(|adapter| adapter.get_info().name).collect();
    let wanted = |adapter: &Adapter| {
        name.is_none_or(|name| adapter.get_info().name.to_lowercase().contains(&name.to_lowercase()))
    };
    adapters.into_iter().find(wanted).ok_or_else(|| {
        GpuError::NoAdapter(match name {
            Some(name) if !found.is_empty() => {
                format!("no adapter is called `{name}`; there are {}", found.join(", "))
            }
            _ => "no adapter for Vulkan, Metal or DX12 was found: install the graphics driver of your card, or on Linux \
                  the software adapter of Mesa (Debian: mesa-vulkan-drivers)"
                .to_owned(),
        })
    })
}

pub(crate) fn kind(ty: DeviceType) -> AdapterKind {
    match ty {
        DeviceType::DiscreteGpu => AdapterKind::Discrete,
        DeviceType::IntegratedGpu => AdapterKind::Integrated,
        DeviceType::Cpu => AdapterKind::Software,
        DeviceType::Other | DeviceType::VirtualGpu => AdapterKind::Other,
    }
}

pub(crate) fn report(adapter: &Adapter) -> AdapterReport {
    let (info, limits, features) = (adapter.get_info(), adapter.limits(), adapter.features());
    let has = |feature| features.contains(feature);
    AdapterReport {
        name: info.name,
        backend: match info.backend {
            Backend::Vulkan => "vulkan".to_owned(),
            Backend::Metal => "metal".to_owned(),
            Backend::Dx12 => "dx12".to_owned(),
            other => format!("{other:?}").to_lowercase(),
        },
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        kind: kind(info.device_type),
        largest_binding: limits.max_storage_buffer_binding_size,
        largest_buffer: limits.max_buffer_size,
        workgroup_memory: limits.max_compute_workgroup_storage_size,
        workgroup_threads: limits.max_compute_invocations_per_workgroup,
        subgroup: [info.subgroup_min_size, info.subgroup_max_size],
        bindings: limits.max_storage_buffers_per_shader_stage,
        features: vec![
            ("timestamps", has(wgpu::Features::TIMESTAMP_QUERY)),
            ("subgroups", has(wgpu::Features::SUBGROUP)),
            ("pipeline cache", has(wgpu::Features::PIPELINE_CACHE)),
            ("16-bit floats", has(wgpu::Features::SHADER_F16)),
        ],
    }
}
