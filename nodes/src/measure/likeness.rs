//! What is measured of a volume against its exemplar.

/// How well slices resemble the exemplar. None of these numbers means much alone: a flat volume may have a small
/// distance, and pixel noise with the right colours a small divergence. Look at pictures too.
///
/// Halves of the exemplar are two of its quadrants each, which share no pixel: the opposite ones for patches and copies, all
/// three ways of pairing on average for the rest. "Of the exemplar's own" means
/// over what one half scores against the other, so that 1 is as good as the exemplar itself. Small numbers added to both sides
/// let the ratio be taken where the halves are equal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Likeness {
    /// Kullback-Leibler divergence of colour histograms in nats, 0 and up; small is good. See
    /// [`color_divergence`](super::color_divergence). Misses all arrangement: shuffled pixels score 0.
    pub color_kl: f64,
    /// Standard deviation of luminance over that of the exemplar; 1 is good. Misses scale and arrangement.
    pub contrast: f64,
    /// The same of the fine detail, luminance minus its 3 × 3 mean: below 1 is faint or blurred, above 1 noisy.
    pub fine_contrast: f64,
    /// Root mean square gradient of luminance over its standard deviation (Krotkov 1988, the gradient energy), over that of the
    /// exemplar: below 1 is blurred or coarser, above 1 noisy or finer. Misses contrast, on purpose, and colour. Nearest
    /// voxels make oblique cuts a little sharper or less sharp.
    pub sharpness: f64,
    /// Neighbourhood distance: the root mean square distance of 5 × 5 RGB patches to the nearest patch in either half of the
    /// exemplar, of the exemplar's own (Kwatra et al. 2005, Eq. 1).
    ///
    /// 1 is as good as the exemplar itself, verbatim copies reach about 0.7, foreign patches go above 1.
    /// Each axis is compared unturned and transposed, and the better counts. Misses collapse: a volume
    /// that repeats one smooth region scores low.
    pub distance: f64,
    /// The same the other way round: from patches of the exemplar to the nearest of as many patches of the slices as half the
    /// exemplar has. 1 or a little below is good; above 1 something of the exemplar is not to be found, as in
    /// streaks, blur and collapse. Misses what is there besides.
    pub completeness: f64,
    /// Variety of the patches in terms of the exemplar's, 0 and up; 1 is as varied as the exemplar.
    ///
    /// Patches each look for the nearest patch in either half, and so does each
    /// half in the other. From how often each cell of 2 × 2 pixels was hit follows how many different cells
    /// as many hits as there are cells reach on average, `Σ 1 − (1 − pᵢ)^m`; coverage is this number for the
    /// slices over that for the exemplar. Misses whether what is covered is arranged well.
    pub coverage: f64,
    /// Effective number of source positions, `exp(−Σ pᵢ ln pᵢ)` of the same hits, over that of the exemplar; 1 is as evenly used, 0
    /// is collapse. Sources are estimated by the nearest patch. Misses positions that are rare or never used, which coverage
    /// shows.
    pub source_entropy: f64,
    /// Root mean square difference of the autocorrelations of luminance over all lags to a quarter of the size (Urs et
    /// al. 2014, section VI), of the exemplar's own. From 0; up to about 2 is chance. On oblique cuts it is the mean over
    /// all directions. Misses colour and contrast, and lines that break without moving.
    pub autocorrelation: f64,
    /// The most by which the autocorrelation exceeds the exemplar's at a lag of 4 pixels or more, 0 to 1; small is good. More is
    /// stripes, tiles or diagonal bands. Across axes it is the worst axis, on oblique cuts the mean of single cuts. Misses what
    /// repeats after more than a quarter of the size.
    pub repetition: f64,
    /// Kullback-Leibler divergence of local orientations by structure tensor (Urs et al. 2014, section VI) in nats, from
    /// 0; small is good. Each oblique cut is turned to where it is smallest, which leaves how directed it is. Misses scale.
    pub orientation_kl: f64,
    /// The share of a slice that its largest flat region takes (steps of at most 3 grey levels), over that in the exemplar; up
    /// to about 1 is good, more is collapse. Misses collapse to a region with texture of its own.
    pub flat: f64,
    /// Sliced Wasserstein distance of 5 × 5 RGB patches, averaged over the levels of a Laplacian pyramid (Karras et al. 2018,
    /// section 5), of the exemplar's own. From 0; up to about 2 is chance. Misses what is larger than 5 pixels of the coarsest
    /// level, which has at least 8 a side.
    pub wasserstein: f64,
    /// Mean edge of the largest square, from a random pixel on, that stands in the exemplar pixel for pixel (unturned or
    /// transposed), in pixels up to a quarter of the size and 32; of the three axes the worst. What chance gives is told by
    /// the halves. Long is a copy, not a synthesis. Misses copies with changed colours.
    pub copy: f64,
}

/// How well a volume resembles its exemplar.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Quality {
    /// On slices across the axes.
    pub axis: Likeness,
    /// What the halves of the exemplar score against each other on the same measures; 1 for those of the exemplar's own, but for
    /// distance and completeness the worse of the halves over both.
    pub axis_own: Likeness,
    /// On oblique cuts of random directions, nearest voxels. Cuts of a solid through grains differ from its faces a little even
    /// where it is perfect, and those of a directed material much.
    pub oblique: Likeness,
    /// As [`Quality::axis_own`], for squares as large as the oblique cuts.
    pub oblique_own: Likeness,
    /// [`Likeness::distance`] across x, y and z.
    pub distances: [f64; 3],
    /// [`Likeness::completeness`] across x, y and z.
    pub completeness: [f64; 3],
    /// The largest value that [`Likeness::copy`] can have, across axes and oblique.
    pub copy_limits: [usize; 2],
    /// What the numbers are made from, to be looked at.
    pub curves: super::curves::LikenessCurves,
}
