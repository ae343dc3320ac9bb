//! Every preset is valid, described, and gives all its outputs.

mod support;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use breccia_engine::{CancelToken, Document, Engine, Sink};
use breccia_graphs::Sources;

use support::{graph, small};

fn runs(name: &str) {
    let registry = Arc::new(breccia_nodes::registry());
    let graph = small(name, &registry);
    let outputs: Vec<_> = graph.outputs().map(|output| (output.name.to_owned(), output.ty)).collect();
    let names: Vec<_> = outputs.iter().map(|(name, _)| name.as_str()).collect();
    let engine = Engine::builder().files(Arc::new(Sources::default())).build(Arc::clone(&registry)).unwrap();
    let result = engine.run(&Arc::new(graph), &names, &CancelToken::default(), &|_| {}).unwrap();
    assert_eq!(result.failures, []);
    let folder = tempfile::tempdir().unwrap();
    for (name, ty) in &outputs {
        let value = &result.outputs[name];
        assert_eq!(value.type_name(), *ty);
        // Every output of a preset can be written in every format of its type.
        for exporter in registry.exporters().iter().filter(|exporter| exporter.ty == *ty) {
            for extension in exporter.extensions {
                let dot = if *extension == "/" { "" } else { "." };
                let mut sink = Sink::new(&folder.path().join(format!("{name}{dot}{extension}"))).unwrap();
                (exporter.write)(value, &mut sink).unwrap();
                assert!(!sink.commit().unwrap().is_empty());
            }
        }
    }
}

macro_rules! presets_run {
    ($($name:ident),* $(,)?) => {
        $(#[test] fn $name() { runs(stringify!($name)); })*

        #[test]
        fn every_preset_is_tested() {
            let tested = [$(stringify!($name)),*];
            let names: Vec<_> = breccia_graphs::presets().iter().map(|preset| preset.name).collect();
            assert_eq!(names, tested);
        }
    };
}

presets_run![
    lazy_volume,
    lazy_mesh,
    lazy_slice,
    pbr_mesh,
    wood_views,
    cut_mesh,
    compare_volume,
    optimize_volume,
    optimize_painted,
    optimize_ablations,
    kopf_volume,
    particles_volume,
    hybrid_mesh,
    hybrid_slice,
    brick_wall,
    recolour,
    bent_bar
];

#[test]
fn presets_describe_all_that_they_offer() {
    let registry = breccia_nodes::registry();
    for preset in breccia_graphs::presets() {
        let document = Document::parse(preset.ron).unwrap();
        let name = preset.name;
        assert!(!document.title.is_empty() && !document.docs.is_empty(), "{name}");
        let interface = &document.interface;
        let docs = interface.inputs.iter().map(|(n, i)| (n, &i.docs));
        let docs = docs.chain(interface.outputs.iter().map(|(n, o)| (n, &o.docs)));
        for (item, docs) in docs.chain(interface.params.iter().map(|(n, p)| (n, &p.docs))) {
            assert!(docs.ends_with('.'), "{name}: {item}: {docs}");
        }
        graph(name, &registry);
        assert!(interface.outputs.contains_key("preview") && interface.params.contains_key("seed"), "{name}");
    }
}

#[test]
fn presets_with_one_exemplar_can_be_swapped() {
    let registry = breccia_nodes::registry();
    for name in ["lazy_volume", "lazy_mesh", "lazy_slice", "pbr_mesh", "cut_mesh"] {
        let graph = graph(name, &registry);
        for input in ["exemplar", "mask"] {
            assert!(graph.inputs().any(|i| i.name == input && i.ty == "image"), "{name}: {input}");
        }
        for param in ["seed", "period", "coherence", "crossbar"] {
            assert!(graph.params().any(|p| p.name == param), "{name}: {param}");
        }
    }
}

#[test]
fn presets_of_particles_have_the_names_of_the_lazy_ones() {
    let registry = breccia_nodes::registry();
    for name in ["particles_volume", "hybrid_mesh", "hybrid_slice", "recolour", "bent_bar"] {
        let graph = graph(name, &registry);
        for input in ["exemplar", "mask"] {
            assert!(graph.inputs().any(|i| i.name == input && i.ty == "image"), "{name}: {input}");
        }
        for param in ["seed", "size", "threshold", "fraction", "clearance", "border"] {
            assert!(graph.params().any(|p| p.name == param), "{name}: {param}");
        }
    }
}

#[test]
fn what_presets_share_has_one_value() {
    // Usage weights serve the synthesis that they were balanced for.
    let registry = breccia_nodes::registry();
    for preset in breccia_graphs::presets() {
        let graph = graph(preset.name, &registry);
        let Some(synthesis) = graph.node_params("synthesis") else { continue };
        for (name, value) in graph.node_params("usage").into_iter().flatten() {
            assert!(synthesis.get(name).is_none_or(|other| other == value), "{}: {name}", preset.name);
        }
    }
}

#[test]
fn every_embedded_file_has_a_licence() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../graphs");
    let licences = std::fs::read_to_string(root.join("LICENSES.md")).unwrap();
    for asset in breccia_graphs::assets() {
        assert!(licences.contains(asset.name), "{} has no row in LICENSES.md", asset.name);
    }
    let mut files = files_in(&root.join("assets"));
    files.sort();
    let embedded: Vec<PathBuf> =
        breccia_graphs::assets().iter().map(|asset| root.join("assets").join(asset.name)).collect();
    assert_eq!(files, embedded);
}

fn files_in(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files_in(&path) } else { vec![path] }).collect()
}

#[test]
fn every_preset_has_a_picture() {
    for preset in breccia_graphs::presets() {
        let picture = breccia_nodes::io::decode_image(
            preset.picture,
            breccia_nodes::io::Encoding::Auto,
            &breccia_nodes::io::ReadLimits::default(),
        );
        let picture = picture.unwrap_or_else(|error| panic!("{}: {error}", preset.name));
        assert_eq!((picture.width(), picture.height()), (320, 240), "{}", preset.name);
        assert!(preset.picture.len() < 25_000, "{} has {} bytes", preset.name, preset.picture.len());
    }
}
