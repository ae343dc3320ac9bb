//! What a node implements, and what it sees while it runs.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use crate::device::ComputeDevice;
use crate::estimate::{Sizing, Work};
use crate::spec::{NodeSpec, ParamValue};
use crate::value::{Data, Value};

/// A node type: a description and a pure function from inputs and parameters to outputs.
///
/// Nothing but what [`Context`] hands out may influence the outputs, since they are cached by it.
pub trait Node: Send + Sync {
    /// The description. Called once, at registration.
    fn spec(&self) -> NodeSpec;

    /// Computes the outputs.
    ///
    /// # Errors
    /// Says what was found and what was expected; never panics on any input.
    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError>;

    /// Roughly how much there is to do, for nodes that can run on a compute device.
    fn work(&self, _sizing: &Sizing<'_>) -> Option<Work> {
        None
    }

    /// Roughly how many bytes of memory the outputs will take, for those who ask before they run a graph.
    fn estimate(&self, _sizing: &Sizing<'_>) -> Option<u64> {
        None
    }
}

/// Why a node did not finish.
#[derive(Clone, Debug, thiserror::Error)]
pub enum NodeError {
    /// The run was cancelled.
    #[error("cancelled")]
    Cancelled,
    /// A file or another input is unreadable or invalid (exit code 4).
    #[error("{0}")]
    Input(String),
    /// The computation cannot be done (exit code 5).
    #[error("{0}")]
    Failed(String),
}

impl NodeError {
    /// An unreadable or invalid input.
    pub fn input(error: impl std::fmt::Display) -> Self {
        Self::Input(error.to_string())
    }

    /// Any other failure.
    pub fn failed(error: impl std::fmt::Display) -> Self {
        Self::Failed(error.to_string())
    }
}

/// A shared flag that asks a run to stop.
#[derive(Clone, Debug, Default)]
pub struct CancelToken {
    flag: Arc<AtomicBool>,
    /// Of a computation that several runs wait for: their tokens. It stops when all of them want it to.
    wanted_by: Option<Arc<Mutex<Vec<CancelToken>>>>,
}

impl CancelToken {
    /// Asks the run to stop.
    pub fn cancel(&self) {
        self.flag.store(true, Ordering::Relaxed);
    }

    /// Whether the run should stop.
    pub fn is_cancelled(&self) -> bool {
        let unwanted = |runs: &Arc<Mutex<Vec<Self>>>| {
            runs.lock().unwrap_or_else(PoisonError::into_inner).iter().all(Self::is_cancelled)
        };
        self.flag.load(Ordering::Relaxed) || self.wanted_by.as_ref().is_some_and(unwanted)
    }

    /// The token of a computation that this run wants, and perhaps others too.
    pub(crate) fn shared(&self) -> Self {
        Self { flag: Arc::default(), wanted_by: Some(Arc::new(Mutex::new(vec![self.clone()]))) }
    }

    /// Another run wants the computation.
    pub(crate) fn join(&self, run: &Self) {
        if let Some(runs) = &self.wanted_by {
            runs.lock().unwrap_or_else(PoisonError::into_inner).push(run.clone());
        }
    }
}

/// What a node sees while it runs: inputs, parameters, contents of its files, progress, cancellation.
pub struct Context<'a> {
    pub(crate) inputs: BTreeMap<&'static str, Vec<Value>>,
    pub(crate) params: BTreeMap<&'static str, ParamValue>,
    pub(crate) files: BTreeMap<&'static str, Arc<Vec<u8>>>,
    pub(crate) outputs: BTreeMap<&'static str, Value>,
    pub(crate) cancel: &'a CancelToken,
    pub(crate) progress: &'a (dyn Fn(f32) + Sync),
    pub(crate) device: Option<Arc<dyn ComputeDevice>>,
    pub(crate) apart: bool,
    pub(crate) device_used: AtomicBool,
    pub(crate) warn: &'a (dyn Fn(String) + Sync),
}

impl Context<'_> {
    /// The value linked to a required input.
    ///
    /// # Errors
    /// If the node's own declaration lacks such an input of this type.
    pub fn input<T: Data>(&self, name: &str) -> Result<Arc<T>, NodeError> {
        self.optional(name)?.ok_or_else(|| NodeError::Failed(format!("nothing is linked to input `{name}`")))
    }

    /// The value linked to an optional input.
    ///
    /// # Errors
    /// If the node's own declaration gives this input another type.
    pub fn optional<T: Data>(&self, name: &str) -> Result<Option<Arc<T>>, NodeError> {
        Ok(self.many(name)?.into_iter().next())
    }

    /// The values linked to an input that takes many, in the order of the document.
    ///
    /// # Errors
    /// If the node's own declaration gives this input another type.
    pub fn many<T: Data>(&self, name: &str) -> Result<Vec<Arc<T>>, NodeError> {
        let values = self.inputs.get(name).map_or(&[][..], Vec::as_slice);
        let typed = values.iter().map(|value| {
            value.downcast::<T>().ok_or_else(|| {
                NodeError::Failed(format!(
                    "input `{name}` carries {}, the node asks for {}",
                    value.type_name(),
                    T::TYPE
                ))
            })
        });
        typed.collect()
    }

    fn param(&self, name: &str) -> Result<&ParamValue, NodeError> {
        self.params
            .get(name)
            .ok_or_else(|| NodeError::Failed(format!("the node asks for an undeclared parameter `{name}`")))
    }

    fn wrong<T>(name: &str, value: &ParamValue, expected: &str) -> Result<T, NodeError> {
        Err(NodeError::Failed(format!("parameter `{name}` is {value:?}, the node asks for {expected}")))
    }

    /// A yes-or-no parameter.
    ///
    /// # Errors
    /// If the declaration lacks it.
    pub fn flag(&self, name: &str) -> Result<bool, NodeError> {
        match self.param(name)? {
            ParamValue::Bool(b) => Ok(*b),
            other => Self::wrong(name, other, "true or false"),
        }
    }

    /// A whole-number parameter, within its declared range.
    ///
    /// # Errors
    /// If the declaration lacks it.
    pub fn int(&self, name: &str) -> Result<i64, NodeError> {
        match self.param(name)? {
            ParamValue::Int(i) => Ok(*i),
            other => Self::wrong(name, other, "a whole number"),
        }
    }

    /// A real-number parameter, within its declared range.
    ///
    /// # Errors
    /// If the declaration lacks it.
    pub fn float(&self, name: &str) -> Result<f64, NodeError> {
        match self.param(name)? {
            ParamValue::Float(f) => Ok(*f),
            ParamValue::Int(i) => Ok(*i as f64),
            other => Self::wrong(name, other, "a number"),
        }
    }

    /// A text, choice or path parameter.
    ///
    /// # Errors
    /// If the declaration lacks it.
    pub fn text(&self, name: &str) -> Result<&str, NodeError> {
        match self.param(name)? {
            ParamValue::Text(s) => Ok(s),
            other => Self::wrong(name, other, "a text"),
        }
    }

    /// A list of whole numbers.
    ///
    /// # Errors
    /// If the declaration lacks it.
    pub fn ints(&self, name: &str) -> Result<Vec<i64>, NodeError> {
        let value = self.param(name)?;
        let ParamValue::List(items) = value else { return Self::wrong(name, value, "whole numbers") };
        let ints = items.iter().map(|item| match item {
            ParamValue::Int(i) => Ok(*i),
            other => Self::wrong(name, other, "a whole number"),
        });
        ints.collect()
    }

    /// A list of real numbers.
    ///
    /// # Errors
    /// If the declaration lacks it.
    pub fn floats(&self, name: &str) -> Result<Vec<f64>, NodeError> {
        let value = self.param(name)?;
        let ParamValue::List(items) = value else { return Self::wrong(name, value, "numbers") };
        let floats = items.iter().map(|item| match item {
            ParamValue::Int(i) => Ok(*i as f64),
            ParamValue::Float(f) => Ok(*f),
            other => Self::wrong(name, other, "a number"),
        });
        floats.collect()
    }

    /// The contents of the file that a file parameter names.
    ///
    /// # Errors
    /// If the declaration lacks it.
    pub fn file(&self, name: &str) -> Result<Arc<Vec<u8>>, NodeError> {
        self.files
            .get(name)
            .cloned()
            .ok_or_else(|| NodeError::Failed(format!("the node asks for an undeclared file `{name}`")))
    }

    /// Sets an output.
    pub fn set<T: Data>(&mut self, name: &'static str, data: T) {
        self.outputs.insert(name, Value::new(data));
    }

    /// Sets an output to a value that is shared already.
    pub fn set_shared<T: Data>(&mut self, name: &'static str, data: Arc<T>) {
        self.outputs.insert(name, Value::from_arc(data));
    }

    /// Whether the run should stop; long computations ask at least every 50 ms.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.is_cancelled()
    }

    /// The compute device, if the node is to run there. Whoever asks is taken to use it.
    pub fn device(&self) -> Option<&dyn ComputeDevice> {
        let device = self.device.as_deref().filter(|device| device.lost().is_none())?;
        self.device_used.store(true, Ordering::Relaxed);
        Some(device)
    }

    /// The compute device, if the node is to run there and its results may differ from the CPU's in rounding: those of a node that
    /// says so ([`crate::Placement::Apart`]).
    pub fn device_for_floats(&self) -> Option<&dyn ComputeDevice> {
        if self.apart { self.device() } else { None }
    }

    /// Tells of something that does not stop the node.
    pub fn warn(&self, message: impl Into<String>) {
        (self.warn)(message.into());
    }

    /// Reports the fraction done, 0 to 1.
    pub fn progress(&self, fraction: f32) {
        (self.progress)(fraction);
    }
}
