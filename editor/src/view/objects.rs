//! The views of objects: which of them is shown, its widgets, its handles and its marks.

use std::sync::Arc;

use breccia_nodes::data::{Filter, Image, Mesh, Solid};
use breccia_nodes::render::Scene;
use breccia_shaders::Gpu;
use eframe::egui::{Rect, Sense, Slider, Ui, WidgetInfo, WidgetType};

use super::content::{Body, Content};
use super::cube::{Cube, Planes};
use super::cut::{self, Cut};
use super::faces::Source;
use super::marks;
use super::on_mesh::{Baking, OnMesh, Wanted};
use super::stage::{Props, Stage};
use super::toolbar::{self, Show};
use super::translucent::{Glass, Translucent};
use crate::run::Fit;

/// What is remembered of the views of objects.
pub struct Objects {
    map: String,
    /// Voxels along the longest side of the mesh that a solid is shown on, once that was chosen.
    resolution: Option<u32>,
    /// Texels a side that textures end at.
    finest: u32,
    /// Voxels along the edge of a box.
    edge: u32,
    opacity: f32,
    surface: OnMesh,
    cut: Cut,
    cube: Cube,
    planes: Planes,
    glass: Translucent,
    particles: bool,
    show: Show,
}

/// The mesh and its version.
type MeshOf<'a> = (u64, &'a Arc<Mesh>);

/// How a solid lies in a mesh where the graph does not say.
const FIT: Fit = Fit { resolution: 192, origin: [0; 3], filter: Filter::Trilinear };

/// What is looked at, and what goes with it.
pub struct Seen<'a> {
    /// What is looked at, and its version.
    pub main: (u64, &'a Content),
    /// How the graph fits it where it is baked.
    pub fit: Option<Fit>,
    /// The mesh that a solid can be shown on.
    pub mesh: Option<MeshOf<'a>>,
    /// The solid in a mesh that was baked, and its version.
    pub inside: Option<(u64, &'a Arc<dyn Solid>)>,
}

impl Seen<'_> {
    /// Whether there is texture where it is cut open.
    fn is_filled(&self) -> bool {
        self.main.1.body().is_some() || self.fit.is_some()
    }
}

impl Objects {
    /// Nothing yet.
    pub fn new(gpu: Option<&Arc<Gpu>>) -> Self {
        Self {
            map: "color".to_owned(),
            resolution: None,
            finest: 1024,
            edge: 96,
            opacity: 0.04,
            surface: OnMesh::new(gpu),
            cut: Cut::new(gpu),
            cube: Cube::new(gpu),
            planes: Planes::new(gpu),
            glass: Translucent::new(gpu),
            particles: false,
            show: Show::Cube,
        }
    }

    /// See [`super::Viewport::set_detail`].
    pub fn set_detail(&mut self, texture: u32, edge: u32) {
        self.finest = texture.clamp(128, 2048);
        self.edge = edge.clamp(16, 512);
    }

    /// The widgets for what is shown.
    pub fn controls(&mut self, ui: &mut Ui, content: &Content, show: Show, fit: Option<Fit>) {
        let names: Vec<&str> = match content {
            Content::Mesh(mesh) => mesh.textures.iter().map(|(name, _)| name.as_str()).collect(),
            Content::Body(body) => {
                let labels = matches!(show, Show::Cube | Show::Planes);
                body.maps.iter().map(String::as_str).filter(|name| labels || *name != "label").collect()
            }
            _ => Vec::new(),
        };
        if !matches!(show, Show::Translucent | Show::Particles) {
            toolbar::map_choice(ui, &names, &mut self.map);
        }
        match show {
            Show::Mesh => {
                let is_solid = content.body().is_some();
                if is_solid {
                    let baked = fit.map(|fit| fit.resolution);
                    toolbar::resolution(ui, &mut self.resolution, baked, FIT.resolution);
                    toolbar::texture(ui, &mut self.finest);
                }
                self.cut_controls(ui);
                if !is_solid && fit.is_some() && self.cut.on {
                    toolbar::texture(ui, &mut self.finest);
                }
            }
            Show::Translucent => {
                self.edge_control(ui);
                toolbar::slider(ui, "Opacity", Slider::new(&mut self.opacity, 0.002..=1.0).logarithmic(true))
                    .on_hover_text("How much a voxel hides of what lies behind it");
            }
            Show::Cube => {
                self.edge_control(ui);
                toolbar::places(
                    ui,
                    "Corner",
                    "Where the cut's corner lies along each axis",
                    &mut self.cube.corner,
                );
            }
            Show::Planes => {
                self.edge_control(ui);
                toolbar::places(ui, "Places", "Where each plane lies along its axis", &mut self.planes.at);
            }
            Show::Particles | Show::Slice => self.edge_control(ui),
        }
    }

    fn edge_control(&mut self, ui: &mut Ui) {
        toolbar::slider(ui, "Box", Slider::new(&mut self.edge, 16..=512).logarithmic(true))
            .on_hover_text("Voxels along the edge of the box that is shown, at most");
    }

    fn cut_controls(&mut self, ui: &mut Ui) {
        ui.toggle_value(&mut self.cut.on, "Cut").on_hover_text("Cut the object open by a plane");
        if self.cut.on {
            toolbar::slider(ui, "Depth", Slider::new(&mut self.cut.depth, -1.0..=1.0))
                .on_hover_text("Where the plane lies along its normal");
            toolbar::slider(
                ui,
                "Turn",
                Slider::new(&mut self.cut.turn, -180.0..=180.0).suffix("°").step_by(1.0),
            );
            toolbar::slider(
                ui,
                "Tilt",
                Slider::new(&mut self.cut.tilt, -90.0..=90.0).suffix("°").step_by(1.0),
            );
            if ui.button("Other side").on_hover_text("Keep what was cut off").clicked() {
                self.cut.flipped = !self.cut.flipped;
            }
        }
    }

    /// Shows an object. Returns what was drawn, for pictures that are saved; what is seen through is not drawn.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        rect: Rect,
        stage: &mut Stage,
        seen: &Seen<'_>,
        show: Show,
    ) -> Option<Props> {
        let main = seen.main;
        self.show = show;
        self.particles = show == Show::Particles;
        let response = ui.interact(rect, ui.id().with("stage"), Sense::click_and_drag());
        let label = "Object: drag to turn, Shift and drag to move, wheel to zoom, arrow keys turn";
        response.widget_info(|| WidgetInfo::labeled(WidgetType::Image, true, label));
        stage.turn_to(show == Show::Mesh);
        stage.steer(ui, &response);
        let body = main.1.body();
        let props = match (show, body) {
            (Show::Mesh, _) => {
                let own = main.1.mesh().map(|mesh| (main.0, mesh));
                own.or(seen.mesh).map(|mesh| self.surface_props(ui, stage, seen, mesh))
            }
            (Show::Cube, Some(body)) => {
                let source = self.source(main.0, body);
                Some(self.cube.props(ui, stage, &source))
            }
            (Show::Planes, Some(body)) => {
                let source = self.source(main.0, body);
                Some(self.planes.props(ui, stage, &source))
            }
            (_, Some(body)) => {
                self.see_through(ui, rect, stage, (main.0, body));
                None
            }
            _ => None,
        };
        if let Some(props) = &props {
            stage.show(ui, rect, props);
        }
        match (show, body) {
            (Show::Mesh, _) if self.cut.on => self.cut.handles(ui, rect, stage),
            (Show::Cube, Some(body)) => self.cube.handles(ui, rect, stage, body.shown(self.edge)),
            (Show::Planes, Some(body)) => self.planes.handles(ui, rect, stage, body.shown(self.edge)),
            _ => {}
        }
        if let Some(body) = body.filter(|_| show != Show::Mesh) {
            marks::note(ui, rect, &body.left_out(self.edge));
        }
        self.marks(ui, rect, seen.is_filled());
        props
    }

    fn source(&self, version: u64, body: &Body) -> Source {
        let map = if body.maps.contains(&self.map) { self.map.clone() } else { "color".to_owned() };
        Source { version, solid: Arc::clone(&body.solid), map, shown: body.shown(self.edge) }
    }

    fn surface_props(
        &mut self,
        ui: &Ui,
        stage: &Stage,
        seen: &Seen<'_>,
        (mesh_version, mesh): MeshOf<'_>,
    ) -> Props {
        let body = seen.main.1.body();
        // A solid is shown as it would be baked, unless another resolution was chosen; the inside of a mesh as it was.
        let mut fit = seen.fit.unwrap_or(FIT);
        fit.resolution = self.resolution.filter(|_| body.is_some()).unwrap_or(fit.resolution);
        let baking = Baking { fit, finest: self.finest };
        let on_surface = body.map(|body| (seen.main.0, Arc::clone(&body.solid)));
        let within = seen.inside.filter(|_| seen.fit.is_some());
        let within = within.map(|(version, solid)| (version, Arc::clone(solid)));
        // Versions of the subject and of the mesh beside it are counted apart.
        let mesh_version = mesh_version * 2 + u64::from(body.is_some());
        // A mesh without that texture shows the colours of its vertices, and so does its inside.
        let has_map = body.is_some() || mesh.texture(&self.map).is_some();
        let map = if has_map { self.map.clone() } else { "color".to_owned() };
        let mesh = (mesh_version, Arc::clone(mesh));
        let solid = on_surface.clone().map(|(version, solid)| (version, solid, baking));
        let wanted = Wanted { mesh: mesh.clone(), solid, map: map.clone() };
        self.surface.update(ui.ctx(), &stage.renderer, &wanted);
        let mut props = Props { inside: self.surface.mean, ..Props::default() };
        props.parts.extend(self.surface.part(&stage.renderer, self.cut.on));
        let filling = on_surface.or(within).filter(|_| self.cut.on && self.surface.has_shape());
        let capped = filling.map(|solid| cut::Wanted { mesh, solid, baking, map });
        self.cut.update(ui.ctx(), &stage.renderer, self.surface.placement, capped.as_ref());
        if self.cut.on {
            self.cut.add(&mut props);
            props.parts.extend(self.surface.ghost(&stage.renderer));
        }
        props
    }

    fn see_through(&mut self, ui: &Ui, rect: Rect, stage: &Stage, (version, body): (u64, &Body)) {
        let glass = Glass { opacity: self.opacity, particles: self.particles };
        let shown = body.shown(self.edge);
        self.glass.update(ui, (version, &body.solid, shown), glass, stage.camera, rect);
        stage.paint_background(ui, rect);
        self.glass.show(ui, rect, stage.camera);
    }

    fn marks(&self, ui: &mut Ui, rect: Rect, is_filled: bool) {
        let (running, progress, error) = match self.show {
            Show::Cube => (self.cube.is_running(), 0.0, self.cube.error()),
            Show::Planes => (self.planes.is_running(), 0.0, self.planes.error()),
            Show::Mesh if self.cut.on => {
                let running = self.surface.is_running() || self.cut.is_running();
                let error = self.surface.error().or(self.cut.error());
                (running, if self.cut.is_running() { 0.0 } else { self.surface.progress() }, error)
            }
            Show::Mesh => (self.surface.is_running(), self.surface.progress(), self.surface.error()),
            _ => (self.glass.is_running(), self.glass.progress(), self.glass.error()),
        };
        if running {
            let what = if self.show == Show::Mesh && self.cut.on && self.cut.is_running() {
                "filling the cut"
            } else {
                "updating"
            };
            marks::working(ui, rect, what, progress);
        }
        if self.show == Show::Mesh && self.cut.on && !is_filled {
            marks::note(ui, rect, "The inside shows no texture: no solid was baked into this mesh");
        }
        if let Some(error) = error {
            marks::error(ui, rect, error);
        }
    }

    /// The last picture of what is seen through.
    pub fn glass_picture(&self) -> Option<&Image> {
        self.glass.last.as_ref()
    }

    /// What is seen through, and how.
    pub fn glass_scene(&self) -> Option<(Arc<Scene>, Glass)> {
        let glass = Glass { opacity: self.opacity, particles: self.particles };
        Some((Arc::clone(self.glass.scene()?), glass))
    }

    /// Gives up what is on its way for all but what is shown.
    pub fn rest_but(&mut self, show: Option<Show>) {
        if show != Some(Show::Mesh) {
            self.surface.rest();
            self.cut.rest();
        }
        if show != Some(Show::Cube) {
            self.cube.rest();
        }
        if show != Some(Show::Planes) {
            self.planes.rest();
        }
        if !matches!(show, Some(Show::Translucent | Show::Particles)) {
            self.glass.rest();
        }
    }

    /// Whether work goes on.
    pub fn is_running(&self) -> bool {
        let surface = self.surface.is_running() || self.cut.is_running();
        surface || self.cube.is_running() || self.planes.is_running() || self.glass.is_running()
    }
}
