//! What descriptions of node types lack.

use std::collections::BTreeSet;

use crate::registry::Registry;
use crate::spec::{NodeSpec, ParamKind, ParamSpec};

/// What the descriptions of all node and socket types lack: docs, units, sensible defaults and ranges,
/// proper names, known socket types. Empty if all is well.
///
/// Numbers need a unit; those without a dimension have `1` or `count`.
pub fn lint(registry: &Registry) -> Vec<String> {
    let mut complaints = Vec::new();
    for ty in registry.types() {
        if !is_name(ty.name) {
            complaints.push(format!("type `{}`: the name is not in snake case", ty.name));
        }
        if ty.docs.trim().is_empty() {
            complaints.push(format!("type `{}` has no docs", ty.name));
        }
    }
    for node in registry.nodes() {
        let mut complain = |text: String| complaints.push(format!("node `{}`: {text}", node.spec.id));
        lint_node(&node.spec, registry, &mut complain);
    }
    complaints
}

fn lint_node(spec: &NodeSpec, registry: &Registry, complain: &mut dyn FnMut(String)) {
    let parts: Vec<_> = spec.id.split('.').collect();
    if parts.len() < 2 || !parts.iter().all(|part| is_name(part)) {
        complain("the id is not `family.name` in snake case".into());
    }
    for (what, text) in [("summary", spec.summary), ("docs", spec.docs), ("category", spec.category)] {
        if text.trim().is_empty() {
            complain(format!("no {what}"));
        }
    }
    if spec.summary.ends_with('.') || spec.summary.contains('\n') {
        complain("the summary is not one line without a full stop".into());
    }
    // The sockets of a node that stands for a group are the group's.
    if spec.outputs.is_empty() && !crate::flow::stands_for_graph(spec.id) {
        complain("no outputs".into());
    }
    for sockets in [&spec.inputs, &spec.outputs] {
        let mut seen = BTreeSet::new();
        for socket in sockets {
            let name = socket.name;
            if !is_name(name) || !seen.insert(name) {
                complain(format!("socket `{name}`: the name is not in snake case, or there twice"));
            }
            if socket.docs.trim().is_empty() {
                complain(format!("socket `{name}` has no docs"));
            }
            if registry.socket_type(socket.ty).is_none() {
                complain(format!("socket `{name}` has the unknown type `{}`", socket.ty));
            }
        }
    }
    let mut seen = BTreeSet::new();
    for param in &spec.params {
        if !is_name(param.name) || !seen.insert(param.name) {
            complain(format!("parameter `{}`: the name is not in snake case, or there twice", param.name));
        }
        lint_param(param, complain);
    }
}

fn lint_param(param: &ParamSpec, complain: &mut dyn FnMut(String)) {
    let name = param.name;
    if param.docs.trim().is_empty() {
        complain(format!("parameter `{name}` has no docs"));
    }
    let number = matches!(
        param.kind,
        ParamKind::Int { .. } | ParamKind::Float { .. } | ParamKind::Ints { .. } | ParamKind::Floats { .. }
    );
    if number && param.unit.is_empty() {
        complain(format!("parameter `{name}` has no unit; `1` or `count` if it has no dimension"));
    }
    if let Err(mismatch) = param.kind.check(&param.default) {
        complain(format!(
            "parameter `{name}`: the default is {}, expected {}",
            mismatch.found, mismatch.expected
        ));
    }
    match &param.kind {
        ParamKind::Choice(choices) => {
            for (choice, _) in
                choices.iter().filter(|(choice, docs)| !is_name(choice) || docs.trim().is_empty())
            {
                complain(format!(
                    "parameter `{name}`: choice `{choice}` has no docs, or is not in snake case"
                ));
            }
        }
        ParamKind::Float { step, .. } if !(*step > 0.0 && step.is_finite()) => {
            complain(format!("parameter `{name}`: the step {step} is not above 0"));
        }
        _ => {}
    }
}

/// Whether a name is in snake case.
fn is_name(name: &str) -> bool {
    !name.is_empty() && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
}
