//! Reference pages and complaints about them.

use breccia_engine::{
    Context, Node, NodeError, NodeSpec, ParamKind, ParamValue, describe, lint, markdown, plain,
};

use crate::nodes::registry;

struct Shabby;

impl Node for Shabby {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new("Shabby", 1, "Ends in a full stop.", "")
            .input("in", "unheard", "")
            .output("out", "number", "It.")
            .int("size", 1..=4, 9, "", "")
            .param("mode", ParamKind::Choice(&[("a", "")]), ParamValue::Text("b".into()), "", "Docs.")
    }
    fn run(&self, _: &mut Context<'_>) -> Result<(), NodeError> {
        Ok(())
    }
}

#[test]
fn whatever_a_description_lacks_is_found() {
    assert_eq!(lint(&registry()), [""; 0]);
    let mut registry = registry();
    registry.add_nodes([Box::new(Shabby) as Box<dyn Node>]);
    let complaints = lint(&registry);
    for part in [
        "the id",
        "no docs",
        "full stop",
        "socket `in` has no docs",
        "unknown type `unheard`",
        "parameter `size` has no docs",
        "parameter `size` has no unit",
        "the default is 9, expected a whole number from 1 to 4",
        "the default is \"b\"",
        "choice `a` has no docs",
    ] {
        assert!(complaints.iter().any(|c| c.contains(part)), "{part}: {complaints:#?}");
    }
}

#[test]
fn pages_name_everything() {
    let registry = registry();
    for node in registry.nodes() {
        let doc = describe(&node.spec);
        for page in [markdown(&node.spec), plain(&node.spec)] {
            let sockets = doc.inputs.iter().chain(&doc.outputs).map(|s| s.name);
            let names = sockets.chain(doc.params.iter().flat_map(|p| {
                [p.name, p.docs].into_iter().chain(p.choices.iter().map(|c| c.name)).collect::<Vec<_>>()
            }));
            for name in names.chain([doc.id, doc.summary]) {
                assert!(page.contains(name), "{name}: {page}");
            }
        }
    }
    let slow = markdown(&registry.node("test.slow").unwrap().spec);
    assert!(slow.contains("| `millis` | a whole number from 0 to 60000, in milliseconds | `50` |"), "{slow}");
    assert!(slow.contains("| `in` | number, optional | A number. |"), "{slow}");
}
