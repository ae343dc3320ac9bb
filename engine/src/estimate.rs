//! How much memory a node's outputs will take, guessed before anything runs.

use std::collections::BTreeMap;

use crate::spec::ParamValue;

/// How much a node has to do, for the choice of where it runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Work {
    /// Seconds on all CPU threads of an ordinary machine.
    pub seconds: f64,
    /// Bytes that would move to a compute device and back.
    pub bytes: u64,
}

/// What a node guesses the size of its outputs from: its parameters, and the sizes of its inputs as far as they
/// are known or guessed.
pub struct Sizing<'a> {
    pub(crate) params: &'a BTreeMap<&'static str, ParamValue>,
    pub(crate) inputs: BTreeMap<&'static str, Option<u64>>,
}

impl Sizing<'_> {
    /// A whole-number parameter.
    pub fn int(&self, name: &str) -> Option<i64> {
        match self.params.get(name)? {
            ParamValue::Int(i) => Some(*i),
            _ => None,
        }
    }

    /// A list of whole numbers, or the one number that stands for it.
    pub fn ints(&self, name: &str) -> Option<Vec<i64>> {
        match self.params.get(name)? {
            ParamValue::Int(i) => Some(vec![*i]),
            ParamValue::List(items) => {
                let int = |item: &ParamValue| if let ParamValue::Int(i) = item { Some(*i) } else { None };
                items.iter().map(int).collect()
            }
            _ => None,
        }
    }

    /// The bytes of what is linked to an input; nothing if that is not known.
    pub fn input(&self, name: &str) -> Option<u64> {
        self.inputs.get(name).copied().flatten()
    }
}
