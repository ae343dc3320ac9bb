//! The device's answers against the processor's.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};

use breccia_shaders::{Gpu, GpuError, GpuSettings};
use proptest::prelude::*;

use crate::control::Control;
use crate::control::testing::OnDevice;
use crate::data::{Filter, MapInfo, Solid, SolidError, Tap, VoxelSet};
use crate::lazy::tests::{Stages, stages_with, stages_with_barred, stages_with_maps};
use crate::lazy::{ColorRule, Schedule, Settings};
use crate::mesh::{BakeSettings, bake_solid};
use crate::solid::{CheckerSolid, Plane, sample, slice};

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
    let mut runner = deterministic(1000);
    let cases = (0..kinds().len(), some_settings(), some_voxels());
    let result = runner.run(&cases, |(kind, settings, voxels)| {
        same(&kinds()[kind], &settings, &voxels, &device);
        Ok(())
    });
    result.unwrap();
    assert_eq!(device.losses(), 0);
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
        assert!(device.losses() > 0, "after {dispatches} dispatches");
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

fn deterministic(cases: u32) -> proptest::test_runner::TestRunner {
    proptest::test_runner::TestRunner::new_with_rng(
        ProptestConfig { cases, failure_persistence: None, ..Default::default() },
        proptest::test_runner::TestRng::deterministic_rng(proptest::test_runner::RngAlgorithm::ChaCha),
    )
}

/// Exemplars whose maps are sampled.
fn sampled_kinds() -> &'static [Stages] {
    static KINDS: OnceLock<Vec<Stages>> = OnceLock::new();
    KINDS.get_or_init(|| vec![stages_with_maps(1), stages_with_maps(2), stages_with(32, 2, false, &[8])])
}

/// The maps of a solid that devices can sample.
fn of_bytes(solid: &dyn Solid) -> Vec<MapInfo> {
    solid.maps().into_iter().filter(crate::solid::device::can_sample).collect()
}

fn same_samples(solid: &dyn Solid, fresh: &dyn Solid, taps: &[Tap], device: &OnDevice) {
    let infos = of_bytes(solid);
    let on_cpu = sample(solid, &infos, taps, &()).expect("samples");
    let on_gpu = fresh.sample(&device.gpu, &infos, taps, device).expect("samples").expect("on the device");
    assert_eq!(on_gpu, on_cpu, "{taps:?}");
}

#[test]
fn on_the_device_samples_at_random_points_are_the_same_bit_for_bit() {
    let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
    let place = prop_oneof![Just([0.0; 3]), Just([-1_000_000.0, 7.25, 900_000.0]), Just([-9.0, -3.5, 5.0])];
    let one = prop::array::uniform3(-9.0f64..9.0);
    let filter = prop_oneof![Just(Filter::Nearest), Just(Filter::Trilinear)];
    let points = (place, filter, prop::collection::vec(one, 1..20));
    let cases = (0..sampled_kinds().len(), some_settings(), points);
    let result = deterministic(200).run(&cases, |(kind, settings, (place, filter, points))| {
        let stages = &sampled_kinds()[kind];
        let tap = |point: &[f64; 3]| Tap::new(std::array::from_fn(|i| place[i] + point[i]), filter);
        let taps: Vec<Tap> = points.iter().filter_map(tap).collect();
        same_samples(&stages.solid(&settings), &stages.solid(&settings), &taps, &device);
        Ok(())
    });
    result.unwrap();
    assert_eq!(device.losses(), 0);
}

#[test]
fn on_the_device_random_oblique_slices_are_the_same_bit_for_bit() {
    let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
    let vector = |reach: f64| prop::array::uniform3(-reach..reach);
    let cases =
        (0..sampled_kinds().len(), some_settings(), vector(50.0), vector(1.0), 0.2f64..2.0, 0usize..4);
    let result = deterministic(24).run(&cases, |(kind, settings, center, normal, scale, map)| {
        let stages = &sampled_kinds()[kind];
        // Octants take seconds a picture.
        let settings = Settings { schedule: vec![Schedule::Jacobi], ..settings };
        let plane = Plane::new(center, normal, 360.0 * scale, scale).expect("a plane");
        let solid = stages.solid(&settings);
        let infos = solid.maps();
        let map = &infos[map % infos.len()].name;
        let of = |solid: &dyn Solid, control: &dyn Control| {
            slice(solid, &plane, [23, 17], Filter::Trilinear, map, control).expect("a slice")
        };
        assert_eq!(of(&stages.solid(&settings), &device), of(&solid, &()), "{map} {plane:?} {settings:?}");
        Ok(())
    });
    result.unwrap();
    assert_eq!(device.losses(), 0);
}

#[test]
fn on_the_device_samples_around_taken_voxels_are_the_same() {
    let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
    let stages = stages_with_barred();
    let solid = || {
        let taken = CheckerSolid { colors: [[0; 3], [255; 3]], cell: 5, noise: 0, seed: 1 };
        let settings = Settings { period: Some([20, 24, 16]), ..Default::default() };
        stages.solid(&settings).with_taken(Arc::new(taken)).expect("a solid with holes")
    };
    let point = |i: u32| [0.37, 0.61, -0.43].map(|step| f64::from(i) * step - 20.0);
    let taps: Vec<Tap> = (0..90).filter_map(|i| Tap::new(point(i), Filter::Trilinear)).collect();
    same_samples(&solid(), &solid(), &taps, &device);
}

#[test]
fn on_the_device_a_slice_comes_back_as_texels_alone() {
    let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
    let solid = sampled_kinds()[2].solid(&Settings::default());
    let plane = Plane::new([3.0; 3], [1.0, 2.0, -3.0], 0.0, 0.7).expect("a plane");
    let ask = || slice(&solid, &plane, [32, 32], Filter::Trilinear, "color", &device).expect("a slice");
    let first = ask();
    let traffic = device.gpu.traffic();
    assert_eq!(traffic.downloaded, 32 * 32 * 4);
    // What was synthesised stays.
    assert_eq!(ask(), first);
    assert_eq!(device.gpu.traffic().dispatches, traffic.dispatches + 1);
}

#[test]
fn on_the_device_a_slice_in_many_portions_is_the_same() {
    // Room for a few dozen bricks at once.
    let Some(device) = OnDevice::open(GpuSettings { memory: 4 << 20, ..Default::default() }) else { return };
    let stages = &sampled_kinds()[2];
    let plane = Plane::new([3.0; 3], [1.0, 2.0, -3.0], 0.0, 1.0).expect("a plane");
    let of = |control: &dyn Control| {
        slice(&stages.solid(&Settings::default()), &plane, [64, 48], Filter::Trilinear, "color", control)
    };
    assert_eq!(of(&device).expect("a slice"), of(&()).expect("a slice"));
    assert_eq!(device.gpu.traffic().downloaded, 64 * 48 * 4);
}

#[test]
fn on_the_device_a_mesh_is_baked_the_same() {
    let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
    let settings = BakeSettings {
        resolution: 24,
        texture_size: 64,
        gutter: 2,
        origin: [-7, 100, 3],
        block: 16,
        ..Default::default()
    };
    // The first has a map that devices cannot sample, the second has none.
    for kind in [0, 2] {
        let stages = &sampled_kinds()[kind];
        let mesh = crate::mesh::tests::torus(16, 8);
        let bake = |control: &dyn Control| {
            bake_solid(&mesh, &stages.solid(&Settings::default()), settings, control).expect("a mesh")
        };
        assert_eq!(bake(&device), bake(&()));
    }
}

#[test]
fn on_the_device_that_is_lost_a_slice_goes_on() {
    let stages = &sampled_kinds()[2];
    let plane = Plane::new([3.0; 3], [1.0, 2.0, -3.0], 0.0, 1.0).expect("a plane");
    let of = |control: &dyn Control| {
        slice(&stages.solid(&Settings::default()), &plane, [16, 16], Filter::Trilinear, "color", control)
            .expect("a slice")
    };
    let expected = of(&());
    for dispatches in [0, 9] {
        let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
        device.gpu.lose_after(dispatches);
        assert_eq!(of(&device), expected);
        assert!(device.losses() > 0, "after {dispatches} dispatches");
    }
    // Once the bricks are there, the first dispatch is the one that samples.
    let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
    assert_eq!((of(&device), device.losses()), (expected.clone(), 0));
    device.gpu.lose_after(0);
    assert_eq!(of(&device), expected);
    assert!(device.losses() > 0);
}

#[test]
fn on_the_device_cancelling_stops_a_slice() {
    for questions in [0, 2, 4] {
        let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
        let control = Impatient(device, AtomicU32::new(questions));
        let plane = Plane::new([3.0; 3], [1.0, 2.0, -3.0], 0.0, 1.0).expect("a plane");
        let solid = sampled_kinds()[2].solid(&Settings::default());
        let answer = slice(&solid, &plane, [16, 16], Filter::Trilinear, "color", &control);
        assert!(
            matches!(answer, Err(crate::solid::PlaneError::Solid(SolidError::Cancelled))),
            "after {questions} questions"
        );
    }
}
