//! All problems of a graph at once, with suggestions.

use breccia_engine::{Graph, ParamValue, Problem, ProblemKind as Kind, Problems};

use crate::nodes::registry;
use crate::support::{document, int, sum};

fn problems(interface: &str, nodes: &str, links: &str) -> Vec<Problem> {
    match Graph::new(&document(interface, nodes, links), &registry()) {
        Ok(_) => Vec::new(),
        Err(Problems(problems)) => problems,
    }
}

/// The only problem of a graph.
fn problem(interface: &str, nodes: &str, links: &str) -> Problem {
    let mut all = problems(interface, nodes, links);
    assert_eq!(all.len(), 1, "{all:#?}");
    all.remove(0)
}

fn shape(problem: &Problem) -> (Kind, Option<&str>, &str, Option<&str>) {
    (problem.kind, problem.node.as_deref(), &problem.item, problem.suggestion.as_deref())
}

#[test]
fn all_problems_are_reported_at_once() {
    let all = problems(
        r#"outputs: {"sum": (node: "ad", socket: "sum")}"#,
        r#""a": (type: "test.constnt"), "b": (type: "test.constant", params: {"valu": 1, "value": 5000}),
           "add": (type: "test.add"), "half": (type: "test.halve"), "x": (type: "test.halve"),
           "y": (type: "test.halve")"#,
        r#""b.oout -> add.terms", "b.out -> add.term", "nonsense", "x.out -> y.in", "y.out -> x.in", "c.out -> add.terms""#,
    );
    let shapes: Vec<_> = all.iter().map(shape).collect();
    assert_eq!(
        shapes,
        [
            (Kind::UnknownType, Some("a"), "type", Some("test.constant")),
            (Kind::UnknownParam, Some("b"), "parameter", Some("value")),
            (Kind::BadValue, Some("b"), "parameter `value`", None),
            (Kind::UnknownSocket, Some("add"), "input", Some("terms")),
            (Kind::UnknownSocket, Some("b"), "output", Some("out")),
            (Kind::UnknownNode, None, "link `c.out -> add.terms`", None),
            (Kind::BadLink, None, "link", None),
            (Kind::MissingInput, Some("half"), "input `in`", None),
            (Kind::Cycle, Some("x"), "links", None),
            (Kind::UnknownNode, None, "interface output `sum`", Some("add")),
        ]
    );
    let text = Problems(all).to_string();
    assert!(
        text.contains("node `b`, parameter `value`: found 5000, expected a whole number from -1000 to 1000")
    );
    assert!(text.contains("found a loop `x` -> `y` -> `x`"), "{text}");
    assert!(text.contains("did you mean `test.constant`?"));
}

#[test]
fn types_must_agree() {
    let problem =
        problem("", r#""a": (type: "test.constant"), "u": (type: "test.unwrap")"#, r#""a.out -> u.in""#);
    assert_eq!(shape(&problem), (Kind::TypeMismatch, Some("u"), "input `in`", None));
    assert_eq!((problem.found.as_str(), problem.expected.as_str()), ("number from `a.out`", "opaque"));
}

#[test]
fn one_link_fits_into_a_socket_for_one() {
    let problem = problem(
        "",
        r#""a": (type: "test.constant"), "b": (type: "test.constant"), "h": (type: "test.halve")"#,
        r#""a.out -> h.in", "b.out -> h.in""#,
    );
    assert_eq!(shape(&problem), (Kind::TooManyLinks, Some("h"), "input `in`", None));
    assert_eq!(problem.found, "2 links, from a.out, b.out");
}

#[test]
fn a_node_linked_to_itself_is_a_loop() {
    let problem = problem("", r#""h": (type: "test.halve")"#, r#""h.out -> h.in""#);
    assert_eq!(problem.found, "a loop `h` -> `h`");
}

#[test]
fn values_of_the_wrong_type_are_reported() {
    for (value, found) in [
        ("\"x\"", "\"x\""),
        ("true", "true"),
        ("1.5", "1.5"),
        ("(1, 2)", "(1, 2)"),
        ("{\"a\": 1}", "{\"a\":1}"),
    ] {
        let nodes = format!(r#""a": (type: "test.constant", params: {{"value": {value}}})"#);
        let problem = problem("", &nodes, "");
        assert_eq!(shape(&problem), (Kind::BadValue, Some("a"), "parameter `value`", None), "{value}");
        assert_eq!(problem.found, found);
    }
    let unquoted = problem("", r#""f": (type: "test.fail", params: (how: failed))"#, "");
    assert!(unquoted.found.contains("quotes"), "{unquoted}");
    let misspelt = problem("", r#""f": (type: "test.fail", params: (how: "faled"))"#, "");
    assert_eq!(misspelt.suggestion.as_deref(), Some("failed"));
}

#[test]
fn unknown_fields_and_names_are_reported() {
    let field = problem("", r#""a": (type: "test.constant", parms: {})"#, "");
    assert_eq!(shape(&field), (Kind::UnknownField, Some("a"), "field", Some("params")));
    let name = problem("", r#""a.b": (type: "test.constant")"#, "");
    assert_eq!(name.kind, Kind::BadName);
}

#[test]
fn the_interface_must_point_at_something() {
    let nodes = r#""n": (type: "test.length"), "a": (type: "test.constant")"#;
    let input = |text: &str| problem(&format!("inputs: {{\"i\": {text}}}"), nodes, "");
    assert_eq!(input(r#"(type: "number", node: "m", param: "path")"#).kind, Kind::UnknownNode);
    let param = input(r#"(type: "number", node: "n", param: "pth")"#);
    assert_eq!(shape(&param), (Kind::UnknownParam, Some("n"), "interface input `i`", Some("path")));
    assert_eq!(input(r#"(type: "opaque", node: "n", param: "path")"#).kind, Kind::TypeMismatch);
    let socket = problem(r#"outputs: {"o": (node: "a", socket: "ot")}"#, nodes, "");
    assert_eq!(shape(&socket), (Kind::UnknownSocket, Some("a"), "interface output `o`", Some("out")));
    let target = |text: &str| problem(&format!("params: {{\"p\": (targets: [{text}])}}"), nodes, "");
    assert_eq!(target(r#""a.valu""#).suggestion.as_deref(), Some("value"));
    assert_eq!(target(r#""b.value""#).kind, Kind::UnknownNode);
    assert_eq!(target(r#""value""#).kind, Kind::BadLink);
    assert_eq!(target("").kind, Kind::BadLink);
    let default = problem(r#"params: {"p": (targets: ["a.value"], default: 9999)}"#, nodes, "");
    assert_eq!(default.kind, Kind::BadValue);
}

#[test]
fn the_interface_lists_what_can_be_set() {
    let document = document(
        r#"inputs: {"text": (type: "number", docs: "Any text.", node: "n", param: "path")},
           outputs: {"length": (node: "n", socket: "out")},
           params: {"x": (docs: "", targets: ["a.value", "b.value"], default: 7)}"#,
        r#""n": (type: "test.length", params: (path: "sub/file.txt")), "a": (type: "test.constant"),
           "b": (type: "test.constant")"#,
        "",
    );
    let mut graph = Graph::with_folder(&document, &registry(), "some/folder".as_ref()).unwrap();
    let input = graph.inputs().next().unwrap();
    assert_eq!((input.name, input.ty, input.extensions), ("text", "number", &["txt"][..]));
    assert_eq!(input.path, std::path::Path::new("some/folder").join("sub/file.txt").to_string_lossy());
    let output = graph.outputs().next().unwrap();
    assert_eq!((output.name, output.ty, output.docs), ("length", "number", "Its length."));
    let param = graph.params().next().unwrap();
    assert_eq!((param.name, param.docs, param.value), ("x", "A number.", &int(7)));

    graph.set("x", &int(9)).unwrap();
    assert_eq!(graph.node_params("b").unwrap()["value"], int(9));
    graph.set("a.value", &int(-9)).unwrap();
    assert_eq!(graph.node_params("a").unwrap()["value"], int(-9));
    let error = graph.set("y", &int(1)).unwrap_err();
    assert_eq!(error.0[0].kind, Kind::UnknownInterface);
    assert_eq!(graph.set("x", &ParamValue::Bool(true)).unwrap_err().0[0].item, "parameter `x`");
    assert_eq!(graph.set_input("txt", "x").unwrap_err().0[0].suggestion.as_deref(), Some("text"));
}

#[test]
fn paths_with_a_scheme_stay_as_they_are() {
    let document = document("", r#""n": (type: "test.length", params: (path: "builtin:stone.txt"))"#, "");
    let graph = Graph::with_folder(&document, &registry(), "some/folder".as_ref()).unwrap();
    assert_eq!(graph.node_params("n").unwrap()["path"], ParamValue::Text("builtin:stone.txt".into()));
}

#[test]
fn consumers_are_known() {
    assert_eq!(sum().consumers("add"), ["half"]);
    assert_eq!(sum().consumers("half"), [""; 0]);
}
