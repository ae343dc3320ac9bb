//! Triangles and lines as the renderer takes them.

use breccia_nodes::data::Mesh;
use breccia_nodes::mesh::smooth_normals;
use bytemuck::{Pod, Zeroable};

#[cfg(test)]
use super::vector::sub;
use super::vector::{Vec3, cross, unit_or};

/// The grey of what has no colour of its own.
pub const CLAY: [u8; 4] = [168, 166, 162, 255];
/// No tint.
pub const WHITE: [u8; 4] = [255; 4];

/// A corner of a triangle, or an end of a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Vertex {
    /// Where it is.
    pub position: [f32; 3],
    /// Unit normal; zero faces the viewer.
    pub normal: [f32; 3],
    /// Texture coordinates.
    pub uv: [f32; 2],
    /// sRGB and alpha.
    pub color: [u8; 4],
}

/// Triangles that share vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Geometry {
    /// The vertices.
    pub vertices: Vec<Vertex>,
    /// Three a triangle.
    pub indices: Vec<u32>,
}

impl Geometry {
    /// Adds a flat quadrilateral from a corner and two edges; the texture's first pixel lies at the corner, rows run along `right`.
    /// `uv` is the rectangle of the texture, as two corners.
    pub fn quad(&mut self, corner: Vec3, right: Vec3, down: Vec3, uv: [[f32; 2]; 2], color: [u8; 4]) {
        let first = self.vertices.len() as u32;
        let normal = unit_or(cross(down, right), [0.0; 3]);
        for [a, b] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
            let position = std::array::from_fn(|i| corner[i] + a * right[i] + b * down[i]);
            let at = |i: usize, t: f32| uv[0][i] + t * (uv[1][i] - uv[0][i]);
            self.vertices.push(Vertex { position, normal, uv: [at(0, a), at(1, b)], color });
        }
        self.indices.extend([0, 3, 2, 0, 2, 1].map(|i| first + i));
    }
}

/// How a mesh is laid into the ball of radius 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// What comes to lie at the origin.
    pub center: [f64; 3],
    /// How much it is enlarged.
    pub scale: f64,
}

impl Placement {
    /// Fits a box into the ball.
    pub fn of_box(low: [f64; 3], high: [f64; 3]) -> Self {
        let center = std::array::from_fn(|i| (low[i] + high[i]) / 2.0);
        let half: f64 = (0..3).map(|i| ((high[i] - low[i]) / 2.0).powi(2)).sum();
        let scale = 1.0 / half.sqrt();
        Self { center, scale: if scale.is_finite() { scale } else { 1.0 } }
    }

    /// Fits a mesh, by its bounding box.
    pub fn of_mesh(mesh: &Mesh) -> Self {
        let (low, high) = mesh.bounds().unwrap_or(([-1.0; 3], [1.0; 3]));
        Self::of_box(low.map(f64::from), high.map(f64::from))
    }

    /// Where a point comes to lie.
    pub fn place(&self, point: [f64; 3]) -> Vec3 {
        std::array::from_fn(|i| ((point[i] - self.center[i]) * self.scale) as f32)
    }

    /// The inverse.
    pub fn back(&self, point: Vec3) -> [f64; 3] {
        std::array::from_fn(|i| f64::from(point[i]) / self.scale + self.center[i])
    }
}

/// The triangles of a mesh, laid into the ball. Vertex colours count only where `color` gives none.
pub fn of_mesh(mesh: &Mesh, placement: Placement, color: Option<[u8; 4]>) -> Geometry {
    let count = mesh.positions.len();
    let made;
    let normals = if mesh.normals.len() == count {
        &mesh.normals
    } else {
        made = smooth_normals(&mesh.positions, &mesh.triangles);
        &made
    };
    let vertices = mesh.positions.iter().enumerate().map(|(i, p)| Vertex {
        position: placement.place(p.map(f64::from)),
        normal: normals.get(i).copied().unwrap_or_default(),
        uv: mesh.uvs.get(i).copied().unwrap_or_default(),
        color: color.or_else(|| mesh.colors.get(i).copied()).unwrap_or(CLAY),
    });
    let inside = |t: &&[u32; 3]| t.iter().all(|&i| (i as usize) < count);
    Geometry {
        vertices: vertices.collect(),
        indices: mesh.triangles.iter().filter(inside).flatten().copied().collect(),
    }
}

/// The twelve edges of a box as ends of lines.
pub fn box_lines(low: Vec3, high: Vec3, color: [u8; 4]) -> Vec<Vertex> {
    let corner = |i: usize| std::array::from_fn(|a| if i >> a & 1 == 1 { high[a] } else { low[a] });
    let edges =
        (0..8usize).flat_map(|i| (0..3).filter(move |a| i >> a & 1 == 0).map(move |a| [i, i | 1 << a]));
    edges.flatten().map(|i| Vertex { position: corner(i), color, ..Vertex::default() }).collect()
}

/// A closed outline as ends of lines.
pub fn outline(points: &[Vec3], color: [u8; 4]) -> Vec<Vertex> {
    let next = points.iter().cycle().skip(1);
    let ends = points.iter().zip(next).flat_map(|(&a, &b)| [a, b]);
    ends.map(|position| Vertex { position, color, ..Vertex::default() }).collect()
}

/// The normal of a triangle, not of unit length.
#[cfg(test)]
pub fn face_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    cross(sub(b, a), sub(c, a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quad_faces_where_its_texture_is_read_upright() {
        let mut geometry = Geometry::default();
        geometry.quad([0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [[0.0; 2], [1.0; 2]], WHITE);
        let corners: Vec<Vec3> =
            geometry.indices.iter().map(|&i| geometry.vertices[i as usize].position).collect();
        for triangle in corners.chunks_exact(3) {
            let normal = face_normal([triangle[0], triangle[1], triangle[2]]);
            assert!(normal[2] > 0.0, "{normal:?}");
        }
        assert_eq!(geometry.vertices[0].normal, [0.0, 0.0, 1.0]);
    }

    #[test]
    fn a_placed_mesh_lies_in_the_ball_and_comes_back() {
        let placement = Placement::of_box([1.0, 2.0, 3.0], [5.0, 3.0, 9.0]);
        let corner = placement.place([5.0, 3.0, 9.0]);
        assert!((corner.iter().map(|c| c * c).sum::<f32>() - 1.0).abs() < 1e-5);
        let back = placement.back(corner);
        assert!(back.iter().zip([5.0, 3.0, 9.0]).all(|(a, b)| (a - b).abs() < 1e-5));
        assert_eq!(Placement::of_box([1.0; 3], [1.0; 3]).scale, 1.0);
    }

    #[test]
    fn damaged_meshes_are_drawn_as_far_as_they_go() {
        let mesh = Mesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 1, 7]],
            ..Mesh::default()
        };
        let geometry = of_mesh(&mesh, Placement::of_mesh(&mesh), None);
        assert_eq!(geometry.indices, [0, 1, 2]);
    }
}
