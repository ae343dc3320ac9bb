//! Every node type describes itself fully.

#[test]
fn nodes_lack_no_docs_units_or_ranges() {
    assert_eq!(breccia_engine::lint(&breccia_nodes::registry()), [""; 0]);
}
