//! A small table of named numbers, such as measurements or candidate statistics.

use breccia_engine::{Data, Digest};

use super::{Reader, Writer};

/// Named numbers with units, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// What the numbers are about.
    pub title: String,
    /// The numbers.
    pub rows: Vec<Row>,
}

/// A named number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// What it is.
    pub name: String,
    /// The number.
    pub value: f64,
    /// Unit or remark.
    pub unit: String,
    /// The same of what it is compared with, if it is.
    pub reference: Option<f64>,
    /// The range that is good, bounds included, if there is one.
    pub good: Option<[f64; 2]>,
}

impl Row {
    /// Whether the value lies outside of what is good. A value that is no number does.
    pub fn flagged(&self) -> bool {
        self.good.is_some_and(|[low, high]| !(low..=high).contains(&self.value))
    }
}

impl Report {
    /// An empty report.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), rows: Vec::new() }
    }

    /// Adds a row.
    pub fn row(&mut self, name: impl Into<String>, value: f64, unit: impl Into<String>) -> &mut Self {
        self.rows.push(Row { name: name.into(), value, unit: unit.into(), ..Row::default() });
        self
    }

    /// The value of a row.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.rows.iter().find(|row| row.name == name).map(|row| row.value)
    }
}

impl Data for Report {
    const TYPE: &'static str = "report";
    const DOCS: &'static str = "Named numbers with units.";

    fn byte_size(&self) -> u64 {
        self.rows.iter().map(|row| (row.name.len() + row.unit.len() + 96) as u64).sum()
    }

    fn summary(&self) -> String {
        let shown = self.rows.iter().take(4).map(|row| format!("{} {:.4}", row.name, row.value));
        format!("{}: {}", self.title, shown.collect::<Vec<_>>().join(", "))
    }

    fn digest(&self) -> Digest {
        Digest::of(&self.encode().unwrap_or_default())
    }

    fn encode(&self) -> Option<Vec<u8>> {
        let mut out = Writer::new();
        out.text(&self.title).u64(self.rows.len() as u64);
        for row in &self.rows {
            out.text(&row.name).u64(row.value.to_bits()).text(&row.unit);
            out.array(row.reference.as_slice()).array(row.good.as_ref().map_or(&[], |good| &good[..]));
        }
        Some(out.finish())
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = Reader::new(bytes);
        let mut report = Self::new(reader.text()?);
        for _ in 0..reader.u64()? {
            let (name, value, unit) = (reader.text()?, f64::from_bits(reader.u64()?), reader.text()?);
            let (reference, good) = (reader.array::<f64>()?, reader.array::<f64>()?);
            let good = match good.as_slice() {
                [] => None,
                &[low, high] => Some([low, high]),
                _ => return Err("a range needs two bounds".to_owned()),
            };
            report.rows.push(Row { name, value, unit, reference: reference.first().copied(), good });
        }
        reader.end()?;
        Ok(report)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back_and_values_outside_are_flagged() {
        let mut report = Report::new("quality");
        report.row("plain", 3.0, "voxels");
        let row = Row { name: "r".into(), value: 2.0, unit: "nats".into(), ..Row::default() };
        report.rows.push(Row { reference: Some(0.5), good: Some([1.0, f64::INFINITY]), ..row.clone() });
        assert_eq!(Report::decode(&report.encode().unwrap()), Ok(report));
        let flagged = |value, good| Row { value, good, ..row.clone() }.flagged();
        assert!(!flagged(2.0, None) && !flagged(2.0, Some([2.0, 2.0])));
        assert!(flagged(2.1, Some([0.0, 2.0])) && flagged(f64::NAN, Some([0.0, 2.0])));
    }
}
