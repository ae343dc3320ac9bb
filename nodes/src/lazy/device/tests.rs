//! The device's answers against the processor's.

use std::sync::{Arc, OnceLock};

use breccia_shaders::{GpuError, GpuSettings, kernels};
use proptest::prelude::*;

use crate::control::testing::{OnDevice, cases};
use crate::control::{Control, Stopped};
use crate::data::{Solid, SolidError, VoxelSet};
use crate::lazy::random::hash;
use crate::lazy::tests::{Stages, exemplar_of, stages_with};
use crate::lazy::{
    CandidateSettings, ColorRule, LevelView, Pyramid, Schedule, Settings, make_candidates, make_descriptors,
    similarity_sets,
};

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

pub(super) fn some_settings() -> impl Strategy<Value = Settings> {
    // Octants seldom: one voxel needs tens of thousands of corrections then.
    let schedule =
        prop_oneof![40 => Just(Schedule::Jacobi), 4 => Just(Schedule::Parity), 1 => Just(Schedule::Octants)];
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
    let subsets = (0..kinds().len(), some_settings(), some_voxels());
    let result = cases(1000).run(&subsets, |(kind, settings, voxels)| {
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

#[test]
fn on_the_device_cancelling_works_between_submissions() {
    for questions in [0, 1, 2, 3] {
        let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
        let control = device.patient(questions);
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

/// Pyramids of one level of one or three views that differ in size and edges, some with pixels that must not be copied, of few
/// colours, so that many neighbourhoods are equal.
fn some_pyramid() -> impl Strategy<Value = Pyramid> {
    let view = (8..30i32, 8..30i32, any::<bool>(), any::<u64>(), 0..4u32);
    let views = prop_oneof![prop::collection::vec(view.clone(), 1), prop::collection::vec(view, 3)];
    views.prop_map(|views| {
        let view = |(width, height, tileable, seed, barred): (i32, i32, bool, u64, u32)| {
            let at = |i: i32| [i % width, i / width, 0];
            let texel = |i: i32| {
                let [x, y, _] = at(i);
                let grey = (hash(seed, 1, [x / 2, y / 3, 0]) % 4) as u8;
                [grey * 80, grey * 30, 200 - grey * 60, (hash(seed, 2, at(i)) % 2) as u8 * 9]
            };
            // None, some, most or all pixels.
            let barred_at =
                |i: i32| [false, hash(seed, 3, at(i)).is_multiple_of(4), i != 40, true][barred as usize];
            LevelView {
                width,
                height,
                tileable,
                texels: (0..width * height).map(texel).collect(),
                barred: if barred == 0 { Vec::new() } else { (0..width * height).map(barred_at).collect() },
            }
        };
        Pyramid { levels: vec![views.into_iter().map(view).collect()] }
    })
}

#[test]
fn on_the_device_similarity_sets_are_the_same() {
    let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
    let result = cases(60).run(&(some_pyramid(), 1..17i32, 2..17i64), |(pyramid, spread, dims)| {
        let descriptors = make_descriptors(&pyramid, &[dims]);
        let on_cpu = similarity_sets(&pyramid, &descriptors, spread, &()).unwrap();
        prop_assert_eq!(similarity_sets(&pyramid, &descriptors, spread, &device).unwrap(), on_cpu);
        Ok(())
    });
    result.unwrap();
    assert_eq!(device.losses(), 0);
}

#[test]
fn on_the_device_candidates_are_the_same() {
    let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
    let settings = (1..90usize, 1..120usize, 1..13usize, 0..3usize, 0..9i32).prop_map(
        |(strips, best, keep, iterations, exclusion)| CandidateSettings {
            strips,
            best,
            keep,
            iterations,
            exclusion,
        },
    );
    let result = cases(20).run(&(some_pyramid(), settings), |(pyramid, settings)| {
        let on_cpu = make_candidates(&pyramid, &settings, &()).unwrap();
        prop_assert!(make_candidates(&pyramid, &settings, &device).unwrap() == on_cpu);
        Ok(())
    });
    result.unwrap();
    assert_eq!(device.losses(), 0);
    assert!(device.gpu.traffic().dispatches >= 20);
}

#[test]
fn on_the_device_as_many_strips_and_triples_as_there_may_be_are_the_same() {
    // So little memory that triples are made in several portions.
    let settings = GpuSettings { memory: 600_000, ..Default::default() };
    let Some(device) = OnDevice::open(settings) else { return };
    let (_, pyramid) = exemplar_of(32, 1, true);
    let settings = CandidateSettings { strips: 256, best: 400, exclusion: 2, ..Default::default() };
    let on_cpu = make_candidates(&pyramid, &settings, &()).unwrap();
    assert!(make_candidates(&pyramid, &settings, &device).unwrap() == on_cpu);
}

#[test]
fn on_the_device_that_is_lost_the_processor_prepares() {
    let (_, pyramid) = exemplar_of(32, 2, false);
    let descriptors = make_descriptors(&pyramid, &[8]);
    for dispatches in [0, 1] {
        let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
        device.gpu.lose_after(dispatches);
        let sets = similarity_sets(&pyramid, &descriptors, 3, &device).unwrap();
        assert!(sets == similarity_sets(&pyramid, &descriptors, 3, &()).unwrap());
        let candidates = make_candidates(&pyramid, &CandidateSettings::default(), &device).unwrap();
        assert!(candidates == make_candidates(&pyramid, &CandidateSettings::default(), &()).unwrap());
        assert_eq!(device.losses(), 2, "after {dispatches} dispatches");
    }
}

#[test]
fn on_the_device_preparing_stops_when_it_is_told_to() {
    let (_, pyramid) = exemplar_of(32, 2, false);
    let descriptors = make_descriptors(&pyramid, &[8]);
    for questions in [0, 1] {
        let open = || Some(OnDevice::open(GpuSettings::default())?.patient(questions));
        let (Some(one), Some(other)) = (open(), open()) else { return };
        let sets = similarity_sets(&pyramid, &descriptors, 3, &one);
        assert_eq!(sets.err(), Some(Stopped::Cancelled));
        let candidates = make_candidates(&pyramid, &CandidateSettings::default(), &other);
        assert_eq!(candidates.err(), Some(Stopped::Cancelled));
    }
}

#[test]
fn on_the_device_wrong_kernels_of_the_preparation_are_noticed() {
    let (_, pyramid) = exemplar_of(32, 1, false);
    let descriptors = make_descriptors(&pyramid, &[8]);
    for (right, wrong) in
        [(">= params.keep", ">= params.keep - 60u"), ("< params.size.w", "<= params.size.w")]
    {
        let Some(device) = OnDevice::mistaken(&kernels::SIMILAR, right, wrong) else { return };
        let ask = |control: &dyn Control| similarity_sets(&pyramid, &descriptors, 3, control).unwrap();
        assert!(ask(&device) != ask(&()), "{wrong}");
    }
    for (right, wrong) in [("< params.exclusion", "<= params.exclusion"), ("i < 5u", "i < 4u")] {
        let Some(device) = OnDevice::mistaken(&kernels::TRIPLES, right, wrong) else { return };
        let settings = CandidateSettings { iterations: 0, ..Default::default() };
        let ask = |control: &dyn Control| make_candidates(&pyramid, &settings, control).unwrap();
        assert!(ask(&device) != ask(&()), "{wrong}");
    }
}
