use std::collections::BTreeMap;
use std::io::{Cursor, Write};
use std::path::Path;
use std::sync::Arc;

use breccia_engine::{Document, FileSource, Graph, ParamValue, Registry};
use breccia_graphs::Sources;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::*;

fn registry() -> Registry {
    breccia_nodes::registry()
}

/// A graph that reads two pictures of the same name, one through a group in a file, and a built-in one.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::create_dir_all(path("in/groups/deep")).unwrap();
    std::fs::write(path("in/stone.png"), "first").unwrap();
    std::fs::write(path("in/groups/Stone.png"), "second").unwrap();
    std::fs::write(path("in/groups/deep/mesh.obj"), "third").unwrap();
    std::fs::write(
        path("in/groups/read.ron"),
        r#"(format: "breccia-graph", version: 2,
            interface: (
                outputs: {"image": (node: "read", socket: "image"), "mesh": (node: "mesh", socket: "mesh")},
                params: {"path": (targets: ["mesh.path"])},
            ),
            nodes: {
                "read": (type: "io.read_image", params: {"path": "Stone.png"}),
                "mesh": (type: "mesh.read"),
            })"#,
    )
    .unwrap();
    std::fs::write(path("in/graph.ron"), GRAPH_TEXT).unwrap();
    folder
}

const GRAPH_TEXT: &str = r#"(format: "breccia-graph", version: 2, title: "Two stones",
    interface: (params: {"photo": (targets: ["photo.path"], default: "stone.png")}),
    nodes: {
        "photo": (type: "io.read_image"),
        "again": (type: "io.read_image", params: {"path": "stone.png"}, mode: "mute"),
        "built_in": (type: "io.read_image", params: {"path": "builtin:cobbles/color_64.png"}),
        "none": (type: "io.read_image"),
        "group": (type: "flow.group", params: {"body": "read", "path": "groups/deep/mesh.obj"}),
        "unknown": (type: "future.read", params: {"path": "stone.png"}),
    },
    groups: {"read": (file: "groups/read.ron"), "level": (file: "builtin:groups/optimize_level.ron")},
    editor: {"positions": {"photo": (1.5, 2.0)}},
)"#;

fn bundle(folder: &Path) -> Vec<u8> {
    let document = Document::parse(GRAPH_TEXT).unwrap();
    export(&document, &folder.join("in"), &registry(), &Sources::default()).unwrap()
}

/// The paths of files that the nodes of a graph read once it is unpacked.
fn paths(graph: &Path) -> BTreeMap<String, Vec<u8>> {
    let (mut document, folder) = breccia_graphs::read(graph).unwrap();
    document.nodes.remove("unknown");
    let graph = Graph::with_folder(&document, &registry(), &folder).unwrap_or_else(|error| panic!("{error}"));
    let nodes: Vec<String> = graph.nodes().map(|(name, _)| name.to_owned()).collect();
    let path = |node: &String| match graph.node_params(node)?.get("path")? {
        ParamValue::Text(path) if !path.is_empty() => {
            Some((node.clone(), Sources::default().read(path).unwrap().to_vec()))
        }
        _ => None,
    };
    nodes.iter().filter_map(path).collect()
}

#[test]
fn a_bundle_runs_wherever_it_is_unpacked() {
    let folder = folder();
    let expected = paths(&folder.path().join("in/graph.ron"));
    assert_eq!(expected["group/mesh"], b"third");
    let bytes = bundle(folder.path());
    // Nothing but the bundle is left.
    std::fs::remove_dir_all(folder.path().join("in")).unwrap();
    let graph = import(&bytes, &folder.path().join("out/new")).unwrap();
    assert_eq!(graph, folder.path().join("out/new/graph.ron"));
    assert_eq!(paths(&graph), expected);
    let document = Document::parse_bytes(&std::fs::read(&graph).unwrap()).unwrap();
    assert_eq!(document.title, "Two stones");
    assert_eq!(document.editor, Document::parse(GRAPH_TEXT).unwrap().editor);
    assert_eq!(document.groups["level"].file, "builtin:groups/optimize_level.ron");
    let unknown = &Document::parse(GRAPH_TEXT).unwrap().nodes["unknown"];
    assert_eq!(&document.nodes["unknown"], unknown, "what a node is that nobody knows cannot be known");
    // Packed again it is the same.
    let again = export(&document, graph.parent().unwrap(), &registry(), &Sources::default()).unwrap();
    let second = import(&again, &folder.path().join("again")).unwrap();
    assert_eq!(paths(&second), expected);
}

#[test]
fn names_are_unique_and_plain() {
    let folder = folder();
    let graph = import(&bundle(folder.path()), &folder.path().join("out")).unwrap();
    let mut names: Vec<_> = std::fs::read_dir(graph.parent().unwrap().join("files"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names.len(), 3, "{names:?}");
    let lower: std::collections::BTreeSet<_> = names.iter().map(|name| name.to_lowercase()).collect();
    assert_eq!(lower.len(), 3, "{names:?} are the same where upper and lower case are");

    struct Anything;
    impl FileSource for Anything {
        fn read(&self, _: &str) -> io::Result<Arc<Vec<u8>>> {
            Ok(Arc::default())
        }
    }
    let odd = [
        "a/con.png",
        "b/nul",
        "c/..",
        "d/.hidden",
        "e/ü ñ*?.png",
        "f/x.",
        "g/a\\b.png",
        "h/ ",
        &format!("i/{}.png", "x".repeat(400)),
        &format!("j/x.{}", "y".repeat(400)),
        "k/a.b.c",
    ];
    let mut document = Document::default();
    for (i, path) in odd.iter().enumerate() {
        let node = breccia_engine::NodeEntry::new("io.read_image")
            .with("path", ParamValue::Text((*path).to_owned()));
        document.nodes.insert(format!("n{i}"), node);
    }
    let bytes = export(&document, Path::new(""), &registry(), &Anything).unwrap();
    let graph = import(&bytes, &folder.path().join("odd")).unwrap();
    assert_eq!(std::fs::read_dir(graph.parent().unwrap().join("files")).unwrap().count(), odd.len());
}

#[test]
fn a_missing_file_is_named() {
    let folder = folder();
    std::fs::remove_file(folder.path().join("in/stone.png")).unwrap();
    let document = Document::parse(GRAPH_TEXT).unwrap();
    let error = export(&document, &folder.path().join("in"), &registry(), &Sources::default()).unwrap_err();
    assert!(error.to_string().contains("stone.png"), "{error}");
    std::fs::remove_file(folder.path().join("in/groups/read.ron")).unwrap();
    let error = export(&document, &folder.path().join("in"), &registry(), &Sources::default()).unwrap_err();
    assert!(error.to_string().contains("group `read`"), "{error}");
}

#[test]
fn what_is_there_stays() {
    let folder = folder();
    let bytes = bundle(folder.path());
    let target = folder.path().join("in");
    let first = import(&bytes, &target).unwrap();
    let second = import(&bytes, &target).unwrap();
    assert_eq!(first, folder.path().join("in-2/graph.ron"));
    assert_eq!(second, folder.path().join("in-3/graph.ron"));
    assert_eq!(std::fs::read_to_string(target.join("graph.ron")).unwrap(), GRAPH_TEXT);
}

const MINIMAL: &str = r#"(format: "breccia-graph", version: 2, nodes: {})"#;

/// An archive of these entries.
fn archive(entries: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// Fails to unpack, and leaves nothing behind.
#[track_caller]
fn refused(bytes: &[u8]) -> BundleError {
    let folder = tempfile::tempdir().unwrap();
    let error = import(bytes, &folder.path().join("out")).unwrap_err();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "{error}");
    error
}

#[test]
fn entries_that_lead_elsewhere_are_refused() {
    for name in [
        "../evil",
        "/etc/evil",
        "files/../../evil",
        "files/../evil",
        "C:\\evil",
        "files\\..\\evil",
        "files/a/b",
        "files/.hidden",
        "files/con",
        "files/LPT1.png",
        "files/a:b",
        "files/a.",
        "files//a",
        "evil.ron",
        "files/\u{1}",
    ] {
        let error = refused(&archive(&[("graph.ron", MINIMAL.as_bytes()), (name, b"x")]));
        assert!(matches!(error, BundleError::Entry { .. }), "{name}: {error}");
    }
}

#[test]
fn links_and_folders_are_refused() {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    zip.add_symlink("files/a", "/etc/passwd", SimpleFileOptions::default()).unwrap();
    let bytes = zip.finish().unwrap().into_inner();
    assert!(refused(&bytes).to_string().contains("a link `files/a`"));
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    zip.add_directory("files/a", SimpleFileOptions::default()).unwrap();
    let bytes = zip.finish().unwrap().into_inner();
    assert!(refused(&bytes).to_string().contains("a folder `files/a/`"));
}

#[test]
fn no_name_may_come_twice() {
    let upper = archive(&[("graph.ron", MINIMAL.as_bytes()), ("files/a", b"1"), ("files/A", b"2")]);
    assert!(matches!(refused(&upper), BundleError::Entry { .. }));
    // The same name in another place of the archive: bytes of a name are swapped by hand.
    let mut bytes = archive(&[("graph.ron", MINIMAL.as_bytes()), ("files/a", b"1"), ("files/b", b"2")]);
    for at in 0..bytes.len() - 7 {
        if &bytes[at..at + 7] == b"files/b" {
            bytes[at + 6] = b'a';
        }
    }
    refused(&bytes);
}

#[test]
fn a_bundle_needs_a_graph() {
    assert!(matches!(refused(&archive(&[("files/a", b"x")])), BundleError::NoGraph));
    assert!(matches!(refused(&archive(&[("graph.ron", b"(")])), BundleError::Graph(_)));
    assert!(matches!(refused(b"no archive"), BundleError::Archive(_)));
    assert!(matches!(refused(b""), BundleError::Archive(_)));
}

#[test]
fn too_much_is_refused_before_it_is_written() {
    let zeros = vec![0_u8; (LIMITS.graph + 1) as usize];
    let error = refused(&archive(&[("graph.ron", &zeros)]));
    assert!(matches!(error, BundleError::TooLarge { .. }), "{error}");
    let names: Vec<String> = (0..LIMITS.entries).map(|i| format!("files/{i}")).collect();
    let mut entries: Vec<(&str, &[u8])> = names.iter().map(|name| (name.as_str(), &b""[..])).collect();
    entries.push(("graph.ron", MINIMAL.as_bytes()));
    assert!(matches!(refused(&archive(&entries)), BundleError::TooLarge { .. }));
}

#[test]
fn damage_is_an_error() {
    let folder = folder();
    let bytes = bundle(folder.path());
    for at in (0..bytes.len()).step_by(13) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x55;
        let target = tempfile::tempdir().unwrap();
        // Some bytes do not matter. None makes the program fail.
        if import(&damaged, &target.path().join("out")).is_err() {
            assert_eq!(std::fs::read_dir(target.path()).unwrap().count(), 0);
        }
        let _ = import(&bytes[..at], &target.path().join("short"));
    }
}
