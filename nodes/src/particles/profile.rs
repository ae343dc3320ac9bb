//! A cross-section seen from a centre: its boundary in polar coordinates, and whether it is star-shaped and convex.

use super::section::Section;

/// Angles of a profile, evenly around the circle.
const ANGLES: usize = 360;
/// A notch narrower than this many pixels is no boundary.
const NOTCH: f64 = 1.5;
/// Steps along a ray in pixels.
const STEP: f64 = 0.25;

/// The boundary of a cross-section around a centre.
#[derive(Clone, Debug)]
pub struct Profile {
    /// For each angle, from the columns' axis to the rows' axis, the distance to the boundary in pixels.
    radius: Vec<f64>,
    /// The fraction of the section that can be seen from the centre, 0 to 1.
    pub visible: f64,
    /// The area of the section as a fraction of its convex hull's, steps of pixels set aside.
    pub solidity: f64,
}

impl Profile {
    /// The profile of a section around one of its pixels.
    pub fn new(section: &Section, center: [i32; 2]) -> Self {
        let mut radius = Vec::with_capacity(ANGLES);
        let reach = f64::from(section.size[0]) + f64::from(section.size[1]);
        let soft = Soft::new(section);
        for i in 0..ANGLES {
            let angle = i as f64 * std::f64::consts::TAU / ANGLES as f64;
            let (dx, dy) = (libm::cos(angle), libm::sin(angle));
            let (mut t, mut edge, mut before) = (0.0, 0.5, 1.0);
            while t < reach && t - edge <= NOTCH {
                let cover = soft.at(f64::from(center[0]) + dx * t, f64::from(center[1]) + dy * t);
                if cover >= 0.5 {
                    edge = t;
                } else if before >= 0.5 {
                    edge = t - STEP * (0.5 - cover) / (before - cover);
                }
                before = cover;
                t += STEP;
            }
            // A pixel reaches half a pixel, however little of its surroundings it covers.
            radius.push(edge.max(0.5));
        }
        let mut profile = Self { radius, visible: 1.0, solidity: solidity(section) };
        let seen = section.pixels().filter(|&[x, y]| {
            let (dx, dy) = (f64::from(x - center[0]), f64::from(y - center[1]));
            libm::sqrt(dx * dx + dy * dy) <= profile.radius(libm::atan2(dy, dx)) + 1.0
        });
        let seen = seen.count() as f64;
        profile.visible = seen / f64::from(section.area.max(1));
        // The profile encloses as much as it shows.
        let sector = std::f64::consts::PI / ANGLES as f64;
        let enclosed: f64 = profile.radius.iter().map(|r| r * r * sector).sum();
        let scale = libm::sqrt(seen / enclosed.max(1e-9));
        profile.radius.iter_mut().for_each(|r| *r *= scale);
        profile
    }

    /// The distance to the boundary at an angle in radians.
    pub fn radius(&self, angle: f64) -> f64 {
        let at = angle * (ANGLES as f64 / std::f64::consts::TAU);
        let below = libm::floor(at);
        let (i, f) = (below as i64, at - below);
        let get = |i: i64| self.radius[i.rem_euclid(ANGLES as i64) as usize];
        get(i) * (1.0 - f) + get(i + 1) * f
    }

    /// The largest distance.
    pub fn reach(&self) -> f64 {
        self.radius.iter().copied().fold(0.0, f64::max)
    }

    /// Whether all of the section can be seen from the centre, but for what pixels blur.
    pub fn is_star_shaped(&self) -> bool {
        self.visible >= 0.97
    }

    /// Whether the section is convex, but for what pixels blur.
    pub fn is_convex(&self) -> bool {
        self.solidity >= 0.9
    }
}

/// How much of a place's surroundings a section covers, 0 to 1: steps of pixels are not the shape, and the half-way line of
/// this has none.
struct Soft {
    low: [i32; 2],
    width: usize,
    cover: Vec<f64>,
}

impl Soft {
    fn new(section: &Section) -> Self {
        let low = section.low.map(|c| c - 2);
        let [width, height] = section.size.map(|n| n as usize + 4);
        let weighted = |i: usize| {
            let (x, y) = (low[0] + (i % width) as i32, low[1] + (i / width) as i32);
            let near = (0..9).map(|k| (k % 3 - 1, k / 3 - 1));
            let weights = near.map(|(dx, dy)| {
                f64::from(u8::from(section.holds(x + dx, y + dy)) * ((2 - dx.abs()) * (2 - dy.abs())) as u8)
            });
            weights.sum::<f64>() / 16.0
        };
        Self { low, width, cover: (0..width * height).map(weighted).collect() }
    }

    fn at(&self, x: f64, y: f64) -> f64 {
        let (fx, fy) = (libm::floor(x), libm::floor(y));
        let get = |x: i32, y: i32| {
            let (x, y) = (x - self.low[0], y - self.low[1]);
            let inside = x >= 0 && y >= 0 && (x as usize) < self.width;
            if inside {
                self.cover.get(y as usize * self.width + x as usize).copied().unwrap_or(0.0)
            } else {
                0.0
            }
        };
        let (i, j, u, v) = (fx as i32, fy as i32, x - fx, y - fy);
        let low = get(i, j) * (1.0 - u) + get(i + 1, j) * u;
        let high = get(i, j + 1) * (1.0 - u) + get(i + 1, j + 1) * u;
        low * (1.0 - v) + high * v
    }
}

/// The area of a section as a fraction of its convex hull's, both of whole pixels.
fn solidity(section: &Section) -> f64 {
    let mut points: Vec<[i64; 2]> = Vec::new();
    let width = section.size[0] as usize;
    for (y, row) in section.inside.chunks(width).enumerate() {
        let (first, last) = (row.iter().position(|&i| i), row.iter().rposition(|&i| i));
        for x in first.into_iter().chain(last.map(|x| x + 1)) {
            points.extend([[x as i64, y as i64], [x as i64, y as i64 + 1]]);
        }
    }
    points.sort_unstable();
    points.dedup();
    let turn =
        |a: [i64; 2], b: [i64; 2], c: [i64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    // Both chains of the hull (Andrew 1979).
    let chain = |points: &mut dyn Iterator<Item = [i64; 2]>| {
        let mut hull: Vec<[i64; 2]> = Vec::new();
        for p in points {
            while hull.len() > 1 && turn(hull[hull.len() - 2], hull[hull.len() - 1], p) <= 0 {
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
        hull
    };
    let mut hull = chain(&mut points.iter().copied());
    hull.extend(chain(&mut points.iter().rev().copied()));
    let twice: i64 = (0..hull.len())
        .map(|i| {
            let (a, b) = (hull[i], hull[(i + 1) % hull.len()]);
            a[0] * b[1] - a[1] * b[0]
        })
        .sum();
    let around: f64 = (0..hull.len())
        .map(|i| {
            let (a, b) = (hull[i], hull[(i + 1) % hull.len()]);
            libm::sqrt(((a[0] - b[0]).pow(2) + (a[1] - b[1]).pow(2)) as f64)
        })
        .sum();
    // Steps of pixels cost slanted sides about a quarter of a pixel, which counts in small sections.
    ((f64::from(section.area) + around / 4.0) / (twice as f64 / 2.0).max(1.0)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn section(inside: impl Fn(i32, i32) -> bool) -> Section {
        let pixels: Vec<[i32; 2]> =
            (-30..30).flat_map(|y| (-30..30).map(move |x| [x, y])).filter(|&[x, y]| inside(x, y)).collect();
        Section::of(&pixels, false).unwrap()
    }

    #[test]
    fn a_disc_has_one_radius_and_is_convex() {
        let profile = Profile::new(&section(|x, y| x * x + y * y <= 144), [0, 0]);
        for i in 0..36 {
            let radius = profile.radius(f64::from(i) * 0.1745);
            assert!((radius - 11.85).abs() < 0.5, "{radius}");
        }
        assert!(profile.is_star_shaped() && profile.is_convex());
    }

    #[test]
    fn a_crescent_is_neither_and_a_cross_is_a_star() {
        let crescent = section(|x, y| x * x + y * y <= 400 && (x - 8).pow(2) + y * y > 225);
        let profile = Profile::new(&crescent, [-13, 0]);
        assert!(!profile.is_convex() && !profile.is_star_shaped());
        let cross = section(|x, y| x.abs() <= 3 && y.abs() <= 15 || y.abs() <= 3 && x.abs() <= 15);
        let profile = Profile::new(&cross, [0, 0]);
        assert!(profile.is_star_shaped() && !profile.is_convex());
    }
}
