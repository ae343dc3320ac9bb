//! The node `measure.phases`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::{PhaseSettings, compare_phases};
use crate::data::{Curves, Image, Report, Volume};

const DOCS: &str = "For media of two phases: stone and pore, fibre and matrix, particles and gaps. The phase is the bright one: what is \
     above the exemplar's threshold of luminance by Otsu 1979, which parts volume and truth too; a mask of two values is parted between \
     them. Of labels 0 is the dark phase and all others the bright one; of a map of one channel with two values the smaller is dark. A \
     medium without two phases is parted all the same, and the numbers then mean little.\n\n\
     Rows `slice_` compare slices across the axes with the exemplar, rows `solid_` the volume with `truth` in 3D. A number is good if it \
     is the reference's, four standard errors (of both, from quadrants, octants and slices) and 5 to 10 % aside. Lags reach to a quarter \
     of the shortest edge.\n\n\
     - `fraction`: volume fraction φ of the phase, 0 to 1. Blind to arrangement.\n\
     - `surface`: specific surface, area of the boundary per volume in 1/voxel, `2 P_L` from the crossings P_L per length of lines along \
     the axes; the same from slices and in 3D. From 0. Exact for isotropic media. Blind to shape.\n\
     - `euler_8`, `euler_4` in 2D, `euler_26`, `euler_6` in 3D: Euler number per 1000 pixels or voxels (objects − holes, objects − tunnels + \
     cavities), the phase joined through corners (8, 26) or through faces alone (4, 6), the rest the other way. Of either sign. Blind to \
     size; noise of single voxels dominates it.\n\
     - `connectivity`: share of the phase in its largest component by faces, in windows of one size. 0 to 1. Blind to how thin the bridges \
     are, and in slices to what is connected in 3D.\n\
     - `chord`: mean of the chord length distribution of the phase along the axes in voxels, without chords that the border cuts. From 0. \
     Blind to the spread, which the curve shows.\n\
     - `two_point`: root mean square difference of the two-point correlations S₂(r), the probability that two points at distance r are in \
     the phase (mean over the axes), over that between halves of the reference. From 0; up to 2.5 is good. Blind to connection.\n\
     - `lineal_path`: the same of the lineal path function L(r), the probability that a segment of length r lies in the phase. Blind to \
     directions other than the axes.";

/// Statistics of a medium of two phases.
pub struct MeasurePhases;

impl Node for MeasurePhases {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new("measure.phases", 1, "How the two phases of a volume are arranged, in numbers", DOCS)
            .paper(
                "Torquato 2002 (Random heterogeneous materials) for S₂; Lu & Torquato 1992 for L; Torquato & Lu 1993 for chords; Underwood \
                 1970 for the surface; Ohser & Mücklich 2000 for the Euler number; Otsu 1979 for the threshold",
            )
            .input("volume", Volume::TYPE, "What is measured: a map `label`, `color` or `value`, at least 16 voxels along each axis.")
            .input("exemplar", Image::TYPE, "A picture or mask that slices should resemble, at least 16 × 16 pixels.")
            .optional("truth", Volume::TYPE, "A volume of the same size that the volume should resemble.")
            .output("report", Report::TYPE, "The numbers, a row each, next to those of the exemplar and of the truth.")
            .output("curves", Curves::TYPE, "Two-point correlation, lineal path and chord lengths.")
            .int("slices", 1..=4096, 8, "slices", "Slices across each axis.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let volume = context.input::<Volume>("volume")?;
        let exemplar = context.input::<Image>("exemplar")?;
        let truth = context.optional::<Volume>("truth")?;
        let settings = PhaseSettings { slices: context.int("slices")?.clamp(1, 4096) as usize };
        let (report, curves) = compare_phases(&volume, &exemplar, truth.as_deref(), &settings, context)?;
        context.set("report", report);
        context.set("curves", curves);
        Ok(())
    }
}
