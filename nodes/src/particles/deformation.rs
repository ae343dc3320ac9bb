//! Bending, twisting and tapering a box of material.

/// What is done to the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Its middle line becomes an arc of this angle, in the plane of the axis and the next one.
    Bend(f64),
    /// Its far end is turned around the axis by this angle against its near end.
    Twist(f64),
    /// Its far end is scaled by this factor across the axis.
    Taper(f64),
}

/// A deformation of space that fits a box of material. Angles are in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deformation {
    /// What is done.
    pub kind: Kind,
    /// The axis along which it varies.
    pub axis: usize,
    /// The edges of the box, whose first corner is the origin.
    pub size: [f64; 3],
}

impl Deformation {
    fn axes(&self) -> [usize; 3] {
        [self.axis, (self.axis + 1) % 3, (self.axis + 2) % 3]
    }

    /// Where a point of the material goes.
    pub fn forward(&self, p: [f64; 3]) -> [f64; 3] {
        let [a, b, c] = self.axes();
        let middle = self.size.map(|n| n / 2.0);
        let mut q = p;
        match self.kind {
            Kind::Bend(angle) if angle.abs() > 1e-9 => {
                let radius = self.size[a] / angle;
                let (turn, reach) = ((p[a] - middle[a]) / radius, radius - (p[b] - middle[b]));
                q[a] = middle[a] + reach * libm::sin(turn);
                q[b] = middle[b] + radius - reach * libm::cos(turn);
            }
            Kind::Bend(_) => {}
            Kind::Twist(angle) => {
                let turn = angle * p[a] / self.size[a];
                let (s, k) = (libm::sin(turn), libm::cos(turn));
                let (u, v) = (p[b] - middle[b], p[c] - middle[c]);
                q[b] = middle[b] + k * u - s * v;
                q[c] = middle[c] + s * u + k * v;
            }
            Kind::Taper(end) => {
                let scale = self.scale(end, p[a]);
                [b, c].into_iter().for_each(|i| q[i] = middle[i] + (p[i] - middle[i]) * scale);
            }
        }
        q
    }

    /// Which point of the material came to a place.
    pub fn inverse(&self, q: [f64; 3]) -> [f64; 3] {
        let [a, b, c] = self.axes();
        let middle = self.size.map(|n| n / 2.0);
        let mut p = q;
        match self.kind {
            Kind::Bend(angle) if angle.abs() > 1e-9 => {
                let radius = self.size[a] / angle;
                let sign = if radius < 0.0 { -1.0 } else { 1.0 };
                let (u, v) = (sign * (q[a] - middle[a]), sign * (middle[b] + radius - q[b]));
                p[a] = middle[a] + radius * libm::atan2(u, v);
                p[b] = middle[b] + radius - sign * libm::sqrt(u * u + v * v);
            }
            Kind::Bend(_) => {}
            Kind::Twist(angle) => {
                let turn = -angle * q[a] / self.size[a];
                let (s, k) = (libm::sin(turn), libm::cos(turn));
                let (u, v) = (q[b] - middle[b], q[c] - middle[c]);
                p[b] = middle[b] + k * u - s * v;
                p[c] = middle[c] + s * u + k * v;
            }
            Kind::Taper(end) => {
                let scale = self.scale(end, q[a]);
                [b, c].into_iter().for_each(|i| p[i] = middle[i] + (q[i] - middle[i]) / scale);
            }
        }
        p
    }

    fn scale(&self, end: f64, along: f64) -> f64 {
        (1.0 + (end - 1.0) * along / self.size[self.axis]).clamp(0.05, 20.0)
    }

    /// The derivative at a point of the material, rows of the result along x, y and z.
    pub fn jacobian(&self, p: [f64; 3]) -> [[f64; 3]; 3] {
        let mut rows = [[0.0; 3]; 3];
        for i in 0..3 {
            let (mut low, mut high) = (p, p);
            low[i] -= 0.5;
            high[i] += 0.5;
            let (from, to) = (self.forward(low), self.forward(high));
            (0..3).for_each(|r| rows[r][i] = to[r] - from[r]);
        }
        rows
    }
}

/// The rotation nearest to a matrix, by Newton's iteration for the polar decomposition (Higham 1986).
pub(super) fn rotation(mut m: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    for _ in 0..24 {
        let Some(inverse) = inverted(m) else { return m };
        for r in 0..3 {
            for c in r..3 {
                let (a, b) = (m[r][c], m[c][r]);
                m[r][c] = (a + inverse[c][r]) / 2.0;
                if r != c {
                    m[c][r] = (b + inverse[r][c]) / 2.0;
                }
            }
        }
    }
    m
}

/// The inverse of a matrix; `None` if it has none.
pub(super) fn inverted(m: [[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let minor = |r: usize, c: usize| {
        let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
    };
    let determinant: f64 = (0..3).map(|c| m[0][c] * minor(0, c)).sum();
    (determinant.abs() > 1e-9)
        .then(|| std::array::from_fn(|r| std::array::from_fn(|c| minor(c, r) / determinant)))
}

/// A matrix times a vector.
pub(super) fn apply(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|r| (0..3).map(|c| m[r][c] * v[c]).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_deformed_comes_back() {
        for kind in [Kind::Bend(1.2), Kind::Bend(-0.7), Kind::Bend(0.0), Kind::Twist(2.0), Kind::Taper(0.4)] {
            for axis in 0..3 {
                let mut size = [30.0; 3];
                size[axis] = 90.0;
                let deformation = Deformation { kind, axis, size };
                for k in 0..64 {
                    let p = std::array::from_fn(|a| f64::from(k >> (2 * a) & 3) * size[a] / 3.0);
                    let back = deformation.inverse(deformation.forward(p));
                    assert!((0..3).all(|a| (back[a] - p[a]).abs() < 1e-6), "{deformation:?} {p:?} {back:?}");
                }
            }
        }
    }

    #[test]
    fn the_rotation_of_a_turned_stretch_is_the_turn() {
        let (s, c) = (libm::sin(0.6), libm::cos(0.6));
        let turn = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]];
        let stretch = [[1.4, 0.1, 0.0], [0.1, 0.8, 0.05], [0.0, 0.05, 1.1]];
        let both = std::array::from_fn(|r| {
            std::array::from_fn(|k| (0..3).map(|i| turn[r][i] * stretch[i][k]).sum())
        });
        let found = rotation(both);
        assert!((0..9).all(|i| f64::abs(found[i / 3][i % 3] - turn[i / 3][i % 3]) < 1e-9), "{found:?}");
    }
}
