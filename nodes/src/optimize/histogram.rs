//! `optimize.histogram`: position and index histograms as pictures (Chen & Wang 2010, figures 4 and 5).

use breccia_engine::{Context, Node, NodeError, NodeSpec};

use super::field::Field;
use crate::data::{Image, Report};
use crate::lazy::{LevelView, Pyramid};

/// Which histogram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Histogram {
    /// How often each texel's colour appears.
    Position,
    /// How often each neighbourhood is matched.
    Index,
}

/// Counts of every pixel of a view.
pub(super) fn counts(field: &Field, which: Histogram, view: usize, level: &LevelView) -> Vec<u32> {
    match which {
        Histogram::Index => field.index.get(view).cloned().unwrap_or_else(|| vec![0; level.texels.len()]),
        Histogram::Position => {
            let mut counts = vec![0; level.texels.len()];
            for (i, &source) in field.sources[view].iter().enumerate() {
                if field.view_of(i) == view {
                    counts[level.index(source)] += 1;
                }
            }
            counts
        }
    }
}

/// A picture of a histogram, all views side by side: red where a pixel is never used, else the brighter the more often; an even
/// share is middle grey.
pub fn histogram_image(field: &Field, which: Histogram, views: &[LevelView]) -> Image {
    let counts: Vec<Vec<u32>> =
        views.iter().enumerate().map(|(v, level)| counts(field, which, v, level)).collect();
    let width: i32 = views.iter().map(|view| view.width).sum();
    let height = views.iter().map(|view| view.height).max().unwrap_or(1);
    Image::from_fn(width as u32, height as u32, |x, y| {
        let (mut x, y) = (x as i32, y as i32);
        for (view, counts) in views.iter().zip(&counts) {
            if x < view.width {
                if y >= view.height {
                    return [0; 3];
                }
                let count = counts[(y * view.width + x) as usize];
                let even = counts.iter().map(|&n| u64::from(n)).sum::<u64>() as f64 / counts.len() as f64;
                let grey = (f64::from(count) / even.max(1e-9) * 127.0).min(255.0) as u8;
                return if count == 0 { [220, 30, 30] } else { [grey.max(16); 3] };
            }
            x -= view.width;
        }
        [0; 3]
    })
}

pub(super) struct HistogramNode;

impl Node for HistogramNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "optimize.histogram",
            1,
            "What of the exemplar is used, and how often",
            "A picture of the exemplar's size: red where a pixel is never used, else the brighter the more often; middle \
             grey is an even share.",
        )
        .paper("Chen & Wang 2010, figures 4 and 5")
        .memory_only()
        .input("field", "field", "The voxels.")
        .input("pyramid", "pyramid", "The exemplar's levels.")
        .output("image", "image", "The picture, views side by side.")
        .output("report", "report", "Shares of the exemplar.")
        .choice(
            "histogram",
            &[
                ("position", "How often each texel's colour appears."),
                ("index", "How often each neighbourhood is matched."),
            ],
            "Which histogram.",
        )
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let field = context.input::<Field>("field")?;
        let pyramid = context.input::<Pyramid>("pyramid")?;
        let which =
            if context.text("histogram")? == "index" { Histogram::Index } else { Histogram::Position };
        let views = pyramid.levels.get(field.level).map_or(&[][..], Vec::as_slice);
        let inside =
            field.sources.iter().zip(views).all(|(sources, view)| sources.iter().all(|&s| view.holds(s)));
        let indexed = field.index.is_empty()
            || field.index.iter().zip(views).all(|(index, view)| index.len() == view.texels.len());
        if views.is_empty() || views.len() != field.sources.len() || !inside || !indexed {
            return Err(NodeError::Failed("the voxels are of another exemplar than the pyramid".into()));
        }
        let mut report = Report::new("histogram");
        let all: Vec<u32> =
            views.iter().enumerate().flat_map(|(v, level)| counts(&field, which, v, level)).collect();
        let total = all.iter().map(|&n| f64::from(n)).sum::<f64>().max(1.0);
        let unused = all.iter().filter(|&&n| n == 0).count() as f64 / all.len() as f64;
        let entropy: f64 = all
            .iter()
            .filter(|&&n| n > 0)
            .map(|&n| f64::from(n) / total)
            .map(|share| -share * libm::log(share))
            .sum();
        report.row("unused", unused, "of the exemplar's pixels; small is good");
        let most = libm::log(all.len().max(2) as f64);
        report.row("entropy", entropy / most, "of an even use; 1 is good");
        context.set("image", histogram_image(&field, which, views));
        context.set("report", report);
        Ok(())
    }
}
