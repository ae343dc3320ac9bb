//! Particles from triples of cross-sections: octants swept from one section to another (Du et al. 2013, section 3.1).

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use rayon::prelude::*;

use super::axes::{AXES, coordinate};
use super::particle::{NOTHING, Particle, ParticleSet};
use super::profile::Profile;
use super::quarter::Quarter;
use super::section::{Section, Sections, pixel_index};
use super::triples::{Triple, TripleCounts, TripleError, TripleSettings, find_triples};
use crate::control::{Cancelled, Control, check};

/// The particles of the triples that [`find_triples`] finds in one picture or three views.
///
/// # Errors
/// [`TripleError`].
pub fn reconstruct(
    views: Vec<Arc<Sections>>,
    settings: &TripleSettings,
    control: &dyn Control,
) -> Result<(ParticleSet, TripleCounts), TripleError> {
    let of = |v: usize| &*views[v.min(views.len() - 1)];
    let (triples, counts) = find_triples([of(0), of(1), of(2)], settings, control)?;
    let made: Vec<Option<Particle>> = triples
        .par_iter()
        .map(|triple| {
            check(control)?;
            Ok(sweep([of(0), of(1), of(2)], triple))
        })
        .collect::<Result<_, Cancelled>>()?;
    let discarded = made.iter().filter(|particle| particle.is_none()).count() as u32;
    let particles = made.into_iter().flatten().collect();
    control.progress(1.0);
    Ok((ParticleSet { views, particles, discarded }, counts))
}

/// One particle.
///
/// The base plane is the first of the views normal to z, y and x whose section is star-shaped around its centre; without one the
/// triple is too complicated (`None`). In each octant the section that stands on the base plane's first axis is swept around
/// the base plane's normal to the one that stands on the second axis, and the morphed section is scaled in the base plane's
/// directions to meet the base section's boundary. A voxel takes, of the pixels that correspond to it in the three sections,
/// the one whose colour is nearest to their mean.
pub fn sweep(views: [&Sections; 3], triple: &Triple) -> Option<Particle> {
    let sections: [&Section; 3] = std::array::from_fn(|v| &views[v].sections[triple.sections[v] as usize]);
    let profiles: [Profile; 3] = std::array::from_fn(|v| Profile::new(sections[v], triple.centers[v]));
    let base = [2, 1, 0].into_iter().find(|&v| profiles[v].is_star_shaped())?;
    let [u, w] = AXES[base];
    // The view that holds an axis and the sweep axis is normal to the other axis.
    let (on_u, on_w) = (w, u);
    let quarters: Vec<Quarter> = (0..8)
        .map(|octant| {
            let sign = |bit: usize| if octant >> bit & 1 == 0 { 1 } else { -1 };
            let (su, sw, sa) = (sign(0), sign(1), sign(2));
            let from = (sections[on_u], triple.centers[on_u], &profiles[on_u], signs(on_u, u, su, base, sa));
            let to = (sections[on_w], triple.centers[on_w], &profiles[on_w], signs(on_w, w, sw, base, sa));
            Quarter::new(from, coordinate(on_u, u), to, coordinate(on_w, w))
        })
        .collect();
    let reach = |axis: usize| {
        let views = (0..3).filter(|&v| v != axis);
        views.map(|v| libm::ceil(profiles[v].reach()) as i32 + 1).max().unwrap_or(1)
    };
    let half = [reach(0), reach(1), reach(2)];
    let size = half.map(|n| 2 * n as u32 + 1);
    let mut source = Vec::with_capacity(size.iter().map(|&n| n as usize).product());
    for z in -half[2]..=half[2] {
        for y in -half[1]..=half[1] {
            for x in -half[0]..=half[0] {
                let p = [x, y, z];
                let octant =
                    usize::from(p[u] < 0) | usize::from(p[w] < 0) << 1 | usize::from(p[base] < 0) << 2;
                let found = locate(&quarters[octant], &profiles[base], p, [u, w], base);
                source.push(found.map_or(NOTHING, |[in_u, in_w, in_base]| {
                    let at = |v: usize, axes: [usize; 2], place: [f64; 2]| {
                        let mut planar = [0.0; 2];
                        for i in 0..2 {
                            let sign = if p[axes[i]] < 0 { -1.0 } else { 1.0 };
                            planar[coordinate(v, axes[i])] = sign * place[i];
                        }
                        shown(views[v], sections[v], triple.centers[v], planar) | (v as u32) << 30
                    };
                    let pixels =
                        [at(on_u, [u, base], in_u), at(on_w, [w, base], in_w), at(base, [u, w], in_base)];
                    nearest_to_mean(views, pixels)
                }));
            }
        }
    }
    let low = half.map(|n| -n);
    let Triple { sections, centers, error } = *triple;
    Particle { sections, centers, error, low, size, source, volume: 0 }.trimmed()
}

/// The signs of a view's columns and rows in an octant.
fn signs(view: usize, axis: usize, sign: i32, base: usize, sign_base: i32) -> [i32; 2] {
    let mut signs = [sign_base; 2];
    signs[coordinate(view, axis)] = sign;
    signs[coordinate(view, base)] = sign_base;
    signs
}

/// Where a voxel lies in the section on the first axis, in that on the second (both: along that axis, along the sweep axis), and
/// in the base section; all without signs. `None` outside the particle.
fn locate(
    quarter: &Quarter,
    base: &Profile,
    p: [i32; 3],
    [u, w]: [usize; 2],
    axis: usize,
) -> Option<[[f64; 2]; 3]> {
    let (pu, pw, h) = (f64::from(p[u]), f64::from(p[w]), f64::from(p[axis].abs()));
    let r = libm::sqrt(pu * pu + pw * pw);
    // On the sweep axis itself all directions meet: take the middle one.
    let turn = if r > 0.0 { libm::atan2(pw.abs(), pu.abs()) } else { FRAC_PI_2 / 2.0 };
    let t = turn / FRAC_PI_2;
    let half = if pu < 0.0 { std::f64::consts::PI - turn } else { turn };
    let edge = base.radius(if pw < 0.0 { -half } else { half });
    let scale = edge / quarter.width(t).max(1e-9);
    let [from, to] = quarter.locate(t, r / scale, h)?;
    let shrink = if r > edge { edge / r } else { 1.0 };
    Some([from, to, [pu.abs() * shrink, pw.abs() * shrink]])
}

/// The pixel of a section nearest to a place given from its centre; the next one towards the centre if that is outside.
fn shown(view: &Sections, section: &Section, center: [i32; 2], place: [f64; 2]) -> u32 {
    let mut at = center;
    for step in 0..24 {
        let scale = 1.0 - f64::from(step) / 24.0;
        at = std::array::from_fn(|i| center[i] + libm::round(place[i] * scale) as i32);
        if section.holds(at[0], at[1]) {
            break;
        }
    }
    pixel_index(&view.view, at[0], at[1]) as u32
}

/// Of three pixels, each with its view in the upper bits, the one whose colour is nearest to their mean; the first of equals.
fn nearest_to_mean(views: [&Sections; 3], pixels: [u32; 3]) -> u32 {
    let colors = pixels.map(|pixel| {
        let view = &views[(pixel >> 30) as usize].view;
        let i = pixel & 0x3fff_ffff;
        view.carried
            .first()
            .map_or([0; 3], |(_, image)| image.rgb8(i % view.width, i / view.width))
            .map(i32::from)
    });
    let away = |color: &[i32; 3]| {
        (0..3).map(|c| (3 * color[c] - colors.iter().map(|other| other[c]).sum::<i32>()).pow(2)).sum::<i32>()
    };
    let best = (0..3).min_by_key(|&i| away(&colors[i])).unwrap_or(0);
    pixels[best]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Image;
    use crate::exemplar::View;
    use crate::particles::{SectionSettings, find_sections};

    /// One picture of shapes far from each other, 40 pixels apart.
    fn picture(shapes: &[&dyn Fn(i32, i32) -> bool]) -> Arc<Sections> {
        let (w, h) = (40 * shapes.len() as i32, 40);
        let mask: Vec<bool> =
            (0..w * h).map(|i| shapes[(i % w / 40) as usize](i % w % 40 - 20, i / w - 20)).collect();
        let color = Image::from_fn(w as u32, 40, |x, y| [(x % 40 * 6) as u8, (y * 6) as u8, 99]);
        let view = View {
            width: w as u32,
            height: 40,
            texels: vec![[0; 4]; (w * h) as usize],
            carried: vec![("color".to_owned(), color)],
            tileable: false,
            guided: true,
            barred: Vec::new(),
        };
        let settings = SectionSettings { split: 0.0, most: 1.0, ..SectionSettings::default() };
        Arc::new(find_sections(&view, &mask, &settings, &()).unwrap())
    }

    fn only(sections: &Arc<Sections>, triple: [u32; 3]) -> Particle {
        let views: [&Sections; 3] = [sections; 3];
        let centers = triple.map(|s| sections.sections[s as usize].centroid.map(|c| libm::roundf(c) as i32));
        sweep(views, &Triple { sections: triple, centers, error: 0.0 }).unwrap()
    }

    #[test]
    fn three_discs_make_a_ball() {
        let found = picture(&[&|x, y| x * x + y * y <= 144]);
        let particle = only(&found, [0; 3]);
        let ball = 4.0 / 3.0 * std::f64::consts::PI * 11.85f64.powi(3);
        assert!((f64::from(particle.volume) / ball - 1.0).abs() < 0.06, "{} {ball}", particle.volume);
        for voxel in particle.voxels() {
            assert!(voxel.iter().map(|c| c * c).sum::<i32>() <= 13 * 13 + 13, "{voxel:?}");
        }
    }

    #[test]
    fn three_rectangles_make_a_brick() {
        // Edges 22, 14 and 10: normal to z 22 × 14, normal to y 22 × 10, normal to x 14 × 10.
        let found = picture(&[
            &|x, y| x.abs() <= 7 && y.abs() <= 5,
            &|x, y| x.abs() <= 11 && y.abs() <= 5,
            &|x, y| x.abs() <= 11 && y.abs() <= 7,
        ]);
        // Sections come by their first rows: the tallest is the first.
        let particle = only(&found, [1, 2, 0]);
        let brick = 23.0 * 15.0 * 11.0;
        // Sweeping rounds the upright edges a little.
        assert!((f64::from(particle.volume) / brick - 1.0).abs() < 0.12, "{} {brick}", particle.volume);
        for (axis, half) in [(0, 11), (1, 7), (2, 5)] {
            let reach = particle.voxels().map(|v| v[axis].abs()).max().unwrap();
            assert!((reach - half).abs() <= 1, "{axis} {reach}");
        }
    }

    #[test]
    fn the_middle_planes_show_the_sections() {
        let found = picture(&[&|x, y| x.abs() + y.abs() <= 12, &|x, y| x * x + 2 * y * y <= 200]);
        let particle = only(&found, [1, 1, 0]);
        let section = &found.sections[0];
        let [cx, cy] = particle.centers[2];
        let (mut same, mut all) = (0, 0);
        for y in -20..=20 {
            for x in -20..=20 {
                let inside = section.holds(cx + x, cy + y);
                all += i32::from(inside);
                same += i32::from(inside && particle.holds([x, y, 0]));
            }
        }
        assert!(same * 100 >= all * 93, "{same} of {all}");
    }

    #[test]
    fn triples_that_cannot_match_are_an_error_with_numbers() {
        let found = picture(&[&|x, y| x.abs() <= 15 && y.abs() <= 3]);
        let settings = TripleSettings { threshold: 0.01, ..TripleSettings::default() };
        let error = reconstruct(vec![found], &settings, &()).unwrap_err().to_string();
        assert!(error.contains("the threshold is 1.0 %") && error.contains("error of"), "{error}");
    }

    #[test]
    fn equal_sections_match_and_others_do_not() {
        let found = picture(&[&|x, y| x * x + y * y <= 36, &|x, y| x * x + y * y <= 225, &|x, y| {
            x * x + y * y <= 40
        }]);
        let (set, counts) = reconstruct(vec![found], &TripleSettings::default(), &()).unwrap();
        assert_eq!(counts.possible, 27);
        for particle in &set.particles {
            let large = particle.sections.iter().filter(|&&s| s == 0).count();
            assert!(large == 0 || large == 3, "{:?}", particle.sections);
        }
        assert!(set.particles.iter().any(|p| p.sections == [0; 3]));
    }
}
