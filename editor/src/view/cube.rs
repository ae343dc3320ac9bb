//! A box of a solid with a corner cut out that can be dragged.

use std::sync::Arc;

use breccia_shaders::Gpu;
use eframe::egui::{Rect, Ui};

use super::faces::{Face, Faces, Source, blank, part, placement, world};
use super::geometry::{Geometry, Placement};
use super::gpu_parts::{Material, Shape};
use super::handle::{COLORS, Handle};
use super::stage::{Props, Stage};

/// What the shapes were made for.
type Laid = ([f64; 3], ([i32; 3], [u32; 3]));

/// The cube.
pub struct Cube {
    /// The cut's corner as fractions of the edges along x, y and z.
    pub corner: [f64; 3],
    outer: Faces,
    inner: [Faces; 3],
    shapes: Vec<(Option<Shape>, Place)>,
    laid: Option<Laid>,
    blank: Option<Material>,
}

/// Which texture a shape has.
#[derive(Clone, Copy)]
enum Place {
    Outer(usize),
    Inner(usize),
}

impl Cube {
    /// A cube with an eighth cut out.
    pub fn new(gpu: Option<&Arc<Gpu>>) -> Self {
        let faces = || Faces::new(gpu.cloned());
        Self {
            corner: [0.5; 3],
            outer: faces(),
            inner: [faces(), faces(), faces()],
            shapes: Vec::new(),
            laid: None,
            blank: None,
        }
    }

    /// Updates, and says what is to be drawn.
    pub fn props(&mut self, ui: &Ui, stage: &Stage, source: &Source) -> Props {
        let (ctx, renderer) = (ui.ctx(), &stage.renderer);
        let (outer, inner) = faces_of(source.shown, self.corner);
        self.outer.update(ctx, renderer, source, &outer);
        for (faces, face) in self.inner.iter_mut().zip(&inner) {
            faces.update(ctx, renderer, source, std::slice::from_ref(face));
        }
        let placement = placement(source.shown);
        if self.laid != Some((self.corner, source.shown)) {
            self.laid = Some((self.corner, source.shown));
            let lay = |geometry: &Geometry| Shape::new(renderer.device(), geometry);
            self.shapes = shapes(&outer, &inner, source.shown, self.corner, &placement)
                .into_iter()
                .map(|(geometry, place)| (lay(&geometry), place))
                .collect();
        }
        let blank = self.blank.get_or_insert_with(|| blank(renderer));
        let material = |place: Place| match place {
            Place::Outer(i) => self.outer.material(i),
            Place::Inner(i) => self.inner.get(i).and_then(|faces| faces.material(0)),
        };
        let parts = self
            .shapes
            .iter()
            .filter_map(|(shape, place)| Some((shape.clone()?, material(*place).unwrap_or(blank).clone())));
        Props { parts: parts.collect(), ..Props::default() }
    }

    /// Shows the three handles of the corner.
    pub fn handles(&mut self, ui: &Ui, rect: Rect, stage: &Stage, shown: ([i32; 3], [u32; 3])) {
        let placement = placement(shown);
        let (origin, size) = shown;
        let at = |i: usize, t: f64| f64::from(origin[i]) + t * f64::from(size[i]);
        let [x, y, z] = self.corner;
        // The middle of each inner face.
        let middles = [[x, y / 2.0, z / 2.0], [(1.0 + x) / 2.0, y, z / 2.0], [(1.0 + x) / 2.0, y / 2.0, z]];
        let names = ["Move the cut along x", "Move the cut along y", "Move the cut along z"];
        let directions = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
        for axis in 0..3 {
            let place = world(&placement, std::array::from_fn(|i| at(i, middles[axis][i])));
            let handle =
                Handle { label: names[axis], at: place, along: directions[axis], color: COLORS[axis] };
            let id = ui.id().with(("cube", axis));
            if let Some(by) = handle.show(ui, id, &stage.camera, rect) {
                let voxels = f64::from(by) / placement.scale / f64::from(size[axis].max(1));
                self.corner[axis] = (self.corner[axis] + voxels).clamp(0.0, 1.0);
            }
        }
    }

    /// Gives up what is on its way.
    pub fn rest(&mut self) {
        self.outer.rest();
        self.inner.iter_mut().for_each(Faces::rest);
    }

    /// Whether finer textures are on their way.
    pub fn is_running(&self) -> bool {
        self.outer.is_running() || self.inner.iter().any(Faces::is_running)
    }

    /// What went wrong.
    pub fn error(&self) -> Option<&str> {
        self.outer.error().or_else(|| self.inner.iter().find_map(Faces::error))
    }
}

/// The six outer faces and the three of the cut.
fn faces_of((origin, size): ([i32; 3], [u32; 3]), corner: [f64; 3]) -> (Vec<Face>, [Face; 3]) {
    let low = origin.map(f64::from);
    let high: [f64; 3] = std::array::from_fn(|i| low[i] + f64::from(size[i]));
    let cut: [f64; 3] = std::array::from_fn(|i| (low[i] + corner[i] * f64::from(size[i])).round());
    let face = |axis: usize, at: f64, from: [f64; 3], to: [f64; 3]| {
        let [c, r] = super::faces::columns_and_rows(axis);
        Face { axis, at, from: [from[c], from[r]], to: [to[c], to[r]] }
    };
    let outer = (0..3).flat_map(|axis| [face(axis, low[axis], low, high), face(axis, high[axis], low, high)]);
    // What is cut out: towards larger x, smaller y and smaller z.
    let (from, to) = ([cut[0], low[1], low[2]], [high[0], cut[1], cut[2]]);
    (outer.collect(), std::array::from_fn(|axis| face(axis, cut[axis], from, to)))
}

/// The triangles of all faces; those that the cut opens lack its rectangle.
fn shapes(
    outer: &[Face],
    inner: &[Face; 3],
    (origin, size): ([i32; 3], [u32; 3]),
    corner: [f64; 3],
    placement: &Placement,
) -> Vec<(Geometry, Place)> {
    let cut: [f64; 3] =
        std::array::from_fn(|i| (f64::from(origin[i]) + corner[i] * f64::from(size[i])).round());
    let mut out = Vec::new();
    for (i, face) in outer.iter().enumerate() {
        let mut geometry = Geometry::default();
        let Face { from, to, .. } = *face;
        match i {
            // The last across x, the first across y, the first across z.
            1 => {
                face.add(&mut geometry, placement, [cut[1], from[1]], to);
                face.add(&mut geometry, placement, [from[0], cut[2]], [cut[1], to[1]]);
            }
            2 | 4 => {
                let row = if i == 2 { cut[2] } else { cut[1] };
                face.add(&mut geometry, placement, from, [cut[0], to[1]]);
                face.add(&mut geometry, placement, [cut[0], row], to);
            }
            _ => face.add(&mut geometry, placement, from, to),
        }
        out.push((geometry, Place::Outer(i)));
    }
    for (i, face) in inner.iter().enumerate() {
        let mut geometry = Geometry::default();
        face.add(&mut geometry, placement, face.from, face.to);
        out.push((geometry, Place::Inner(i)));
    }
    out
}

/// Three planes across the axes of a box, each dragged along its normal.
pub struct Planes {
    /// Where each lies, as a fraction of the edge.
    pub at: [f64; 3],
    faces: [Faces; 3],
    parts: [Option<Shape>; 3],
    laid: Option<Laid>,
    blank: Option<Material>,
}

impl Planes {
    /// Planes through the middle.
    pub fn new(gpu: Option<&Arc<Gpu>>) -> Self {
        let faces = || Faces::new(gpu.cloned());
        Self {
            at: [0.5; 3],
            faces: [faces(), faces(), faces()],
            parts: [None, None, None],
            laid: None,
            blank: None,
        }
    }

    /// Updates, and says what is to be drawn.
    pub fn props(&mut self, ui: &Ui, stage: &Stage, source: &Source) -> Props {
        let (origin, size) = source.shown;
        let low = origin.map(f64::from);
        let high: [f64; 3] = std::array::from_fn(|i| low[i] + f64::from(size[i]));
        let placement = placement(source.shown);
        let renderer = &stage.renderer;
        let blank = self.blank.get_or_insert_with(|| blank(renderer)).clone();
        let moved = self.laid != Some((self.at, source.shown));
        self.laid = Some((self.at, source.shown));
        let mut props = Props::default();
        for axis in 0..3 {
            let [c, r] = super::faces::columns_and_rows(axis);
            let at = (low[axis] + self.at[axis] * f64::from(size[axis])).round();
            let face = Face { axis, at, from: [low[c], low[r]], to: [high[c], high[r]] };
            self.faces[axis].update(ui.ctx(), renderer, source, &[face]);
            if moved {
                let mut geometry = Geometry::default();
                face.add(&mut geometry, &placement, face.from, face.to);
                self.parts[axis] = part(renderer, &geometry, &blank).map(|(shape, _)| shape);
            }
            if let Some(shape) = &self.parts[axis] {
                let material = self.faces[axis].material(0).unwrap_or(&blank);
                props.parts.push((shape.clone(), material.clone()));
            }
        }
        let (a, b) = (world(&placement, low), world(&placement, high));
        let corner = |pick: fn(f32, f32) -> f32| std::array::from_fn(|i| pick(a[i], b[i]));
        props.lines = super::geometry::box_lines(corner(f32::min), corner(f32::max), [150, 150, 155, 255]);
        props
    }

    /// Shows a handle on each plane.
    pub fn handles(&mut self, ui: &Ui, rect: Rect, stage: &Stage, shown: ([i32; 3], [u32; 3])) {
        let placement = placement(shown);
        let (origin, size) = shown;
        let names = ["Move the plane across x", "Move the plane across y", "Move the plane across z"];
        let directions = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
        for axis in 0..3 {
            // At the edge that is nearest in the first view, so that handles do not lie on each other.
            let mut t = [1.0, 0.0, 0.0];
            t[axis] = self.at[axis];
            let point = std::array::from_fn(|i| f64::from(origin[i]) + t[i] * f64::from(size[i]));
            let handle = Handle {
                label: names[axis],
                at: world(&placement, point),
                along: directions[axis],
                color: COLORS[axis],
            };
            let id = ui.id().with(("planes", axis));
            if let Some(by) = handle.show(ui, id, &stage.camera, rect) {
                let voxels = f64::from(by) / placement.scale / f64::from(size[axis].max(1));
                self.at[axis] = (self.at[axis] + voxels).clamp(0.0, 1.0);
            }
        }
    }

    /// Gives up what is on its way.
    pub fn rest(&mut self) {
        self.faces.iter_mut().for_each(Faces::rest);
    }

    /// Whether finer textures are on their way.
    pub fn is_running(&self) -> bool {
        self.faces.iter().any(Faces::is_running)
    }

    /// What went wrong.
    pub fn error(&self) -> Option<&str> {
        self.faces.iter().find_map(Faces::error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The area of all faces of a box with a corner cut out is that of the box, wherever the corner lies.
    #[test]
    fn cutting_a_corner_out_keeps_the_area() {
        let shown = ([3, -4, 0], [40, 20, 10]);
        let placement = placement(shown);
        let area = |corner: [f64; 3]| -> f64 {
            let (outer, inner) = faces_of(shown, corner);
            let shapes = shapes(&outer, &inner, shown, corner, &placement);
            shapes.iter().map(|(geometry, _)| surface(geometry)).sum()
        };
        let whole = area([1.0, 0.0, 0.0]);
        for corner in [[0.5; 3], [0.25, 0.5, 0.9], [0.0, 1.0, 1.0], [0.1, 0.0, 0.7]] {
            assert!((area(corner) / whole - 1.0).abs() < 1e-4, "{corner:?}: {} of {whole}", area(corner));
        }
    }

    fn surface(geometry: &Geometry) -> f64 {
        geometry
            .indices
            .chunks_exact(3)
            .map(|t| {
                let corner = |i: usize| geometry.vertices[t[i] as usize].position;
                let n = super::super::geometry::face_normal([corner(0), corner(1), corner(2)]);
                f64::from(n.iter().map(|c| c * c).sum::<f32>().sqrt()) / 2.0
            })
            .sum()
    }
}
