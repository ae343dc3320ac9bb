//! Curves to be plotted, such as histograms and correlation functions.

use breccia_engine::{Data, Digest};

use super::{Reader, Writer};

/// Plots of curves, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curves {
    /// What they are about.
    pub title: String,
    /// The plots.
    pub plots: Vec<Plot>,
}

/// Curves over one axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plot {
    /// What is plotted.
    pub title: String,
    /// What x is, with its unit.
    pub x: String,
    /// What y is, with its unit.
    pub y: String,
    /// The curves.
    pub series: Vec<Series>,
}

/// One curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// What the curve is of.
    pub name: String,
    /// x and y of its points, x ascending.
    pub points: Vec<[f64; 2]>,
}

impl Curves {
    /// No plots yet.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), plots: Vec::new() }
    }
}

impl Plot {
    /// A plot of some curves.
    pub fn new(
        title: impl Into<String>,
        x: impl Into<String>,
        y: impl Into<String>,
        series: Vec<Series>,
    ) -> Self {
        Self { title: title.into(), x: x.into(), y: y.into(), series }
    }
}

impl Data for Curves {
    const TYPE: &'static str = "curves";
    const DOCS: &'static str = "Plots of named curves.";

    fn byte_size(&self) -> u64 {
        let series = self.plots.iter().flat_map(|plot| &plot.series);
        series.map(|series| (series.name.len() + 16 * series.points.len() + 64) as u64).sum()
    }

    fn summary(&self) -> String {
        let titles: Vec<_> = self.plots.iter().map(|plot| plot.title.as_str()).collect();
        format!("{}: {}", self.title, titles.join(", "))
    }

    fn digest(&self) -> Digest {
        Digest::of(&self.encode().unwrap_or_default())
    }

    fn encode(&self) -> Option<Vec<u8>> {
        let mut out = Writer::new();
        out.text(&self.title).u64(self.plots.len() as u64);
        for plot in &self.plots {
            out.text(&plot.title).text(&plot.x).text(&plot.y).u64(plot.series.len() as u64);
            for series in &plot.series {
                out.text(&series.name).array(bytemuck::cast_slice::<_, f64>(&series.points));
            }
        }
        Some(out.finish())
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = Reader::new(bytes);
        let mut curves = Self::new(reader.text()?);
        for _ in 0..reader.u64()? {
            let mut plot = Plot::new(reader.text()?, reader.text()?, reader.text()?, Vec::new());
            for _ in 0..reader.u64()? {
                let (name, numbers) = (reader.text()?, reader.array::<f64>()?);
                let (points, []) = numbers.as_chunks::<2>() else {
                    return Err("a curve has a point without y".to_owned());
                };
                plot.series.push(Series { name, points: points.to_vec() });
            }
            curves.plots.push(plot);
        }
        reader.end()?;
        Ok(curves)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_come_back_from_the_disk_and_damage_is_seen() {
        let series = |name: &str| Series { name: name.into(), points: vec![[0.0, 1.0], [1.0, -0.5]] };
        let mut curves = Curves::new("two");
        curves.plots.push(Plot::new("a", "lag", "value", vec![series("p"), series("q")]));
        curves.plots.push(Plot::new("b", "x", "y", Vec::new()));
        let bytes = curves.encode().unwrap();
        assert_eq!(Curves::decode(&bytes), Ok(curves));
        assert!(Curves::decode(&bytes[..bytes.len() - 1]).is_err());
    }
}
