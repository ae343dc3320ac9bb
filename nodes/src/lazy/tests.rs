//! What the lazy synthesis promises, over random subsets, seeds and schedules.

use std::sync::Arc;

use breccia_engine::{Data, Digest};
use proptest::prelude::*;

use super::*;
use crate::data::{BRICK_VOXELS, Image, Samples, Solid, VoxelMap, VoxelSet, local_index};
use crate::exemplar::{Exemplar, MakeSettings, make_exemplar};

/// Cells around scattered points with dark borders, the same for every caller.
fn picture(side: u32) -> Image {
    let points: Vec<[i32; 2]> = (0..side as i32 / 2)
        .map(|i| [(i * 7919 + 13) % side as i32, (i * 104_729 + i * i * 31 + 7) % side as i32])
        .collect();
    Image::from_fn(side, side, |x, y| {
        let mut nearest: Vec<i32> =
            points.iter().map(|p| (p[0] - x as i32).pow(2) + (p[1] - y as i32).pow(2)).collect();
        nearest.sort_unstable();
        let edge = (nearest[1] - nearest[0]).min(60) as u8;
        [60 + 3 * edge, 50 + 2 * edge, 40 + edge]
    })
}

pub(super) struct Stages {
    exemplar: Exemplar,
    tables: Arc<Tables>,
    initial: Initial,
}

fn stages(side: u32, levels: usize, tileable: bool) -> Stages {
    stages_with(side, levels, tileable, &[12, 16])
}

pub(super) fn exemplar_of(side: u32, levels: usize, tileable: bool) -> (Exemplar, Pyramid) {
    let make = MakeSettings { tileable, ..Default::default() };
    let exemplar = make_exemplar(&picture(side), None, None, &[], &make).expect("an exemplar");
    let pyramid = Pyramid::new(&exemplar, levels).expect("a pyramid");
    (exemplar, pyramid)
}

/// Three pictures of different sizes with maps of several forms.
pub(super) fn stages_with_maps(levels: usize) -> Stages {
    let view = |side: u32| {
        let normal = Image::from_fn(side, side, |x, y| [(x * 37) as u8, (y * 53) as u8, 200]);
        let bytes: Vec<u8> = (0..side * side).map(|i| (i * 101 % 251) as u8).collect();
        let floats = Samples::F32(bytes.iter().map(|&b| f32::from(b) / 7.0).collect());
        let grey = Image::new(side, side, 1, Samples::U8(bytes)).expect("a picture");
        let height = Image::new(side, side, 1, floats).expect("a picture");
        let maps = [("normal", &normal), ("roughness", &grey), ("height", &height)];
        make_exemplar(&picture(side), None, None, &maps, &MakeSettings::default()).expect("an exemplar")
    };
    let exemplar = crate::exemplar::combine(&view(32), &view(44), &view(36)).expect("three views");
    stages_of(exemplar, levels, &[8])
}

/// Pictures that are barred in part, as those of a matrix around particles.
pub(super) fn stages_with_barred() -> Stages {
    let mut exemplar =
        make_exemplar(&picture(32), None, None, &[], &MakeSettings::default()).expect("an exemplar");
    let view = &mut exemplar.views[0];
    view.barred = (0..32 * 32).map(|i| i % 32 < 12 && i / 32 < 14).collect();
    stages_of(exemplar, 1, &[8])
}

pub(super) fn stages_with(side: u32, levels: usize, tileable: bool, dims: &[i64]) -> Stages {
    stages_of(exemplar_of(side, levels, tileable).0, levels, dims)
}

fn stages_of(exemplar: Exemplar, levels: usize, dims: &[i64]) -> Stages {
    let pyramid = Pyramid::new(&exemplar, levels).expect("a pyramid");
    let descriptors = make_descriptors(&pyramid, dims);
    let similarity = similarity_sets(&pyramid, &descriptors, 3, &()).expect("sets");
    let candidates = make_candidates(&pyramid, &CandidateSettings::default(), &()).expect("candidates");
    let mut initial = make_slab(&pyramid, &candidates);
    initial.jitter = Some(Jitter { amount: 0.2, sigma_min: 0.3, sigma_max: 1.2, density: 3.0 });
    let tables =
        Tables::new(&exemplar, &pyramid, &descriptors, &similarity, &candidates, None).expect("tables");
    Stages { exemplar, tables: Arc::new(tables), initial }
}

/// Gives tables some contrast to restore, and weights to add.
fn weigh(tables: &mut Tables) {
    for level in &mut tables.levels {
        level.stretch = 77;
        let records = level.views.iter_mut().flat_map(|view| &mut view.records);
        records.zip(0..).for_each(|(record, i)| record.usage = i * 7919 % 1000);
    }
}

/// Tables with all that a correction may meet.
pub(super) fn tables_of_noise(dims: i64, tileable: bool) -> Tables {
    let stages = stages_with(32, 1, tileable, &[dims]);
    let mut tables = Arc::into_inner(stages.tables).expect("the only owner");
    weigh(&mut tables);
    tables
}

impl Stages {
    pub(super) fn solid(&self, settings: &Settings) -> LazySolid {
        LazySolid::new(Arc::clone(&self.tables), self.initial.clone(), settings.clone(), Digest([7; 32]))
    }
}

fn color(map: &VoxelMap, voxel: [i32; 3]) -> [u8; 3] {
    let Samples::U8(samples) = &map.maps[0].samples else { panic!("colours are bytes") };
    let at = map.index(voxel).expect("a voxel that was asked for") * 3;
    [samples[at], samples[at + 1], samples[at + 2]]
}

/// The whole box at once against `subset` alone, in a fresh solid without any finished brick.
fn same(stages: &Stages, settings: &Settings, whole: &VoxelSet, subset: &VoxelSet) {
    let all = stages.solid(settings).evaluate(whole, &()).expect("the whole");
    let few = stages.solid(settings).evaluate(subset, &()).expect("the subset");
    for voxel in subset.voxels() {
        assert_eq!(color(&all, voxel), color(&few, voxel), "voxel {voxel:?}");
    }
}

#[test]
fn one_voxel_depends_on_6778() {
    // The paper's figure (section 5.2) for N = 5, two passes, three levels: what must be there before each pass.
    let settings = Settings { passes: vec![2], schedule: vec![Schedule::Jacobi], ..Default::default() };
    let domain = Domain { period: None };
    let mut wanted = VoxelSet::from_iter([[40, 40, 40]]);
    let mut counts = Vec::new();
    for level in 0..3 {
        let need = dependency(&settings, &domain, level, &wanted);
        // The set before the last pass is what the first pass corrects.
        counts.extend([need.corrected[0].len(), need.before.len()]);
        wanted = dependency::parents(&need.before);
    }
    assert_eq!(counts, [61, 473, 569, 1749, 1111, 2815]);
    assert_eq!(counts.iter().sum::<usize>(), 6778);
}

#[test]
fn dilation_equals_its_definition() {
    for domain in
        [Domain { period: None }, Domain { period: Some([16; 3]) }, Domain { period: Some([13, 9, 10]) }]
    {
        let wrap = |v: [i32; 3]| -> [i32; 3] { std::array::from_fn(|i| domain.wrap(i, v[i])) };
        let set: VoxelSet = [[3, 4, 5], [12, 8, 0], [0, 0, 9]].into_iter().map(wrap).collect();
        let mut expected = VoxelSet::new();
        for v in set.voxels() {
            for a in -2..=2 {
                for b in -2..=2 {
                    for offset in [[a, b, 0], [a, 0, b], [0, a, b]] {
                        expected.insert(wrap(std::array::from_fn(|i| v[i] + offset[i])));
                    }
                }
            }
        }
        assert_eq!(dependency::dilate(&set, &domain), expected, "{domain:?}");
    }
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    let odd = Settings { similar: vec![1, 3], triples: vec![3, 11], ..Settings::default() };
    let mean = Settings { color: ColorRule::Mean, ..Settings::default() };
    let cases = [
        (false, [8, 16], Settings::default()),
        (true, [12, 16], Settings::default()),
        (true, [8, 8], odd),
        (false, [16, 4], mean),
    ];
    for (tileable, dims, settings) in cases {
        let mut stages = stages_with(32, 2, tileable, &dims);
        weigh(Arc::get_mut(&mut stages.tables).expect("the only owner"));
        let whole = VoxelSet::from_box([-5, 3, 9], [21, 18, 17]);
        let reference = stages.solid(&settings).with_isa(Isa::Portable).evaluate(&whole, &()).expect("it");
        for isa in available_instruction_sets() {
            let other = stages.solid(&settings).with_isa(isa).evaluate(&whole, &()).expect("it");
            assert_eq!(reference.maps, other.maps, "{isa:?}, tileable {tileable}, {dims:?}, {settings:?}");
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let stages = stages(32, 2, false);
    let whole = VoxelSet::from_box([0; 3], [24; 3]);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| stages.solid(&Settings::default()).evaluate(&whole, &()).expect("it")).maps
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(5));
}

#[test]
fn octants_in_four_steps_cover_every_voxel_once() {
    for schedule in [Schedule::Jacobi, Schedule::Parity, Schedule::Octants] {
        let mut seen = [0u64; 8];
        for step in 0..schedule.steps() {
            let subset = schedule.subset(step);
            assert!((0..8).all(|z| seen[z] & subset[z] == 0));
            (0..8).for_each(|z| seen[z] |= subset[z]);
        }
        assert_eq!(seen, [u64::MAX; 8]);
    }
}

#[test]
fn complementary_octants_do_not_see_each_other() {
    // A voxel of one octant and its neighbours in the complementary one differ by odd numbers along all axes,
    // while the crossbar's voxels share at least one coordinate.
    let one = VoxelSet::from_iter([[8, 8, 8]]);
    for v in dependency::dilate(&one, &Domain { period: None }).voxels() {
        assert!(v.iter().any(|c| (c - 8) % 2 == 0));
    }
}

#[test]
fn a_period_repeats() {
    let stages = stages(32, 2, false);
    // A period that is neither a multiple of a brick nor of the coarsest level's voxel.
    let settings = Settings { period: Some([21, 16, 19]), ..Default::default() };
    let solid = stages.solid(&settings);
    let first = solid.evaluate(&VoxelSet::from_box([0; 3], [21, 16, 19]), &()).expect("one period");
    let there = solid.evaluate(&VoxelSet::from_box([-21, 32, 19], [21, 16, 19]), &()).expect("another");
    for v in VoxelSet::from_box([0; 3], [21, 16, 19]).voxels() {
        assert_eq!(color(&first, v), color(&there, [v[0] - 21, v[1] + 32, v[2] + 19]));
    }
}

#[test]
fn neighbouring_requests_share_finished_bricks() {
    let stages = stages(32, 2, false);
    let solid = stages.solid(&Settings::default());
    let slab = |z: i32| VoxelSet::from_box([0, 0, z], [16, 16, 1]);
    let (_, cold) = solid.evaluate_counting(&slab(0), &()).expect("it");
    let (_, again) = solid.evaluate_counting(&slab(0), &()).expect("it");
    assert!(cold.corrections[0] > 0);
    assert_eq!(again.corrections, [0, 0]);
}

#[test]
fn colours_come_from_the_exemplar() {
    let stages = stages(32, 2, false);
    let map =
        stages.solid(&Settings::default()).evaluate(&VoxelSet::from_box([0; 3], [8; 3]), &()).expect("it");
    let known: std::collections::HashSet<[u8; 4]> = stages.exemplar.views[0].texels.iter().copied().collect();
    for at in 0..BRICK_VOXELS {
        let v = [at & 7, at >> 3 & 7, at >> 6].map(|c| c as i32);
        assert_eq!(local_index(v), at);
        let [r, g, b] = color(&map, v);
        assert!(known.iter().any(|t| t[..3] == [r, g, b]));
    }
}

#[test]
fn stages_survive_the_disk_cache() {
    let exemplar =
        make_exemplar(&picture(24), None, None, &[], &MakeSettings::default()).expect("an exemplar");
    let pyramid = Pyramid::new(&exemplar, 2).expect("a pyramid");
    let descriptors = make_descriptors(&pyramid, &[12]);
    let candidates = make_candidates(&pyramid, &CandidateSettings::default(), &()).expect("candidates");
    let slab = make_slab(&pyramid, &candidates);
    assert_eq!(Pyramid::decode(&pyramid.encode().expect("bytes")), Ok(pyramid));
    assert_eq!(Descriptors::decode(&descriptors.encode().expect("bytes")), Ok(descriptors));
    let bytes = candidates.encode().expect("bytes");
    assert!(Candidates::decode(&bytes[..bytes.len() - 1]).is_err());
    assert_eq!(Candidates::decode(&bytes), Ok(candidates));
    assert_eq!(Initial::decode(&slab.encode().expect("bytes")), Ok(slab));
    assert_eq!(Exemplar::decode(&exemplar.encode().expect("bytes")), Ok(exemplar));
}

#[test]
fn candidates_fit_better_than_chance_and_keep_to_their_number() {
    let exemplar =
        make_exemplar(&picture(32), None, None, &[], &MakeSettings::default()).expect("an exemplar");
    let pyramid = Pyramid::new(&exemplar, 1).expect("a pyramid");
    let settings = CandidateSettings { keep: 7, ..Default::default() };
    let candidates = make_candidates(&pyramid, &settings, &()).expect("candidates");
    let (view, set) = (&pyramid.levels[0][0], &candidates.levels[0][0]);
    assert!(set.counts.iter().all(|&n| (1..=7).contains(&n)));
    let crossbar = |p: Pixel, next: Pixel, last: Pixel| -> u32 {
        use super::candidates::{column_strip, row_strip};
        [(p, next), (next, last), (last, p)]
            .iter()
            .flat_map(|&(a, b)| column_strip(view, a).into_iter().zip(row_strip(view, b)))
            .map(|(a, b)| (i32::from(a) - i32::from(b)).pow(2) as u32)
            .sum()
    };
    let (mut kept, mut chance) = (0u64, 0u64);
    let centres = view.centres();
    for (i, &p) in centres.iter().enumerate() {
        let triple = set.triples[view.index(p)][0];
        assert_eq!(triple.crossbar, crossbar(p, triple.next, triple.last));
        kept += u64::from(triple.crossbar);
        chance += u64::from(crossbar(
            p,
            centres[(i * 61 + 17) % centres.len()],
            centres[(i * 29 + 5) % centres.len()],
        ));
    }
    assert!(kept * 4 < chance, "{kept} against {chance}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn lazy_equals_full(
        seed in any::<u64>(),
        fine in 0usize..3,
        coarse in 0usize..3,
        passes in 1i64..3,
        period in prop::option::of(prop::array::uniform3(9u32..24)),
        picks in prop::collection::vec(prop::array::uniform3(-6i32..14), 1..12),
    ) {
        static STAGES: std::sync::OnceLock<Stages> = std::sync::OnceLock::new();
        let stages = STAGES.get_or_init(|| stages(32, 2, false));
        let schedules = [Schedule::Jacobi, Schedule::Parity, Schedule::Octants];
        let settings = Settings {
            seed,
            period,
            passes: vec![passes, 2],
            schedule: vec![schedules[fine], schedules[coarse]],
            ..Default::default()
        };
        let whole = VoxelSet::from_box([-6; 3], [20; 3]);
        same(stages, &settings, &whole, &picks.iter().copied().collect());
    }

    #[test]
    fn any_decomposition_in_any_order_gives_the_same(
        cut in prop::array::uniform3(1u32..19),
        reverse in any::<bool>(),
    ) {
        static STAGES: std::sync::OnceLock<Stages> = std::sync::OnceLock::new();
        let stages = STAGES.get_or_init(|| stages(32, 2, true));
        let settings = Settings::default();
        let all = stages.solid(&settings).evaluate(&VoxelSet::from_box([0; 3], [20; 3]), &()).expect("the whole");
        // Eight boxes around one corner, asked of one solid that remembers finished bricks.
        let solid = stages.solid(&settings);
        let mut parts: Vec<usize> = (0..8).collect();
        if reverse {
            parts.reverse();
        }
        for part in parts {
            let far = |i: usize| part >> i & 1 == 1;
            let origin = std::array::from_fn(|i| if far(i) { cut[i] as i32 } else { 0 });
            let size = std::array::from_fn(|i| if far(i) { 20 - cut[i] } else { cut[i] });
            let set = VoxelSet::from_box(origin, size);
            let map = solid.evaluate(&set, &()).expect("a part");
            for v in set.voxels() {
                prop_assert_eq!(color(&all, v), color(&map, v));
            }
        }
    }
}

#[test]
fn without_a_mask_synthesis_starts_at_a_finer_level() {
    let levels = |side: u32, masked: bool| {
        let mask =
            Image::from_fn(side, side, |x, y| if (x / 8 + y / 8) % 2 == 0 { [255; 3] } else { [0; 3] });
        let make = MakeSettings { max_size: 256, ..Default::default() };
        let exemplar =
            make_exemplar(&picture(side), masked.then_some(&mask), None, &[], &make).expect("an exemplar");
        Pyramid::new(&exemplar, 0).expect("a pyramid").levels.len()
    };
    assert_eq!([16, 32, 64, 128, 256].map(|side| levels(side, true)), [1, 1, 2, 3, 4]);
    assert_eq!([16, 32, 64, 128, 256].map(|side| levels(side, false)), [1, 1, 2, 2, 3]);
    // Three views of a directed material start coarse.
    let mut three =
        make_exemplar(&picture(128), None, None, &[], &MakeSettings::default()).expect("an exemplar");
    three.views = vec![three.views[0].clone(); 3];
    assert_eq!(Pyramid::new(&three, 0).expect("a pyramid").levels.len(), 3);
}
