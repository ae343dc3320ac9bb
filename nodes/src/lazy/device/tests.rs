//! The device's answers against the processor's.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};

use breccia_shaders::{Gpu, GpuError, GpuSettings, testing};
use proptest::prelude::*;

use crate::control::Control;
use crate::data::{Solid, SolidError, VoxelSet};
use crate::lazy::tests::{Stages, stages_with};
use crate::lazy::{ColorRule, Schedule, Settings};

/// Whoever asks for work on a device.
struct OnDevice {
    gpu: Gpu,
    losses: AtomicU32,
}

impl OnDevice {
    fn open(settings: GpuSettings) -> Option<Self> {
        Some(Self { gpu: testing::gpu(settings)?, losses: AtomicU32::new(0) })
    }
}

impl Control for OnDevice {
    fn gpu(&self) -> Option<&Gpu> {
        Some(&self.gpu)
    }

    fn device_lost(&self, _: &GpuError) {
        self.losses.fetch_add(1, Ordering::Relaxed);
    }
}

/// Exemplars of several kinds: levels, edges, components.
fn kinds() -> &'static [Stages] {
    static KINDS: OnceLock<Vec<Stages>> = OnceLock::new();
    KINDS.get_or_init(|| {
        vec![
            stages_with(32, 2, false, &[8, 16]),
            stages_with(32, 1, true, &[12]),
            stages_with(48, 3, false, &[8]),
        ]
    })
}

fn same(stages: &Stages, settings: &Settings, wanted: &VoxelSet, device: &OnDevice) {
    let on_cpu = stages.solid(settings).evaluate(wanted, &()).expect("an answer");
    let on_gpu = stages.solid(settings).evaluate(wanted, device).expect("an answer");
    for voxel in wanted.voxels() {
        let of = |map: &crate::data::VoxelMap| {
            let at = map.index(voxel).expect("a voxel that was asked for") * 3;
            [0, 1, 2].map(|c| map.maps[0].samples.get_u8(at + c))
        };
        assert_eq!(of(&on_gpu), of(&on_cpu), "voxel {voxel:?} with {settings:?}");
    }
}

fn some_settings() -> impl Strategy<Value = Settings> {
    // Octants seldom: one voxel needs tens of thousands of corrections then.
    let schedule =
        prop_oneof![12 => Just(Schedule::Jacobi), 2 => Just(Schedule::Parity), 1 => Just(Schedule::Octants)];
    let period = prop_oneof![
        Just(None),
        Just(Some([16, 24, 32])),
        (8u32..29, 8u32..29, 8u32..29).prop_map(|(x, y, z)| Some([x, y, z])),
    ];
    (any::<u64>(), period, 0i64..3, schedule.clone(), schedule, 1i64..5, 0i64..13, any::<bool>()).prop_map(
        |(seed, period, passes, fine, coarse, similar, triples, mean)| Settings {
            seed,
            period,
            passes: vec![passes, 1],
            schedule: vec![fine, coarse],
            similar: vec![similar, 4],
            triples: vec![triples, 12],
            color: if mean { ColorRule::Mean } else { ColorRule::Nearest },
            ..Settings::default()
        },
    )
}

fn some_voxels() -> impl Strategy<Value = VoxelSet> {
    let place = prop_oneof![Just([0; 3]), Just([-1_000_000, 7, 900_000]), Just([-9, -3, 5])];
    let one = [-9i32..9, -9..9, -9..9];
    (place, prop::collection::vec(one, 1..12)).prop_map(|(place, voxels)| {
        voxels.into_iter().map(|v| std::array::from_fn(|i| place[i] + v[i])).collect()
    })
}

#[test]
fn on_the_device_a_thousand_random_subsets_are_the_same_bit_for_bit() {
    let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
    let config = ProptestConfig { cases: 1000, failure_persistence: None, ..Default::default() };
    let mut runner = proptest::test_runner::TestRunner::new_with_rng(
        config,
        proptest::test_runner::TestRng::deterministic_rng(proptest::test_runner::RngAlgorithm::ChaCha),
    );
    let cases = (0..kinds().len(), some_settings(), some_voxels());
    let result = runner.run(&cases, |(kind, settings, voxels)| {
        same(&kinds()[kind], &settings, &voxels, &device);
        Ok(())
    });
    result.unwrap();
    assert_eq!(device.losses.load(Ordering::Relaxed), 0);
}

#[test]
fn on_the_device_a_volume_in_many_portions_is_the_same() {
    // Room for a few dozen bricks at once.
    let settings = GpuSettings { memory: 4 << 20, ..Default::default() };
    let Some(device) = OnDevice::open(settings) else { return };
    let wanted = VoxelSet::from_box([-5, 3, 0], [40, 33, 24]);
    same(&kinds()[0], &Settings::default(), &wanted, &device);
    assert!(device.gpu.traffic().peak_memory <= 4 << 20);
    assert!(device.gpu.traffic().submissions > 10);
}

#[test]
fn on_the_device_that_is_lost_the_processor_goes_on() {
    for dispatches in [0, 5, 23] {
        let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
        device.gpu.lose_after(dispatches);
        let wanted = VoxelSet::from_box([0; 3], [24; 3]);
        same(&kinds()[0], &Settings::default(), &wanted, &device);
        assert!(device.losses.load(Ordering::Relaxed) > 0, "after {dispatches} dispatches");
    }
}

#[test]
fn on_the_device_what_does_not_fit_is_refused_by_its_size() {
    let settings = GpuSettings { memory: 60_000, ..Default::default() };
    let Some(device) = OnDevice::open(settings) else { return };
    let solid = kinds()[0].solid(&Settings::default());
    match solid.evaluate(&VoxelSet::from_box([0; 3], [8; 3]), &device) {
        Err(SolidError::Device(GpuError::OutOfMemory(message))) => {
            assert!(message.contains("bytes"), "{message}")
        }
        other => panic!("{:?}", other.err()),
    }
}

/// Cancels after some questions.
struct Impatient(OnDevice, AtomicU32);

impl Control for Impatient {
    fn gpu(&self) -> Option<&Gpu> {
        Some(&self.0.gpu)
    }

    fn is_cancelled(&self) -> bool {
        self.1.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1)).is_err()
    }
}

#[test]
fn on_the_device_cancelling_works_between_submissions() {
    for questions in [0, 1, 2, 3] {
        let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
        let control = Impatient(device, AtomicU32::new(questions));
        let solid = kinds()[0].solid(&Settings::default());
        let answer = solid.evaluate(&VoxelSet::from_box([0; 3], [32; 3]), &control);
        assert!(matches!(answer, Err(SolidError::Cancelled)), "after {questions} questions");
    }
}

#[test]
fn on_the_device_tables_stay_until_others_need_the_room() {
    let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
    let solid = Arc::new(kinds()[0].solid(&Settings::default()));
    let ask = |at: i32| {
        let before = device.gpu.traffic().uploaded;
        solid.evaluate(&VoxelSet::from_box([at; 3], [2; 3]), &device).unwrap();
        device.gpu.traffic().uploaded - before
    };
    let (first, second) = (ask(0), ask(1000));
    assert!(second + 200_000 < first, "{first} bytes, then {second}");
}
