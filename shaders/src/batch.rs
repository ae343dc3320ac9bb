//! Work for a device: dispatches and copies in order.

use std::sync::atomic::Ordering;
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use wgpu::{
    BindGroupDescriptor, BindGroupEntry, BufferUsages, CommandEncoder, CommandEncoderDescriptor,
    ComputePassDescriptor, MapMode, PollType,
};

use crate::{Access, Buffer, Gpu, GpuError, Kernel};

/// Workgroups of a dispatch, laid out in two dimensions where one has too few.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Groups(pub u32);

/// Workgroups in a row of a dispatch; kernels count `workgroup_id.x + GROUP_ROW * workgroup_id.y`.
const GROUP_ROW: u32 = 32768;

/// How long an answer may be under way from one thread to another before the device is asked again.
const DELIVERY: Duration = Duration::from_millis(100);

impl Groups {
    /// Enough for so many threads.
    pub fn for_threads(kernel: &Kernel, threads: usize) -> Self {
        Self(threads.div_ceil(kernel.workgroup as usize) as u32)
    }

    fn layout(self) -> (u32, u32) {
        if self.0 <= GROUP_ROW { (self.0, 1) } else { (GROUP_ROW, self.0.div_ceil(GROUP_ROW)) }
    }
}

/// Dispatches and copies, done in order once they are submitted.
pub struct Batch<'g> {
    gpu: &'g Gpu,
    encoder: Option<CommandEncoder>,
}

impl<'g> Batch<'g> {
    /// Nothing to do yet.
    pub fn new(gpu: &'g Gpu) -> Self {
        Self { gpu, encoder: None }
    }

    fn encoder(&mut self) -> &mut CommandEncoder {
        let device = &self.gpu.0.device;
        self.encoder
            .get_or_insert_with(|| device.create_command_encoder(&CommandEncoderDescriptor::default()))
    }

    /// Runs a kernel. `params` fills its uniform block, if it has one, and `buffers` are the others in order.
    ///
    /// # Errors
    /// If the kernel does not compile, or has another number of buffers.
    pub fn dispatch<P: bytemuck::NoUninit>(
        &mut self,
        kernel: &'static Kernel,
        params: &P,
        buffers: &[&Buffer],
        groups: Groups,
    ) -> Result<(), GpuError> {
        if groups.0 == 0 {
            return Ok(());
        }
        let gpu = self.gpu;
        let pipeline = gpu.pipeline(kernel)?;
        let storage = kernel.bindings.iter().filter(|binding| binding.access != Access::Uniform).count();
        if storage != buffers.len() {
            return Err(GpuError::Refused(format!(
                "`{}` takes {storage} buffers, found {}",
                kernel.name,
                buffers.len()
            )));
        }
        let bytes = bytemuck::bytes_of(params);
        let uniform = gpu.0.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: (bytes.len().max(16) as u64).next_multiple_of(16),
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        gpu.0.queue.write_buffer(&uniform, 0, bytes);
        gpu.0.counters.uploaded.fetch_add(bytes.len() as u64, Ordering::Relaxed);
        let mut buffers = buffers.iter();
        let entries: Vec<_> = kernel
            .bindings
            .iter()
            .zip(0..)
            .filter_map(|(binding, number)| {
                let raw = match binding.access {
                    Access::Uniform => &uniform,
                    _ => &buffers.next()?.raw,
                };
                Some(BindGroupEntry { binding: number, resource: raw.as_entire_binding() })
            })
            .collect();
        let group = gpu.0.device.create_bind_group(&BindGroupDescriptor {
            label: Some(kernel.name),
            layout: &pipeline.layout,
            entries: &entries,
        });
        let mut pass = self
            .encoder()
            .begin_compute_pass(&ComputePassDescriptor { label: Some(kernel.name), timestamp_writes: None });
        pass.set_pipeline(&pipeline.raw);
        pass.set_bind_group(0, &group, &[]);
        let (x, y) = groups.layout();
        pass.dispatch_workgroups(x, y, 1);
        drop(pass);
        gpu.count_dispatch();
        Ok(())
    }

    /// Copies the whole of a buffer into another of the same size.
    pub fn copy(&mut self, from: &Buffer, to: &Buffer) {
        let size = from.size().min(to.size());
        self.encoder().copy_buffer_to_buffer(&from.raw, 0, &to.raw, 0, size);
    }

    /// Does everything so far, and waits for it.
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    pub fn finish(&mut self) -> Result<(), GpuError> {
        let Some(encoder) = self.encoder.take() else { return Ok(()) };
        let gpu = &self.gpu.0;
        let start = Instant::now();
        let submission = gpu.queue.submit([encoder.finish()]);
        gpu.counters.submissions.fetch_add(1, Ordering::Relaxed);
        let waited = gpu.device.poll(PollType::Wait { submission_index: Some(submission), timeout: None });
        gpu.counters.busy_us.fetch_add(start.elapsed().as_micros() as u64, Ordering::Relaxed);
        match self.gpu.lost() {
            Some(reason) => Err(GpuError::Lost(reason)),
            // A submission that was refused cannot be waited for; the scope around knows why.
            None => waited.map(|_| ()).map_err(|error| GpuError::Refused(error.to_string())),
        }
    }

    /// Runs a kernel of any length in submissions that each take about as long as the settings allow. `params` is given the
    /// first workgroup of each.
    ///
    /// # Errors
    /// [`GpuError::Cancelled`] between two submissions if `cancelled` says so, and as [`Batch::dispatch`].
    pub fn dispatch_long<P: bytemuck::NoUninit>(
        &mut self,
        kernel: &'static Kernel,
        params: impl Fn(u32) -> P,
        buffers: &[&Buffer],
        groups: Groups,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<(), GpuError> {
        self.dispatch_weighed(kernel, 1.0, params, buffers, groups, cancelled)
    }

    /// As [`Batch::dispatch_long`], for kernels whose workgroups do more in one call than in another: `work` is how much one does
    /// here, in a unit of the kernel's own, so that the pace of one call foretells the next.
    ///
    /// # Errors
    /// As [`Batch::dispatch_long`].
    pub fn dispatch_weighed<P: bytemuck::NoUninit>(
        &mut self,
        kernel: &'static Kernel,
        work: f64,
        params: impl Fn(u32) -> P,
        buffers: &[&Buffer],
        groups: Groups,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<(), GpuError> {
        self.finish()?;
        let mut first = 0;
        while first < groups.0 {
            if cancelled() {
                return Err(GpuError::Cancelled);
            }
            let portion = self.gpu.portion(kernel, work).min(groups.0 - first);
            self.dispatch(kernel, &params(first), buffers, Groups(portion))?;
            let start = Instant::now();
            self.finish()?;
            self.gpu.note_pace(kernel, f64::from(portion) * work, start.elapsed().as_secs_f64());
            first += portion;
        }
        Ok(())
    }

    /// Does everything so far and reads a buffer from its start into `to`.
    ///
    /// # Errors
    /// [`GpuError::Lost`], or [`GpuError::Refused`] if the buffer is smaller.
    pub fn read<T: bytemuck::AnyBitPattern + bytemuck::NoUninit>(
        &mut self,
        from: &Buffer,
        to: &mut [T],
    ) -> Result<(), GpuError> {
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(to);
        if bytes.len() as u64 > from.size() {
            return Err(GpuError::Refused(format!(
                "{} bytes are to be read from a buffer of {}",
                bytes.len(),
                from.size()
            )));
        }
        if bytes.is_empty() {
            return self.finish();
        }
        let gpu = &self.gpu.0;
        let size = (bytes.len() as u64).next_multiple_of(4);
        let staging = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        // What was asked for before is waited for apart, so that moving and computing are timed apart.
        self.finish()?;
        let start = Instant::now();
        self.encoder().copy_buffer_to_buffer(&from.raw, 0, &staging, 0, size);
        if let Some(encoder) = self.encoder.take() {
            gpu.queue.submit([encoder.finish()]);
        }
        let (sender, receiver) = std::sync::mpsc::channel();
        staging.map_async(MapMode::Read, .., move |result| {
            let _ = sender.send(result);
        });
        let lost = |what: String| match self.gpu.lost() {
            Some(reason) => GpuError::Lost(reason),
            None => GpuError::Refused(what),
        };
        let answer = loop {
            let waited = gpu.device.poll(PollType::wait_indefinitely());
            waited.map_err(|error| lost(error.to_string()))?;
            // Another thread that polls may have taken the answer, and be about to deliver it.
            match receiver.recv_timeout(DELIVERY) {
                Ok(answer) => break answer,
                Err(RecvTimeoutError::Timeout) if self.gpu.lost().is_none() => {}
                Err(_) => return Err(lost("no answer to a read".to_owned())),
            }
        };
        answer.map_err(|error| lost(error.to_string()))?;
        let view = staging.get_mapped_range(..).map_err(|error| lost(error.to_string()))?;
        bytes.copy_from_slice(&view[..bytes.len()]);
        gpu.counters.downloaded.fetch_add(bytes.len() as u64, Ordering::Relaxed);
        gpu.counters.download_us.fetch_add(start.elapsed().as_micros() as u64, Ordering::Relaxed);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GpuSettings, testing};

    #[test]
    fn on_the_device_threads_that_read_at_once_get_their_answers() {
        let Some(gpu) = testing::gpu(GpuSettings::default()) else { return };
        std::thread::scope(|scope| {
            for thread in 0..8u32 {
                let gpu = &gpu;
                scope.spawn(move || {
                    for round in 0..4000 {
                        let contents = [thread, round, 7, thread * round];
                        let buffer = gpu.upload(&contents).unwrap();
                        let mut found = [0u32; 4];
                        Batch::new(gpu).read(&buffer, &mut found).unwrap();
                        assert_eq!(found, contents);
                    }
                });
            }
        });
    }
}
