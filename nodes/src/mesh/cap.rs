//! The surface inside the outline of a cut: a constrained Delaunay triangulation whose faces count as inside
//! if an odd number of outline edges lies between them and the outside. Holes, islands in holes and outlines
//! that cross themselves need no special case.

use std::collections::VecDeque;

use rustc_hash::FxHashMap;
use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

use super::cut::OutlinePoint;
use super::vector::{Vec3, cross, dot, sub, unit};

/// A triangulated cap.
#[derive(Debug, Default)]
pub(super) struct Cap {
    /// Corners: the outline's points, and those where outlines cross.
    pub points: Vec<OutlinePoint>,
    /// The same in the plane's own two axes, in world units.
    pub flat: Vec<[f64; 2]>,
    /// Counter-clockwise seen from where the plane's normal points.
    pub triangles: Vec<[u32; 3]>,
    /// What was done to an outline that is not closed.
    pub note: Option<String>,
}

struct Vertex {
    at: Point2<f64>,
    point: Option<u32>,
}

impl HasPosition for Vertex {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.at
    }
}

/// Fills an outline given as edges in any order; open chains are closed by straight edges.
pub(super) fn fill(outline: &[[OutlinePoint; 2]], origin: Vec3, normal: Vec3, size: f64) -> Cap {
    let mut cap = Cap::default();
    let Some((right, up)) = axes(normal) else { return cap };
    let mut ids = FxHashMap::default();
    let mut id_of = |point: &OutlinePoint, cap: &mut Cap| -> u32 {
        let key = point.position.map(|c| (c + 0.0).to_bits());
        *ids.entry(key).or_insert_with(|| {
            let offset = sub(point.position.map(f64::from), origin);
            cap.points.push(*point);
            cap.flat.push([dot(offset, right), dot(offset, up)]);
            cap.points.len() as u32 - 1
        })
    };
    // Edges run an even number of times cancel out.
    let mut counts: FxHashMap<[u32; 2], usize> = FxHashMap::default();
    for [a, b] in outline {
        let (a, b) = (id_of(a, &mut cap), id_of(b, &mut cap));
        if a != b {
            *counts.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    let mut edges: Vec<[u32; 2]> =
        counts.into_iter().filter(|&(_, n)| n % 2 == 1).map(|(edge, _)| edge).collect();
    edges.sort_unstable();
    let gaps = close_chains(&mut edges, &cap.flat);
    if gaps > 0 {
        cap.note = Some(format!(
            "the mesh is open where it was cut; closed {gaps} gaps of the cut by straight edges"
        ));
    }
    triangulate(&mut cap, &edges, size, |[x, y]| {
        std::array::from_fn(|i| (origin[i] + right[i] * x + up[i] * y) as f32)
    });
    cap
}

/// Two unit vectors that span the plane, so that right × up is the normal.
fn axes(normal: Vec3) -> Option<(Vec3, Vec3)> {
    let least = (0..3).min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs()))?;
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let right = unit(cross(axis, normal))?;
    Some((right, cross(normal, right)))
}

/// Joins ends of open chains, the nearest first; returns how many edges were added.
fn close_chains(edges: &mut Vec<[u32; 2]>, flat: &[[f64; 2]]) -> usize {
    let mut degree = vec![0usize; flat.len()];
    edges.iter().flatten().for_each(|&i| degree[i as usize] += 1);
    let mut ends: Vec<u32> = (0..flat.len() as u32).filter(|&i| degree[i as usize] % 2 == 1).collect();
    let mut added = 0;
    let far = |a: u32, b: u32| {
        let [dx, dy] = [0, 1].map(|i| flat[a as usize][i] - flat[b as usize][i]);
        dx * dx + dy * dy
    };
    while let Some(end) = ends.pop() {
        let Some(nearest) = (0..ends.len()).min_by(|&a, &b| far(end, ends[a]).total_cmp(&far(end, ends[b])))
        else {
            break;
        };
        let other = ends.remove(nearest);
        let edge = [end.min(other), end.max(other)];
        // An edge that is there already would cancel out.
        match edges.binary_search(&edge) {
            Ok(at) => drop(edges.remove(at)),
            Err(at) => edges.insert(at, edge),
        }
        added += 1;
    }
    added
}

fn triangulate(cap: &mut Cap, edges: &[[u32; 2]], size: f64, to_world: impl Fn([f64; 2]) -> [f32; 3]) {
    let scale = if size > 0.0 && size.is_finite() { 1.0 / size } else { 1.0 };
    let mut cdt = ConstrainedDelaunayTriangulation::<Vertex>::new();
    let mut handles: Vec<Option<FixedVertexHandle>> = Vec::with_capacity(cap.flat.len());
    for (i, p) in cap.flat.iter().enumerate() {
        // Below this the triangulation's exact predicates would lose bits.
        let [x, y] = p.map(|c| if (c * scale).abs() < 1e-30 { 0.0 } else { c * scale });
        handles.push(cdt.insert(Vertex { at: Point2::new(x, y), point: Some(i as u32) }).ok());
    }
    for &[a, b] in edges {
        if let (Some(a), Some(b)) = (handles[a as usize], handles[b as usize])
            && a != b
        {
            cdt.add_constraint_and_split(a, b, |at| Vertex { at, point: None });
        }
    }
    // Vertices where outlines cross become points of their own.
    let mut points = Vec::with_capacity(cdt.num_vertices());
    for vertex in cdt.vertices() {
        let data = vertex.data();
        points.push(data.point.unwrap_or_else(|| {
            let flat = [data.at.x / scale, data.at.y / scale];
            cap.flat.push(flat);
            cap.points.push(OutlinePoint { position: to_world(flat), color: [128, 128, 128, 255] });
            cap.points.len() as u32 - 1
        }));
    }
    let mut inside: Vec<Option<bool>> = vec![None; cdt.num_all_faces()];
    let mut pending = VecDeque::from([(cdt.outer_face().fix(), false)]);
    inside[0] = Some(false);
    while let Some((face, is_inside)) = pending.pop_front() {
        let neighbours: Vec<_> = match cdt.face(face).as_inner() {
            Some(inner) => inner.adjacent_edges().to_vec(),
            None => cdt.convex_hull().collect(),
        };
        for edge in neighbours {
            // The hull's edges have the outer face on their own side.
            for side in [edge, edge.rev()] {
                let next = side.face().fix();
                if let Some(slot @ None) = inside.get_mut(next.index()) {
                    let next_inside = is_inside != edge.is_constraint_edge();
                    *slot = Some(next_inside);
                    pending.push_back((next, next_inside));
                }
            }
        }
    }
    for face in cdt.inner_faces() {
        if inside.get(face.fix().index()).copied().flatten() == Some(true) {
            cap.triangles.push(face.vertices().map(|vertex| points[vertex.fix().index()]));
        }
    }
}
