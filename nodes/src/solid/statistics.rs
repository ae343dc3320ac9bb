//! The node `solid.statistics`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::params::{box_of, with_box};
use super::{available_memory, box_statistics, box_volume};
use crate::data::{Report, SolidValue};

/// Mean, spread, range and entropy of a box.
pub struct Statistics;

impl Node for Statistics {
    fn spec(&self) -> NodeSpec {
        let spec = NodeSpec::new(
            "solid.statistics",
            1,
            "Mean, spread, range and entropy of a box",
            "For each channel of each map: mean, standard deviation, smallest and largest value (bytes count as 0 \
             to 255) and the entropy of the 256-bin histogram in bits.",
        )
        .on_device()
        .input("solid", SolidValue::TYPE, "What is described.")
        .output("report", Report::TYPE, "Five rows a channel, such as `color.r mean`.");
        with_box(spec, 64)
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let solid = context.input::<SolidValue>("solid")?;
        let (origin, size) = box_of(context)?;
        let volume = box_volume(&*solid.0, origin, size, available_memory(), context)?;
        let mut report = Report::new("statistics");
        for s in box_statistics(&volume, context)? {
            report.row(format!("{} mean", s.name), s.mean, "");
            report.row(format!("{} std", s.name), s.std, "");
            report.row(format!("{} min", s.name), s.min, "");
            report.row(format!("{} max", s.name), s.max, "");
            report.row(format!("{} entropy", s.name), s.entropy, "bits");
        }
        context.set("report", report);
        Ok(())
    }
}
