//! What a device promises: answers, a budget, errors instead of crashes.

use crate::kernels::SCAN;
use crate::{Batch, Gpu, GpuError, GpuSettings, Groups, testing};

fn sums(gpu: &Gpu, counts: &[u32]) -> Result<Vec<u32>, GpuError> {
    gpu.scope(|| {
        let mut all = counts.to_vec();
        all.push(0);
        let buffer = gpu.upload(&all)?;
        let mut batch = Batch::new(gpu);
        batch.dispatch(&SCAN, &[counts.len() as u32, 0, 0, 0], &[&buffer], Groups(1))?;
        batch.read(&buffer, &mut all)?;
        Ok(all)
    })
}

#[test]
fn on_the_device_counts_become_sums() {
    let Some(gpu) = testing::gpu(GpuSettings::default()) else { return };
    for length in [1usize, 255, 256, 257, 1000] {
        let counts: Vec<u32> = (0..length as u32).map(|i| i * 7919 % 513).collect();
        let mut expected = vec![0];
        counts.iter().for_each(|count| expected.push(expected[expected.len() - 1] + count));
        assert_eq!(sums(&gpu, &counts).unwrap(), expected);
    }
    let traffic = gpu.traffic();
    assert!(traffic.dispatches == 5 && traffic.downloaded == 4 * (2 + 256 + 257 + 258 + 1001));
    assert_eq!(traffic.memory, 0);
}

#[test]
fn on_the_device_of_a_window_work_is_done_too() {
    let Some(_) = testing::gpu(GpuSettings::default()) else { return };
    let instance = crate::adapters::instance();
    let adapter = crate::adapters::choose(&instance, None).unwrap();
    let descriptor = wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    let gpu = Gpu::from_window(&adapter, device, queue, GpuSettings::default());
    assert_eq!(sums(&gpu, &[3, 4]).unwrap(), [0, 3, 7]);
    assert_eq!(gpu.report(), testing::gpu(GpuSettings::default()).unwrap().report());
}

#[test]
fn on_the_device_what_is_kept_gives_way_the_oldest_first() {
    let settings = GpuSettings { memory: 3 << 20, ..Default::default() };
    let Some(gpu) = testing::gpu(settings) else { return };
    let made = std::cell::Cell::new(0);
    let entry = |id: u8| {
        let make = || {
            made.set(made.get() + 1);
            gpu.zeros(1 << 20)
        };
        gpu.resident([id; 32], make).map(drop)
    };
    for id in [1, 2, 3, 1, 2, 3, 1] {
        entry(id).unwrap();
    }
    assert_eq!(made.get(), 3);
    // The one that was not used for longest goes.
    entry(4).unwrap();
    entry(3).unwrap();
    entry(1).unwrap();
    assert_eq!(made.get(), 4);
    entry(2).unwrap();
    assert_eq!(made.get(), 5);
    // What is in use stays.
    let held = gpu.resident([5; 32], || gpu.zeros(2 << 20)).unwrap();
    assert!(matches!(gpu.zeros(2 << 20), Err(GpuError::OutOfMemory(_))));
    drop(held);
    assert!(gpu.zeros(2 << 20).is_ok());
}

#[test]
fn on_the_device_mistakes_are_errors_and_the_device_goes_on() {
    let Some(gpu) = testing::gpu(GpuSettings::default()) else { return };
    let buffer = gpu.zeros(64).unwrap();
    let wrong = gpu.scope(|| Batch::new(&gpu).dispatch(&SCAN, &[1u32; 4], &[&buffer, &buffer], Groups(1)));
    assert!(matches!(wrong, Err(GpuError::Refused(_))));
    let large = gpu.scope(|| Batch::new(&gpu).read(&buffer, &mut [0u32; 1000]));
    assert!(matches!(large, Err(GpuError::Refused(_))));
    assert_eq!(sums(&gpu, &[5]).unwrap(), [0, 5]);
}

#[test]
fn on_the_device_compiled_kernels_are_kept_and_damage_is_not_believed() {
    let folder = std::env::temp_dir().join(format!("breccia-pipelines-{}", std::process::id()));
    let open = || testing::gpu(GpuSettings { pipeline_cache: Some(folder.clone()), ..Default::default() });
    let Some(gpu) = open() else { return };
    sums(&gpu, &[1]).unwrap();
    let files =
        || std::fs::read_dir(&folder).map(|files| files.flatten().collect::<Vec<_>>()).unwrap_or_default();
    for file in files() {
        let mut bytes = std::fs::read(file.path()).unwrap();
        bytes.iter_mut().for_each(|byte| *byte = !*byte);
        std::fs::write(file.path(), bytes).unwrap();
    }
    assert_eq!(sums(&open().unwrap(), &[1, 2]).unwrap(), [0, 1, 3]);
    assert!(files().iter().all(|file| !file.path().to_string_lossy().ends_with("part")));
    std::fs::remove_dir_all(&folder).unwrap();
}
