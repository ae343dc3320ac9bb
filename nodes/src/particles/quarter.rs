//! The morph between two quarters of cross-sections, from one upright plane to the other (Du et al. 2013, section 3.1).
//!
//! Quarters of convex sections morph by their polar radius. Others, and those that are not star-shaped, by as-rigid-as-possible
//! interpolation ([`super::rigid`]).

use super::profile::Profile;
use super::rigid::RigidMorph;
use super::section::Section;

/// Steps of the tables along the sweep and along the polar angle.
const STEPS: usize = 32;

/// One octant's morph.
pub(super) enum Quarter {
    /// Both quarters by polar radius, after stretching them horizontally to their mean width.
    Polar(Polar),
    /// Meshes of the morphed quarter.
    Rigid(RigidMorph),
}

/// Quarters by polar radius. They are stretched to one width before they are morphed, since their width is to become the base
/// section's anyway: so boxes stay boxes, whose corners a morph of unequal rectangles would cut off.
pub(super) struct Polar {
    /// The radii of both, from the horizontal axis to the sweep axis, in [`STEPS`] steps.
    radii: [Vec<f64>; 2],
    /// The width that both are stretched to.
    width: f64,
    /// By how much each was stretched.
    stretch: [f64; 2],
}

/// A section, its centre, its profile, and the signs of its columns and rows in an octant.
pub(super) type Side<'a> = (&'a Section, [i32; 2], &'a Profile, [i32; 2]);

impl Quarter {
    /// The morph from one side to another; `horizontal` says which of a side's coordinates (0 column, 1 row) lies in the base plane.
    pub fn new(from: Side<'_>, horizontal_from: usize, to: Side<'_>, horizontal_to: usize) -> Self {
        let simple = |profile: &Profile| profile.is_convex() && profile.is_star_shaped();
        if !(simple(from.2) && simple(to.2))
            && let Some(morph) =
                RigidMorph::new(&quarter_mask(from, horizontal_from), &quarter_mask(to, horizontal_to))
        {
            return Self::Rigid(morph);
        }
        let radius = |(_, _, profile, signs): Side<'_>, horizontal: usize, along: f64, up: f64| {
            let mut direction = [0.0; 2];
            direction[horizontal] = along * f64::from(signs[horizontal]);
            direction[1 - horizontal] = up * f64::from(signs[1 - horizontal]);
            profile.radius(libm::atan2(direction[1], direction[0]))
        };
        let sides = [(from, horizontal_from), (to, horizontal_to)];
        let widths = sides.map(|(side, horizontal)| radius(side, horizontal, 1.0, 0.0).max(1e-6));
        let width = (widths[0] + widths[1]) / 2.0;
        let stretch = widths.map(|own| width / own);
        let table = |i: usize| {
            let (side, horizontal) = sides[i];
            let at = |step: usize| {
                let angle = step as f64 * std::f64::consts::FRAC_PI_2 / STEPS as f64;
                let (along, up) = (libm::cos(angle) / stretch[i], libm::sin(angle));
                radius(side, horizontal, along, up) / libm::sqrt(along * along + up * up)
            };
            (0..=STEPS).map(at).collect()
        };
        Self::Polar(Polar { radii: [table(0), table(1)], width, stretch })
    }

    /// How far the morphed quarter reaches along its horizontal axis, `t` from 0 to 1.
    pub fn width(&self, t: f64) -> f64 {
        match self {
            Self::Polar(polar) => polar.width,
            Self::Rigid(morph) => morph.width(t),
        }
    }

    /// Where a place of the morphed quarter (along the horizontal axis, along the sweep axis) lies in both quarters.
    pub fn locate(&self, t: f64, r: f64, h: f64) -> Option<[[f64; 2]; 2]> {
        match self {
            Self::Polar(polar) => {
                let at = libm::atan2(h, r) / std::f64::consts::FRAC_PI_2 * STEPS as f64;
                let i = (at as usize).min(STEPS - 1);
                let f = at - i as f64;
                let radius = |of: &[f64]| of[i] * (1.0 - f) + of[i + 1] * f;
                let own = [radius(&polar.radii[0]), radius(&polar.radii[1])];
                let morphed = own[0] * (1.0 - t) + own[1] * t;
                let q = libm::sqrt(r * r + h * h);
                (q <= morphed)
                    .then(|| [0, 1].map(|i| [r * own[i] / morphed / polar.stretch[i], h * own[i] / morphed]))
            }
            Self::Rigid(morph) => morph.locate(t, [r, h]),
        }
    }
}

/// The pixels of a section in one quadrant around its centre, by distance along the horizontal and along the sweep axis.
fn quarter_mask((section, center, _, signs): Side<'_>, horizontal: usize) -> Vec<Vec<bool>> {
    let reach = section.size[0].max(section.size[1]) as i32 + 1;
    let holds = |r: i32, h: i32| {
        let mut at = center;
        at[horizontal] += signs[horizontal] * r;
        at[1 - horizontal] += signs[1 - horizontal] * h;
        section.holds(at[0], at[1])
    };
    (0..reach).map(|h| (0..reach).map(|r| holds(r, h)).collect()).collect()
}
