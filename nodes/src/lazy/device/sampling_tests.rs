//! Slices and bakes on the device against the processor's.

use std::sync::{Arc, OnceLock};

use breccia_shaders::GpuSettings;
use proptest::prelude::*;

use super::tests::some_settings;
use crate::control::Control;
use crate::control::testing::{OnDevice, cases};
use crate::data::{Filter, MapInfo, Solid, SolidError, Tap};
use crate::lazy::tests::{Stages, stages_with, stages_with_barred, stages_with_maps};
use crate::lazy::{Schedule, Settings};
use crate::mesh::{BakeSettings, bake_solid};
use crate::solid::{CheckerSolid, Plane, sample, slice};

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
    let inputs = (0..sampled_kinds().len(), some_settings(), points);
    let result = cases(200).run(&inputs, |(kind, settings, (place, filter, points))| {
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
    let inputs =
        (0..sampled_kinds().len(), some_settings(), vector(50.0), vector(1.0), 0.2f64..2.0, 0usize..4);
    let result = cases(24).run(&inputs, |(kind, settings, center, normal, scale, map)| {
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
        let control = device.patient(questions);
        let plane = Plane::new([3.0; 3], [1.0, 2.0, -3.0], 0.0, 1.0).expect("a plane");
        let solid = sampled_kinds()[2].solid(&Settings::default());
        let answer = slice(&solid, &plane, [16, 16], Filter::Trilinear, "color", &control);
        assert!(
            matches!(answer, Err(crate::solid::PlaneError::Solid(SolidError::Cancelled))),
            "after {questions} questions"
        );
    }
}
