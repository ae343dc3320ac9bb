//! Tests of reading and writing.

mod damage;
mod pictures;
mod volumes;

use std::path::Path;

use breccia_engine::{Data, Sink, Value};

use crate::data::{Map, Samples, Volume};

/// Writes a value by the exporter of its type for the target's extension, as the command line does.
fn export<T: Data>(data: T, target: &Path, extension: &str) -> std::io::Result<Vec<std::path::PathBuf>> {
    let exporter = super::exporters()
        .into_iter()
        .find(|exporter| exporter.ty == T::TYPE && exporter.extensions.contains(&extension))
        .expect("an exporter of that extension");
    let mut sink = Sink::new(target)?;
    (exporter.write)(&Value::new(data), &mut sink)?;
    sink.commit()
}

/// A volume with samples that all differ from their neighbours.
fn volume(size: [usize; 3], name: &str, channels: usize, samples: fn(usize) -> Samples) -> Volume {
    let samples = samples(size.iter().product::<usize>() * channels);
    let maps = vec![Map { name: name.to_owned(), channels, samples }];
    Volume { size, origin: [-3, 0, 7], spacing: [0.5, 0.25, 2.0], maps }
}

fn bytes(n: usize) -> Samples {
    Samples::U8((0..n).map(|i| (i * 37 % 251) as u8).collect())
}

fn labels(n: usize) -> Samples {
    Samples::U32((0..n).map(|i| (i * 641 % 65_521) as u32).collect())
}

fn floats(n: usize) -> Samples {
    Samples::F32((0..n).map(|i| i as f32 * 0.37 - 2.0).collect())
}
