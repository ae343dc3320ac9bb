//! One adapter with its queue, its pipelines and its memory.

use std::any::Any;
use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;
use std::sync::atomic::{AtomicI64, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use wgpu::{
    BindGroupLayoutDescriptor, BindGroupLayoutEntry, BindingType, BufferBindingType, BufferUsages,
    ComputePipelineDescriptor, Device, DeviceDescriptor, ErrorFilter, Features, Instance,
    PipelineLayoutDescriptor, Queue, ShaderModuleDescriptor, ShaderSource, ShaderStages,
};

use crate::adapters::{self, AdapterReport};
use crate::compose::compose;
use crate::memory::Memory;
use crate::resident::Resident;
use crate::{Access, Buffer, GpuError, Kernel};

/// How a device is to be used.
#[derive(Clone, Debug)]
pub struct GpuSettings {
    /// A part of the adapter's name, if not simply the best is wanted.
    pub adapter: Option<String>,
    /// Bytes of device memory that may be in use, those kept for later included.
    pub memory: u64,
    /// How long one submission should take at most. Display drivers reset a device that does not answer for some seconds, and
    /// between submissions others get their turn and cancelling is noticed.
    pub submission: Duration,
    /// A folder where compiled kernels are kept, where the driver offers them.
    pub pipeline_cache: Option<PathBuf>,
    /// Texts to use in place of those of kernels, by name: for trying changes out.
    pub texts: BTreeMap<&'static str, String>,
}

impl Default for GpuSettings {
    fn default() -> Self {
        Self {
            adapter: None,
            memory: 2 << 30,
            submission: Duration::from_millis(50),
            pipeline_cache: None,
            texts: BTreeMap::new(),
        }
    }
}

/// What a device has moved and done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Traffic {
    /// Bytes written to the device.
    pub uploaded: u64,
    /// Bytes read back.
    pub downloaded: u64,
    /// Dispatches.
    pub dispatches: u64,
    /// Submissions.
    pub submissions: u64,
    /// Microseconds spent waiting for dispatches.
    pub busy_us: u64,
    /// Microseconds spent reading back.
    pub download_us: u64,
    /// Bytes of device memory in use now.
    pub memory: u64,
    /// The most that were in use.
    pub peak_memory: u64,
    /// Entries kept on the device.
    pub resident: u64,
}

impl Traffic {
    /// What came since an earlier look; memory and entries as they are now.
    pub fn since(&self, before: &Self) -> Self {
        Self {
            uploaded: self.uploaded - before.uploaded,
            downloaded: self.downloaded - before.downloaded,
            dispatches: self.dispatches - before.dispatches,
            submissions: self.submissions - before.submissions,
            busy_us: self.busy_us - before.busy_us,
            download_us: self.download_us - before.download_us,
            ..*self
        }
    }
}

/// A compute device. Cloning copies a pointer.
#[derive(Clone)]
pub struct Gpu(pub(crate) Arc<Inner>);

pub(crate) struct Inner {
    pub report: AdapterReport,
    pub device: Device,
    pub queue: Queue,
    pub settings: GpuSettings,
    pub memory: Arc<Memory>,
    pub resident: Resident,
    pub counters: Counters,
    pipelines: Mutex<HashMap<&'static str, Arc<Pipeline>>>,
    cache: Option<crate::pipelines::DiskPipelines>,
    lost: Arc<Mutex<Option<String>>>,
    /// Work a second, by kernel; where callers do not weigh it, workgroups.
    pace: Mutex<HashMap<&'static str, f64>>,
    /// Dispatches until the device is given up, below zero for never.
    lose_after: AtomicI64,
    _instance: Option<Instance>,
}

#[derive(Default)]
pub(crate) struct Counters {
    pub uploaded: AtomicU64,
    pub downloaded: AtomicU64,
    pub dispatches: AtomicU64,
    pub submissions: AtomicU64,
    pub busy_us: AtomicU64,
    pub download_us: AtomicU64,
}

pub(crate) struct Pipeline {
    pub raw: wgpu::ComputePipeline,
    pub layout: wgpu::BindGroupLayout,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Gpu {
    /// Opens the best adapter, or the one that is asked for.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] with advice, or what the driver says.
    pub fn open(settings: GpuSettings) -> Result<Self, GpuError> {
        let instance = adapters::instance();
        let adapter = adapters::choose(&instance, settings.adapter.as_deref())?;
        let wanted = Features::TIMESTAMP_QUERY | Features::SUBGROUP | Features::PIPELINE_CACHE;
        let descriptor = DeviceDescriptor {
            label: Some("breccia"),
            required_features: adapter.features() & wanted,
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let name = adapter.get_info().name;
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| GpuError::NoAdapter(format!("`{name}` cannot be used: {error}")))?;
        Ok(Self::shared(Some(instance), &adapter, device, queue, settings))
    }

    /// A device that a window uses as well.
    pub fn from_window(adapter: &wgpu::Adapter, device: Device, queue: Queue, settings: GpuSettings) -> Self {
        Self::shared(None, adapter, device, queue, settings)
    }

    fn shared(
        instance: Option<Instance>,
        adapter: &wgpu::Adapter,
        device: Device,
        queue: Queue,
        settings: GpuSettings,
    ) -> Self {
        let lost = Arc::new(Mutex::new(None));
        let note = Arc::clone(&lost);
        device.set_device_lost_callback(move |reason, message| {
            *locked(&note) = Some(format!("{reason:?}: {message}"));
        });
        // Every error is caught by a scope; one that is not must not end the program.
        device.on_uncaptured_error(Arc::new(|_| ()));
        let cache = settings
            .pipeline_cache
            .as_deref()
            .and_then(|folder| crate::pipelines::DiskPipelines::open(folder, adapter, &device));
        Self(Arc::new(Inner {
            report: adapters::report(adapter),
            memory: Memory::new(settings.memory),
            device,
            queue,
            settings,
            resident: Resident::default(),
            counters: Counters::default(),
            pipelines: Mutex::default(),
            cache,
            lost,
            pace: Mutex::default(),
            lose_after: AtomicI64::new(-1),
            _instance: instance,
        }))
    }

    /// What the adapter says of itself.
    pub fn report(&self) -> &AdapterReport {
        &self.0.report
    }

    /// The settings.
    pub fn settings(&self) -> &GpuSettings {
        &self.0.settings
    }

    /// Why the device is gone, if it is.
    pub fn lost(&self) -> Option<String> {
        locked(&self.0.lost).clone()
    }

    /// Gives the device up after so many more dispatches, as a driver does that is reset: for rehearsing the loss.
    pub fn lose_after(&self, dispatches: u32) {
        self.0.lose_after.store(dispatches.into(), Ordering::Relaxed);
    }

    /// Counts a dispatch; gives the device up if that was rehearsed.
    pub(crate) fn count_dispatch(&self) {
        self.0.counters.dispatches.fetch_add(1, Ordering::Relaxed);
        let left = &self.0.lose_after;
        if left.load(Ordering::Relaxed) >= 0 && left.fetch_sub(1, Ordering::Relaxed) == 0 {
            self.0.device.destroy();
            locked(&self.0.lost).get_or_insert_with(|| "given up on request".to_owned());
        }
    }

    /// What was moved and done so far.
    pub fn traffic(&self) -> Traffic {
        let counters = &self.0.counters;
        let of = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        Traffic {
            uploaded: of(&counters.uploaded),
            downloaded: of(&counters.downloaded),
            dispatches: of(&counters.dispatches),
            submissions: of(&counters.submissions),
            busy_us: of(&counters.busy_us),
            download_us: of(&counters.download_us),
            memory: self.0.memory.used(),
            peak_memory: self.0.memory.peak(),
            resident: self.0.resident.len() as u64,
        }
    }

    /// The budget of device memory in bytes.
    pub fn memory_budget(&self) -> u64 {
        self.0.memory.budget()
    }

    /// The largest buffer that a kernel can be given here, in bytes.
    pub fn largest_binding(&self) -> u64 {
        self.0.report.largest_binding.min(self.0.report.largest_buffer).min(self.memory_budget())
    }

    /// Does some work, and turns whatever the device says about it into one error.
    ///
    /// # Errors
    /// The work's own, or the device's.
    pub fn scope<T>(&self, work: impl FnOnce() -> Result<T, GpuError>) -> Result<T, GpuError> {
        let memory = self.0.device.push_error_scope(ErrorFilter::OutOfMemory);
        let internal = self.0.device.push_error_scope(ErrorFilter::Internal);
        let validation = self.0.device.push_error_scope(ErrorFilter::Validation);
        let result = work();
        // Every scope is closed before any is looked at.
        let closed = [validation.pop(), internal.pop()].map(pollster::block_on);
        let memory = pollster::block_on(memory.pop());
        if let Some(reason) = self.lost() {
            return match result {
                Err(GpuError::Cancelled) => Err(GpuError::Cancelled),
                _ => Err(GpuError::Lost(reason)),
            };
        }
        // What the device says explains more than what came of it.
        match (result, memory, closed.into_iter().flatten().next()) {
            (Err(GpuError::Cancelled), ..) => Err(GpuError::Cancelled),
            (_, Some(error), _) => Err(GpuError::OutOfMemory(error.to_string())),
            (_, None, Some(error)) => Err(GpuError::Refused(error.to_string())),
            (result, None, None) => result,
        }
    }

    /// A buffer of zeros. What is only kept for later makes room if it must.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`] beyond the budget or what a kernel can be given.
    pub fn zeros(&self, bytes: u64) -> Result<Buffer, GpuError> {
        // Even an empty buffer must hold one of whatever a kernel takes it for.
        let size = bytes.max(64).next_multiple_of(16);
        if size > self.largest_binding() {
            return Err(GpuError::OutOfMemory(format!(
                "a buffer of {size} bytes is asked of a compute device that takes {} at once",
                self.largest_binding()
            )));
        }
        let lease = loop {
            match self.0.memory.take(size) {
                Some(lease) => break lease,
                None if self.0.resident.evict() => {}
                None => {
                    return Err(GpuError::OutOfMemory(format!(
                        "{size} more bytes of device memory are needed, {} of {} are in use",
                        self.0.memory.used(),
                        self.0.memory.budget()
                    )));
                }
            }
        };
        let raw = self.0.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage: BufferUsages::STORAGE
                | BufferUsages::UNIFORM
                | BufferUsages::COPY_SRC
                | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Ok(Buffer { raw, _lease: lease })
    }

    /// A buffer with these contents.
    ///
    /// # Errors
    /// As [`Gpu::zeros`].
    pub fn upload<T: bytemuck::NoUninit>(&self, contents: &[T]) -> Result<Buffer, GpuError> {
        let bytes: &[u8] = bytemuck::cast_slice(contents);
        let buffer = self.zeros(bytes.len() as u64)?;
        let whole = bytes.len() & !3;
        self.0.queue.write_buffer(&buffer.raw, 0, &bytes[..whole]);
        if whole < bytes.len() {
            let mut rest = [0; 4];
            rest[..bytes.len() - whole].copy_from_slice(&bytes[whole..]);
            self.0.queue.write_buffer(&buffer.raw, whole as u64, &rest);
        }
        self.0.counters.uploaded.fetch_add(bytes.len() as u64, Ordering::Relaxed);
        Ok(buffer)
    }

    /// Writes into a buffer, from a byte on that is a multiple of four.
    pub fn write<T: bytemuck::NoUninit>(&self, buffer: &Buffer, at: u64, contents: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(contents);
        self.0.queue.write_buffer(&buffer.raw, at, bytes);
        self.0.counters.uploaded.fetch_add(bytes.len() as u64, Ordering::Relaxed);
    }

    /// What is kept on the device under a digest, or is made and kept from now on until others need the memory.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn resident<T: Any + Send + Sync>(
        &self,
        id: [u8; 32],
        make: impl FnOnce() -> Result<T, GpuError>,
    ) -> Result<Arc<T>, GpuError> {
        if let Some(found) = self.0.resident.find(&id) {
            return Ok(found);
        }
        let made = Arc::new(make()?);
        self.0.resident.keep(id, Arc::clone(&made));
        Ok(made)
    }

    /// Lets go of everything that is kept for later.
    pub fn clear(&self) {
        self.0.resident.clear();
    }

    pub(crate) fn pipeline(&self, kernel: &'static Kernel) -> Result<Arc<Pipeline>, GpuError> {
        if let Some(pipeline) = locked(&self.0.pipelines).get(kernel.name) {
            return Ok(Arc::clone(pipeline));
        }
        let text = self.0.settings.texts.get(kernel.name).map_or(kernel.source, String::as_str);
        let composed = compose(kernel, text).map_err(GpuError::Refused)?;
        let device = &self.0.device;
        let module = device.create_shader_module(ShaderModuleDescriptor {
            label: Some(kernel.name),
            source: ShaderSource::Naga(std::borrow::Cow::Owned(composed.module)),
        });
        let entries: Vec<_> = kernel
            .bindings
            .iter()
            .zip(0..)
            .map(|(binding, number)| BindGroupLayoutEntry {
                binding: number,
                visibility: ShaderStages::COMPUTE,
                ty: BindingType::Buffer {
                    ty: match binding.access {
                        Access::Uniform | Access::Constant => BufferBindingType::Uniform,
                        access => BufferBindingType::Storage { read_only: access == Access::Read },
                    },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            })
            .collect();
        let layout = device.create_bind_group_layout(&BindGroupLayoutDescriptor {
            label: Some(kernel.name),
            entries: &entries,
        });
        let pipeline_layout = device.create_pipeline_layout(&PipelineLayoutDescriptor {
            label: Some(kernel.name),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let raw = device.create_compute_pipeline(&ComputePipelineDescriptor {
            label: Some(kernel.name),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some("main"),
            compilation_options: Default::default(),
            cache: self.0.cache.as_ref().map(|cache| &cache.raw),
        });
        if let Some(cache) = &self.0.cache {
            cache.keep();
        }
        let pipeline = Arc::new(Pipeline { raw, layout });
        locked(&self.0.pipelines).insert(kernel.name, Arc::clone(&pipeline));
        Ok(pipeline)
    }

    /// Workgroups of a kernel that take about as long as a submission may, if each does so much work.
    pub(crate) fn portion(&self, kernel: &Kernel, work: f64) -> u32 {
        let pace = locked(&self.0.pace).get(kernel.name).copied();
        let groups =
            pace.map_or(256.0, |pace| pace * self.0.settings.submission.as_secs_f64() / work.max(1e-6));
        groups.clamp(16.0, 4e9) as u32
    }

    /// Takes note of how long some work took.
    pub(crate) fn note_pace(&self, kernel: &Kernel, work: f64, seconds: f64) {
        // A submission of no work takes some time too, hence portions grow by steps.
        let pace = work / seconds.max(1e-6);
        let mut paces = locked(&self.0.pace);
        let known = paces.entry(kernel.name).or_insert(pace);
        *known = if pace < *known { pace } else { pace.min(*known * 2.0) };
    }
}
