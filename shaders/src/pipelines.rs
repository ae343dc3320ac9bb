//! Compiled kernels on disk, where the driver hands them out.

use std::path::{Path, PathBuf};

use wgpu::{Adapter, Device, Features, PipelineCache, PipelineCacheDescriptor};

/// The compiled kernels of one driver. What is on disk is believed only with its checksum, since drivers trust it.
pub(crate) struct DiskPipelines {
    pub raw: PipelineCache,
    path: PathBuf,
}

impl DiskPipelines {
    /// `None` where the driver hands nothing out.
    pub fn open(folder: &Path, adapter: &Adapter, device: &Device) -> Option<Self> {
        if !device.features().contains(Features::PIPELINE_CACHE) {
            return None;
        }
        let path = folder.join(wgpu::util::pipeline_cache_key(&adapter.get_info())?);
        let data = std::fs::read(&path).ok().and_then(|file| {
            let (sum, data) = file.split_at_checked(32)?;
            (blake3::hash(data).as_bytes() == sum).then(|| data.to_vec())
        });
        let descriptor = PipelineCacheDescriptor { label: None, data: data.as_deref(), fallback: true };
        // SAFETY: the data come from `keep` on this adapter and driver, as the name and the checksum say.
        let raw = unsafe { device.create_pipeline_cache(&descriptor) };
        Some(Self { raw, path })
    }

    /// Writes what is compiled by now. That it cannot be written costs time alone, so nobody is told.
    pub fn keep(&self) {
        let Some(data) = self.raw.get_data() else { return };
        let Some(folder) = self.path.parent() else { return };
        let file = [&blake3::hash(&data).as_bytes()[..], &data].concat();
        let part = self.path.with_extension(format!("{}.part", std::process::id()));
        let written = std::fs::create_dir_all(folder)
            .and_then(|()| std::fs::write(&part, file))
            .and_then(|()| std::fs::rename(&part, &self.path));
        if written.is_err() {
            let _ = std::fs::remove_file(&part);
        }
    }
}
