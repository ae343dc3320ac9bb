//! A mesh made ready for drawing: valid triangles only, with normals at every corner.

use rustc_hash::FxHashMap;

use super::error::RenderError;
use super::vector::{Vec3, add, cross, dot, scale, sub, unit_or};
use crate::data::{Mesh, srgb_to_linear};

/// Faces that meet at less than this angle are shaded as one smooth surface, if the mesh has no normals:
/// the cosine of 45°.
const CREASE: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// The largest coordinate that is drawn; squares of it stay finite.
const FAR: f64 = 1e18;

/// What is drawn.
pub(super) struct Surface {
    /// Positions of the three corners of each triangle.
    pub corners: Vec<[Vec3; 3]>,
    /// Unit normals at the corners.
    pub normals: Vec<[Vec3; 3]>,
    /// Texture coordinates at the corners, or empty.
    pub uvs: Vec<[[f64; 2]; 3]>,
    /// Linear vertex colours at the corners, or empty.
    pub colors: Vec<[Vec3; 3]>,
}

impl Surface {
    /// The triangles of a mesh that have an area and lie within reach.
    ///
    /// # Errors
    /// [`RenderError::EmptyMesh`] if there are none.
    pub fn new(mesh: &Mesh) -> Result<Self, RenderError> {
        let position = |i: u32| {
            let p = mesh.positions.get(i as usize)?.map(f64::from);
            p.iter().all(|c| c.abs() < FAR).then_some(p)
        };
        let mut surface = Self { corners: vec![], normals: vec![], uvs: vec![], colors: vec![] };
        let mut drawn = Vec::new();
        for &triangle in &mesh.triangles {
            let [Some(a), Some(b), Some(c)] = triangle.map(position) else { continue };
            let area = cross(sub(b, a), sub(c, a));
            if dot(area, area) > 0.0 {
                drawn.push(triangle.map(|i| i as usize));
                surface.corners.push([a, b, c]);
            }
        }
        if drawn.is_empty() {
            return Err(RenderError::EmptyMesh(mesh.positions.len(), mesh.triangles.len()));
        }
        let count = mesh.positions.len();
        surface.normals = if mesh.normals.len() == count {
            let given = |i: usize| mesh.normals[i].map(f64::from);
            let faces = drawn.iter().zip(&surface.corners);
            faces.map(|(t, corners)| t.map(|i| unit_or(given(i), face_normal(corners)))).collect()
        } else {
            smooth_normals(&surface.corners)
        };
        if mesh.uvs.len() == count {
            surface.uvs = drawn.iter().map(|t| t.map(|i| mesh.uvs[i].map(f64::from))).collect();
        }
        if mesh.colors.len() == count {
            let linear = |i: usize| {
                let [r, g, b, _] = mesh.colors[i];
                [r, g, b].map(|c| f64::from(srgb_to_linear(c)))
            };
            surface.colors = drawn.iter().map(|t| t.map(linear)).collect();
        }
        Ok(surface)
    }

    /// All corners of all triangles.
    pub fn points(&self) -> impl Iterator<Item = Vec3> + Clone + '_ {
        self.corners.iter().flatten().copied()
    }
}

/// The unit normal of a triangle that has an area.
pub(super) fn face_normal([a, b, c]: &[Vec3; 3]) -> Vec3 {
    unit_or(cross(sub(*b, *a), sub(*c, *a)), [0.0, 1.0, 0.0])
}

/// Normals at the corners: of the faces around a position those within the crease angle, by area.
fn smooth_normals(corners: &[[Vec3; 3]]) -> Vec<[Vec3; 3]> {
    let mut faces_at: FxHashMap<[u64; 3], Vec<u32>> = FxHashMap::default();
    // Adding zero turns −0 into 0, which is the same position.
    let key = |p: Vec3| p.map(|c| (c + 0.0).to_bits());
    for (face, triangle) in corners.iter().enumerate() {
        for &corner in triangle {
            faces_at.entry(key(corner)).or_default().push(face as u32);
        }
    }
    let areas: Vec<Vec3> = corners.iter().map(|[a, b, c]| cross(sub(*b, *a), sub(*c, *a))).collect();
    let units: Vec<Vec3> = corners.iter().map(face_normal).collect();
    let normal = |face: usize, corner: Vec3| {
        let around = faces_at.get(&key(corner)).map_or(&[][..], Vec::as_slice);
        let near = around.iter().map(|&f| f as usize).filter(|&f| dot(units[f], units[face]) > CREASE);
        unit_or(near.fold([0.0; 3], |sum, f| add(sum, areas[f])), units[face])
    };
    corners.iter().enumerate().map(|(face, triangle)| triangle.map(|corner| normal(face, corner))).collect()
}

/// The weighted mean of three corners.
pub(super) fn blend(corners: &[Vec3; 3], weights: Vec3) -> Vec3 {
    let [a, b, c] = corners;
    add(add(scale(*a, weights[0]), scale(*b, weights[1])), scale(*c, weights[2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_triangles_are_left_out() {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [f32::NAN, 0.0, 0.0]];
        let triangles = vec![[0, 1, 2], [0, 1, 1], [0, 1, 9], [0, 1, 3]];
        let mesh = Mesh { positions, triangles, ..Mesh::default() };
        let surface = Surface::new(&mesh).unwrap();
        assert_eq!(surface.corners.len(), 1);
        assert_eq!(surface.normals, [[[0.0, 0.0, 1.0]; 3]]);
        assert!(matches!(Surface::new(&Mesh::default()), Err(RenderError::EmptyMesh(0, 0))));
    }

    #[test]
    fn a_right_angle_stays_sharp_and_a_flat_fold_becomes_smooth() {
        let normals = |tip: Vec3| {
            let (a, b) = ([0.0, 0.0, 0.0], [0.0, 0.0, -1.0]);
            smooth_normals(&[[a, [1.0, 0.0, 0.0], b], [b, tip, a]])
        };
        assert_eq!(normals([0.0, -1.0, 0.0])[0][0], [0.0, 1.0, 0.0]);
        let bent = normals([-1.0, -0.2, 0.0])[0][0];
        assert!(bent[0] < -0.05 && bent[1] > 0.9, "{bent:?}");
    }
}
