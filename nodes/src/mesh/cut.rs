//! Cutting a mesh by a plane into two closed halves.
//!
//! Triangles are clipped with all their attributes; where an edge crosses the plane, both of its triangles get
//! the same point bit for bit, whichever way they run it and whether or not they share its vertices. The cap's
//! outline is the set of cut edges; what lies inside it is decided by [`super::cap`].
//!
//! Where the mesh has UVs, the old atlas shrinks to the left part of the texture and the cap's flat chart takes
//! the strip beside it, at equal texels per area. Textures laid out by the old UVs are dropped: bake the halves
//! again. They keep the voxel space of the whole, so the solid runs on through the cut.

use rustc_hash::FxHashMap;

use super::cap::{Cap, fill};
use super::vector::{Vec3, cross, dot, sub, unit};
use crate::data::Mesh;

/// A plane; its normal points to what lies above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// A point of the plane.
    pub point: [f64; 3],
    /// A vector at right angles to it, of any length.
    pub normal: [f64; 3],
}

/// A mesh could not be cut.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CutError {
    /// The normal has no direction.
    #[error("{0:?} is not the normal of a plane")]
    Normal([f64; 3]),
    /// All of the mesh lies on one side.
    #[error("the plane misses the mesh: all of it lies {0}")]
    Misses(&'static str),
    /// A triangle names a vertex that is not there, or arrays differ in length.
    #[error("the mesh is damaged: {0}")]
    Damaged(String),
}

/// The two parts of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Halves {
    /// What lies to the side that the normal points to.
    pub above: Mesh,
    /// The rest.
    pub below: Mesh,
}

/// Cuts a mesh by a plane and closes both halves.
///
/// # Errors
/// See [`CutError`].
pub fn cut_mesh(mesh: &Mesh, plane: Plane) -> Result<Halves, CutError> {
    super::write::check(mesh).map_err(CutError::Damaged)?;
    let finite = plane.point.iter().all(|c| c.is_finite());
    let normal = unit(plane.normal).filter(|_| finite).ok_or(CutError::Normal(plane.normal))?;
    let (lo, hi) = mesh.bounds().unwrap_or_default();
    let size = (0..3).map(|i| f64::from(hi[i]) - f64::from(lo[i])).fold(0.0, f64::max);
    // Vertices within rounding of the plane count as on it, and what is on it as above.
    let snap = size * 1e-7;
    let distance = |p: &[f32; 3]| {
        let d = dot(sub(p.map(f64::from), plane.point), normal);
        if d.abs() <= snap { 0.0 } else { d }
    };
    let distances: Vec<f64> = mesh.positions.iter().map(distance).collect();
    let is_above = |t: &[u32; 3]| t.iter().any(|&i| distances[i as usize] > 0.0);
    let is_below = |t: &[u32; 3]| t.iter().any(|&i| distances[i as usize] < 0.0);
    if !mesh.triangles.iter().any(is_below) {
        return Err(CutError::Misses("above it"));
    }
    if !mesh.triangles.iter().any(is_above) {
        return Err(CutError::Misses("below it"));
    }
    let mut halves = [Half::new(mesh), Half::new(mesh)];
    let mut outline = Vec::new();
    for triangle in &mesh.triangles {
        clip(mesh, triangle, &distances, &mut halves, &mut outline);
    }
    let cap = fill(&outline, plane.point, normal, size);
    let layout = Layout::new(mesh, &cap);
    let [above, below] = halves;
    let opposite = normal.map(|c| -c);
    Ok(Halves {
        above: above.close(&cap, opposite, true, &layout),
        below: below.close(&cap, normal, false, &layout),
    })
}

/// A point of the cut's outline with the vertex colour there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OutlinePoint {
    pub position: [f32; 3],
    pub color: [u8; 4],
}

/// One half while it grows: old vertices are copied when first used.
struct Half<'a> {
    source: &'a Mesh,
    mesh: Mesh,
    copies: FxHashMap<u32, u32>,
    crossings: FxHashMap<[u32; 2], u32>,
}

impl<'a> Half<'a> {
    fn new(source: &'a Mesh) -> Self {
        let mesh = Mesh {
            name: source.name.clone(),
            space_bounds: source.voxel_bounds(),
            notes: source.notes.clone(),
            ..Mesh::default()
        };
        Self { source, mesh, copies: FxHashMap::default(), crossings: FxHashMap::default() }
    }

    fn copy(&mut self, i: u32) -> u32 {
        if let Some(&copy) = self.copies.get(&i) {
            return copy;
        }
        let at = i as usize;
        let copy = self.mesh.positions.len() as u32;
        self.mesh.positions.push(self.source.positions[at]);
        self.mesh.normals.extend(self.source.normals.get(at));
        self.mesh.uvs.extend(self.source.uvs.get(at));
        self.mesh.colors.extend(self.source.colors.get(at));
        self.copies.insert(i, copy);
        copy
    }

    /// The vertex where edge i–j crosses the plane.
    fn crossing(&mut self, i: u32, j: u32, distances: &[f64]) -> u32 {
        let key = [i.min(j), i.max(j)];
        if let Some(&vertex) = self.crossings.get(&key) {
            return vertex;
        }
        let point = Crossing::new(self.source, i, j, distances);
        let vertex = self.mesh.positions.len() as u32;
        self.mesh.positions.push(point.position);
        if let (Some(a), Some(b)) = (self.source.normals.get(point.from), self.source.normals.get(point.to)) {
            let mixed: Vec3 = std::array::from_fn(|k| point.mix(a[k], b[k]));
            self.mesh.normals.push(unit(mixed).map_or(*a, |n| n.map(|c| c as f32)));
        }
        if let (Some(a), Some(b)) = (self.source.uvs.get(point.from), self.source.uvs.get(point.to)) {
            self.mesh.uvs.push(std::array::from_fn(|k| point.mix(a[k], b[k]) as f32));
        }
        if !self.source.colors.is_empty() {
            self.mesh.colors.push(point.color(self.source));
        }
        self.crossings.insert(key, vertex);
        vertex
    }

    /// Adds a triangle unless two of its corners coincide.
    fn add(&mut self, triangle: [u32; 3]) {
        let [a, b, c] = triangle.map(|i| self.mesh.positions[i as usize]);
        if a != b && b != c && c != a {
            self.mesh.triangles.push(triangle);
        }
    }

    /// Adds the cap and makes room for its chart.
    fn close(mut self, cap: &Cap, normal: Vec3, flip: bool, layout: &Layout) -> Mesh {
        for uv in &mut self.mesh.uvs {
            *uv = layout.old(*uv);
        }
        let first = self.mesh.positions.len() as u32;
        for (point, flat) in cap.points.iter().zip(&cap.flat) {
            self.mesh.positions.push(point.position);
            if !self.source.normals.is_empty() {
                self.mesh.normals.push(normal.map(|c| c as f32));
            }
            if !self.source.uvs.is_empty() {
                self.mesh.uvs.push(layout.cap(*flat));
            }
            if !self.source.colors.is_empty() {
                self.mesh.colors.push(point.color);
            }
        }
        for &[a, b, c] in &cap.triangles {
            let [b, c] = if flip { [c, b] } else { [b, c] };
            self.add([first + a, first + b, first + c]);
        }
        if !self.source.textures.is_empty() && !self.source.uvs.is_empty() {
            self.mesh.notes.push("dropped the textures, since the cut made room for its surface".to_owned());
        }
        self.mesh.notes.extend(cap.note.clone());
        self.mesh
    }
}

/// Where an edge crosses the plane, computed the same way whichever triangle asks.
struct Crossing {
    from: usize,
    to: usize,
    t: f64,
    position: [f32; 3],
}

impl Crossing {
    fn new(mesh: &Mesh, i: u32, j: u32, distances: &[f64]) -> Self {
        let key = |i: u32| mesh.positions[i as usize].map(|c| (c + 0.0).to_bits());
        let (from, to) = if key(i) <= key(j) { (i as usize, j as usize) } else { (j as usize, i as usize) };
        let (d0, d1) = (distances[from], distances[to]);
        let t = if d0 == 0.0 {
            0.0
        } else if d1 == 0.0 {
            1.0
        } else {
            d0 / (d0 - d1)
        };
        let (a, b) = (mesh.positions[from], mesh.positions[to]);
        let mut crossing = Self { from, to, t, position: a };
        crossing.position = if t == 0.0 {
            a
        } else if t == 1.0 {
            b
        } else {
            std::array::from_fn(|k| crossing.mix(a[k], b[k]) as f32)
        };
        crossing
    }

    fn mix(&self, a: f32, b: f32) -> f64 {
        f64::from(a) * (1.0 - self.t) + f64::from(b) * self.t
    }

    fn color(&self, mesh: &Mesh) -> [u8; 4] {
        match (mesh.colors.get(self.from), mesh.colors.get(self.to)) {
            (Some(a), Some(b)) => std::array::from_fn(|k| (self.mix(a[k].into(), b[k].into()) + 0.5) as u8),
            _ => [255; 4],
        }
    }
}

/// Hands the parts of a triangle to the halves and notes the edge at which it is cut.
fn clip(
    mesh: &Mesh,
    triangle: &[u32; 3],
    distances: &[f64],
    halves: &mut [Half<'_>; 2],
    outline: &mut Vec<[OutlinePoint; 2]>,
) {
    let above = triangle.map(|i| distances[i as usize] >= 0.0);
    let whole = above.iter().all(|&a| a == above[0]);
    let [upper, lower] = halves;
    if whole {
        let half = if above[0] { upper } else { lower };
        let copy = triangle.map(|i| half.copy(i));
        half.add(copy);
        return;
    }
    // Turned so that the first corner is alone on its side.
    let alone =
        (0..3).find(|&k| above[k] != above[(k + 1) % 3] && above[k] != above[(k + 2) % 3]).unwrap_or(0);
    let [a, b, c] = [0, 1, 2].map(|k| triangle[(alone + k) % 3]);
    let (one, two) = if above[alone] { (upper, lower) } else { (lower, upper) };
    let corner = one.copy(a);
    let (ab, ca) = (one.crossing(a, b, distances), one.crossing(c, a, distances));
    one.add([corner, ab, ca]);
    let (b2, c2) = (two.copy(b), two.copy(c));
    let (ab, ca) = (two.crossing(a, b, distances), two.crossing(c, a, distances));
    two.add([ab, b2, c2]);
    two.add([ab, c2, ca]);
    let point = |i, j| {
        let crossing = Crossing::new(mesh, i, j, distances);
        OutlinePoint { position: crossing.position, color: crossing.color(mesh) }
    };
    outline.push([point(a, b), point(c, a)]);
}

/// Where the old atlas and the cap's chart lie in the new one.
struct Layout {
    scale: f32,
    density: f64,
    corner: [f64; 2],
    turned: bool,
}

/// The share of the texture's side kept free around the cap's chart: 16 texels of 2048.
const MARGIN: f64 = 1.0 / 128.0;

impl Layout {
    fn new(mesh: &Mesh, cap: &Cap) -> Self {
        let (lo, hi) = cap.flat.iter().fold(([f64::MAX; 2], [f64::MIN; 2]), |(lo, hi), p| {
            (std::array::from_fn(|i| lo[i].min(p[i])), std::array::from_fn(|i| hi[i].max(p[i])))
        });
        let sides = [hi[0] - lo[0], hi[1] - lo[1]];
        let old = Self { scale: 1.0, density: 0.0, corner: [0.0; 2], turned: false };
        if cap.flat.is_empty() || mesh.uvs.is_empty() || !(sides[0].is_finite() && sides[1].is_finite()) {
            return old;
        }
        // The chart stands upright, so that its strip is narrow.
        let turned = sides[0] > sides[1];
        let (width, height) = if turned { (sides[1], sides[0]) } else { (sides[0], sides[1]) };
        let density = texel_density(mesh);
        let scale = ((1.0 - 2.0 * MARGIN) / (1.0 + width * density))
            .min((1.0 - 2.0 * MARGIN) / (height * density).max(1e-9));
        let scale = scale.clamp(1e-3, 1.0 - 2.0 * MARGIN);
        Self { scale: scale as f32, density: density * scale, corner: lo, turned }
    }

    fn old(&self, uv: [f32; 2]) -> [f32; 2] {
        uv.map(|c| c * self.scale)
    }

    fn cap(&self, flat: [f64; 2]) -> [f32; 2] {
        let [x, y] = [0, 1].map(|i| (flat[i] - self.corner[i]) * self.density);
        let [x, y] = if self.turned { [y, x] } else { [x, y] };
        [f64::from(self.scale) + MARGIN + x, MARGIN + y].map(|c| (c as f32).clamp(0.0, 1.0))
    }
}

/// Length in UV space of a unit of length on the surface, over the whole mesh.
fn texel_density(mesh: &Mesh) -> f64 {
    let (mut flat, mut solid) = (0.0, 0.0);
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize].map(f64::from));
        let n = cross(sub(b, a), sub(c, a));
        solid += dot(n, n).sqrt();
        let [a, b, c] = t.map(|i| mesh.uvs[i as usize].map(f64::from));
        flat += ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs();
    }
    let density = (flat / solid).sqrt();
    if density.is_finite() && density > 0.0 { density } else { 0.0 }
}
