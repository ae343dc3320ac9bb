//! Lists of particles as CSV and JSON.

use std::io::{self, Write};

use breccia_engine::{Data, Exporter, Sink, Value};

use super::export::typed;
use crate::particles::ParticleList;

/// Exporters of lists of particles.
pub(super) const EXPORTERS: &[Exporter] = &[
    Exporter {
        ty: ParticleList::TYPE,
        extensions: &["csv"],
        docs: "table with a header line, one particle a line",
        write: |value, sink| write_file(value, sink, ParticleList::csv),
    },
    Exporter {
        ty: ParticleList::TYPE,
        extensions: &["json"],
        docs: "array of objects, one a particle",
        write: |value, sink| write_file(value, sink, ParticleList::json),
    },
];

fn write_file(value: &Value, sink: &mut Sink, text: fn(&ParticleList) -> String) -> io::Result<()> {
    let list = typed::<ParticleList>(value)?;
    let mut out = sink.main()?;
    out.write_all(text(&list).as_bytes())?;
    out.flush()
}
