//! Particles as graphs: no overlap on any preset, portions of the hybrid, what is said of bad input.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::sync::Arc;

use breccia_engine::{CancelToken, Document, Engine, FileSource, Graph, ParamValue, RunResult, parse_value};
use breccia_graphs::Sources;
use breccia_nodes::data::{Image, SolidValue, VoxelMap, VoxelSet};
use breccia_nodes::particles::Packing;

/// Built-in files, and pictures made here under names of their own.
struct Files(BTreeMap<&'static str, Vec<u8>>);

impl FileSource for Files {
    fn read(&self, path: &str) -> io::Result<Arc<Vec<u8>>> {
        let own = self.0.get(path).cloned();
        own.map_or_else(|| Sources::default().read(path), |bytes| Ok(Arc::new(bytes)))
    }
}

fn files(pictures: &[(&'static str, Image)]) -> Files {
    let encode = |image: &Image| {
        let mut bytes = Vec::new();
        breccia_nodes::io::write_image_png(image, &mut bytes).unwrap();
        bytes
    };
    Files(pictures.iter().map(|(name, image)| (*name, encode(image))).collect())
}

/// A preset with one more output.
fn preset(name: &str, node: &str, socket: &str) -> Document {
    let ron = breccia_graphs::preset(name).unwrap().ron.replacen(
        "outputs: {",
        &format!(
            "outputs: {{ \"wanted\": (node: \"{node}\", socket: \"{socket}\", docs: \"For this test.\"),"
        ),
        1,
    );
    let mut document = Document::parse(&ron).unwrap();
    document.include(Path::new(""), &Files(BTreeMap::new())).unwrap();
    document
}

fn graph(name: &str, node: &str, socket: &str, settings: &[(&str, &str)]) -> Graph {
    let mut graph = Graph::new(&preset(name, node, socket), &breccia_nodes::registry()).unwrap();
    let nodes: Vec<_> = graph.nodes().map(|(node, spec)| (node.to_owned(), spec.id)).collect();
    for (node, id) in nodes {
        for (of, param, value) in [
            ("particles.reconstruct", "most", 48),
            ("lazy.candidates", "strips", 8),
            ("lazy.candidates", "best", 16),
        ] {
            if id == of {
                graph.set(&format!("{node}.{param}"), &ParamValue::Int(value)).unwrap();
            }
        }
    }
    for (name, value) in settings {
        graph.set(name, &parse_value(value).unwrap()).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
    graph
}

fn run(files: Files, graph: Graph) -> RunResult {
    let engine = Engine::builder()
        .files(Arc::new(files))
        .threads(2)
        .build(Arc::new(breccia_nodes::registry()))
        .unwrap();
    engine.run(&Arc::new(graph), &["wanted"], &CancelToken::default(), &|_| {}).unwrap()
}

/// The one message that a run ends with.
fn failure(pictures: &[(&'static str, Image)], settings: &[(&str, &str)]) -> String {
    let mut all = vec![("exemplar.tileable", "false")];
    all.extend(settings);
    let mut graph = graph("particles_volume", "fill", "packing", &all);
    for input in ["exemplar", "mask"] {
        if pictures.iter().any(|(name, _)| *name == input) {
            let node = if input == "mask" { "mask_image.path" } else { "photo.path" };
            graph.set(node, &ParamValue::Text(input.to_owned())).unwrap();
        }
    }
    let result = run(files(pictures), graph);
    let first = result.failures.iter().find(|failure| failure.because_of.is_none());
    first.map(|failure| format!("{}: {}", failure.node, failure.message)).unwrap_or_default()
}

fn no_particles_overlap(name: &str, settings: &[(&str, &str)]) {
    let result = run(files(&[]), graph(name, "fill", "packing", settings));
    assert_eq!(result.failures, []);
    let packing = result.outputs["wanted"].downcast::<Packing>().unwrap();
    assert!(packing.placed.len() > 3, "{name}: {}", packing.placed.len());
    let mut claimed: BTreeMap<[i32; 3], usize> = BTreeMap::new();
    for (i, placed) in packing.placed.iter().enumerate() {
        for voxel in packing.voxels(placed) {
            let at: [i32; 3] = std::array::from_fn(|a| placed.center[a] + voxel[a]);
            let at = if packing.wrap {
                std::array::from_fn(|a| at[a].rem_euclid(packing.size[a] as i32))
            } else {
                at
            };
            // Beyond a domain that ends nothing is ever shown.
            if !packing.wrap && (0..3).any(|a| at[a] < 0 || at[a] >= packing.size[a] as i32) {
                continue;
            }
            if let Some(other) = claimed.insert(at, i) {
                assert_eq!(other, i, "{name}: two particles at {at:?}");
            }
        }
    }
}

macro_rules! no_overlap {
    ($($name:ident: $settings:expr),* $(,)?) => {
        mod no_overlap {
            $(#[test] fn $name() { super::no_particles_overlap(stringify!($name), &$settings); })*
        }

        #[test]
        fn every_preset_of_particles_is_tested_for_overlap() {
            let tested = [$(stringify!($name)),*];
            let with = breccia_graphs::presets().iter().filter(|preset| preset.ron.contains("particles.fill"));
            assert_eq!(with.map(|preset| preset.name).collect::<Vec<_>>(), tested);
        }
    };
}

no_overlap! {
    particles_volume: [("size", "64")],
    hybrid_mesh: [("size", "64")],
    hybrid_slice: [("domain", "64")],
    brick_wall: [("size", "64")],
    recolour: [("size", "64")],
    bent_bar: [("size", "(80, 48, 48)")],
}

fn color(map: &VoxelMap, voxel: [i32; 3]) -> [u8; 3] {
    let at = map.index(voxel).unwrap() * 3;
    [0, 1, 2].map(|c| map.maps[0].samples.get_u8(at + c))
}

#[test]
fn portions_of_the_hybrid_equal_the_whole() {
    let solid = || {
        let settings = [("size", "48"), ("exemplar.max_size", "64")];
        let result = run(files(&[]), graph("hybrid_mesh", "solid", "solid", &settings));
        assert_eq!(result.failures, []);
        result.outputs["wanted"].downcast::<SolidValue>().unwrap()
    };
    let whole = solid().0.evaluate(&VoxelSet::from_box([0; 3], [48; 3]), &()).unwrap();
    let other = solid();
    // A plane, a line beyond the domain, single voxels, from the far end to the near.
    let plane: VoxelSet = (0..48).flat_map(|y| (0..48).map(move |x| [x, y, (x + y) % 48])).collect();
    let line: VoxelSet = (0..40).map(|i| [100 + i, -30, 7]).collect();
    let spots: VoxelSet = (0..30).map(|i| [47 - i, (i * 31) % 48, (i * 17) % 48]).collect();
    for part in [spots, line, plane] {
        let answer = other.0.evaluate(&part, &()).unwrap();
        for voxel in part.voxels() {
            assert_eq!(color(&answer, voxel), color(&whole, voxel.map(|c| c.rem_euclid(48))), "{voxel:?}");
        }
    }
}

fn plain(side: u32, value: u8) -> Image {
    Image::from_fn(side, side, |_, _| [value; 3])
}

/// White where `inside` holds.
fn drawn(side: u32, inside: impl Fn(i32, i32) -> bool) -> Image {
    Image::from_fn(side, side, |x, y| [if inside(x as i32, y as i32) { 255 } else { 0 }; 3])
}

fn disc(x: i32, y: i32, r: i32) -> bool {
    x * x + y * y <= r * r
}

#[test]
fn masks_without_particles_are_refused_with_the_reason() {
    let photo = ("exemplar", drawn(64, |x, y| (x + y) % 7 < 3));
    let cases = [
        (plain(64, 0), "sections: the mask has no cross-section to use: it is black everywhere"),
        (plain(64, 255), "it is white everywhere"),
        // Four particles, each cut by two edges.
        (drawn(64, |x, y| !(28..36).contains(&x) && !(28..36).contains(&y)), "4 pieces that cover"),
        (plain(32, 255), "32 × 32"),
    ];
    for (mask, expected) in cases {
        let found = failure(&[photo.clone(), ("mask", mask)], &[]);
        assert!(found.contains(expected), "{found}");
    }
}

#[test]
fn one_particle_is_enough() {
    let one = drawn(64, |x, y| disc(x - 32, y - 32, 9));
    assert_eq!(failure(&[("exemplar", one.clone()), ("mask", one)], &[("size", "48")]), "");
}

#[test]
fn a_domain_smaller_than_all_particles_is_refused_with_both_sizes() {
    let one = drawn(64, |x, y| disc(x - 32, y - 32, 12));
    let found = failure(&[("exemplar", one.clone()), ("mask", one)], &[("pack.size", "8")]);
    assert!(found.contains("pack: the smallest particle has 25 × 25 × 25 voxels"), "{found}");
}

#[test]
fn cross_sections_that_cannot_match_are_refused_with_the_best_error() {
    let bar = drawn(64, |x, y| (12..52).contains(&x) && (30..34).contains(&y));
    let found = failure(&[("exemplar", bar.clone()), ("mask", bar)], &[("threshold", "0.02")]);
    assert!(
        found.contains("the best triple has an error of") && found.contains("threshold is 2.0 %"),
        "{found}"
    );
}

#[test]
fn ten_thousand_cross_sections_are_packed() {
    // 128² single pixels.
    let dots = drawn(256, |x, y| x % 2 == 0 && y % 2 == 0);
    let settings = [
        ("exemplar.max_size", "256"),
        ("sections.least", "1"),
        ("sections.split", "0.0"),
        ("border", "\"keep\""),
        ("pack.size", "24"),
        ("synthesis.period", "24"),
    ];
    assert_eq!(failure(&[("exemplar", dots.clone()), ("mask", dots)], &settings), "");
}
