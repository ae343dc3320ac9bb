use super::*;

const SAMPLE: &str = r#"(
    format: "breccia-graph",
    version: 1,
    title: "Sum",
    interface: (
        inputs: { "file": (type: "number", docs: "A file.", node: "length", param: "path") },
        outputs: { "sum": (docs: "The sum.", node: "add", socket: "sum") },
        params: { "x": (docs: "A number.", targets: ["b.value", "a.value"], default: -3) },
    ),
    nodes: {
        "length": (type: "test.length"),
        "a": (type: "test.constant", params: (value: 2)),
        "b": (type: "future.node", params: { "deep": {"x": [1, 0.10000000149011612]}, "size": 128 }, colour: "red"),
        "add": (type: "test.add"),
    },
    links: ["b.out->add.terms", "a.out  ->  add.terms", "length.out -> add.first"],
    editor: { "positions": {"a": (1.5, 2.25), "b": Some('c')} },
)"#;

#[test]
fn loads_saves_and_loads_the_same() {
    let document = Document::parse(SAMPLE).unwrap();
    let text = document.to_ron();
    let again = Document::parse(&text).unwrap();
    assert_eq!(document, again, "{text}");
    assert_eq!(text, again.to_ron());
}

#[test]
fn links_into_one_socket_keep_their_order() {
    let document = Document::parse(SAMPLE).unwrap();
    assert_eq!(document.links, ["length.out -> add.first", "b.out -> add.terms", "a.out -> add.terms"]);
}

#[test]
fn unknown_nodes_keep_all_fields() {
    let document = Document::parse(SAMPLE).unwrap();
    let text = document.to_ron();
    for part in ["future.node", "\"deep\": {\"x\": [1, 0.10000000149011612]}", "colour: \"red\""] {
        assert!(text.contains(part), "{part} is missing in {text}");
    }
}

#[test]
fn errors_name_line_and_column() {
    let text = SAMPLE.replace("title:", "titel:");
    let error = Document::parse(&text).unwrap_err();
    let DocumentError::Syntax { line: 4, message, .. } = &error else { panic!("{error}") };
    assert!(message.contains("titel") && message.contains("title"), "{message}");

    let error = Document::parse("(format: \"breccia-graph\",\n version: 1,\n nodes: {]").unwrap_err();
    assert!(matches!(error, DocumentError::Syntax { line: 3, .. }), "{error}");
}

#[test]
fn a_name_given_twice_is_an_error() {
    let text = SAMPLE.replace("\"b\": (type: \"future.node\"", "\"a\": (type: \"future.node\"");
    let error = Document::parse(&text).unwrap_err().to_string();
    assert!(error.contains("`a` is there twice"), "{error}");
}

#[test]
fn a_newer_document_says_both_versions() {
    let text = "(format: \"breccia-graph\", version: 7, whatever: [1])";
    let error = Document::parse(text).unwrap_err();
    assert_eq!(error, DocumentError::Newer { found: 7, supported: VERSION });
    assert!(error.to_string().contains('7') && error.to_string().contains(&VERSION.to_string()));
}

#[test]
fn other_files_are_no_graph_documents() {
    assert!(matches!(Document::parse("(version: 1)"), Err(DocumentError::Format(_))));
    assert!(matches!(Document::parse("(format: \"x\", version: 1)"), Err(DocumentError::Format(_))));
    assert!(matches!(Document::parse("[1, 2]"), Err(DocumentError::Format(_))));
    for version in ["-1", "1.5", "\"1\"", "99999999999999"] {
        let text = format!("(format: \"breccia-graph\", version: {version})");
        assert!(matches!(Document::parse(&text), Err(DocumentError::Version(_))), "{version}");
    }
    assert!(matches!(Document::parse_bytes(b"\xff\xfe"), Err(DocumentError::Utf8(0))));
}

#[test]
fn version_0_wrote_links_as_tuples() {
    let text = r#"(format: "breccia-graph", version: 0, title: "Old",
        nodes: { "a": (type: "t.a", params: {"x": 1}), "b": (type: "t.b") },
        links: [("a", "out", "b", "in")])"#;
    let document = Document::parse(text).unwrap();
    assert_eq!(document.links, ["a.out -> b.in"]);
    assert_eq!(document.title, "Old");
    assert_eq!(Document::parse(&document.to_ron()).unwrap(), document);

    let bad = text.replace("\"out\", ", "");
    let error = Document::parse(&bad).unwrap_err().to_string();
    assert!(error.contains("version 0") && error.contains("link 0"), "{error}");
}

#[test]
fn interface_parameters_may_override_the_nodes() {
    let document = Document::parse(SAMPLE).unwrap();
    assert_eq!(document.interface.params["x"].default, Some(ParamValue::Int(-3)));
}
