//! Whether a device gives the right answers, and how fast.

use std::sync::Arc;
use std::time::{Duration, Instant};

use breccia_engine::Digest;
use breccia_shaders::{Batch, Gpu, GpuError, Traffic};

use crate::control::Control;
use crate::data::{Image, Solid, SolidError, VoxelMap, VoxelSet};
use crate::exemplar::{MakeSettings, make_exemplar};
use crate::lazy::{
    CandidateSettings, Initial, Jitter, LazySolid, Pyramid, Settings, Tables, make_candidates,
    make_descriptors, make_slab, similarity_sets,
};

/// What a self-test found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SelfTest {
    /// Bytes a second to the device.
    pub upload: f64,
    /// Bytes a second back.
    pub download: f64,
    /// Subsets of voxels that were synthesised on both.
    pub subsets: u64,
    /// Voxels compared.
    pub voxels: u64,
    /// Voxels that differed.
    pub different: u64,
    /// An oblique cut of 256² pixels, then cubes of growing size.
    pub tasks: Vec<Task>,
}

/// What one request took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Task {
    /// What it was.
    pub name: String,
    /// Voxels that were asked for.
    pub voxels: u64,
    /// Seconds on CPU threads.
    pub cpu: f64,
    /// Seconds on the device.
    pub device: f64,
    /// What the device moved and did for it.
    pub traffic: Traffic,
}

/// Why a self-test ended early.
#[derive(Clone, Debug, thiserror::Error)]
pub enum SelfTestError {
    /// The device could not do it.
    #[error(transparent)]
    Device(#[from] GpuError),
    /// The synthesis could not be done.
    #[error(transparent)]
    Solid(#[from] SolidError),
    /// The test picture could not be prepared: a defect of this program.
    #[error("the test picture cannot be prepared: {0}")]
    Prepare(String),
}

/// Whoever wants the device, and notices when it is lost.
struct OnDevice<'a>(&'a Gpu);

impl Control for OnDevice<'_> {
    fn gpu(&self) -> Option<&Gpu> {
        Some(self.0)
    }
}

/// Spends about `time` on a device: moves data, synthesises random subsets of voxels on it and on CPU threads, and then
/// cubes of growing size.
///
/// # Errors
/// [`SelfTestError`]; that answers differ is none, but is counted.
pub fn self_test(gpu: &Gpu, time: Duration) -> Result<SelfTest, SelfTestError> {
    let start = Instant::now();
    let mut found = SelfTest::default();
    (found.upload, found.download) = transfers(gpu)?;
    let solid = prepare().map_err(SelfTestError::Prepare)?;
    let mut number = 0;
    while start.elapsed() < time / 2 {
        let wanted = subset(number);
        number += 1;
        let (there, here) = both(&solid(number), &wanted, gpu)?;
        found.subsets += 1;
        found.voxels += wanted.len() as u64;
        found.different += differing(&wanted, &there.0, &here.0);
    }
    let mut measure = |name: String, wanted: VoxelSet| -> Result<f64, SelfTestError> {
        let before = gpu.traffic();
        let (there, here) = both(&solid(wanted.len() as u64), &wanted, gpu)?;
        found.voxels += wanted.len() as u64;
        found.different += differing(&wanted, &there.0, &here.0);
        found.tasks.push(Task {
            name,
            voxels: wanted.len() as u64,
            cpu: here.1,
            device: there.1,
            traffic: gpu.traffic().since(&before),
        });
        Ok(there.1 + here.1)
    };
    // A small one first: the first task on a device compiles its kernels.
    let mut cube = 16;
    let mut last = measure(format!("{cube}³"), VoxelSet::from_box([0; 3], [cube; 3]))?;
    // A cut depends on about as many voxels as two cubes of 48.
    if start.elapsed().as_secs_f64() + 54.0 * last < time.as_secs_f64() {
        measure("cut of 256²".to_owned(), oblique(256))?;
    }
    // The next cube takes up to eight times as long.
    while cube < 512 && start.elapsed().as_secs_f64() + 8.0 * last < time.as_secs_f64() {
        cube *= 2;
        last = measure(format!("{cube}³"), VoxelSet::from_box([0; 3], [cube; 3]))?;
    }
    Ok(found)
}

/// The voxels of a plane across (1, 2, 3), `size` pixels a side.
fn oblique(size: i32) -> VoxelSet {
    // Two directions at right angles to it and to each other, in voxels.
    let (right, down) = ([0.894, -0.447, 0.0], [0.359, 0.717, -0.598]);
    let pixels = (0..size).flat_map(|r| (0..size).map(move |c| [f64::from(c), f64::from(r)]));
    pixels.map(|[c, r]| std::array::from_fn(|i| libm::floor(c * right[i] + r * down[i]) as i32)).collect()
}

/// Bytes a second to the device and back.
fn transfers(gpu: &Gpu) -> Result<(f64, f64), GpuError> {
    let mut words = vec![0x5a5a_5a5au32; (gpu.largest_binding().min(64 << 20) / 4) as usize];
    let bytes = (words.len() * 4) as f64;
    gpu.scope(|| {
        let start = Instant::now();
        let buffer = gpu.upload(&words)?;
        // Only what was used is known to have arrived.
        Batch::new(gpu).read(&buffer, &mut words[..1])?;
        let upload = bytes / start.elapsed().as_secs_f64();
        let start = Instant::now();
        Batch::new(gpu).read(&buffer, &mut words)?;
        Ok((upload, bytes / start.elapsed().as_secs_f64()))
    })
}

/// Cells with dark borders, as a solid for each seed.
fn prepare() -> Result<impl Fn(u64) -> LazySolid, String> {
    let side = 32;
    let picture = Image::from_fn(side, side, |x, y| {
        let edge = [[5, 9], [21, 4], [13, 20], [28, 26], [2, 29], [27, 14]].map(|[u, v]: [i32; 2]| {
            let (dx, dy) = ((x as i32 - u).rem_euclid(32), (y as i32 - v).rem_euclid(32));
            dx.min(32 - dx).pow(2) + dy.min(32 - dy).pow(2)
        });
        let near = edge.into_iter().min().unwrap_or(0).min(80) as u8;
        [220 - 2 * near, 200 - near, 90 + near]
    });
    let make = MakeSettings { tileable: true, ..Default::default() };
    let exemplar = make_exemplar(&picture, None, None, &[], &make).map_err(|error| error.to_string())?;
    let pyramid = Pyramid::new(&exemplar, 2).map_err(|error| error.to_string())?;
    let descriptors = make_descriptors(&pyramid, &[8, 16]);
    let cancelled = |_| "cancelled".to_owned();
    let similarity = similarity_sets(&pyramid, &descriptors, 3, &()).map_err(cancelled)?;
    let candidates = make_candidates(&pyramid, &CandidateSettings::default(), &()).map_err(cancelled)?;
    let jitter = Some(Jitter { amount: 0.2, sigma_min: 0.3, sigma_max: 1.2, density: 3.0 });
    let initial = Initial { jitter, ..make_slab(&pyramid, &candidates) };
    let tables = Tables::new(&exemplar, &pyramid, &descriptors, &similarity, &candidates, None);
    let tables = Arc::new(tables.map_err(|error| error.to_string())?);
    Ok(move |seed| {
        let settings = Settings { seed, ..Default::default() };
        LazySolid::new(Arc::clone(&tables), initial.clone(), settings, Digest::of(b"self-test"))
    })
}

/// A few voxels here and there.
fn subset(number: u64) -> VoxelSet {
    let draw = |i: i32| crate::lazy::random::hash(number, 1, [i, 0, 0]);
    (0..1 + (draw(0) % 40) as i32)
        .map(|i| std::array::from_fn(|axis| (draw(3 * i + axis as i32 + 1) % 29) as i32 - 14))
        .collect()
}

type Timed = (VoxelMap, f64);

/// The voxels from the device and from CPU threads, each with the seconds it took.
fn both(solid: &LazySolid, wanted: &VoxelSet, gpu: &Gpu) -> Result<(Timed, Timed), SelfTestError> {
    let timed = |control: &dyn Control| -> Result<Timed, SolidError> {
        solid.clear_cache();
        let start = Instant::now();
        let map = solid.evaluate(wanted, control)?;
        Ok((map, start.elapsed().as_secs_f64()))
    };
    let there = timed(&OnDevice(gpu))?;
    match gpu.lost() {
        Some(reason) => Err(GpuError::Lost(reason).into()),
        None => Ok((there, timed(&())?)),
    }
}

fn differing(wanted: &VoxelSet, a: &VoxelMap, b: &VoxelMap) -> u64 {
    let color = |map: &VoxelMap, voxel| {
        let at = 3 * map.index(voxel)?;
        Some([0, 1, 2].map(|c| map.maps[0].samples.get_u8(at + c)))
    };
    wanted.voxels().filter(|&voxel| color(a, voxel) != color(b, voxel)).count() as u64
}
