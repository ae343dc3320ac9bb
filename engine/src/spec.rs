//! Self-description of node types: sockets, parameters, docs. Help, palettes, validation and the
//! reference pages are all generated from it.

use serde::Serialize;

/// A parameter's value as it stands in a document and on the command line.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum ParamValue {
    /// `true` or `false`.
    Bool(bool),
    /// A whole number.
    Int(i64),
    /// A real number.
    Float(f64),
    /// A text, the name of a choice, or a path.
    Text(String),
    /// Several numbers: `(1, 2, 3)` or `[1, 2, 3]`.
    List(Vec<ParamValue>),
}

/// What values a parameter takes.
#[derive(Clone, Debug, PartialEq)]
pub enum ParamKind {
    /// `true` or `false`.
    Bool,
    /// A whole number from `min` to `max`.
    Int {
        /// Smallest value allowed.
        min: i64,
        /// Largest value allowed.
        max: i64,
    },
    /// A real number from `min` to `max`; `step` is what one click in an editor changes.
    Float {
        /// Smallest value allowed.
        min: f64,
        /// Largest value allowed.
        max: f64,
        /// A sensible increment.
        step: f64,
    },
    /// One of several names, each with its one-line docs.
    Choice(&'static [(&'static str, &'static str)]),
    /// Any text.
    Text,
    /// A file to read. Its contents are part of the cache key. Empty means not given; a node whose
    /// path is not given is absent: optional sockets see nothing, others report a missing input.
    File {
        /// Extensions that can be read, in lower case and without the dot.
        extensions: &'static [&'static str],
    },
    /// Between `min_len` and `max_len` whole numbers, each from `min` to `max`.
    Ints {
        /// Fewest numbers.
        min_len: usize,
        /// Most numbers.
        max_len: usize,
        /// Smallest value allowed.
        min: i64,
        /// Largest value allowed.
        max: i64,
    },
    /// Between `min_len` and `max_len` real numbers, each from `min` to `max`.
    Floats {
        /// Fewest numbers.
        min_len: usize,
        /// Most numbers.
        max_len: usize,
        /// Smallest value allowed.
        min: f64,
        /// Largest value allowed.
        max: f64,
    },
}

/// A parameter of a node type.
#[derive(Clone, Debug)]
pub struct ParamSpec {
    /// Its name, in snake case.
    pub name: &'static str,
    /// The values it takes.
    pub kind: ParamKind,
    /// Its unit (`voxels`, `pixels`, `degrees`, …); `""` where a unit makes no sense.
    pub unit: &'static str,
    /// The value used where a document gives none.
    pub default: ParamValue,
    /// What it does, in a sentence or more.
    pub docs: &'static str,
}

/// How many links a socket takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arity {
    /// Exactly one.
    One,
    /// None or one.
    Optional,
    /// Any number, kept in the order of the document.
    Many,
}

/// An input or output socket.
#[derive(Clone, Debug)]
pub struct SocketSpec {
    /// Its name, in snake case.
    pub name: &'static str,
    /// The name of its type ([`crate::Data::TYPE`]).
    pub ty: &'static str,
    /// How many links it takes (outputs are always [`Arity::One`]).
    pub arity: Arity,
    /// What flows through it.
    pub docs: &'static str,
}

/// Where a node can run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// On CPU threads only.
    Cpu,
    /// On CPU threads or on the compute device, with the same result bit for bit.
    CpuOrGpu,
    /// On CPU threads, or on the compute device with a result that differs in rounding. The two are kept apart in the cache, and
    /// `auto` stays with CPU threads, so that what comes out depends on what is asked for alone.
    Apart,
}

/// Everything there is to know of a node type but how it computes.
#[derive(Clone, Debug)]
pub struct NodeSpec {
    /// Stable dotted id (`lazy.candidates`), never derived from a Rust path.
    pub id: &'static str,
    /// Raised whenever the output for the same inputs changes; part of every cache key.
    pub version: u32,
    /// Its heading in palettes and references.
    pub category: &'static str,
    /// One line, without a full stop.
    pub summary: &'static str,
    /// Paragraphs of documentation in Markdown.
    pub docs: &'static str,
    /// The paper and section it implements.
    pub paper: Option<&'static str>,
    /// Where it can run.
    pub placement: Placement,
    /// Whether outputs are worth keeping in the disk cache (cheap nodes say no).
    pub disk_cache: bool,
    /// Input sockets, in display order.
    pub inputs: Vec<SocketSpec>,
    /// Output sockets, in display order.
    pub outputs: Vec<SocketSpec>,
    /// Parameters, in display order.
    pub params: Vec<ParamSpec>,
    /// What may be coarser in a draft, while somebody drags something.
    pub draft: Vec<Draft>,
}

/// A whole-number parameter, or a list of them, that may be smaller in a draft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draft {
    /// Its name.
    pub param: &'static str,
    /// What its numbers are divided by.
    pub divisor: i64,
    /// What they do not go below; smaller ones stay as they are.
    pub least: i64,
}

impl NodeSpec {
    /// A node type without sockets or parameters; the category is the id's first part.
    pub fn new(id: &'static str, version: u32, summary: &'static str, docs: &'static str) -> Self {
        Self {
            id,
            version,
            category: id.split('.').next().unwrap_or(id),
            summary,
            docs,
            paper: None,
            placement: Placement::Cpu,
            disk_cache: true,
            inputs: Vec::new(),
            outputs: Vec::new(),
            params: Vec::new(),
            draft: Vec::new(),
        }
    }

    /// Says that a whole-number parameter, or all numbers of a list, may be divided for a draft, as long as what is left is not below
    /// `least`: the result is coarser or smaller, but shows what it will be.
    pub fn draft(mut self, param: &'static str, divisor: i64, least: i64) -> Self {
        self.draft.push(Draft { param, divisor: divisor.max(1), least });
        self
    }

    /// Names the paper and section.
    pub fn paper(mut self, paper: &'static str) -> Self {
        self.paper = Some(paper);
        self
    }

    /// Says that the node runs on a compute device too, with the same result bit for bit.
    pub fn on_device(mut self) -> Self {
        self.placement = Placement::CpuOrGpu;
        self
    }

    /// Says that the node runs on a compute device too, with a result that differs in rounding.
    pub fn on_device_apart(mut self) -> Self {
        self.placement = Placement::Apart;
        self
    }

    /// Keeps outputs out of the disk cache: computing them is about as fast as reading them.
    pub fn memory_only(mut self) -> Self {
        self.disk_cache = false;
        self
    }

    /// Adds a required input.
    pub fn input(self, name: &'static str, ty: &'static str, docs: &'static str) -> Self {
        self.socket(name, ty, Arity::One, docs)
    }

    /// Adds an input that may stay unlinked.
    pub fn optional(self, name: &'static str, ty: &'static str, docs: &'static str) -> Self {
        self.socket(name, ty, Arity::Optional, docs)
    }

    /// Adds an input that takes any number of links.
    pub fn many(self, name: &'static str, ty: &'static str, docs: &'static str) -> Self {
        self.socket(name, ty, Arity::Many, docs)
    }

    fn socket(mut self, name: &'static str, ty: &'static str, arity: Arity, docs: &'static str) -> Self {
        self.inputs.push(SocketSpec { name, ty, arity, docs });
        self
    }

    /// Adds an output.
    pub fn output(mut self, name: &'static str, ty: &'static str, docs: &'static str) -> Self {
        self.outputs.push(SocketSpec { name, ty, arity: Arity::One, docs });
        self
    }

    /// Adds a parameter of any kind.
    pub fn param(
        mut self,
        name: &'static str,
        kind: ParamKind,
        default: ParamValue,
        unit: &'static str,
        docs: &'static str,
    ) -> Self {
        self.params.push(ParamSpec { name, kind, unit, default, docs });
        self
    }

    /// Adds a whole-number parameter.
    pub fn int(
        self,
        name: &'static str,
        range: std::ops::RangeInclusive<i64>,
        default: i64,
        unit: &'static str,
        docs: &'static str,
    ) -> Self {
        let kind = ParamKind::Int { min: *range.start(), max: *range.end() };
        self.param(name, kind, ParamValue::Int(default), unit, docs)
    }

    /// Adds a real-number parameter whose step is a hundredth of its default, or of 1.
    pub fn float(
        self,
        name: &'static str,
        range: std::ops::RangeInclusive<f64>,
        default: f64,
        unit: &'static str,
        docs: &'static str,
    ) -> Self {
        let step = if default == 0.0 { 0.01 } else { default.abs() / 100.0 };
        let kind = ParamKind::Float { min: *range.start(), max: *range.end(), step };
        self.param(name, kind, ParamValue::Float(default), unit, docs)
    }

    /// Adds a yes-or-no parameter.
    pub fn flag(self, name: &'static str, default: bool, docs: &'static str) -> Self {
        self.param(name, ParamKind::Bool, ParamValue::Bool(default), "", docs)
    }

    /// Adds a choice; the first name is the default.
    pub fn choice(
        self,
        name: &'static str,
        choices: &'static [(&'static str, &'static str)],
        docs: &'static str,
    ) -> Self {
        let default = choices.first().map_or("", |c| c.0).to_owned();
        self.param(name, ParamKind::Choice(choices), ParamValue::Text(default), "", docs)
    }

    /// Adds a file to read; not given by default.
    pub fn file(self, name: &'static str, extensions: &'static [&'static str], docs: &'static str) -> Self {
        self.param(name, ParamKind::File { extensions }, ParamValue::Text(String::new()), "", docs)
    }
}
