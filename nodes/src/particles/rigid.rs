//! As-rigid-as-possible interpolation between two quarters of cross-sections (Alexa, Cohen-Or & Levin 2000), for quarters that are
//! not convex or cannot be seen from their centre.
//!
//! Both quarters are mapped onto a quarter of the unit disc by a discrete harmonic map, which is one to one since that is convex
//! (Tutte 1963). A polar mesh of the disc, pulled back by both maps, is the compatible triangulation that the interpolation
//! needs. Each triangle's affine map is divided into a rotation and a stretch, which are interpolated apart; the vertices then
//! fit all triangles in the least-squares sense. Vertices on the axes stay on them, so that octants join.

use rustc_hash::FxHashMap;

/// Rings and spokes of the polar mesh.
const RINGS: usize = 5;
const SPOKES: usize = 12;
/// Solved steps of the interpolation.
const STEPS: usize = 16;

/// The interpolation between two quarters.
pub(super) struct RigidMorph {
    triangles: Vec<[usize; 3]>,
    ends: [Vec<[f64; 2]>; 2],
    /// Vertices at each step.
    steps: Vec<Vec<[f64; 2]>>,
    /// For each step, the triangle in each cell of a grid of [`CELL`]s, [`NONE`] outside.
    lookup: Vec<Lookup>,
}

/// The triangles of one step by place.
struct Lookup {
    width: usize,
    triangles: Vec<u8>,
}

/// Edge of the lookup's cells in pixels.
const CELL: f64 = 0.5;
/// No triangle.
const NONE: u8 = u8::MAX;

impl Lookup {
    fn new(vertices: &[[f64; 2]], triangles: &[[usize; 3]]) -> Self {
        let reach = |c: usize| vertices.iter().map(|v| v[c]).fold(0.0, f64::max);
        let [width, height] = [0, 1].map(|c| (reach(c) / CELL) as usize + 2);
        let mut found = vec![NONE; width * height];
        for (index, triangle) in triangles.iter().enumerate() {
            let corners = triangle.map(|v| vertices[v]);
            let span = |c: usize, n: usize| {
                let all = corners.map(|corner| corner[c] / CELL);
                let low = all.iter().copied().fold(f64::INFINITY, f64::min);
                let high = all.iter().copied().fold(0.0, f64::max);
                (low.max(0.0) as usize)..=((high as usize + 1).min(n - 1))
            };
            for y in span(1, height) {
                for x in span(0, width) {
                    let place = [x, y].map(|i| (i as f64 + 0.5) * CELL);
                    let inside = barycentric(corners, place).is_some_and(|w| w.iter().all(|&w| w >= -1e-9));
                    if inside && found[y * width + x] == NONE {
                        found[y * width + x] = index as u8;
                    }
                }
            }
        }
        Self { width, triangles: found }
    }

    fn at(&self, place: [f64; 2]) -> Option<usize> {
        let [x, y] = place.map(|c| (c.max(0.0) / CELL) as usize);
        let found = if x < self.width { self.triangles.get(y * self.width + x) } else { None };
        found.copied().filter(|&t| t != NONE).map(usize::from)
    }
}

/// The vertex of a ring (1 to [`RINGS`]) and spoke; vertex 0 is the centre.
fn vertex(ring: usize, spoke: usize) -> usize {
    if ring == 0 { 0 } else { 1 + (ring - 1) * (SPOKES + 1) + spoke }
}

fn triangles() -> Vec<[usize; 3]> {
    let mut all = Vec::new();
    for spoke in 0..SPOKES {
        all.push([0, vertex(1, spoke), vertex(1, spoke + 1)]);
        for ring in 1..RINGS {
            let [a, b] = [vertex(ring, spoke), vertex(ring, spoke + 1)];
            let [c, d] = [vertex(ring + 1, spoke), vertex(ring + 1, spoke + 1)];
            all.extend([[a, c, d], [a, d, b]]);
        }
    }
    all
}

impl RigidMorph {
    /// The interpolation between two masks `[row][column]` whose first pixel lies at the centre and inside; `None` if a mask is too
    /// thin for a mesh.
    pub fn new(from: &[Vec<bool>], to: &[Vec<bool>]) -> Option<Self> {
        let ends = [pulled_back(from)?, pulled_back(to)?];
        let triangles = triangles();
        let steps = interpolate(&ends, &triangles)?;
        let lookup = steps.iter().map(|vertices| Lookup::new(vertices, &triangles)).collect();
        Some(Self { triangles, ends, steps, lookup })
    }

    /// How far the interpolated quarter reaches along its columns' axis.
    pub fn width(&self, t: f64) -> f64 {
        self.steps[step(t)][vertex(RINGS, 0)][0]
    }

    /// Where a place of the interpolated quarter lies in both ends; `None` outside.
    pub fn locate(&self, t: f64, place: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        let triangle = self.triangles[self.lookup[step(t)].at(place)?];
        // A place at the border may lie outside of the triangle by part of a cell.
        let weights = barycentric(triangle.map(|v| self.steps[step(t)][v]), place)?.map(|w| w.max(0.0));
        let sum: f64 = weights.iter().sum();
        Some([0, 1].map(|end: usize| {
            std::array::from_fn(|c| (0..3).map(|k| weights[k] / sum * self.ends[end][triangle[k]][c]).sum())
        }))
    }
}

/// The solved step nearest to `t`.
fn step(t: f64) -> usize {
    (libm::round(t.clamp(0.0, 1.0) * STEPS as f64) as usize).min(STEPS)
}

/// The weights of a triangle's corners at a place; `None` if the triangle has no area.
fn barycentric([a, b, c]: [[f64; 2]; 3], p: [f64; 2]) -> Option<[f64; 3]> {
    let cross =
        |o: [f64; 2], u: [f64; 2], v: [f64; 2]| (u[0] - o[0]) * (v[1] - o[1]) - (u[1] - o[1]) * (v[0] - o[0]);
    let area = cross(a, b, c);
    if area.abs() < 1e-9 {
        return None;
    }
    let [u, v] = [cross(p, b, c) / area, cross(p, c, a) / area];
    Some([u, v, 1.0 - u - v])
}

/// The polar mesh in a quarter: corners of its pixels are mapped harmonically, then each vertex of the mesh is looked up among
/// the mapped pixels.
fn pulled_back(mask: &[Vec<bool>]) -> Option<Vec<[f64; 2]>> {
    let region = component(mask)?;
    let boundary = trace(&region)?;
    let mapped = harmonic(&region, &boundary);
    let mut found: Vec<([f64; 2], f64)> = vec![([0.0; 2], f64::NEG_INFINITY); 1 + RINGS * (SPOKES + 1)];
    let targets: Vec<[f64; 2]> = std::iter::once([0.0; 2])
        .chain((1..=RINGS).flat_map(|ring| {
            (0..=SPOKES).map(move |spoke| {
                let angle = spoke as f64 * std::f64::consts::FRAC_PI_2 / SPOKES as f64;
                let radius = ring as f64 / RINGS as f64;
                [radius * libm::cos(angle), radius * libm::sin(angle)]
            })
        }))
        .collect();
    for (y, row) in region.iter().enumerate() {
        for x in (0..row.len()).filter(|&x| row[x]) {
            let [a, b, c, d] = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]];
            for corners in [[a, b, c], [a, c, d]] {
                let image = corners.map(|corner| mapped.get(&corner).copied().unwrap_or([0.0; 2]));
                for (target, found) in targets.iter().zip(&mut found) {
                    let Some(weights) = barycentric(image, *target) else { continue };
                    // Inside all weights are positive; on the arc the nearest triangle must do.
                    let least = weights.iter().copied().fold(f64::INFINITY, f64::min);
                    if least > found.1 {
                        let place = |i: usize| (0..3).map(|k| weights[k] * corners[k][i] as f64).sum::<f64>();
                        *found = ([place(0), place(1)], least);
                    }
                }
            }
        }
    }
    let mut vertices: Vec<[f64; 2]> = found.into_iter().map(|(place, _)| place).collect();
    vertices[0] = [0.0; 2];
    for ring in 1..=RINGS {
        vertices[vertex(ring, 0)][1] = 0.0;
        vertices[vertex(ring, SPOKES)][0] = 0.0;
    }
    Some(vertices)
}

/// The pixels connected to the first.
fn component(mask: &[Vec<bool>]) -> Option<Vec<Vec<bool>>> {
    let mut region: Vec<Vec<bool>> = mask.iter().map(|row| vec![false; row.len()]).collect();
    let mut queue = vec![[0usize, 0usize]];
    let mut count = 0;
    while let Some([x, y]) = queue.pop() {
        if !*mask.get(y)?.get(x).unwrap_or(&false) || region[y][x] {
            continue;
        }
        region[y][x] = true;
        count += 1;
        queue.extend([[x + 1, y], [x, (y + 1).min(mask.len() - 1)]]);
        queue.extend([[x.saturating_sub(1), y], [x, y.saturating_sub(1)]]);
    }
    (count >= 4).then_some(region)
}

/// The corners along the boundary, once around, from (0, 0) along the columns' axis first.
fn trace(region: &[Vec<bool>]) -> Option<Vec<[usize; 2]>> {
    let inside = |x: i64, y: i64| {
        x >= 0 && y >= 0 && region.get(y as usize).and_then(|row| row.get(x as usize)) == Some(&true)
    };
    let (mut at, mut direction) = ([0i64, 0i64], [1i64, 0i64]);
    let mut corners = Vec::new();
    for _ in 0..8 * region.len() * region.len() + 8 {
        corners.push(at.map(|c| c as usize));
        at = [at[0] + direction[0], at[1] + direction[1]];
        if at == [0, 0] {
            return (corners.len() >= 8).then_some(corners);
        }
        // The inside lies to the left; look for the sharpest turn to the right that keeps it there.
        let [dx, dy] = direction;
        let ahead = |side: i64| {
            // The pixel ahead on the left (+1) or right (−1) of the corner.
            let (lx, ly) = (-dy * side, dx * side);
            let x = at[0] + if dx + lx > 0 { 0 } else { -1 };
            let y = at[1] + if dy + ly > 0 { 0 } else { -1 };
            inside(x, y)
        };
        direction = match (ahead(1), ahead(-1)) {
            (false, _) => [-dy, dx],
            (true, false) => direction,
            (true, true) => [dy, -dx],
        };
    }
    None
}

/// The harmonic map of the region's corners onto the quarter disc, whose boundary follows the region's by length.
fn harmonic(region: &[Vec<bool>], boundary: &[[usize; 2]]) -> FxHashMap<[usize; 2], [f64; 2]> {
    let n = boundary.len();
    let along = boundary.iter().position(|&[_, y]| y > 0).unwrap_or(1).saturating_sub(1).max(1);
    let back = n - boundary.iter().rposition(|&[x, _]| x > 0).unwrap_or(n - 2) - 1;
    let back = back.max(1);
    let arc = (n - along).saturating_sub(back).max(1);
    let mut fixed: FxHashMap<[usize; 2], [f64; 2]> = FxHashMap::default();
    for (i, &corner) in boundary.iter().enumerate() {
        let place = if i <= along {
            [i as f64 / along as f64, 0.0]
        } else if i >= n - back {
            [0.0, (n - i) as f64 / back as f64]
        } else {
            let angle = (i - along) as f64 / arc as f64 * std::f64::consts::FRAC_PI_2;
            [libm::cos(angle), libm::sin(angle)]
        };
        fixed.insert(corner, place);
    }
    // Corners of the region in reading order, with their neighbours along edges of its pixels.
    let inside = |x: usize, y: usize| region.get(y).and_then(|row| row.get(x)) == Some(&true);
    let mut index: FxHashMap<[usize; 2], usize> = FxHashMap::default();
    let mut corners = Vec::new();
    for y in 0..=region.len() {
        for x in 0..=region[0].len() {
            let touches = (0..4).any(|k| x >= k % 2 && y >= k / 2 && inside(x - k % 2, y - k / 2));
            if touches {
                index.insert([x, y], corners.len());
                corners.push([x, y]);
            }
        }
    }
    let mut values: Vec<[f64; 2]> =
        corners.iter().map(|corner| fixed.get(corner).copied().unwrap_or([0.35; 2])).collect();
    let free: Vec<(usize, Vec<usize>)> = corners
        .iter()
        .enumerate()
        .filter(|(_, corner)| !fixed.contains_key(*corner))
        .map(|(i, &[x, y])| {
            let near = [[x + 1, y], [x.wrapping_sub(1), y], [x, y + 1], [x, y.wrapping_sub(1)]];
            (i, near.iter().filter_map(|corner| index.get(corner).copied()).collect())
        })
        .collect();
    // Successive over-relaxation; regions are tens of pixels wide.
    for _ in 0..400 {
        let mut change = 0.0f64;
        for (i, near) in &free {
            let sum = near.iter().fold([0.0; 2], |sum, &j| [sum[0] + values[j][0], sum[1] + values[j][1]]);
            for (value, sum) in values[*i].iter_mut().zip(sum) {
                let step = 1.7 * (sum / near.len().max(1) as f64 - *value);
                *value += step;
                change = change.max(step.abs());
            }
        }
        if change < 1e-6 {
            break;
        }
    }
    corners.into_iter().zip(values).collect()
}

/// The vertices at each step.
fn interpolate(ends: &[Vec<[f64; 2]>; 2], triangles: &[[usize; 3]]) -> Option<Vec<Vec<[f64; 2]>>> {
    let count = ends[0].len();
    // Gradients of the corners' hat functions in the first end, and the map of each triangle as rotation and stretch.
    struct Piece {
        corners: [usize; 3],
        gradients: [[f64; 2]; 3],
        area: f64,
        angle: f64,
        stretch: [f64; 3],
    }
    let mut pieces = Vec::new();
    for &corners in triangles {
        let [a, b, c] = corners.map(|v| ends[0][v]);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area.abs() < 1e-6 {
            continue;
        }
        let gradient = |p: [f64; 2], q: [f64; 2]| [(p[1] - q[1]) / area, (q[0] - p[0]) / area];
        let gradients = [gradient(b, c), gradient(c, a), gradient(a, b)];
        let mut map = [[0.0; 2]; 2];
        for (corner, gradient) in corners.iter().zip(&gradients) {
            for (row, line) in map.iter_mut().enumerate() {
                (0..2).for_each(|column| line[column] += ends[1][*corner][row] * gradient[column]);
            }
        }
        // The rotation nearest to the map, and what is left, which is symmetric.
        let [[m00, m01], [m10, m11]] = map;
        let angle = libm::atan2(m10 - m01, m00 + m11);
        let (s, c) = (libm::sin(angle), libm::cos(angle));
        let stretch = [c * m00 + s * m10, c * m01 + s * m11, -s * m01 + c * m11];
        pieces.push(Piece { corners, gradients, area: area.abs(), angle, stretch });
    }
    let axis = |v: usize, c: usize| {
        // Coordinate c is zero at the centre, and on the axis along the other coordinate.
        let spoke = if c == 1 { 0 } else { SPOKES };
        v == 0 || (1..=RINGS).any(|ring| vertex(ring, spoke) == v)
    };
    let mut steps = vec![vec![[0.0; 2]; count]; STEPS + 1];
    for c in 0..2 {
        let free: Vec<usize> = (0..count).filter(|&v| !axis(v, c)).collect();
        let mut row = vec![usize::MAX; count];
        free.iter().enumerate().for_each(|(i, &v)| row[v] = i);
        let n = free.len();
        let mut matrix = vec![0.0; n * n];
        for piece in &pieces {
            for (i, gi) in piece.corners.iter().zip(&piece.gradients) {
                for (j, gj) in piece.corners.iter().zip(&piece.gradients) {
                    if row[*i] < n && row[*j] < n {
                        matrix[row[*i] * n + row[*j]] += piece.area * (gi[0] * gj[0] + gi[1] * gj[1]);
                    }
                }
            }
        }
        let factor = cholesky(matrix, n)?;
        for (step, vertices) in steps.iter_mut().enumerate() {
            let t = step as f64 / STEPS as f64;
            let mut right = vec![0.0; n];
            for piece in &pieces {
                let [s0, s1, s2] = piece.stretch;
                let stretch = [[1.0 - t + t * s0, t * s1], [t * s1, 1.0 - t + t * s2]];
                let (s, co) = (libm::sin(t * piece.angle), libm::cos(t * piece.angle));
                let turn = if c == 0 { [co, -s] } else { [s, co] };
                let wanted = [0, 1].map(|k| turn[0] * stretch[0][k] + turn[1] * stretch[1][k]);
                for (i, g) in piece.corners.iter().zip(&piece.gradients) {
                    if row[*i] < n {
                        right[row[*i]] += piece.area * (g[0] * wanted[0] + g[1] * wanted[1]);
                    }
                }
            }
            solve(&factor, &mut right);
            free.iter().zip(&right).for_each(|(&v, &value)| vertices[v][c] = value);
        }
    }
    Some(steps)
}

/// The lower factor of a symmetric positive definite matrix; `None` if it is none.
fn cholesky(mut a: Vec<f64>, n: usize) -> Option<Vec<f64>> {
    for j in 0..n {
        for i in j..n {
            let mut sum = a[i * n + j];
            for k in 0..j {
                sum -= a[i * n + k] * a[j * n + k];
            }
            if i == j {
                if sum <= 1e-12 {
                    return None;
                }
                a[i * n + j] = libm::sqrt(sum);
            } else {
                a[i * n + j] = sum / a[j * n + j];
            }
        }
    }
    Some(a)
}

fn solve(factor: &[f64], x: &mut [f64]) {
    let n = x.len();
    for i in 0..n {
        let sum: f64 = (0..i).map(|k| factor[i * n + k] * x[k]).sum();
        x[i] = (x[i] - sum) / factor[i * n + i];
    }
    for i in (0..n).rev() {
        let sum: f64 = (i + 1..n).map(|k| factor[k * n + i] * x[k]).sum();
        x[i] = (x[i] - sum) / factor[i * n + i];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask(inside: impl Fn(f64, f64) -> bool) -> Vec<Vec<bool>> {
        (0..40).map(|y| (0..40).map(|x| inside(f64::from(x) + 0.5, f64::from(y) + 0.5)).collect()).collect()
    }

    fn area(vertices: &[[f64; 2]]) -> f64 {
        let signed = |t: [usize; 3]| {
            let [a, b, c] = t.map(|v| vertices[v]);
            ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2.0
        };
        triangles().into_iter().map(signed).sum()
    }

    /// A quarter that bends so far that its end cannot be seen from the centre.
    fn hook(x: f64, y: f64) -> bool {
        x < 20.0 && y < 6.0
            || (14.0..20.0).contains(&x) && y < 24.0
            || (4.0..20.0).contains(&x) && (18.0..24.0).contains(&y)
            || x < 3.0 && y < 12.0
    }

    #[test]
    fn the_ends_are_the_quarters() {
        let disc = mask(|x, y| x * x + y * y < 400.0);
        let hooked = mask(hook);
        let morph = RigidMorph::new(&disc, &hooked).unwrap();
        for (step, end, mask) in [(0, 0, &disc), (STEPS, 1, &hooked)] {
            for (found, wanted) in morph.steps[step].iter().zip(&morph.ends[end]) {
                assert!((0..2).all(|c| (found[c] - wanted[c]).abs() < 0.35), "{found:?} {wanted:?}");
            }
            let pixels = mask.iter().flatten().filter(|&&m| m).count() as f64;
            assert!(
                (area(&morph.ends[end]) / pixels - 1.0).abs() < 0.12,
                "{} {pixels}",
                area(&morph.ends[end])
            );
        }
        assert!(morph.locate(1.0, [17.0, 20.0]).is_some());
        assert!(morph.locate(1.0, [8.0, 12.0]).is_none(), "the hook's inside is empty");
    }

    #[test]
    fn triangles_of_the_ends_keep_their_orientation() {
        let morph = RigidMorph::new(&mask(hook), &mask(|x, y| x < 12.0 && y < 18.0)).unwrap();
        let turned = |vertices: &[[f64; 2]]| {
            triangles()
                .into_iter()
                .filter(|t| {
                    let [a, b, c] = t.map(|v| vertices[v]);
                    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) < -0.2
                })
                .count()
        };
        assert!(
            morph.ends.iter().all(|end| turned(end) <= 4),
            "{:?}",
            morph.ends.each_ref().map(|e| turned(e))
        );
    }

    #[test]
    fn a_turned_shape_keeps_its_area_halfway() {
        // Linear interpolation of a bar turned by a quarter would shrink to half its area.
        let flat = mask(|x, y| x < 24.0 && y < 8.0);
        let tall = mask(|x, y| x < 8.0 && y < 24.0);
        let morph = RigidMorph::new(&flat, &tall).unwrap();
        let halfway = area(&morph.steps[STEPS / 2]);
        assert!(halfway > 100.0, "{halfway}");
    }

    #[test]
    fn what_is_too_thin_has_no_mesh() {
        assert!(
            RigidMorph::new(&mask(|x, y| x < 1.0 && y < 1.0), &mask(|x, y| x < 9.0 && y < 9.0)).is_none()
        );
    }
}
