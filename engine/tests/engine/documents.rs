//! Properties of documents.

use std::collections::BTreeMap;

use breccia_engine::{
    Document, Interface, InterfaceInput, InterfaceOutput, InterfaceParam, NodeEntry, NodeMode, ParamValue,
};
use proptest::prelude::*;

fn value() -> impl Strategy<Value = ParamValue> {
    let leaf = prop_oneof![
        any::<bool>().prop_map(ParamValue::Bool),
        any::<i64>().prop_map(ParamValue::Int),
        any::<f64>().prop_filter("equal to itself", |x| !x.is_nan()).prop_map(ParamValue::Float),
        any::<f32>()
            .prop_filter("equal to itself", |x| !x.is_nan())
            .prop_map(|x| ParamValue::Float(x.into())),
        any::<String>().prop_map(ParamValue::Text),
    ];
    leaf.prop_recursive(2, 8, 4, |inner| prop::collection::vec(inner, 0..4).prop_map(ParamValue::List))
}

fn ron_value() -> impl Strategy<Value = ron::Value> {
    let leaf = prop_oneof![
        Just(ron::Value::Unit),
        any::<bool>().prop_map(ron::Value::Bool),
        any::<char>().prop_map(ron::Value::Char),
        any::<String>().prop_map(ron::Value::String),
    ];
    leaf.prop_recursive(3, 16, 4, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..4).prop_map(ron::Value::Seq),
            prop::collection::vec((any::<String>(), inner.clone()), 0..4)
                .prop_map(|items| ron::Value::Map(items.into_iter().collect())),
            inner.prop_map(|value| ron::Value::Option(Some(Box::new(value)))),
        ]
    })
}

fn map<T: std::fmt::Debug>(values: impl Strategy<Value = T>) -> impl Strategy<Value = BTreeMap<String, T>> {
    prop::collection::btree_map(any::<String>(), values, 0..4)
}

fn node() -> impl Strategy<Value = NodeEntry> {
    let fields = prop::collection::btree_map("[a-z_]{3,9}x", ron_value(), 0..2);
    let mode = prop::sample::select(&NodeMode::ALL);
    (any::<String>(), mode, map(value()), fields).prop_map(|(ty, mode, params, other_fields)| NodeEntry {
        ty,
        mode,
        params,
        other_fields,
        ..NodeEntry::default()
    })
}

fn interface() -> impl Strategy<Value = Interface> {
    let texts = || (any::<String>(), any::<String>(), any::<String>());
    let inputs = map((texts(), any::<String>()).prop_map(|((ty, docs, node), param)| InterfaceInput {
        ty,
        docs,
        node,
        param,
        targets: Vec::new(),
    }));
    let outputs = map(texts().prop_map(|(docs, node, socket)| InterfaceOutput { docs, node, socket }));
    let targets = prop::collection::vec(any::<String>(), 0..3);
    let params = (any::<String>(), targets, prop::option::of(value()));
    let params = map(params.prop_map(|(docs, targets, default)| InterfaceParam { docs, targets, default }));
    (inputs, outputs, params).prop_map(|(inputs, outputs, params)| Interface { inputs, outputs, params })
}

fn link() -> impl Strategy<Value = String> {
    prop_oneof!["[abc]\\.[xy] ?-> ?[abc]\\.[xy]", any::<String>()]
}

prop_compose! {
    fn document()(
        title in any::<String>(),
        docs in any::<String>(),
        interface in interface(),
        nodes in map(node()),
        links in prop::collection::vec(link(), 0..6),
        editor in ron_value(),
    ) -> Document {
        Document { title, docs, interface, nodes, links, editor, groups: BTreeMap::new() }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_written_reads_back(document in document()) {
        let text = document.to_ron();
        let read = Document::parse(&text).map_err(|error| TestCaseError::fail(format!("{error}: {text}")))?;
        prop_assert_eq!(&read.nodes, &document.nodes);
        prop_assert_eq!(&read.interface, &document.interface);
        prop_assert_eq!(&read.editor, &document.editor);
        prop_assert_eq!(read.links.len(), document.links.len());
        // Reading brings links into canonical form; from then on nothing changes.
        prop_assert_eq!(read.to_ron(), text);
    }

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = Document::parse_bytes(&bytes);
    }

    #[test]
    fn random_ron_never_panics(text in r#"[(){}\[\],:"'a-c0-9.#\\ rb-]{0,60}"#) {
        let _ = Document::parse(&text);
        let _ = Document::parse(&format!("(format: \"breccia-graph\", version: 1, nodes: {text})"));
        let _ = Document::parse(&format!("(format: \"breccia-graph\", version: 0, links: {text})"));
        let _ = breccia_engine::parse_value(&text);
    }

    #[test]
    fn damaged_documents_never_panic(at in 0usize..400, byte in any::<u8>()) {
        let mut bytes = crate::support::document("", r#""a": (type: "t.a", params: {"x": (1, 2.5, "s")})"#, r#""a.b -> c.d""#)
            .to_ron()
            .into_bytes();
        let at = at % bytes.len();
        bytes[at] = byte;
        let _ = Document::parse_bytes(&bytes);
    }
}

#[test]
fn deep_nesting_is_an_error() {
    let text = format!("(format: \"breccia-graph\", version: 1, nodes: {}", "[".repeat(100_000));
    assert!(Document::parse(&text).is_err());
}
