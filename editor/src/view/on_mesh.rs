//! A mesh with its own textures, or with a solid baked onto it coarse to fine.

use std::sync::{Arc, Mutex, PoisonError};

use breccia_nodes::control::Control;
use breccia_nodes::data::{Mesh, Solid};
use breccia_nodes::mesh::{BakeSettings, UnwrapSettings, bake_solid, ensure_uvs};
use breccia_shaders::Gpu;
use eframe::egui;

use super::geometry::{CLAY, Geometry, Placement, WHITE, of_mesh};
use super::gpu_parts::{Clip, Finish, Material, PLAIN, Shape};
use super::pixels::{Channel, Pixels, rgba_of};
use super::renderer::Renderer;
use super::worker::{Job, Worker};
use crate::run::Fit;

/// How a solid is baked for the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Baking {
    /// How it lies in the mesh.
    pub fit: Fit,
    /// Texels a side of the last pass.
    pub finest: u32,
}

/// Texels a side of the passes.
const PASSES: [u32; 5] = [128, 256, 512, 1024, 2048];

/// A mesh, and what its surface shows.
#[derive(Clone)]
pub struct Wanted {
    /// The mesh and its version.
    pub mesh: (u64, Arc<Mesh>),
    /// The solid, its version and how it is baked; without it the mesh's own textures are shown.
    pub solid: Option<(u64, Arc<dyn Solid>, Baking)>,
    /// The map that is shown.
    pub map: String,
}

type Key = (u64, Option<(u64, Baking)>, String);

impl Wanted {
    fn key(&self) -> Key {
        (self.mesh.0, self.solid.as_ref().map(|(version, _, baking)| (*version, *baking)), self.map.clone())
    }
}

enum Made {
    /// Triangles, with whether they are laid out for baking.
    Shape(Geometry, Placement, bool),
    Texture(Pixels),
}

/// The mesh of a version laid out for baking. Laying it out cannot be cancelled and may take long, so a request that was superseded
/// meanwhile leaves it for the next.
type Laid = Arc<Mutex<Option<(u64, Arc<Mesh>)>>>;

/// The surface that is shown.
pub struct OnMesh {
    worker: Worker<Key, Made>,
    laid: Laid,
    /// The version of the mesh that `shape` shows, and whether it is laid out for baking.
    shown: Option<(u64, bool)>,
    shape: Option<Shape>,
    /// How the mesh lies in the ball.
    pub placement: Placement,
    material: [Option<Material>; 2],
    /// The mean colour of the surface.
    pub mean: [u8; 3],
    /// What the texture shows, and its size.
    finest: Option<(Key, [u32; 2])>,
    pale: Option<Material>,
}

impl OnMesh {
    /// Nothing yet.
    pub fn new(gpu: Option<&Arc<Gpu>>) -> Self {
        Self {
            worker: Worker::new("surface", gpu.cloned()),
            laid: Laid::default(),
            shown: None,
            shape: None,
            placement: Placement { center: [0.0; 3], scale: 1.0 },
            material: [None, None],
            mean: [CLAY[0], CLAY[1], CLAY[2]],
            finest: None,
            pale: None,
        }
    }

    /// Asks for what is to be shown, unless it is known or on its way; takes in what has come.
    pub fn update(&mut self, ctx: &egui::Context, renderer: &Renderer, wanted: &Wanted) {
        let (work, laid) = (wanted.clone(), Arc::clone(&self.laid));
        let is_laid = self.shown == Some((wanted.mesh.0, true));
        if self.worker.want(ctx, wanted.key(), move |job| make(&work, &laid, is_laid, job))
            && self.shown.is_none_or(|(version, _)| version != wanted.mesh.0)
        {
            // Another mesh: nothing of the last one is good for it.
            self.shown = None;
            self.shape = None;
            self.material = [None, None];
            self.finest = None;
        }
        for made in self.worker.poll() {
            match made {
                Made::Shape(geometry, placement, laid) => {
                    self.placement = placement;
                    self.shape = Shape::new(renderer.device(), &geometry);
                    self.shown = Some((wanted.mesh.0, laid));
                }
                Made::Texture(pixels) => {
                    // Begun again after a rest, the first passes are coarser than what is there.
                    let finer = (wanted.key(), pixels.size);
                    if self.finest.as_ref().is_some_and(|f| f.0 == finer.0 && f.1 > finer.1) {
                        continue;
                    }
                    self.finest = Some(finer);
                    self.mean = pixels.mean();
                    self.material = [Clip::Whole, Clip::Kept]
                        .map(|clip| Some(renderer.material(&pixels, Finish { clip, ..PLAIN })));
                }
            }
        }
    }

    /// What is to be drawn, grey as long as there is no texture.
    pub fn part(&mut self, renderer: &Renderer, clipped: bool) -> Option<(Shape, Material)> {
        let shape = self.shape.clone()?;
        let slot = self.material.get_mut(usize::from(clipped))?;
        let clip = if clipped { Clip::Kept } else { Clip::Whole };
        let clay = Pixels::flat([CLAY[0], CLAY[1], CLAY[2]]);
        let grey = || renderer.material(&clay, Finish { clip, ..PLAIN });
        Some((shape, slot.get_or_insert_with(grey).clone()))
    }

    /// What was cut off, as a shade of it.
    pub fn ghost(&mut self, renderer: &Renderer) -> Option<(Shape, Material)> {
        let finish = Finish { clip: Clip::Removed, opacity: 0.05, sharp: false };
        let pale = || renderer.material(&Pixels::flat([190, 190, 200]), finish);
        Some((self.shape.clone()?, self.pale.get_or_insert_with(pale).clone()))
    }

    /// Whether there is something to be seen.
    pub fn has_shape(&self) -> bool {
        self.shape.is_some()
    }

    /// Gives up what is on its way.
    pub fn rest(&mut self) {
        self.worker.rest();
    }

    /// Whether finer textures are on their way.
    pub fn is_running(&self) -> bool {
        self.worker.is_running()
    }

    /// The fraction done of the present pass.
    pub fn progress(&self) -> f32 {
        self.worker.progress()
    }

    /// What went wrong.
    pub fn error(&self) -> Option<&str> {
        self.worker.error()
    }
}

fn make(wanted: &Wanted, laid: &Laid, is_laid: bool, job: &Job<Made>) -> Result<(), String> {
    let mesh = &wanted.mesh.1;
    let placement = Placement::of_mesh(mesh);
    match &wanted.solid {
        None => {
            own(mesh, placement, &wanted.map, job);
            Ok(())
        }
        Some((_, solid, baking)) => {
            let mesh = lay_out(wanted.mesh.0, mesh, laid, is_laid, job)?;
            bake_passes(&mesh, &**solid, *baking, &wanted.map, job, |pixels| job.send(Made::Texture(pixels)))
        }
    }
}

/// The mesh's own texture, or its vertex colours, or grey.
fn own(mesh: &Mesh, placement: Placement, map: &str, job: &Job<Made>) {
    let texture = mesh.texture(map).filter(|_| mesh.uvs.len() == mesh.positions.len());
    let color = texture.map(|_| WHITE);
    let pixels = match texture {
        Some(image) => Pixels::new([image.width(), image.height()], rgba_of(image, Channel::Color)),
        None => Pixels::flat([255; 3]),
    };
    job.send(Made::Texture(pixels));
    job.send(Made::Shape(of_mesh(mesh, placement, color), placement, false));
}

/// The mesh laid out for baking; it is shown in grey meanwhile.
fn lay_out(
    version: u64,
    mesh: &Mesh,
    laid: &Laid,
    is_shown: bool,
    job: &Job<Made>,
) -> Result<Arc<Mesh>, String> {
    let placement = Placement::of_mesh(mesh);
    let show = |mesh: &Mesh, laid| {
        if !is_shown {
            job.send(Made::Shape(of_mesh(mesh, placement, Some(WHITE)), placement, laid));
        }
    };
    let found = laid.lock().unwrap_or_else(PoisonError::into_inner).clone();
    if let Some((_, mesh)) = found.filter(|(of, _)| *of == version) {
        show(&mesh, true);
        return Ok(mesh);
    }
    let bare = Mesh { textures: Vec::new(), ..Mesh::clone(mesh) };
    show(&bare, false);
    let settings = UnwrapSettings { texture_size: 1024, ..UnwrapSettings::default() };
    let made = Arc::new(ensure_uvs(&bare, settings).map_err(|error| error.to_string())?);
    *laid.lock().unwrap_or_else(PoisonError::into_inner) = Some((version, Arc::clone(&made)));
    show(&made, true);
    Ok(made)
}

/// Bakes coarse to fine; every finished pass is handed over.
pub(super) fn bake_passes(
    mesh: &Mesh,
    solid: &dyn Solid,
    baking: Baking,
    map: &str,
    control: &dyn Control,
    hand_over: impl Fn(Pixels),
) -> Result<(), String> {
    for texture_size in PASSES.into_iter().filter(|&size| size <= baking.finest.max(128)) {
        let settings = BakeSettings {
            resolution: baking.fit.resolution,
            origin: baking.fit.origin,
            filter: baking.fit.filter,
            texture_size,
            gutter: (texture_size / 128).max(2),
            ..BakeSettings::default()
        };
        let baked = bake_solid(mesh, solid, settings, control).map_err(|error| error.to_string())?;
        let image = baked.texture(map).or_else(|| baked.texture("color"));
        let image = image.ok_or_else(|| format!("the solid has no map `{map}` that can be baked"))?;
        hand_over(Pixels::new([image.width(), image.height()], rgba_of(image, Channel::Color)));
    }
    Ok(())
}
