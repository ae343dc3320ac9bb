//! A small table of named numbers, such as measurements or candidate statistics.

use breccia_engine::{Data, Digest};

use super::{Reader, Writer};

/// Named numbers with units, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// What the numbers are about.
    pub title: String,
    /// Name, value, and unit or remark of each row.
    pub rows: Vec<(String, f64, String)>,
}

impl Report {
    /// An empty report.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), rows: Vec::new() }
    }

    /// Adds a row.
    pub fn row(&mut self, name: impl Into<String>, value: f64, unit: impl Into<String>) -> &mut Self {
        self.rows.push((name.into(), value, unit.into()));
        self
    }

    /// The value of a row.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.rows.iter().find(|(n, ..)| n == name).map(|&(_, value, _)| value)
    }
}

impl Data for Report {
    const TYPE: &'static str = "report";
    const DOCS: &'static str = "Named numbers with units.";

    fn byte_size(&self) -> u64 {
        self.rows.iter().map(|(n, _, u)| (n.len() + u.len() + 64) as u64).sum()
    }

    fn summary(&self) -> String {
        let shown = self.rows.iter().take(4).map(|(n, v, _)| format!("{n} {v:.4}"));
        format!("{}: {}", self.title, shown.collect::<Vec<_>>().join(", "))
    }

    fn digest(&self) -> Digest {
        Digest::of(&self.encode().unwrap_or_default())
    }

    fn encode(&self) -> Option<Vec<u8>> {
        let mut out = Writer::new();
        out.text(&self.title).u64(self.rows.len() as u64);
        for (name, value, unit) in &self.rows {
            out.text(name).u64(value.to_bits()).text(unit);
        }
        Some(out.finish())
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = Reader::new(bytes);
        let mut report = Self::new(reader.text()?);
        for _ in 0..reader.u64()? {
            report.rows.push((reader.text()?, f64::from_bits(reader.u64()?), reader.text()?));
        }
        reader.end()?;
        Ok(report)
    }
}
