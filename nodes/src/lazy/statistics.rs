//! `lazy.statistics`: what the candidate selection left, as a report.

use breccia_engine::{Context, Node, NodeError, NodeSpec};

use super::candidates::Candidates;
use crate::data::Report;

/// For each level and direction: triples a pixel after each coherence iteration, and the crossbar error a
/// sample of the best triple (root of the mean over pixels, in 8-bit colour steps).
pub fn candidate_statistics(candidates: &Candidates) -> Report {
    let mut report = Report::new("candidates");
    for (l, views) in candidates.levels.iter().enumerate() {
        for (v, view) in views.iter().enumerate() {
            let name = |what: &str| format!("level {l}, view {v}: {what}");
            for (i, &mean) in view.survivors.iter().enumerate() {
                report.row(
                    name(&format!("after iteration {i}")),
                    f64::from(mean) / 1000.0,
                    "triples a pixel",
                );
            }
            let pixels = view.triples.len().max(1) as f64;
            let kept: u64 = view.counts.iter().map(|&n| u64::from(n)).sum();
            report.row(name("kept"), kept as f64 / pixels, "triples a pixel");
            let error: u64 = view.triples.iter().map(|set| u64::from(set[0].crossbar)).sum();
            // Three lines of five pixels with four channels.
            let rms = libm::sqrt(error as f64 / pixels / 60.0);
            report.row(name("crossbar error"), rms, "RMS, 8-bit steps");
        }
    }
    report
}

pub(super) struct StatisticsNode;

impl Node for StatisticsNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "lazy.statistics",
            1,
            "How many candidates survive, and how well they fit",
            "For each level and direction: the mean number of triples a pixel before and after each coherence \
             iteration, and the crossbar error of the best triple.",
        )
        .paper("Dong et al. 2008, section 4.2")
        .input("candidates", "candidates", "The candidates.")
        .output("report", "report", "The statistics.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let candidates = context.input::<Candidates>("candidates")?;
        context.set("report", candidate_statistics(&candidates));
        Ok(())
    }
}
