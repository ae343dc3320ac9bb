//! The node `particles.reconstruct`.

use std::sync::Arc;

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::particle::ParticleSet;
use super::reconstruct::reconstruct;
use super::section::Sections;
use super::triples::{TripleError, TripleSettings};
use crate::data::Report;

/// Makes particles of cross-sections.
pub(super) struct ReconstructNode;

impl Node for ReconstructNode {
    fn spec(&self) -> NodeSpec {
        let defaults = TripleSettings::default();
        NodeSpec::new(
            "particles.reconstruct",
            1,
            "Particles from the cross-sections of three views",
            "Finds triples of cross-sections, one of each view, whose colours and extents agree along the lines where they cross, and \
             sweeps each into a particle with an inside. One picture may serve as all three views. Every aligned pair of \
             cross-sections is compared once; triples are pruned by the best of their pairs; of more cross-sections \
             than `sections` that many are drawn. The triples kept use as many different cross-sections as they can.",
        )
        .paper("Du et al. 2013, section 3.1; Alexa et al. 2000")
        .input("sections", Sections::TYPE, "Cross-sections of the view normal to z (rows y, columns x), or of the only picture.")
        .optional("sections_x", Sections::TYPE, "Cross-sections of the view normal to x: rows z, columns y.")
        .optional("sections_y", Sections::TYPE, "Cross-sections of the view normal to y: rows z, columns x.")
        .output("particles", ParticleSet::TYPE, "The particles.")
        .output("report", Report::TYPE, "How many triples there were, were accepted and discarded, and their errors.")
        .float("threshold", 0.0..=1.0, defaults.threshold, "fraction", "Triples whose error exceeds this fraction of the largest are rejected.")
        .int("most", 1..=65_536, defaults.most as i64, "count", "Particles at most.")
        .int("sections", 1..=1024, defaults.sections as i64, "count", "Cross-sections of a view that are considered at most.")
        .int("alignments", 1..=5, defaults.alignments as i64, "count", "Positions tried for the centre along each axis of a cross-section.")
        .int("seed", 0..=i64::MAX, 1, "count", "Seed of the draws, where there are more than `sections`.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let z = context.input::<Sections>("sections")?;
        let x = context.optional::<Sections>("sections_x")?;
        let y = context.optional::<Sections>("sections_y")?;
        let views: Vec<Arc<Sections>> = if x.is_none() && y.is_none() {
            vec![z]
        } else {
            vec![x.unwrap_or_else(|| Arc::clone(&z)), y.unwrap_or_else(|| Arc::clone(&z)), z]
        };
        let maps = |v: &Arc<Sections>| {
            let infos = v.view.map_infos();
            infos
                .iter()
                .map(|m| format!("{} ({} channels, {:?})", m.name, m.channels, m.ty))
                .collect::<Vec<_>>()
                .join(", ")
        };
        for view in &views[1..] {
            if view.view.map_infos() != views[0].view.map_infos() {
                let (found, expected) = (maps(view), maps(&views[0]));
                return Err(NodeError::Input(format!(
                    "the views carry different maps: {found} against {expected}"
                )));
            }
        }
        let settings = TripleSettings {
            threshold: context.float("threshold")?,
            most: context.int("most")? as usize,
            sections: context.int("sections")? as usize,
            alignments: context.int("alignments")? as usize,
            seed: context.int("seed")? as u64,
        };
        let (set, counts) = reconstruct(views, &settings, &*context).map_err(|error| match error {
            TripleError::Cancelled => NodeError::Cancelled,
            rejected => NodeError::input(rejected),
        })?;
        if set.particles.is_empty() {
            return Err(NodeError::Input(format!(
                "all {} accepted triples are too complicated: none of their sections is star-shaped; a mask without narrow \
                 inlets helps",
                set.discarded
            )));
        }
        let mut report = Report::new("Particles");
        let mean = |f: &dyn Fn(usize) -> f64| {
            (0..set.particles.len()).map(f).sum::<f64>() / set.particles.len() as f64
        };
        report
            .row("triples", counts.possible as f64, "count")
            .row("accepted", counts.accepted as f64, "count")
            .row("particles", set.particles.len() as f64, "count")
            .row("discarded", f64::from(set.discarded), "count")
            .row("largest_error", counts.largest, "1")
            .row("mean_error", mean(&|i| f64::from(set.particles[i].error)), "1")
            .row("mean_volume", mean(&|i| f64::from(set.particles[i].volume)), "voxels");
        for v in 0..set.views.len() {
            let name =
                if set.views.len() == 1 { "used".to_owned() } else { format!("used_{}", ["x", "y", "z"][v]) };
            let used: std::collections::BTreeSet<u32> = (0..3)
                .filter(|&d| set.views.len() == 1 || d == v)
                .flat_map(|d| set.particles.iter().map(move |p| p.sections[d]))
                .collect();
            report.row(
                name,
                used.len() as f64 / set.view(v).sections.len().max(1) as f64,
                "fraction of the cross-sections",
            );
        }
        context.set("report", report);
        context.set("particles", set);
        Ok(())
    }
}
