//! The nodes `measure.quality` and `measure.volume`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::{QualitySettings, measure_views, quality_report};
use crate::data::{Curves, Image, Report, SolidValue, Volume};
use crate::solid::params::{box_of, with_box};
use crate::solid::{available_memory, box_volume};

const DOCS: &str = "Read them together, and look at pictures too: each is blind to something.\n\n\
     All is measured twice: `axis_` on slices across x, y and z, `oblique_` on cuts of random directions (nearest \
     voxels). Halves of the exemplar are two of its quadrants each (the opposite ones for patches and copies, all three ways of pairing \
     on average else); *own* is what one half scores against the \
     other, given beside each value, and what is a fraction *of the exemplar's own* is 1 when it is as good as that. With \
     exemplars for y and z, slices are held to the exemplar of their axis, oblique cuts to all. What nearest voxels do \
     to contrast, sharpness and patches of oblique cuts, nearest pixels of the turned exemplar do too, so they are held to that. A value is flagged outside \
     of its good range; ranges widen with what the halves differ by.\n\n\
     - `color_kl`: Kullback-Leibler divergence of the joint colour histograms (8 × 8 × 8 bins, 10⁻⁴ added to \
     each share), exemplar from solid, in nats. From 0; small is good, up to 0.15 + own. Blind to arrangement.\n\
     - `contrast` and `fine_contrast`: standard deviation of luminance, and of luminance minus its 3 × 3 mean, \
     over the exemplar's. 1 is good, 12 % (15 % for fine, 20 % for oblique fine) more than the halves differ is allowed. Blind to \
     which colours and where.\n\
     - `sharpness`: root mean square gradient over standard deviation of luminance, over the exemplar's; 1 is good, allowed as for \
     fine contrast. Below 1 is blurred or coarser, above 1 noisy or finer. Blind to contrast and colour.\n\
     - `distance` (and `distance_x`, `_y`, `_z`): root mean square distance of 5 × 5 \
     RGB patches to the nearest patch of either half of the exemplar, of the exemplar's own. \
     1 is as good as the exemplar itself, copies reach about 0.7; up to 1.2 times own is good, which is here what the worse \
     of the halves finds in the other. Blind to collapse: one smooth \
     region repeated scores low, which coverage shows.\n\
     - `completeness` (and `completeness_x`, `_y`, `_z`): the same the other way round, from patches of the \
     exemplar to those of the solid. Up to 1.1 (oblique 1.2) times own is good; above, something is not to be found: streaks, blur, \
     collapse. Blind to what is there besides.\n\
     - `coverage`: different places of the exemplar (cells of 2 × 2 pixels) that are the nearest to 5 × 5 patches \
     of the solid, as many hits as there are cells taken, of the exemplar's own. From 0; 1 is as varied as the exemplar, \
     0.8 and more is good. Blind to arrangement beyond 5 pixels.\n\
     - `source_entropy`: effective number of source cells, the exponential of the entropy of the same hits, of the exemplar's \
     own. From 0; 1 is as evenly used as the exemplar, 0.7 and more is good. Sources are estimated by the nearest patch, so \
     that it is blind to which of two equal places was used.\n\
     - `autocorrelation`: root mean square difference of the autocorrelations of luminance over all lags to a \
     quarter of the size, of the exemplar's own; on oblique cuts of the means over all directions. From 0; up to 2 (oblique 3) is \
     good. Blind to colour, contrast, and lines that break without moving.\n\
     - `repetition`: the most by which the autocorrelation exceeds the exemplar's at a lag of 4 pixels or more, 0 to \
     1, of the worst axis, and the mean of single oblique cuts. Up to 0.15 (oblique 0.2) + own is chance, more is stripes, tiles, or diagonal \
     bands. Blind to periods longer than a quarter of the size.\n\
     - `orientation_kl`: Kullback-Leibler divergence of the histograms of local orientation by structure tensor (16 \
     bins over half a turn, weighted by the difference of the eigenvalues), in nats; each oblique cut after its best turn. \
     From 0; up to 0.1 + twice own is good. Blind to scale.\n\
     - `flat`: the share of a slice that its largest region without edges takes (steps of at most 3 grey levels), \
     over that in the exemplar. Up to 2 is good, more is collapse. Blind to collapse to a region with \
     texture of its own.\n\
     - `wasserstein`: sliced Wasserstein distance of 5 × 5 RGB patches (64 directions, numbers over the exemplar's deviation), \
     averaged over the levels of a Laplacian pyramid, of the exemplar's own. From 0; up to 2 (oblique 2.5) is good. Blind to \
     structures larger than 5 pixels of the coarsest level, and to which patch lies beside which.\n\
     - `copy`: mean edge in pixels of the largest square, from random pixels on, that stands in the exemplar pixel for pixel, \
     unturned or transposed; of the worst axis; at most a quarter of the size and 32. Half of that, and half of what \
     chance gives, is allowed. Blind to copies whose colours changed.";

const PAPER: &str = "Kullback & Leibler 1951 for the divergence; nearest-neighbourhood distance as the energy of Kwatra et \
     al. 2005 (Texture optimization for example-based synthesis), Eq. 1; coverage after the index histogram \
     of Chen & Wang 2010; autocorrelation and orientation after Urs et al. 2014, section VI; sharpness as the gradient energy of \
     Krotkov 1988 (Focusing); sliced Wasserstein distance after Karras et al. 2018 (Progressive growing of GANs), section 5";

/// A solid against its exemplar.
pub struct MeasureQuality;

impl Node for MeasureQuality {
    fn spec(&self) -> NodeSpec {
        let spec =
            NodeSpec::new("measure.quality", 3, "How well a solid resembles its exemplar, in numbers", DOCS)
                .paper(PAPER)
                .on_device()
                .input("solid", SolidValue::TYPE, "What is measured.")
                .input("exemplar", Image::TYPE, "The picture it should resemble, at least 16 × 16 pixels.");
        with_sampling(with_box(with_sockets(spec), 64))
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let solid = context.input::<SolidValue>("solid")?;
        let (origin, size) = box_of(context)?;
        let volume = box_volume(&*solid.0, origin, size, available_memory(), context)?;
        measure(&volume, context)
    }
}

/// A volume against its exemplar.
pub struct MeasureVolume;

impl Node for MeasureVolume {
    fn spec(&self) -> NodeSpec {
        let spec =
            NodeSpec::new("measure.volume", 2, "How well a volume resembles its exemplar, in numbers", DOCS)
                .paper(PAPER)
                .input(
                    "volume",
                    Volume::TYPE,
                    "What is measured, with a map `color`, at least 16 voxels along each axis.",
                )
                .input("exemplar", Image::TYPE, "The picture it should resemble, at least 16 × 16 pixels.");
        with_sampling(with_sockets(spec))
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let volume = context.input::<Volume>("volume")?;
        measure(&volume, context)
    }
}

/// Declares the other exemplars and what comes out.
fn with_sockets(spec: NodeSpec) -> NodeSpec {
    spec.optional("exemplar_y", Image::TYPE, "What slices across y should resemble; not given: the same.")
        .optional("exemplar_z", Image::TYPE, "What slices across z should resemble; not given: the same.")
        .output("report", Report::TYPE, "The measures, a row each.")
        .output("curves", Curves::TYPE, "Histograms and autocorrelations, to be plotted.")
}

fn measure(volume: &Volume, context: &mut Context<'_>) -> Result<(), NodeError> {
    let exemplar = context.input::<Image>("exemplar")?;
    let others = [context.optional::<Image>("exemplar_y")?, context.optional::<Image>("exemplar_z")?];
    let settings = sampling(context)?;
    let mut views = vec![&*exemplar];
    if others.iter().flatten().any(|other| **other != *exemplar) {
        views.extend(others.iter().map(|other| other.as_deref().unwrap_or(&exemplar)));
    }
    let quality = measure_views(volume, &views, &settings, context)?;
    context.set("report", quality_report(&quality));
    context.set("curves", quality.curves.plots());
    Ok(())
}

/// Declares how much is sampled.
fn with_sampling(spec: NodeSpec) -> NodeSpec {
    spec.int("samples", 64..=1_048_576, 2048, "patches", "Patches across the axes, and as many oblique ones.")
        .int(
            "slices",
            1..=4096,
            8,
            "slices",
            "Slices across each axis, and three times as many oblique cuts.",
        )
        .int("seed", 0..=i64::from(u32::MAX), 1, "count", "Selects patches and slices.")
}

fn sampling(context: &Context<'_>) -> Result<QualitySettings, NodeError> {
    Ok(QualitySettings {
        samples: context.int("samples")?.clamp(64, 1 << 20) as usize,
        slices: context.int("slices")?.clamp(1, 4096) as usize,
        seed: context.int("seed")? as u64,
    })
}
