//! A volume that a graph makes, to be compared.

use std::path::Path;
use std::sync::Arc;

use breccia_engine::{Engine, Registry, RunError};
use breccia_graphs::Sources;
use breccia_nodes::data::Volume;
use breccia_nodes::io::write_npy;

use super::super::run::failures;
use super::{Compare, output};
use crate::exit::{Code, Failure};
use crate::graphs;
use crate::inputs::{self, Assignment};
use crate::interrupt::Interrupt;

/// The name under which the volume is handed on.
pub(super) const HELD: &str = "the volume that the graph made";

/// The output that is measured.
const OUTPUT: &str = "volume";

/// What a graph made.
pub(super) struct Made {
    /// The colours of the volume, as a file in memory.
    pub npy: Vec<u8>,
    /// The graph's document, before the command line changed it.
    pub document: String,
}

impl Compare {
    /// The volume that is to be compared if a graph makes it; `None` if it is a file.
    pub(super) fn made(
        &self,
        registry: &Arc<Registry>,
        interrupt: &Interrupt,
    ) -> Result<Option<Made>, Failure> {
        let is_document = Path::new(&self.volume).extension().is_some_and(|extension| extension == "ron");
        if !is_document && breccia_graphs::preset(&self.volume).is_none() {
            return match self.inputs.iter().chain(&self.values).next() {
                Some(other) => Err(Failure::usage(format!(
                    "`{}=…` is for a graph or a preset; `{}` is a file",
                    other.name, self.volume
                ))),
                None => Ok(None),
            };
        }
        let mut graph = graphs::load(&self.volume, registry)?;
        let mut files = self.inputs.clone();
        let takes = graph.inputs().any(|input| input.name == "exemplar");
        if takes && !files.iter().any(|file| file.name == "exemplar") {
            files.push(Assignment { name: "exemplar".to_owned(), value: self.exemplar.clone() });
        }
        inputs::give(&mut graph, &files)?;
        inputs::set(&mut graph, &self.values, None)?;
        if !graph.outputs().any(|output| output.name == OUTPUT) {
            return Err(Failure::usage(format!("`{}` has no output `{OUTPUT}` to compare", self.volume)));
        }
        let engine = Engine::builder()
            .files(Arc::new(Sources::default()))
            .cache_dir(breccia_graphs::default_cache())
            .build(Arc::clone(registry))
            .map_err(|error| Failure::new(Code::Node, error.to_string()))?;
        let result = engine.run(&Arc::new(graph), &[OUTPUT], &interrupt.cancel, &|_| {}).map_err(
            |error| match error {
                RunError::Cancelled => interrupt.failure(),
                RunError::Graph(problems) => Failure::usage(problems),
            },
        )?;
        failures(&result, &[])?;
        let volume = output::<Volume>(&result, OUTPUT)?;
        let color =
            volume.map("color").ok_or_else(|| Failure::new(Code::Node, "the volume has no map `color`"))?;
        let mut npy = Vec::new();
        write_npy(volume.size, color, &mut npy)
            .map_err(|error| Failure::new(Code::Output, error.to_string()))?;
        Ok(Some(Made { npy, document: self.document_text()? }))
    }

    /// The document of the graph as it stands in its file or preset.
    fn document_text(&self) -> Result<String, Failure> {
        match breccia_graphs::preset(&self.volume) {
            Some(preset) => Ok(preset.ron.to_owned()),
            None => std::fs::read_to_string(&self.volume).map_err(|error| {
                Failure::new(Code::Input, format!("cannot read `{}`: {error}", self.volume))
            }),
        }
    }
}
