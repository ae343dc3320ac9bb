//! Search and solve against plain tellings of the same, and properties of whole optimisations.

use breccia_shaders::{GpuError, GpuSettings, kernels};
use proptest::prelude::*;

use super::matches as codes;
use super::search::search_with;
use super::solve::solve_with;
use super::*;
use crate::control::testing::{OnDevice, cases};
use crate::control::{Control, Stopped};
use crate::data::{Image, Samples};
use crate::lazy::random::hash;
use crate::lazy::{LevelView, Pixel, Pyramid, available_instruction_sets};
use crate::search::{Keep, Patches, SimilarSets, Window, patch_basis, patches, similar_sets};
use breccia_engine::Data;

fn view(width: i32, height: i32, tileable: bool, seed: u64) -> LevelView {
    let texels = (0..width * height)
        .map(|i| {
            let (x, y) = (i % width, i / width);
            // Blobs, with some noise on top.
            let blob = ((x / 4) * 37 + (y / 5) * 91 + (x / 4) * (y / 5) * 13) % 200;
            let noise = (hash(seed, 1, [x, y, 0]) % 40) as i32;
            [(blob + noise) as u8, (200 - blob + noise / 2) as u8, (noise * 3) as u8, (blob / 2) as u8]
        })
        .collect();
    LevelView { width, height, tileable, texels, barred: Vec::new() }
}

#[derive(Debug)]
struct Scene {
    pyramid: Pyramid,
    patches: Patches,
    sets: SimilarSets,
    field: Field,
}

fn scene(views: Vec<LevelView>, window: i32, size: [usize; 3]) -> Scene {
    let pyramid = Pyramid { levels: vec![views] };
    let keep = Keep { dims: 16, variance: 1.0 };
    let basis = patch_basis(&pyramid, 0, Window { size: window }, keep, &()).unwrap();
    let patches = patches(&pyramid, &basis, &()).unwrap();
    let sets = similar_sets(&patches, 4, 1, &()).unwrap();
    let field = start(size, 0, &pyramid.levels[0], 5);
    Scene { pyramid, patches, sets, field }
}

fn scenes() -> Vec<Scene> {
    let three = (0..3).map(|i| view(20 + i, 24 - i, i == 1, i as u64)).collect();
    vec![
        scene(vec![view(24, 20, false, 1)], 5, [13, 10, 9]),
        scene(vec![view(16, 16, true, 2)], 4, [8, 12, 10]),
        scene(three, 6, [9, 11, 8]),
    ]
}

fn settings(method: Method) -> SearchSettings {
    SearchSettings { method, reach: 1, index: 4.0, directions: [true; 3], seed: 3, sweep: 1 }
}

fn solving(solver: Solver) -> SolveSettings {
    let weights = WeightSettings { position: 100.0, smoothing: 1, color: 200.0 };
    SolveSettings { solver, gamma: 0.8, weights, seed: 3, sweep: 1 }
}

/// Where a direction's window lies: the voxel so many columns and rows away.
fn away(size: [usize; 3], voxel: [usize; 3], direction: usize, along: i32, across: i32) -> usize {
    let mut at = voxel.map(|c| c as i32);
    at[(direction + 1) % 3] += along;
    at[(direction + 2) % 3] += across;
    let [x, y, z] = std::array::from_fn(|a| at[a].rem_euclid(size[a] as i32) as usize);
    (z * size[1] + y) * size[0] + x
}

fn voxels(size: [usize; 3]) -> impl Iterator<Item = (usize, [usize; 3])> {
    let [w, h, d] = size;
    (0..w * h * d).map(move |i| (i, [i % w, i / w % h, i / (w * h)]))
}

/// The squared distance of a voxel's window to a pixel's, in the basis, told plainly.
fn plain_distance(scene: &Scene, direction: usize, voxel: [usize; 3], pixel: Pixel) -> u32 {
    let v = scene.patches.view(direction);
    let basis = &scene.patches.basis;
    let mut samples = Vec::new();
    for (c, r) in scene.patches.window().offsets() {
        samples.extend(scene.field.colors[away(scene.field.size, voxel, direction, c, r)].map(i32::from));
    }
    let level = &scene.pyramid.levels[0][v];
    let stored = scene.patches.views[v].coefficients(level.index(pixel));
    let mut sum = 0i64;
    for (d, &stored) in stored.iter().enumerate() {
        let mut coefficient = basis.bias[v][d];
        for (i, sample) in samples.iter().enumerate() {
            coefficient += sample * i32::from(basis.weights[v][i / 2 * 2 * basis.dims + d * 2 + i % 2]);
        }
        sum += (i64::from(coefficient >> 10) - i64::from(stored)).pow(2);
    }
    sum as u32
}

#[test]
fn an_exhaustive_search_finds_the_nearest_of_all() {
    for scene in scenes() {
        let plain = SearchSettings { index: 0.0, ..settings(Method::Exhaustive) };
        let matches = search(&scene.field, &scene.patches, None, None, &plain, &()).unwrap();
        for (i, voxel) in voxels(scene.field.size).step_by(7) {
            for direction in 0..3 {
                let view = &scene.pyramid.levels[0][scene.patches.view(direction)];
                let centres = scene.patches.window().pixels_of(view);
                let least =
                    centres.iter().map(|&p| plain_distance(&scene, direction, voxel, p)).min().unwrap();
                let found = matches.directions[direction].pixels[i];
                assert!(centres.contains(&found));
                assert_eq!(plain_distance(&scene, direction, voxel, found), least);
                assert_eq!(matches.directions[direction].codes[i], codes::code(least));
            }
        }
    }
}

#[test]
fn a_coherent_search_takes_the_nearest_of_what_is_proposed() {
    for scene in scenes() {
        let plain = SearchSettings { index: 0.0, ..settings(Method::Coherent) };
        let matches = search(&scene.field, &scene.patches, Some(&scene.sets), None, &plain, &()).unwrap();
        for (i, voxel) in voxels(scene.field.size).step_by(11) {
            for direction in 0..3 {
                let v = scene.patches.view(direction);
                let view = &scene.pyramid.levels[0][v];
                let window = scene.patches.window();
                let centres = window.pixels_of(view);
                let mut proposed = Vec::new();
                for (c, r) in window.offsets() {
                    let source = scene.field.sources[v][away(scene.field.size, voxel, direction, c, r)];
                    let (mut x, mut y) = (i32::from(source & 255) - c, i32::from(source >> 8) - r);
                    if view.tileable {
                        (x, y) = (x.rem_euclid(view.width), y.rem_euclid(view.height));
                    }
                    if x < 0 || y < 0 || !centres.contains(&((x | y << 8) as Pixel)) {
                        continue;
                    }
                    let at = (y * view.width + x) as usize;
                    let whole = c.abs() <= 1 && r.abs() <= 1;
                    proposed.extend(&scene.sets.views[v][at * 4..at * 4 + if whole { 4 } else { 1 }]);
                }
                let found = matches.directions[direction].pixels[i];
                let Some(least) = proposed.iter().map(|&p| plain_distance(&scene, direction, voxel, p)).min()
                else {
                    continue;
                };
                assert_eq!(plain_distance(&scene, direction, voxel, found), least);
                assert!(proposed.contains(&found));
            }
        }
    }
}

#[test]
fn colours_are_the_mean_of_what_overlaps_or_the_texel_nearest_to_it() {
    for scene in scenes() {
        let views = &scene.pyramid.levels[0];
        let matches =
            search(&scene.field, &scene.patches, None, None, &settings(Method::Exhaustive), &()).unwrap();
        let weights = WeightSettings { position: 0.0, smoothing: 0, color: 0.0 };
        let plain = SolveSettings { weights, ..solving(Solver::Mean) };
        let mean = solve(&matches, views, Some(&scene.field), None, &plain, &()).unwrap();
        let discrete = SolveSettings { solver: Solver::Discrete, ..plain };
        let discrete = solve(&matches, views, Some(&scene.field), None, &discrete, &()).unwrap();
        for (i, voxel) in voxels(scene.field.size) {
            let (mut sums, mut total) = ([0.0; 4], 0.0);
            let mut texels = Vec::new();
            for direction in 0..3 {
                let v = direction.min(views.len() - 1);
                let view = &views[v];
                for (c, r) in matches.window.offsets() {
                    let at = away(matches.size, voxel, direction, -c, -r);
                    let pixel = matches.directions[direction].pixels[at];
                    let texel = view.texel(i32::from(pixel & 255) + c, i32::from(pixel >> 8) + r);
                    let distance = codes::decode(usize::from(matches.directions[direction].codes[at]));
                    let weight = ((distance + 16.0) / 16.0).powf(-0.6);
                    (0..4).for_each(|k| sums[k] += weight * f64::from(texel[k]));
                    total += weight;
                    texels.push((v, texel));
                }
            }
            let expected = sums.map(|sum| sum / total);
            for k in 0..4 {
                assert!((f64::from(mean.colors[i][k]) - expected[k]).abs() < 0.51, "{expected:?}");
            }
            let gap =
                |texel: [u8; 4]| -> f64 { (0..4).map(|k| (f64::from(texel[k]) - expected[k]).powi(2)).sum() };
            let least = texels.iter().map(|&(_, texel)| gap(texel)).fold(f64::INFINITY, f64::min);
            assert!(gap(discrete.colors[i]) <= least + 0.01);
            let v = discrete.view_of(i);
            assert_eq!(views[v].texels[views[v].index(discrete.sources[v][i])], discrete.colors[i]);
        }
    }
}

#[test]
fn small_windows_are_solved_in_any_directions() {
    for (window, directions) in
        [(1, [true; 3]), (1, [true, false, true]), (2, [false, true, true]), (2, [true; 3])]
    {
        let scene = scene(vec![view(12, 10, true, 1)], window, [5, 4, 3]);
        let set = SearchSettings { directions, ..settings(Method::Exhaustive) };
        let matches = search(&scene.field, &scene.patches, None, None, &set, &()).unwrap();
        let views = &scene.pyramid.levels[0];
        let field = solve(&matches, views, None, None, &solving(Solver::Discrete), &()).unwrap();
        let level = &views[0];
        let pairs = field.colors.iter().zip(&field.sources[0]);
        assert!(
            pairs.into_iter().all(|(c, &s)| *c == level.texels[level.index(s)]),
            "{window}, {directions:?}"
        );
    }
}

#[test]
fn instruction_sets_and_threads_do_not_show() {
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let (one, three) = (pool(1), pool(3));
    for scene in scenes() {
        for method in [Method::Coherent, Method::Exhaustive] {
            let run = |isa, pool: &rayon::ThreadPool| {
                pool.install(|| {
                    let (sets, set) = (Some(&scene.sets), settings(method));
                    let matches =
                        search_with(isa, &scene.field, &scene.patches, sets, None, &set, &()).unwrap();
                    let (views, set) = (&scene.pyramid.levels[0], solving(Solver::Discrete));
                    let field =
                        solve_with(isa, &matches, views, Some(&scene.field), None, &set, &()).unwrap();
                    (matches, field)
                })
            };
            let expected = run(crate::lazy::Isa::Portable, &one);
            for isa in available_instruction_sets() {
                assert!(run(isa, &one) == expected && run(isa, &three) == expected, "{isa:?}");
            }
        }
    }
}

fn optimised(scene: &Scene, index: f64, position: f64, theta: Option<&ControlMap>, sweeps: u32) -> Field {
    let mut field = scene.field.clone();
    for sweep in 0..sweeps {
        let set = SearchSettings { index, sweep, ..settings(Method::Exhaustive) };
        let matches = search(&field, &scene.patches, None, theta, &set, &()).unwrap();
        let weights = WeightSettings { position, smoothing: 0, color: 0.0 };
        let set = SolveSettings { weights, sweep, ..solving(Solver::Discrete) };
        field = solve(&matches, &scene.pyramid.levels[0], Some(&field), theta, &set, &()).unwrap();
    }
    field
}

fn unused(scene: &Scene, field: &Field) -> f64 {
    let level = &scene.pyramid.levels[0][0];
    let counts = histogram::counts(field, Histogram::Position, 0, level);
    counts.iter().filter(|&&n| n == 0).count() as f64 / counts.len() as f64
}

#[test]
fn histograms_keep_the_whole_exemplar_in_use() {
    let scene = scene(vec![view(20, 20, true, 1)], 5, [20, 20, 20]);
    let (none, both) = (optimised(&scene, 0.0, 0.0, None, 6), optimised(&scene, 8.0, 300.0, None, 6));
    let (none, both) = (unused(&scene, &none), unused(&scene, &both));
    assert!(both < none / 2.0, "{both} with both, {none} with none");
}

#[test]
fn a_control_map_says_what_appears_more() {
    let scene = scene(vec![view(20, 20, true, 1)], 5, [16, 16, 16]);
    let image = Image::from_fn(40, 40, |x, _| [if x < 20 { 250 } else { 25 }]);
    let map = ControlMap::new(&image, &scene.pyramid, 0).unwrap();
    let left = |field: &Field| {
        field.sources[0].iter().filter(|&&source| source & 255 < 10).count() as f64 / field.voxels() as f64
    };
    let even = left(&optimised(&scene, 8.0, 300.0, None, 5));
    let more = left(&optimised(&scene, 8.0, 300.0, Some(&map), 5));
    assert!((0.35..0.65).contains(&even) && more > even + 0.15, "{even} without, {more} with the map");
    let black = Image::from_fn(8, 8, |_, _| [0]);
    let error = ControlMap::new(&black, &scene.pyramid, 0).unwrap_err().to_string();
    assert!(error.contains("8 × 8") && error.contains("black"), "{error}");
    let nan = Image::new(1, 1, 1, Samples::F32(vec![f32::NAN])).unwrap();
    assert!(ControlMap::new(&nan, &scene.pyramid, 0).unwrap_err().to_string().contains("(0, 0)"));
}

#[test]
fn children_match_the_children_of_what_their_parents_matched() {
    let scene = scene(vec![view(24, 20, true, 1)], 4, [6, 5, 7]);
    let mut coarse =
        search(&scene.field, &scene.patches, None, None, &settings(Method::Exhaustive), &()).unwrap();
    coarse.level = 1;
    let views = vec![view(48, 40, true, 1)];
    let fine = upsample(&coarse, [12, 9, 14], &views, Window { size: 5 });
    assert_eq!((fine.size, fine.level), ([12, 9, 14], 0));
    for (i, [x, y, z]) in voxels(fine.size) {
        let from = (z / 2 * 5 + y / 2) * 6 + x / 2;
        // Direction y: columns along z, rows along x.
        let parent = coarse.directions[1].pixels[from];
        let expected = (2 * (parent & 255) + z as u16 % 2) | (2 * (parent >> 8) + x as u16 % 2) << 8;
        assert_eq!(fine.directions[1].pixels[i], expected);
    }
}

#[test]
fn fields_and_matches_read_back() {
    for scene in scenes() {
        let matches =
            search(&scene.field, &scene.patches, None, None, &settings(Method::Exhaustive), &()).unwrap();
        let field =
            solve(&matches, &scene.pyramid.levels[0], None, None, &solving(Solver::Mean), &()).unwrap();
        let (a, b) = (matches.encode().unwrap(), field.encode().unwrap());
        assert!(Matches::decode(&a).unwrap() == matches && Field::decode(&b).unwrap() == field);
        assert!(Matches::decode(&a[..a.len() - 1]).is_err() && Field::decode(&b[1..]).is_err());
    }
}

#[test]
fn directions_that_are_not_matched_do_not_count() {
    let scene = scene(vec![view(20, 20, true, 1)], 4, [10, 8, 6]);
    let set = SearchSettings { directions: [false, true, false], ..settings(Method::Exhaustive) };
    let matches = search(&scene.field, &scene.patches, None, None, &set, &()).unwrap();
    assert!(matches.directions[0].pixels.is_empty() && matches.directions[2].pixels.is_empty());
    let field =
        solve(&matches, &scene.pyramid.levels[0], None, None, &solving(Solver::Discrete), &()).unwrap();
    // Every colour is one of the exemplar's.
    let level = &scene.pyramid.levels[0][0];
    assert!(field.colors.iter().zip(&field.sources[0]).all(|(c, &s)| *c == level.texels[level.index(s)]));
}

/// Views that differ in size, window, edges and number, with the field's box.
fn some_scene() -> impl Strategy<Value = Scene> {
    let side = || 9..30i32;
    let one = (side(), side(), any::<bool>(), 0..50u64);
    let views = prop_oneof![prop::collection::vec(one.clone(), 1), prop::collection::vec(one, 3)];
    let size = [1usize..10, 1usize..10, 1usize..10];
    (views, 1..9i32, size).prop_map(|(views, window, size)| {
        let views =
            views.into_iter().map(|(width, height, tileable, seed)| view(width, height, tileable, seed));
        scene(views.collect(), window, size)
    })
}

fn some_search() -> impl Strategy<Value = SearchSettings> {
    let method = prop_oneof![Just(Method::Coherent), Just(Method::Exhaustive)];
    let index = prop_oneof![Just(0.0), Just(1000.0), 0.0..20.0];
    let directions = (1..8u8).prop_map(|bits| [0, 1, 2].map(|d| bits >> d & 1 == 1));
    (method, 0..4i32, index, directions, any::<u64>(), 0..9u32).prop_map(
        |(method, reach, index, directions, seed, sweep)| SearchSettings {
            method,
            reach,
            index,
            directions,
            seed,
            sweep,
        },
    )
}

#[test]
fn on_the_device_searches_find_the_same() {
    let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
    let map = Image::from_fn(16, 16, |x, y| [(x * 16 + y) as u8]);
    let search_cases = (some_scene(), some_search(), any::<bool>(), any::<bool>());
    let result = cases(60).run(&search_cases, |(scene, settings, with_sets, with_map)| {
        let sets = with_sets.then_some(&scene.sets);
        let map = with_map.then(|| ControlMap::new(&map, &scene.pyramid, 0).unwrap());
        let ask = |field: &Field, control: &dyn Control| {
            search(field, &scene.patches, sets, map.as_ref(), &settings, control).unwrap()
        };
        let on_cpu = ask(&scene.field, &());
        prop_assert!(ask(&scene.field, &device) == on_cpu);
        // Once more where histograms and sources are those of a sweep.
        let views = &scene.pyramid.levels[0];
        let field = solve(&on_cpu, views, Some(&scene.field), None, &solving(Solver::Discrete), &()).unwrap();
        prop_assert!(ask(&field, &device) == ask(&field, &()));
        Ok(())
    });
    result.unwrap();
    assert_eq!(device.losses(), 0);
}

#[test]
fn on_the_device_costs_of_more_than_32_bits_are_compared_whole() {
    let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
    // Coefficients as far apart as they get: squared distances go around 32 bits, costs up to 56.
    let mut scene = scene(vec![view(24, 20, true, 1)], 5, [7, 6, 5]);
    let all = scene.patches.views[0].table.iter_mut().zip(0..);
    all.for_each(|(value, i)| *value = if hash(9, 1, [i, 0, 0]) & 1 == 0 { -8192 } else { 8191 });
    for method in [Method::Coherent, Method::Exhaustive] {
        let settings = SearchSettings { index: 1e6, ..settings(method) };
        let ask = |control: &dyn Control| {
            search(&scene.field, &scene.patches, Some(&scene.sets), None, &settings, control).unwrap()
        };
        assert!(ask(&device) == ask(&()), "{method:?}");
    }
}

#[test]
fn on_the_device_that_is_lost_the_processor_searches() {
    for dispatches in [0, 3, 40] {
        let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
        device.gpu.lose_after(dispatches);
        let scene = &scenes()[0];
        let ask = |control: &dyn Control| {
            search(&scene.field, &scene.patches, None, None, &settings(Method::Coherent), control).unwrap()
        };
        assert!(ask(&device) == ask(&()));
        assert_eq!(device.losses(), 1, "after {dispatches} dispatches");
    }
}

#[test]
fn on_the_device_a_search_stops_when_it_is_told_to_or_has_no_room() {
    let scene = &scenes()[0];
    let ask = |control: &dyn Control| {
        search(&scene.field, &scene.patches, None, None, &settings(Method::Coherent), control)
    };
    for questions in [0, 1, 7] {
        let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
        assert_eq!(ask(&device.patient(questions)).err(), Some(Stopped::Cancelled));
    }
    let Some(device) = OnDevice::open(GpuSettings { memory: 20_000, ..Default::default() }) else { return };
    let error = ask(&device).err();
    assert!(matches!(error, Some(Stopped::Device(GpuError::OutOfMemory(_)))), "{error:?}");
}

#[test]
fn on_the_device_wrong_kernels_of_the_search_are_noticed() {
    let scene = &scenes()[0];
    // A rounding, a neighbour, ties to the last, a candidate more than there are.
    for (kernel, right, wrong) in [
        (&kernels::PROJECT, "sum >> vec4<u32>(10u)", "(sum + 512) >> vec4<u32>(10u)"),
        (&kernels::PROJECT, "around(voxel[c], -params.lead", "around(voxel[c], 1 - params.lead"),
        (&kernels::COHERENT, "abs(across) <= params.reach", "abs(across) < params.reach"),
        (&kernels::EXHAUSTIVE, "i < centres", "i + 1u < centres"),
    ] {
        let Some(device) = OnDevice::mistaken(kernel, right, wrong) else { return };
        let method = if kernel.name == "optimize/exhaustive" { Method::Exhaustive } else { Method::Coherent };
        let ask = |control: &dyn Control| {
            let settings = SearchSettings { index: 0.0, ..settings(method) };
            search(&scene.field, &scene.patches, Some(&scene.sets), None, &settings, control).unwrap()
        };
        assert!(ask(&device) != ask(&()), "{}: {wrong}", kernel.name);
    }
}

fn some_solving() -> impl Strategy<Value = SolveSettings> {
    let solver = prop_oneof![Just(Solver::Discrete), Just(Solver::Mean)];
    let strength = || prop_oneof![Just(0.0), 1.0..6000.0];
    (solver, 0.0..2.0, strength(), 0..3i32, strength(), any::<u64>(), 0..9u32).prop_map(
        |(solver, gamma, position, smoothing, color, seed, sweep)| {
            let weights = WeightSettings { position, smoothing, color };
            SolveSettings { solver, gamma, weights, seed, sweep }
        },
    )
}

/// How far fields that were solved for in floats lie apart.
#[derive(Debug, Default)]
struct Apart {
    voxels: usize,
    /// Voxels that choose another texel.
    texels: usize,
    /// Channels that differ by more than a step of 255.
    channels: usize,
}

impl Apart {
    fn add(&mut self, a: &Field, b: &Field) {
        let chosen = |field: &Field, i: usize| (field.view_of(i), field.sources[field.view_of(i)][i]);
        self.voxels += a.voxels();
        self.texels += (0..a.voxels()).filter(|&i| chosen(a, i) != chosen(b, i)).count();
        let pairs = a.colors.as_flattened().iter().zip(b.colors.as_flattened());
        self.channels += pairs.filter(|(a, b)| a.abs_diff(**b) > 1).count();
    }

    /// The shares of voxels and of channels.
    fn shares(&self) -> [f64; 2] {
        let voxels = self.voxels.max(1) as f64;
        [self.texels as f64 / voxels, self.channels as f64 / (4.0 * voxels)]
    }
}

#[test]
fn on_the_device_solvers_differ_by_rounding_only() {
    let Some(device) = OnDevice::open(GpuSettings::default()).map(OnDevice::in_floats) else { return };
    let map = Image::from_fn(16, 16, |x, y| [(x * 16 + y) as u8]);
    let apart = std::cell::RefCell::new([Apart::default(), Apart::default()]);
    let solve_cases = (some_scene(), some_search(), some_solving(), any::<bool>(), any::<bool>());
    let result = cases(60).run(&solve_cases, |(scene, search_settings, settings, with_field, with_map)| {
        let map = with_map.then(|| ControlMap::new(&map, &scene.pyramid, 0).unwrap());
        let views = &scene.pyramid.levels[0];
        let matches = search(&scene.field, &scene.patches, None, None, &search_settings, &()).unwrap();
        let before = with_field.then_some(&scene.field);
        let ask =
            |control: &dyn Control| solve(&matches, views, before, map.as_ref(), &settings, control).unwrap();
        let (on_cpu, on_device) = (ask(&()), ask(&device));
        prop_assert!(ask(&device) == on_device);
        prop_assert!(on_device.index == on_cpu.index);
        apart.borrow_mut()[usize::from(settings.solver == Solver::Mean)].add(&on_cpu, &on_device);
        Ok(())
    });
    result.unwrap();
    assert_eq!(device.losses(), 0);
    let [discrete, mean] = apart.into_inner();
    assert!(discrete.voxels > 2000 && mean.voxels > 2000);
    assert!(discrete.shares()[0] < 0.01 && mean.shares()[1] < 0.01, "{discrete:?}, {mean:?}");
}

/// One sweep over a box, from whoever solves.
fn swept_with(scene: &Scene, solver: Solver, weights: WeightSettings, control: &dyn Control) -> Field {
    let matches =
        search(&scene.field, &scene.patches, Some(&scene.sets), None, &settings(Method::Coherent), &())
            .unwrap();
    let set = SolveSettings { weights, ..solving(solver) };
    solve(&matches, &scene.pyramid.levels[0], Some(&scene.field), None, &set, control).unwrap()
}

const STRONG: WeightSettings = WeightSettings { position: 300.0, smoothing: 0, color: 5000.0 };

/// The same with strong histograms.
fn swept(scene: &Scene, solver: Solver, control: &dyn Control) -> Field {
    swept_with(scene, solver, STRONG, control)
}

#[test]
fn on_the_device_that_rounds_in_another_way_solvers_stay_near() {
    let three = (0..3).map(|i| view(40 + i, 44 - i, i == 1, i as u64)).collect();
    let scenes = [scene(vec![view(48, 48, true, 3)], 6, [24, 25, 26]), scene(three, 8, [20, 24, 22])];
    let even = WeightSettings { position: 0.0, smoothing: 0, color: 0.0 };
    let products = ("sums += weight * color", "sums = fma(vec4<f32>(weight), color, sums)");
    for (right, wrong) in [products, ("sums / total", "sums * (1.0 / total) * 1.000001")] {
        let Some(device) = OnDevice::mistaken(&kernels::SOLVE, right, wrong) else { return };
        let device = device.in_floats();
        for scene in &scenes {
            for solver in [Solver::Discrete, Solver::Mean] {
                let ask = |control: &dyn Control| swept_with(scene, solver, even.clone(), control);
                let mut apart = Apart::default();
                apart.add(&ask(&()), &ask(&device));
                let [texels, channels] = apart.shares();
                assert!(solver == Solver::Mean || texels < 0.01, "{wrong}: {apart:?}");
                assert!(channels < 0.01, "{wrong}: {apart:?}");
            }
        }
    }
}

/// How far the position histogram lies above an even one, on the whole: 0 if it is even.
fn excess(scene: &Scene, field: &Field) -> f64 {
    let level = &scene.pyramid.levels[0][0];
    let counts = histogram::counts(field, Histogram::Position, 0, level);
    let even = field.voxels() as f64 / counts.len() as f64;
    counts.iter().map(|&n| (f64::from(n) / even - 1.0).max(0.0)).sum::<f64>() / counts.len() as f64
}

#[test]
fn on_the_device_where_histograms_amplify_rounding_texels_are_held_back_as_much() {
    let scene = scene(vec![view(48, 48, true, 3)], 6, [24, 25, 26]);
    let (right, wrong) = ("sums / total", "sums / total * 1.0001");
    let Some(device) = OnDevice::mistaken(&kernels::SOLVE, right, wrong) else { return };
    let (on_cpu, on_device) =
        (swept(&scene, Solver::Discrete, &()), swept(&scene, Solver::Discrete, &device.in_floats()));
    assert!(on_cpu != on_device);
    let (on_cpu, on_device) = (excess(&scene, &on_cpu), excess(&scene, &on_device));
    assert!((0.8..1.25).contains(&(on_device / on_cpu)), "{on_device} on the device, {on_cpu} elsewhere");
}

#[test]
fn on_the_device_the_solver_needs_leave_to_round() {
    let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
    let scene = &scenes()[2];
    for solver in [Solver::Discrete, Solver::Mean] {
        assert!(swept(scene, solver, &device) == swept(scene, solver, &()));
    }
    assert_eq!(device.gpu.traffic().dispatches, 0);
    let device = device.in_floats();
    swept(scene, Solver::Discrete, &device);
    assert!(device.gpu.traffic().dispatches > 0);
}

#[test]
fn on_the_device_that_is_lost_the_processor_solves() {
    let scene = &scenes()[0];
    for dispatches in [0, 3, 40] {
        let Some(device) = OnDevice::open(GpuSettings::default()).map(OnDevice::in_floats) else { return };
        device.gpu.lose_after(dispatches);
        assert!(swept(scene, Solver::Mean, &device) == swept(scene, Solver::Mean, &()));
        assert_eq!(device.losses(), 1, "after {dispatches} dispatches");
    }
}

#[test]
fn on_the_device_a_solver_stops_when_it_is_told_to_or_has_no_room() {
    let scene = &scenes()[0];
    let matches =
        search(&scene.field, &scene.patches, None, None, &settings(Method::Exhaustive), &()).unwrap();
    let ask = |control: &dyn Control| {
        solve(&matches, &scene.pyramid.levels[0], None, None, &solving(Solver::Discrete), control)
    };
    for questions in [0, 1, 7] {
        let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
        assert_eq!(ask(&device.in_floats().patient(questions)).err(), Some(Stopped::Cancelled));
    }
    let Some(device) = OnDevice::open(GpuSettings { memory: 20_000, ..Default::default() }) else { return };
    let error = ask(&device.in_floats()).err();
    assert!(matches!(error, Some(Stopped::Device(GpuError::OutOfMemory(_)))), "{error:?}");
}

#[test]
fn on_the_device_wrong_kernels_of_the_solver_are_noticed() {
    let scene = &scenes()[2];
    // A neighbour, a match's weight, a texel's, the last among equals, rounding down, a view that is not looked at.
    for (right, wrong, solver) in [
        ("around(here[c], -params.lead", "around(here[c], 1 - params.lead", Solver::Mean),
        ("weights[matched >> 16u & 2047u] *", "", Solver::Mean),
        ("* texel.weight", "", Solver::Mean),
        ("gap < gap_here", "gap <= gap_here", Solver::Discrete),
        ("vec4<f32>(0.5)", "vec4<f32>(0.0)", Solver::Mean),
        ("best[view] < best[chosen]", "best[view] > best[chosen]", Solver::Discrete),
    ] {
        let Some(device) = OnDevice::mistaken(&kernels::SOLVE, right, wrong) else { return };
        let mut apart = Apart::default();
        let (on_cpu, on_device) = (swept(scene, solver, &()), swept(scene, solver, &device.in_floats()));
        apart.add(&on_cpu, &on_device);
        let off = if solver == Solver::Mean && right != "vec4<f32>(0.5)" { apart.shares()[1] } else { 0.0 };
        assert!(on_cpu != on_device && off.max(apart.shares()[0]) > 0.01, "{wrong}: {apart:?}");
    }
}
