//! Filling gaps: every particle is scaled towards its Voronoi cell (Du et al. 2013, section 3.4).

use std::sync::Arc;

use rayon::prelude::*;

use super::bits::Bits;
use super::cells::cells;
use super::factors::{Factors, NODES, beside, direction};
use super::packing::{Packing, Placed, Shape};
use crate::control::{Cancelled, Control, check};

/// What a particle's cell consists of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellOf {
    /// The places nearest to its surface, so that large particles have large cells.
    Surface,
    /// The places nearest to its centre, as in the paper.
    Center,
}

/// How particles are scaled.
#[derive(Clone, Copy, Debug)]
pub struct FillSettings {
    /// The particles' cells.
    pub cells: CellOf,
    /// How far directions may exceed the uniform factor (α, the paper's 0.1), if no fraction is wanted.
    pub alpha: f64,
    /// The distance that stays free between a particle and the border of its cell; negative: half of how thin the matrix
    /// is between neighbours in the pictures.
    pub clearance: f64,
    /// The fraction of the domain that particles are to fill: one factor for all is chosen for it, and where that is not enough less
    /// clearance. Negative: as in the pictures; 0: the paper's rule.
    pub fraction: f64,
}

impl Default for FillSettings {
    fn default() -> Self {
        Self { cells: CellOf::Surface, alpha: 0.1, clearance: -1.0, fraction: -1.0 }
    }
}

/// Factors within which particles are scaled.
const LEAST: f64 = 0.2;
const MOST: f64 = 3.0;

/// The packing with scaled particles, of which no two overlap.
///
/// In direction d the largest factor f_d keeps the boundary clear of the cell's border. The uniform factor f_u is the least of them
/// in directions that meet the border at a right angle, that is where the border is nearer than in directions beside. The
/// factor in direction d is min((1 + α) f_u, f_d); to fill a wanted fraction it is min(f, f_d) with one f for all
/// particles. Voxels that even so lie beyond the particle's cell, or next to another cell, are dropped.
///
/// # Errors
/// [`Cancelled`].
pub fn fill(packing: &Packing, settings: &FillSettings, control: &dyn Control) -> Result<Packing, Cancelled> {
    let domain = Domain::new(packing, settings.cells, control)?;
    control.progress(0.3);
    let clearance = if settings.clearance < 0.0 { packing.set.thickness() / 2.0 } else { settings.clearance };
    let rays: Vec<Rays> = packing
        .placed
        .par_iter()
        .enumerate()
        .map(|(i, placed)| {
            check(control)?;
            Ok(Rays::new(packing, &domain, placed, Packing::id(i)))
        })
        .collect::<Result<_, Cancelled>>()?;
    control.progress(0.5);
    let shapes = |limit: Limit, clearance: f64| -> Result<Vec<Shape>, Cancelled> {
        let scaled = packing.placed.par_iter().zip(&rays).enumerate();
        scaled
            .map(|(i, (placed, rays))| {
                check(control)?;
                Ok(rays.shape(packing, &domain, placed, Packing::id(i), limit, clearance))
            })
            .collect()
    };
    let wanted = if settings.fraction < 0.0 { packing.set.fraction() } else { settings.fraction };
    let mut found = Vec::new();
    if settings.fraction == 0.0 {
        found = shapes(Limit::Alpha(settings.alpha), clearance)?;
    } else {
        let voxels: f64 = packing.size.iter().map(|&n| f64::from(n)).product();
        let filled = |shapes: &[Shape]| shapes.iter().map(|s| s.bits.count()).sum::<u64>() as f64 / voxels;
        // The fraction grows with the factor; where that is not enough, the clearance shrinks too: halve the interval from the least
        // factor over the largest to the largest with hardly any clearance.
        let (mut low, mut high) = (0.0, 2.0);
        let mut best = f64::INFINITY;
        // Half a voxel is what still keeps particles from touching.
        let shrunk = |at: f64| (clearance * (2.0 - at).min(1.0)).max(clearance.min(0.5));
        for step in 0..9 {
            control.progress(0.55 + 0.05 * step as f32);
            let middle: f64 = (low + high) / 2.0;
            let factor = LEAST * libm::pow(MOST / LEAST, middle.min(1.0));
            let tried = shapes(Limit::Common(factor), shrunk(middle))?;
            let fraction = filled(&tried);
            if (fraction - wanted).abs() < best {
                (best, found) = ((fraction - wanted).abs(), tried);
            }
            if best < 0.002 {
                break;
            }
            if fraction < wanted { low = middle } else { high = middle }
        }
    }
    let placed = packing.placed.iter().zip(found).filter(|(_, shape)| shape.bits.count() > 0);
    let placed =
        placed.map(|(placed, shape)| Placed { shape: Some(Arc::new(shape)), ..placed.clone() }).collect();
    Ok(Packing { placed, set: Arc::clone(&packing.set), size: packing.size, wrap: packing.wrap })
}

/// What limits the factors besides the cells.
#[derive(Clone, Copy)]
enum Limit {
    /// Each particle's own uniform factor, times 1 + α.
    Alpha(f64),
    /// One factor for all particles, which keeps their sizes in proportion where there is room.
    Common(f64),
}

/// A domain whose every voxel has an owner.
struct Domain {
    size: [i32; 3],
    wrap: bool,
    owner: Vec<u32>,
}

impl Domain {
    fn new(packing: &Packing, of: CellOf, control: &dyn Control) -> Result<Self, Cancelled> {
        let size = packing.size.map(|n| n as i32);
        let mut domain = Self { size, wrap: packing.wrap, owner: Vec::new() };
        let mut labels = vec![0u32; packing.size.iter().map(|&n| n as usize).product()];
        for (i, placed) in packing.placed.iter().enumerate() {
            if i.is_multiple_of(64) {
                check(control)?;
            }
            let mut mark = |voxel: [i32; 3]| {
                let at = std::array::from_fn(|a| placed.center[a] + voxel[a]);
                if let Some(at) = domain.index(at)
                    && labels[at] == 0
                {
                    labels[at] = Packing::id(i);
                }
            };
            match of {
                CellOf::Center => mark([0; 3]),
                CellOf::Surface => packing.voxels(placed).into_iter().for_each(mark),
            }
        }
        domain.owner = cells(&labels, packing.size.map(|n| n as usize), packing.wrap, control)?.owner;
        Ok(domain)
    }

    #[inline]
    fn index(&self, voxel: [i32; 3]) -> Option<usize> {
        let mut at = voxel;
        for (c, n) in at.iter_mut().zip(self.size) {
            if !(0..n).contains(c) {
                if !self.wrap {
                    return None;
                }
                *c = c.rem_euclid(n);
            }
        }
        Some(
            (at[2] as usize * self.size[1] as usize + at[1] as usize) * self.size[0] as usize
                + at[0] as usize,
        )
    }

    /// Whether a voxel belongs to a particle's cell; beyond a domain that ends every voxel does.
    #[inline]
    fn owns(&self, id: u32, voxel: [i32; 3]) -> bool {
        self.index(voxel).is_none_or(|at| self.owner[at] == id)
    }
}

/// What rays from a particle's centre meet.
struct Rays {
    /// For each direction, the distance to the particle's own boundary.
    radius: Vec<f64>,
    /// For each direction, the distance to the border of the cell.
    cell: Vec<f64>,
}

impl Rays {
    fn new(packing: &Packing, domain: &Domain, placed: &Placed, id: u32) -> Self {
        let (low, size) = packing.bounds(placed);
        let reach = (0..3).map(|a| low[a].abs().max(low[a] + size[a] as i32)).max().unwrap_or(1);
        let at = |d: [f64; 3], t: f64| d.map(|c| libm::floor(c * t + 0.5) as i32);
        let mut cell = Vec::with_capacity(NODES);
        let mut radius = Vec::with_capacity(NODES);
        for node in 0..NODES {
            let d = direction(node);
            let steps = |t: f64| (0..(2.0 * t) as i32 + 1).map(|k| f64::from(k) / 2.0);
            let own = steps(f64::from(reach) * 1.75 + 1.0).rfind(|&t| packing.holds(placed, at(d, t)));
            let own = own.unwrap_or(0.0) + 0.25;
            let border = steps(own * MOST + 8.0).find(|&t| {
                let v = at(d, t);
                !domain.owns(id, std::array::from_fn(|a| placed.center[a] + v[a]))
            });
            radius.push(own);
            // Where a domain that ends has no border to fill up to, the particle keeps its size.
            cell.push(border.map_or(f64::INFINITY, |t| (t - 0.25).max(0.0)));
        }
        Self { radius, cell }
    }

    fn shape(
        &self,
        packing: &Packing,
        domain: &Domain,
        placed: &Placed,
        id: u32,
        limit: Limit,
        clearance: f64,
    ) -> Shape {
        let Self { cell, radius } = self;
        // The film of voxels that is dropped below is half a voxel of the clearance already.
        let clear = if clearance < 0.5 { clearance } else { clearance - 0.5 };
        let largest = |(cell, own): (&f64, &f64)| {
            if cell.is_finite() { ((cell - clear) / own).clamp(LEAST, MOST) } else { 1.0 }
        };
        let most: Vec<f64> = cell.iter().zip(radius).map(largest).collect();
        let limit = match limit {
            Limit::Common(factor) => factor,
            Limit::Alpha(alpha) => {
                let right_angles =
                    (0..NODES).filter(|&n| cell[n].is_finite() && beside(n).all(|m| cell[n] <= cell[m]));
                let uniform = right_angles.map(|n| most[n]).fold(MOST, f64::min);
                ((1.0 + alpha) * uniform).clamp(LEAST, MOST)
            }
        };
        let scaled: Vec<f64> = most.iter().map(|&most| limit.min(most)).collect();
        let mut low = [0i32; 3];
        let mut high = [0i32; 3];
        for (node, (radius, factor)) in self.radius.iter().zip(&scaled).enumerate() {
            let d = direction(node);
            for a in 0..3 {
                // Between nodes the shape may reach a little further.
                let reach = libm::round(d[a] * radius * factor * 1.08) as i32;
                low[a] = low[a].min(reach - 1);
                high[a] = high[a].max(reach + 1);
            }
        }
        let factors = Factors::of(&scaled);
        let size = std::array::from_fn(|a| (high[a] - low[a] + 1) as u32);
        let before = placed.shape.as_deref();
        // Dropping what touches another cell on three sides leaves a film of one voxel, on six sides of two.
        let near = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]];
        let sides = if clearance < 0.5 {
            0
        } else if clearance < 1.0 {
            3
        } else {
            6
        };
        let bits = Bits::from_fn(low, size, |v| {
            let place: [i32; 3] = std::array::from_fn(|a| placed.center[a] + v[a]);
            // What lies beyond a domain that ends is never shown.
            if domain.index(place).is_none() || !domain.owns(id, place) {
                return false;
            }
            let factor = factors.at(v.map(f64::from));
            let own = v.map(|c| libm::round(f64::from(c) / factor) as i32);
            packing.holds(placed, own)
                && near[..sides].iter().all(|d| domain.owns(id, std::array::from_fn(|a| place[a] + d[a])))
        });
        // A shape that was scaled before is scaled once more.
        let factors = before.map_or(factors, |before| {
            let nodes = (0..NODES).map(|n| before.factors.at(direction(n)) * scaled[n]);
            Factors::of(&nodes.collect::<Vec<_>>())
        });
        Shape { bits, factors }
    }
}
