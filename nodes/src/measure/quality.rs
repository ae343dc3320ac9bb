//! The nodes `measure.quality` and `measure.volume`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::{Quality, QualitySettings, measure_quality};
use crate::data::{Image, Report, SolidValue, Volume};
use crate::solid::params::{box_of, with_box};
use crate::solid::{available_memory, box_volume};

const DOCS: &str = "Read them together, and look at pictures too: each is blind to something.\n\n\
     - `color_kl`: Kullback-Leibler divergence of the joint colour histograms (8 × 8 × 8 bins, 10⁻⁴ added to \
     each share), exemplar from solid, in nats. From 0; small is good. Blind to arrangement.\n\
     - `coverage`: different places of the exemplar (cells of 2 × 2 pixels) that are the nearest to 5 × 5 patches \
     of the solid, as many hits as there are cells taken, over the number that one half of the exemplar reaches \
     in the other. From 0; 1 is as varied as the exemplar. Blind to arrangement beyond 5 pixels.\n\
     - `contrast` and `fine_contrast`: standard deviation of luminance, and of luminance minus its 3 × 3 mean, \
     over the exemplar's. 1 is good; fine contrast below 1 is blur, above 1 noise. Blind to which colours \
     and where.\n\
     - `axis_distance` (and `distance_x`, `_y`, `_z`) and `oblique_distance`: root mean square distance of 5 × 5 \
     RGB patches of slices to the nearest patch of either half of the exemplar, over that between the halves. \
     1 is as good as the exemplar itself, copies reach about 0.7. Blind to collapse: one smooth region \
     repeated scores low, which coverage shows.\n\
     - `axis_completeness` (and `completeness_x`, `_y`, `_z`): the same the other way round, from patches of the \
     exemplar to those of the solid. Above 1 something is not to be found across that axis: streaks, blur, \
     collapse. Blind to what is there besides.\n\
     - `autocorrelation`: root mean square difference of the autocorrelations of luminance over all lags to a \
     quarter of the size, over that between disjoint halves of the exemplar. From 0; up to about 1 is good. Blind to \
     colour, contrast, and lines that break without moving.\n\
     - `repetition`: the most by which the autocorrelation exceeds the exemplar's at a lag of 4 pixels or more, 0 to \
     1; up to 0.2 is chance in a small exemplar, more is stripes, tiles, or diagonal bands. Blind to longer periods.\n\
     - `orientation_kl`: Kullback-Leibler divergence of the histograms of local orientation by structure tensor (16 \
     bins over half a turn, weighted by the difference of the eigenvalues), in nats. From 0; small is good. Blind \
     to scale.\n\
     - `flat`: the share of a slice that its largest region without edges takes (steps of at most 3 grey levels), \
     over that in the exemplar. Up to about 1 is good, more is collapse. Blind to collapse to a region with \
     texture of its own.";

const PAPER: &str = "Kullback & Leibler 1951 for the divergence; nearest-neighbourhood distance as the energy of Kwatra et \
     al. 2005 (Texture optimization for example-based synthesis), Eq. 1; coverage after the index histogram \
     of Chen & Wang 2010; autocorrelation and orientation after Urs et al. 2014, section VI";

/// A solid against its exemplar.
pub struct MeasureQuality;

impl Node for MeasureQuality {
    fn spec(&self) -> NodeSpec {
        let spec =
            NodeSpec::new("measure.quality", 2, "How well a solid resembles its exemplar, in numbers", DOCS)
                .paper(PAPER)
                .input("solid", SolidValue::TYPE, "What is measured.")
                .input("exemplar", Image::TYPE, "The picture it should resemble, at least 16 × 16 pixels.")
                .output("report", Report::TYPE, "The measures, a row each.");
        with_sampling(with_box(spec, 64))
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let solid = context.input::<SolidValue>("solid")?;
        let exemplar = context.input::<Image>("exemplar")?;
        let (origin, size) = box_of(context)?;
        let settings = sampling(context)?;
        let volume = box_volume(&*solid.0, origin, size, available_memory(), context)?;
        let quality = measure_quality(&volume, &exemplar, &settings, context)?;
        context.set("report", report(&quality));
        Ok(())
    }
}

/// A volume against its exemplar.
pub struct MeasureVolume;

impl Node for MeasureVolume {
    fn spec(&self) -> NodeSpec {
        let spec =
            NodeSpec::new("measure.volume", 1, "How well a volume resembles its exemplar, in numbers", DOCS)
                .paper(PAPER)
                .input(
                    "volume",
                    Volume::TYPE,
                    "What is measured, with a map `color`, at least 8 voxels along each axis.",
                )
                .input("exemplar", Image::TYPE, "The picture it should resemble, at least 16 × 16 pixels.")
                .output("report", Report::TYPE, "The measures, a row each.");
        with_sampling(spec)
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let volume = context.input::<Volume>("volume")?;
        let exemplar = context.input::<Image>("exemplar")?;
        let quality = measure_quality(&volume, &exemplar, &sampling(context)?, context)?;
        context.set("report", report(&quality));
        Ok(())
    }
}

/// Declares how much is sampled.
fn with_sampling(spec: NodeSpec) -> NodeSpec {
    spec.int("samples", 64..=1_048_576, 2048, "patches", "Patches across the axes, and as many oblique ones.")
        .int("slices", 1..=4096, 8, "slices", "Slices across each axis for contrast and structure.")
        .int("seed", 0..=i64::from(u32::MAX), 1, "count", "Selects patches and slices.")
}

fn sampling(context: &Context<'_>) -> Result<QualitySettings, NodeError> {
    Ok(QualitySettings {
        samples: context.int("samples")?.clamp(64, 1 << 20) as usize,
        slices: context.int("slices")?.clamp(1, 4096) as usize,
        seed: context.int("seed")? as u64,
    })
}

fn report(quality: &Quality) -> Report {
    let mut report = Report::new("quality");
    report.row("color_kl", quality.color_kl, "nats; small is good");
    report.row("coverage", quality.coverage, "of the exemplar's own; 1 is good");
    report.row("contrast", quality.contrast, "of the exemplar's; 1 is good");
    report.row("fine_contrast", quality.fine_contrast, "of the exemplar's; 1 is good");
    report.row("axis_distance", quality.axis_distance, "of the exemplar's own; up to 1 is good");
    report.row("oblique_distance", quality.oblique_distance, "of the exemplar's own; up to 1 is good");
    for (name, distance) in ["distance_x", "distance_y", "distance_z"].into_iter().zip(quality.distances) {
        report.row(name, distance, "of the exemplar's own; up to 1 is good");
    }
    report.row("axis_completeness", quality.axis_completeness, "of the exemplar's own; up to 1 is good");
    for (name, distance) in
        ["completeness_x", "completeness_y", "completeness_z"].into_iter().zip(quality.completeness)
    {
        report.row(name, distance, "of the exemplar's own; up to 1 is good");
    }
    let structure = quality.structure;
    report.row("autocorrelation", structure.autocorrelation, "of the exemplar's own; up to 1 is good");
    report.row("repetition", structure.repetition, "excess correlation; small is good");
    report.row("orientation_kl", structure.orientation_kl, "nats; small is good");
    report.row("flat", structure.flat, "of the exemplar's; up to 1 is good");
    report
}
