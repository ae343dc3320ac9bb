//! The measures as rows, each with the range that is good.

use super::{Likeness, Quality};
use crate::data::{Report, Row};

/// One measure of a [`Likeness`].
struct Measure {
    name: &'static str,
    value: fn(&Likeness) -> f64,
    unit: &'static str,
    /// The good range on slices and on oblique cuts, from what the halves of the exemplar score against each other.
    good: fn(own: f64, oblique: bool) -> [f64; 2],
}

const OWN: &str = "of the exemplar's own";

/// Around 1, as wide as the halves of the exemplar differ and `slack` more.
fn around_one(own: f64, slack: f64) -> [f64; 2] {
    let most = own.max(1.0) * (1.0 + slack);
    [1.0 / most, most]
}

/// The measures in the order in which they are told. Ranges let pass what synthesis of homogeneous media by a true sample
/// scores over many seeds, and the best syntheses.
const MEASURES: &[Measure] = &[
    Measure { name: "color_kl", value: |l| l.color_kl, unit: "nats", good: |own, _| [0.0, 0.15 + own] },
    Measure {
        name: "contrast",
        value: |l| l.contrast,
        unit: "of the exemplar's",
        good: |own, _| around_one(own, 0.12),
    },
    Measure {
        name: "fine_contrast",
        value: |l| l.fine_contrast,
        unit: "of the exemplar's",
        good: |own, oblique| around_one(own, if oblique { 0.2 } else { 0.15 }),
    },
    Measure {
        name: "sharpness",
        value: |l| l.sharpness,
        unit: "of the exemplar's",
        good: |own, oblique| around_one(own, if oblique { 0.2 } else { 0.15 }),
    },
    Measure { name: "distance", value: |l| l.distance, unit: OWN, good: |own, _| [0.0, 1.2 * own.max(1.0)] },
    Measure {
        name: "completeness",
        value: |l| l.completeness,
        unit: OWN,
        good: |own, o| [0.0, if o { 1.2 } else { 1.1 } * own.max(1.0)],
    },
    Measure { name: "coverage", value: |l| l.coverage, unit: OWN, good: |_, _| [0.8, f64::INFINITY] },
    Measure {
        name: "source_entropy",
        value: |l| l.source_entropy,
        unit: OWN,
        good: |_, _| [0.7, f64::INFINITY],
    },
    Measure {
        name: "autocorrelation",
        value: |l| l.autocorrelation,
        unit: OWN,
        good: |_, o| [0.0, if o { 3.0 } else { 2.0 }],
    },
    Measure {
        name: "repetition",
        value: |l| l.repetition,
        unit: "excess correlation",
        good: |own, oblique| [0.0, own + if oblique { 0.2 } else { 0.15 }],
    },
    Measure {
        name: "orientation_kl",
        value: |l| l.orientation_kl,
        unit: "nats",
        good: |own, _| [0.0, 0.1 + 2.0 * own],
    },
    Measure { name: "flat", value: |l| l.flat, unit: OWN, good: |_, _| [0.0, 2.0] },
    Measure {
        name: "wasserstein",
        value: |l| l.wasserstein,
        unit: OWN,
        good: |_, o| [0.0, if o { 2.5 } else { 2.0 }],
    },
];

/// The rows of a report: slices, then oblique cuts, then each axis where it is told.
pub fn quality_report(quality: &Quality) -> Report {
    let mut report = Report::new("quality");
    let families =
        [("axis", &quality.axis, &quality.axis_own), ("oblique", &quality.oblique, &quality.oblique_own)];
    for (i, (family, found, own)) in families.into_iter().enumerate() {
        for measure in MEASURES {
            let reference = (measure.value)(own);
            report.rows.push(Row {
                name: format!("{family}_{}", measure.name),
                value: (measure.value)(found),
                unit: measure.unit.to_owned(),
                reference: Some(reference),
                good: Some((measure.good)(reference, i == 1)),
            });
        }
        // Half of what can be found at all, above chance, is a copy.
        let limit = quality.copy_limits[i] as f64;
        report.rows.push(Row {
            name: format!("{family}_copy"),
            value: found.copy,
            unit: format!("pixels, at most {limit}"),
            reference: Some(own.copy),
            good: Some([0.0, (own.copy + limit) / 2.0]),
        });
    }
    for (name, values) in [("distance", quality.distances), ("completeness", quality.completeness)] {
        for (axis, value) in ["x", "y", "z"].into_iter().zip(values) {
            report.row(format!("{name}_{axis}"), value, OWN);
        }
    }
    report
}
