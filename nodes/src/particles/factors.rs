//! Scaling by direction: factors on the corners of a grid on a cube, linear in between.

use serde::{Deserialize, Serialize};

/// Cells along an edge of the cube.
const CELLS: usize = 6;
const CORNERS: usize = CELLS + 1;
/// Corners in all; those on the cube's edges are there once for each face, with equal values.
pub const NODES: usize = 6 * CORNERS * CORNERS;
/// Factors are kept in this fraction of one.
const SCALE: f64 = 4096.0;

/// How far a shape is scaled in each direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Factors(Vec<u16>);

impl Factors {
    /// One factor for all directions, 1/4096 to 15.
    pub fn uniform(factor: f64) -> Self {
        Self(vec![quantised(factor)])
    }

    /// Factors of the directions of the grid's nodes, in their order.
    pub fn of(factors: &[f64]) -> Self {
        Self(factors.iter().map(|&f| quantised(f)).collect())
    }

    /// Whether there is one factor, or one for each node; for what comes from a file.
    pub fn is_whole(&self) -> bool {
        (self.0.len() == 1 || self.0.len() == NODES) && !self.0.contains(&0)
    }

    /// Bytes held.
    pub fn byte_size(&self) -> u64 {
        2 * self.0.len() as u64
    }

    /// The largest factor.
    pub fn largest(&self) -> f64 {
        f64::from(self.0.iter().copied().max().unwrap_or(0)) / SCALE
    }

    /// These factors, each times another.
    pub fn times(&self, factor: f64) -> Self {
        Self(self.0.iter().map(|&f| quantised(f64::from(f) / SCALE * factor)).collect())
    }

    /// The factor in the direction of a vector; that of the first node for no direction.
    #[inline]
    pub fn at(&self, v: [f64; 3]) -> f64 {
        if self.0.len() != NODES {
            return f64::from(self.0.first().copied().unwrap_or(SCALE as u16)) / SCALE;
        }
        let size = v.map(f64::abs);
        let axis = if size[0] >= size[1] && size[0] >= size[2] {
            0
        } else if size[1] >= size[2] {
            1
        } else {
            2
        };
        if size[axis] == 0.0 {
            return f64::from(self.0[0]) / SCALE;
        }
        let face = 2 * axis + usize::from(v[axis] < 0.0);
        let place = |a: usize| (v[a] / size[axis] + 1.0) * (CELLS as f64 / 2.0);
        let (s, t) = (place((axis + 1) % 3), place((axis + 2) % 3));
        let (i, j) = ((s as usize).min(CELLS - 1), (t as usize).min(CELLS - 1));
        let (fs, ft) = (s - i as f64, t - j as f64);
        let get = |i: usize, j: usize| f64::from(self.0[(face * CORNERS + j) * CORNERS + i]);
        let low = get(i, j) * (1.0 - fs) + get(i + 1, j) * fs;
        let high = get(i, j + 1) * (1.0 - fs) + get(i + 1, j + 1) * fs;
        (low * (1.0 - ft) + high * ft) / SCALE
    }
}

fn quantised(factor: f64) -> u16 {
    libm::round(factor * SCALE).clamp(1.0, 61_440.0) as u16
}

/// The unit vector of a node.
pub fn direction(node: usize) -> [f64; 3] {
    let (face, j, i) = (node / (CORNERS * CORNERS), node / CORNERS % CORNERS, node % CORNERS);
    let axis = face / 2;
    let mut v = [0.0; 3];
    v[axis] = if face % 2 == 0 { 1.0 } else { -1.0 };
    v[(axis + 1) % 3] = 2.0 * i as f64 / CELLS as f64 - 1.0;
    v[(axis + 2) % 3] = 2.0 * j as f64 / CELLS as f64 - 1.0;
    let length = libm::sqrt(v.iter().map(|c| c * c).sum());
    v.map(|c| c / length)
}

/// The nodes beside a node on its face.
pub fn beside(node: usize) -> impl Iterator<Item = usize> {
    let (face, j, i) = (node / (CORNERS * CORNERS), node / CORNERS % CORNERS, node % CORNERS);
    let near = [(1i64, 0i64), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)];
    near.into_iter().filter_map(move |(di, dj)| {
        let (i, j) = (i as i64 + di, j as i64 + dj);
        let range = 0..CORNERS as i64;
        (range.contains(&i) && range.contains(&j))
            .then(|| (face * CORNERS + j as usize) * CORNERS + i as usize)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_are_met_at_the_nodes_and_join_at_the_edges() {
        let value = |d: [f64; 3]| 1.0 + 0.3 * d[0] - 0.2 * d[1] * d[2];
        let factors = Factors::of(&(0..NODES).map(|n| value(direction(n))).collect::<Vec<_>>());
        for node in 0..NODES {
            let d = direction(node);
            assert!((factors.at(d.map(|c| 7.0 * c)) - value(d)).abs() < 1e-3);
        }
        for k in 0..100 {
            let t = f64::from(k) / 50.0 - 1.0;
            let (a, b) = (factors.at([1.0, 1.0 - 1e-9, t]), factors.at([1.0 - 1e-9, 1.0, t]));
            assert!((a - b).abs() < 1e-3, "{a} {b}");
        }
        assert!((Factors::uniform(1.5).at([0.0, 2.0, 1.0]) - 1.5).abs() < 1e-3);
    }
}
