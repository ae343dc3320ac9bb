//! Which particles may lie next to which, and where (Du et al. 2013, section 3.2).

use breccia_engine::{Data, Digest};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::axes::AXES;
use super::particle::ParticleSet;
use super::section::Sections;
use crate::control::{Cancelled, Control, check};
use crate::data::{pack, unpack};

/// A cross-section near another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Near {
    /// The other cross-section.
    pub section: u32,
    /// From the one's centroid to the other's, along columns and rows, in pixels.
    pub offset: [f32; 2],
}

/// The neighbour sets of cross-sections, N_C, and the particles made of each cross-section, P(c).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Neighbours {
    /// For the views normal to x, y and z, for each cross-section: the nearest others, nearest first.
    pub near: [Vec<Vec<Near>>; 3],
    /// For the views normal to x, y and z, for each cross-section: the particles made of it, largest first.
    pub made: [Vec<Vec<u32>>; 3],
}

impl Neighbours {
    /// The sets of the `k` nearest cross-sections by distance of centroids, around the edges of tileable pictures.
    ///
    /// A cross-section that no particle was made of is stood in for by the one of nearest area that has some, since
    /// its place in the picture tells of the arrangement none the less.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(set: &ParticleSet, k: usize, control: &dyn Control) -> Result<Self, Cancelled> {
        // One picture is looked at once.
        let own: Vec<Vec<Vec<Near>>> =
            (0..set.views.len()).map(|v| nearest(set.view(v), k, control)).collect::<Result<_, _>>()?;
        let near = std::array::from_fn(|v: usize| own[v.min(own.len() - 1)].clone());
        let made = std::array::from_fn(|v| {
            let sections = &set.view(v).sections;
            let mut made: Vec<Vec<u32>> = vec![Vec::new(); sections.len()];
            for (particle, index) in set.particles.iter().zip(0..) {
                made[particle.sections[v] as usize].push(index);
            }
            for of_section in &mut made {
                of_section.sort_by_key(|&p| (std::cmp::Reverse(set.particles[p as usize].volume), p));
            }
            let used: Vec<usize> = (0..made.len()).filter(|&s| !made[s].is_empty()).collect();
            for s in 0..made.len() {
                let stand_in = used.iter().min_by_key(|&&u| (sections[u].area.abs_diff(sections[s].area), u));
                if made[s].is_empty()
                    && let Some(&u) = stand_in
                {
                    made[s] = made[u].clone();
                }
            }
            made
        });
        Ok(Self { near, made })
    }

    /// The neighbour set N_P of a particle by the union formula: particles with the offset of their centre from the particle's
    /// along x, y and z in voxels, and the view that says so.
    pub fn of<'a>(
        &'a self,
        set: &'a ParticleSet,
        particle: u32,
    ) -> impl Iterator<Item = (u32, [f32; 3], usize)> + 'a {
        (0..3).flat_map(move |v| {
            let one = &set.particles[particle as usize];
            let section = one.sections[v] as usize;
            self.near[v][section].iter().flat_map(move |near| {
                self.made[v][near.section as usize].iter().map(move |&other| {
                    let offset = center_offset(set, v, particle, other, near);
                    (other, offset, v)
                })
            })
        })
    }
}

/// The offset between the centres of two particles whose cross-sections in a view are neighbours: the centroids' offset, and how far
/// each centre lies from its centroid.
pub(super) fn center_offset(set: &ParticleSet, view: usize, one: u32, other: u32, near: &Near) -> [f32; 3] {
    let away = |particle: u32| {
        let particle = &set.particles[particle as usize];
        let section = &set.view(view).sections[particle.sections[view] as usize];
        [0, 1].map(|i| particle.centers[view][i] as f32 - section.centroid[i])
    };
    let (from, to) = (away(one), away(other));
    let mut offset = [0.0; 3];
    (0..2).for_each(|i| offset[AXES[view][i]] = near.offset[i] + to[i] - from[i]);
    offset
}

fn nearest(of: &Sections, k: usize, control: &dyn Control) -> Result<Vec<Vec<Near>>, Cancelled> {
    let size = [of.view.width, of.view.height].map(|n| n as f32);
    let offset = |a: [f32; 2], b: [f32; 2]| -> [f32; 2] {
        std::array::from_fn(|i| {
            let d = b[i] - a[i];
            if of.view.tileable { d - size[i] * libm::roundf(d / size[i]) } else { d }
        })
    };
    let one = |i: usize| {
        check(control)?;
        let mut others: Vec<(f32, u32, [f32; 2])> = (0..of.sections.len())
            .filter(|&j| j != i)
            .map(|j| {
                let d = offset(of.sections[i].centroid, of.sections[j].centroid);
                (d[0] * d[0] + d[1] * d[1], j as u32, d)
            })
            .collect();
        let order =
            |a: &(f32, u32, [f32; 2]), b: &(f32, u32, [f32; 2])| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        if others.len() > k {
            others.select_nth_unstable_by(k, order);
            others.truncate(k);
        }
        others.sort_by(order);
        Ok(others.into_iter().map(|(_, section, offset)| Near { section, offset }).collect())
    };
    (0..of.sections.len()).into_par_iter().map(one).collect()
}

impl Data for Neighbours {
    const TYPE: &'static str = "neighbours";
    const DOCS: &'static str = "Which particles may lie next to which, and where.";

    fn byte_size(&self) -> u64 {
        let near: usize = self.near.iter().flatten().map(|n| 24 + 12 * n.len()).sum();
        let made: usize = self.made.iter().flatten().map(|m| 24 + 4 * m.len()).sum();
        (near + made) as u64
    }

    fn summary(&self) -> String {
        let sections = self.near.iter().map(Vec::len).max().unwrap_or(0);
        let most = self.near.iter().flatten().map(Vec::len).max().unwrap_or(0);
        format!("{sections} cross-sections, up to {most} neighbours each")
    }

    fn digest(&self) -> Digest {
        Digest::of(&self.encode().unwrap_or_default())
    }

    fn encode(&self) -> Option<Vec<u8>> {
        pack(self)
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        unpack(bytes)
    }
}
