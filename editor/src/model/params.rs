//! Parameters: setting them, and exposing them on the graph.

use breccia_engine::{InterfaceInput, InterfaceParam, ParamValue};

use super::edit::unique;
use super::level::Address;
use super::state::State;

/// How the graph's interface knows a parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Exposure {
    /// As a file to give.
    Input(String),
    /// As a parameter to set.
    Param(String),
}

impl Exposure {
    /// The name in the interface.
    pub fn name(&self) -> &str {
        match self {
            Self::Input(name) | Self::Param(name) => name,
        }
    }
}

/// Under which name the interface knows a node's parameter.
pub fn exposure(state: &State, at: &Address, node: &str, param: &str) -> Option<Exposure> {
    let interface = state.level(at)?.interface;
    let target = format!("{node}.{param}");
    let file = interface.inputs.iter().find(|(_, input)| input.node == node && input.param == param);
    let file = file.map(|(name, _)| Exposure::Input(name.clone()));
    let exposed = || interface.params.iter().find(|(_, exposed)| exposed.targets.contains(&target));
    file.or_else(|| exposed().map(|(name, _)| Exposure::Param(name.clone())))
}

/// Sets a parameter of a node; `None` goes back to its default. Where an exposed parameter holds the value, it is set there, for all of
/// its targets.
pub fn set_param(state: &mut State, at: &Address, node: &str, param: &str, value: Option<ParamValue>) {
    let shared = match exposure(state, at, node, param) {
        Some(Exposure::Param(name)) => Some(name),
        _ => None,
    };
    let Some(level) = state.level_mut(at) else { return };
    if let Some(exposed) = shared.and_then(|name| level.interface.params.get_mut(&name))
        && (exposed.default.is_some() || exposed.targets.len() > 1)
    {
        exposed.default = value;
        return;
    }
    let Some(entry) = level.nodes.get_mut(node) else { return };
    match value {
        Some(value) => entry.params.insert(param.to_owned(), value),
        None => entry.params.remove(param),
    };
}

/// Offers a parameter to whoever runs the graph. `file` is the type of what a file parameter's node reads.
pub fn expose(
    state: &mut State,
    at: &Address,
    node: &str,
    param: &str,
    file: Option<&str>,
    docs: &str,
) -> Option<String> {
    if let Some(found) = exposure(state, at, node, param) {
        return Some(found.name().to_owned());
    }
    let level = state.level_mut(at)?;
    if let Some(ty) = file.filter(|_| at.0.is_empty()) {
        let name = unique(&level.interface.inputs, node);
        let input = InterfaceInput {
            ty: ty.to_owned(),
            docs: docs.to_owned(),
            node: node.to_owned(),
            param: param.to_owned(),
            targets: Vec::new(),
        };
        level.interface.inputs.insert(name.clone(), input);
        return Some(name);
    }
    let name = unique(&level.interface.params, param);
    let exposed =
        InterfaceParam { docs: docs.to_owned(), targets: vec![format!("{node}.{param}")], default: None };
    level.interface.params.insert(name.clone(), exposed);
    Some(name)
}

/// Takes a parameter back from the interface. What the interface said stays as the node's own value.
pub fn unexpose(state: &mut State, at: &Address, node: &str, param: &str) {
    let found = exposure(state, at, node, param);
    let Some(level) = state.level_mut(at) else { return };
    match found {
        Some(Exposure::Input(name)) => {
            level.interface.inputs.remove(&name);
        }
        Some(Exposure::Param(name)) => {
            let target = format!("{node}.{param}");
            let Some(exposed) = level.interface.params.get_mut(&name) else { return };
            exposed.targets.retain(|other| *other != target);
            let value = exposed.default.clone();
            if exposed.targets.is_empty() {
                level.interface.params.remove(&name);
            }
            if let (Some(value), Some(entry)) = (value, level.nodes.get_mut(node)) {
                entry.params.insert(param.to_owned(), value);
            }
        }
        None => {}
    }
}

/// Lets an exposed parameter set a further one: the two are one from now on.
pub fn link_param(
    state: &mut State,
    at: &Address,
    node: &str,
    param: &str,
    name: &str,
    current: &ParamValue,
) {
    unexpose(state, at, node, param);
    let Some(level) = state.level_mut(at) else { return };
    let Some(exposed) = level.interface.params.get_mut(name) else { return };
    exposed.targets.push(format!("{node}.{param}"));
    // One value for all: that of the parameter that was there first.
    if exposed.default.is_none() {
        exposed.default = Some(current.clone());
    }
    if let Some(entry) = level.nodes.get_mut(node) {
        entry.params.remove(param);
    }
}
