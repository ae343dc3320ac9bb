//! The interactive cut: a plane through a mesh. What lies beyond it is clipped while it is drawn, so that the cut follows the
//! pointer at once; the cap's outline and colours are found behind the window, coarse to fine.

use std::sync::Arc;

use breccia_nodes::data::{Mesh, Solid};
use breccia_nodes::mesh::{CutError, Plane, cut_mesh};
use breccia_shaders::Gpu;
use eframe::egui::{self, Rect, Ui};

use super::geometry::{Geometry, Placement, WHITE, of_mesh, outline};
use super::gpu_parts::{Material, PLAIN, Shape};
use super::handle::{COLORS, Handle};
use super::on_mesh::{Baking, bake_passes};
use super::pixels::Pixels;
use super::renderer::Renderer;
use super::stage::{Props, Stage};
use super::vector::{Vec3, across, add, dot, scale};
use super::worker::{Job, Worker};

/// A plane in the ball; what lies beyond `dot(normal, p) = distance` is cut off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutPlane {
    /// Unit length.
    pub normal: Vec3,
    /// From the origin.
    pub distance: f32,
}

/// What a cap is made for.
#[derive(Clone)]
pub struct Wanted {
    /// The mesh and its version.
    pub mesh: (u64, Arc<Mesh>),
    /// The solid and its version.
    pub solid: (u64, Arc<dyn Solid>),
    /// How the surface is baked; the cap is as fine.
    pub baking: Baking,
    /// The map that is shown.
    pub map: String,
}

type Key = (u64, u64, Baking, String, CutPlane);

struct Made {
    geometry: Option<Geometry>,
    pixels: Pixels,
}

/// The cut.
pub struct Cut {
    /// Whether there is one.
    pub on: bool,
    /// Where the normal points: degrees to the right of the first view's depth.
    pub turn: f32,
    /// And degrees upwards.
    pub tilt: f32,
    /// Where the plane lies along the normal, in the ball.
    pub depth: f32,
    /// Whether the other side is kept.
    pub flipped: bool,
    worker: Worker<Key, Made>,
    cap: Option<(CutPlane, Option<Shape>, Material)>,
}

impl Cut {
    /// No cut yet; the first one opens the side that is seen.
    pub fn new(gpu: Option<&Arc<Gpu>>) -> Self {
        Self {
            on: false,
            turn: 120.0,
            tilt: 10.0,
            depth: 0.05,
            flipped: false,
            worker: Worker::new("cap", gpu.cloned()),
            cap: None,
        }
    }

    /// Along what the plane is moved.
    fn direction(&self) -> Vec3 {
        let ((sin, cos), (sin_t, cos_t)) =
            (self.turn.to_radians().sin_cos(), self.tilt.to_radians().sin_cos());
        [sin * cos_t, sin_t, cos * cos_t]
    }

    /// The plane, its normal to what is cut off.
    pub fn plane(&self) -> CutPlane {
        let normal = self.direction();
        if self.flipped {
            CutPlane { normal: scale(normal, -1.0), distance: -self.depth }
        } else {
            CutPlane { normal, distance: self.depth }
        }
    }

    /// Asks for the cap, unless it is known or on its way; takes in what has come.
    pub fn update(
        &mut self,
        ctx: &egui::Context,
        renderer: &Renderer,
        placement: Placement,
        wanted: Option<&Wanted>,
    ) {
        let Some(wanted) = wanted else {
            if self.worker.key().is_some() {
                self.worker.cancel();
            }
            self.cap = None;
            return;
        };
        let plane = self.plane();
        let key = (wanted.mesh.0, wanted.solid.0, wanted.baking, wanted.map.clone(), plane);
        // A new solid on the same plane keeps the old cap until the new one comes.
        let kept = self.worker.key().is_some_and(|last| last.0 == wanted.mesh.0 && last.4 == plane);
        let work = wanted.clone();
        if self.worker.want(ctx, key, move |job| make(&work, placement, plane, job)) && !kept {
            self.cap = None;
        }
        for made in self.worker.poll() {
            let shape = match made.geometry {
                Some(geometry) => Shape::new(renderer.device(), &geometry),
                None => self.cap.take().and_then(|(_, shape, _)| shape),
            };
            self.cap = Some((plane, shape, renderer.material(&made.pixels, PLAIN)));
        }
    }

    /// Adds the plane and the cap to what is drawn.
    pub fn add(&self, props: &mut Props) {
        let plane = self.plane();
        props.clip = Some((plane.normal, plane.distance));
        if let Some((made_for, Some(shape), material)) = &self.cap
            && *made_for == plane
        {
            props.parts.push((shape.clone(), material.clone()));
        }
        let foot = scale(plane.normal, plane.distance);
        let [right, up] = across(plane.normal);
        let corner = |a: f32, b: f32| add(foot, add(scale(right, a), scale(up, b)));
        let corners = [corner(-0.95, -0.95), corner(0.95, -0.95), corner(0.95, 0.95), corner(-0.95, 0.95)];
        props.lines.extend(outline(&corners, [240, 184, 72, 255]));
    }

    /// Shows a handle that moves the plane, and two that tilt it.
    pub fn handles(&mut self, ui: &Ui, rect: Rect, stage: &Stage) {
        /// How far from the middle the handles that tilt lie.
        const ARM: f32 = 0.8;
        let normal = self.direction();
        let foot = scale(normal, self.depth);
        let ((sin, cos), (sin_t, cos_t)) =
            (self.turn.to_radians().sin_cos(), self.tilt.to_radians().sin_cos());
        let sideways = [cos, 0.0, -sin];
        let upwards = [-sin * sin_t, cos_t, -cos * sin_t];
        let color = COLORS[3];
        let drag = |label, at, name: &str| {
            let handle = Handle { label, at, along: normal, color };
            handle.show(ui, ui.id().with(("cut", name)), &stage.camera, rect)
        };
        if let Some(by) = drag("Move the cut", foot, "depth") {
            self.depth = (self.depth + by).clamp(-1.0, 1.0);
        }
        if let Some(by) = drag("Turn the cut", add(foot, scale(sideways, ARM)), "turn") {
            let degrees = (by / ARM).to_degrees() / cos_t.abs().max(0.2);
            self.turn = (self.turn - degrees + 180.0).rem_euclid(360.0) - 180.0;
        }
        if let Some(by) = drag("Tilt the cut", add(foot, scale(upwards, ARM)), "tilt") {
            self.tilt = (self.tilt - (by / ARM).to_degrees()).clamp(-90.0, 90.0);
        }
    }

    /// Gives up what is on its way.
    pub fn rest(&mut self) {
        self.worker.rest();
    }

    /// Whether a finer cap is on its way.
    pub fn is_running(&self) -> bool {
        self.worker.is_running()
    }

    /// What went wrong.
    pub fn error(&self) -> Option<&str> {
        self.worker.error()
    }
}

fn make(wanted: &Wanted, placement: Placement, plane: CutPlane, job: &Job<Made>) -> Result<(), String> {
    let Some(cap) = cap(&wanted.mesh.1, placement, plane)? else {
        return Ok(());
    };
    let geometry = std::cell::Cell::new(Some(of_mesh(&cap, placement, Some(WHITE))));
    bake_passes(&cap, &*wanted.solid.1, wanted.baking, &wanted.map, job, |pixels| {
        job.send(Made { geometry: geometry.take(), pixels });
    })
}

/// The surface that the plane opens, with texture coordinates in the plane; `None` where the plane misses the mesh.
///
/// # Errors
/// If the mesh is damaged.
pub fn cap(mesh: &Mesh, placement: Placement, plane: CutPlane) -> Result<Option<Mesh>, String> {
    let point = placement.back(scale(plane.normal, plane.distance));
    let normal = plane.normal.map(f64::from);
    // The outside is drawn from the whole mesh, so its attributes need not be cut.
    let bare = Mesh {
        positions: mesh.positions.clone(),
        triangles: mesh.triangles.clone(),
        space_bounds: mesh.voxel_bounds(),
        ..Mesh::default()
    };
    let half = match cut_mesh(&bare, Plane { point, normal }) {
        Ok(halves) => halves.below,
        Err(CutError::Misses(_)) => return Ok(None),
        Err(error) => return Err(error.to_string()),
    };
    let [right, up] = across(plane.normal);
    let placed: Vec<Vec3> = half.positions.iter().map(|p| placement.place(p.map(f64::from))).collect();
    let on_plane = |i: &u32| {
        placed.get(*i as usize).is_some_and(|p| (dot(*p, plane.normal) - plane.distance).abs() < 2e-5)
    };
    let triangles: Vec<[u32; 3]> =
        half.triangles.iter().filter(|t| t.iter().all(on_plane)).copied().collect();
    let mut cap = Mesh { space_bounds: half.space_bounds, ..Mesh::default() };
    let mut flat = Vec::new();
    let mut copies = std::collections::HashMap::new();
    for triangle in triangles {
        let corners = triangle.map(|i| {
            *copies.entry(i).or_insert_with(|| {
                let position = half.positions.get(i as usize).copied().unwrap_or_default();
                let p = placed.get(i as usize).copied().unwrap_or_default();
                cap.positions.push(position);
                cap.normals.push(plane.normal);
                flat.push([dot(p, right), -dot(p, up)]);
                cap.positions.len() as u32 - 1
            })
        });
        cap.triangles.push(corners);
    }
    if cap.triangles.is_empty() {
        return Ok(None);
    }
    // The square that holds the cap, with room for a texel's width at the border.
    let low: [f32; 2] = std::array::from_fn(|i| flat.iter().fold(f32::INFINITY, |m, p| m.min(p[i])));
    let high: [f32; 2] = std::array::from_fn(|i| flat.iter().fold(f32::NEG_INFINITY, |m, p| m.max(p[i])));
    let side = (high[0] - low[0]).max(high[1] - low[1]).max(1e-9);
    cap.uvs = flat.iter().map(|p| std::array::from_fn(|i| 0.01 + 0.98 * (p[i] - low[i]) / side)).collect();
    Ok(Some(cap))
}

#[cfg(test)]
mod tests {
    use breccia_nodes::data::Filter;
    use breccia_nodes::mesh::{BakeSettings, Space, bake_solid};
    use breccia_nodes::solid::{CheckerSolid, Plane as SlicePlane, slice};

    use super::*;
    use crate::run::Fit;

    /// A box from 0 to 2, 1 and 1.
    fn brick() -> Mesh {
        let positions =
            (0..8).map(|i| [2.0 * (i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32]).collect();
        let triangles = vec![
            [0, 2, 1],
            [1, 2, 3],
            [4, 5, 6],
            [5, 7, 6],
            [0, 1, 4],
            [1, 5, 4],
            [2, 6, 3],
            [3, 6, 7],
            [0, 4, 2],
            [2, 4, 6],
            [1, 3, 5],
            [3, 7, 5],
        ];
        Mesh { positions, triangles, ..Mesh::default() }
    }

    #[test]
    fn the_cap_of_a_baked_mesh_shows_what_a_slice_of_its_solid_shows() {
        let solid = CheckerSolid { colors: [[200, 30, 20], [10, 60, 220]], cell: 4, noise: 10, seed: 5 };
        let fit = Fit { resolution: 40, origin: [-13, 7, 102], filter: Filter::Trilinear };
        let settings = BakeSettings {
            resolution: fit.resolution,
            origin: fit.origin,
            texture_size: 64,
            ..BakeSettings::default()
        };
        let mesh = bake_solid(&brick(), &solid, settings, &()).unwrap();
        let placement = Placement::of_mesh(&mesh);
        // Across x at 0.7 of 2.
        let distance = placement.place([0.7, 0.0, 0.0])[0];
        let plane = CutPlane { normal: [1.0, 0.0, 0.0], distance };
        let cap = cap(&mesh, placement, plane).unwrap().unwrap();
        assert!(cap.positions.iter().all(|p| (p[0] - 0.7).abs() < 1e-5));
        let baking = Baking { fit, finest: 128 };
        let passes = std::cell::RefCell::new(Vec::new());
        bake_passes(&cap, &solid, baking, "color", &(), |pixels| passes.borrow_mut().push(pixels)).unwrap();
        let passes = passes.into_inner();
        let pixels = passes.last().unwrap();
        let space = Space::of_mesh(&brick(), fit.resolution, fit.origin).unwrap();
        // For texels all over the cap: the point that each shows, found from three corners of the cap.
        let corner = |i: usize| (cap.positions[i].map(f64::from), cap.uvs[i].map(f64::from));
        let [a, b, c] = cap.triangles[0].map(|i| corner(i as usize));
        let solve = |uv: [f64; 2]| -> [f64; 3] {
            let (e, f) = ([b.1[0] - a.1[0], b.1[1] - a.1[1]], [c.1[0] - a.1[0], c.1[1] - a.1[1]]);
            let d = [uv[0] - a.1[0], uv[1] - a.1[1]];
            let det = e[0] * f[1] - e[1] * f[0];
            let (s, t) = ((d[0] * f[1] - d[1] * f[0]) / det, (e[0] * d[1] - e[1] * d[0]) / det);
            std::array::from_fn(|i| a.0[i] + s * (b.0[i] - a.0[i]) + t * (c.0[i] - a.0[i]))
        };
        for (x, y) in [(20u32, 30u32), (64, 64), (100, 90), (33, 110), (90, 12)] {
            let point = space.to_voxels(solve([(f64::from(x) + 0.5) / 128.0, (f64::from(y) + 0.5) / 128.0]));
            let at = SlicePlane { center: point, right: [0.0, 1.0, 0.0], down: [0.0, 0.0, 1.0] };
            let expected = slice(&solid, &at, [1, 1], Filter::Trilinear, "color", &()).unwrap().rgb8(0, 0);
            let found = &pixels.levels[0][4 * (y as usize * 128 + x as usize)..][..3];
            // The texel's place is found in floats here and there.
            let gap = found.iter().zip(expected).map(|(a, b)| a.abs_diff(b)).max().unwrap();
            assert!(gap <= 6, "texel {x} {y}: {found:?} for {expected:?}");
        }
    }

    #[test]
    fn a_plane_that_misses_opens_nothing() {
        let mesh = brick();
        let placement = Placement::of_mesh(&mesh);
        let plane = CutPlane { normal: [0.0, 1.0, 0.0], distance: 0.9 };
        assert_eq!(cap(&mesh, placement, plane), Ok(None));
        let damaged = Mesh { triangles: vec![[0, 1, 99]], ..brick() };
        assert!(cap(&damaged, placement, CutPlane { distance: 0.0, ..plane }).is_err());
    }

    #[test]
    fn the_other_side_is_the_same_plane() {
        let mut cut = Cut::new(None);
        let plane = cut.plane();
        cut.flipped = true;
        let other = cut.plane();
        assert_eq!(scale(plane.normal, plane.distance), scale(other.normal, other.distance));
        assert!((dot(plane.normal, other.normal) + 1.0).abs() < 1e-6);
    }
}
