//! What a value is, as far as it can be looked at, and whether it is another one than before.

use std::sync::Arc;

use breccia_engine::{Data, Value};
use breccia_nodes::data::{Curves, Extent, Image, Mesh, Report, Solid, SolidValue, Volume, VoxelSet};
use breccia_nodes::exemplar::Exemplar;
use breccia_nodes::solid::{Repeat, VolumeSolid};

use super::Subject;
use super::voxels::SetSolid;
use crate::run::Fit;

/// A solid, and where it is looked at.
#[derive(Clone)]
pub struct Body {
    /// The solid.
    pub solid: Arc<dyn Solid>,
    /// The first voxel and the size of the box that it fills; of a solid without an end, none.
    pub bounds: Option<([i32; 3], [u32; 3])>,
    /// Names of its maps.
    pub maps: Vec<String>,
    /// Whether it stands for a set of voxels, of which only those in it are of interest.
    pub is_set: bool,
}

impl Body {
    fn new(solid: Arc<dyn Solid>, bounds: Option<([i32; 3], [u32; 3])>) -> Self {
        let maps = solid.maps().into_iter().map(|map| map.name).collect();
        let bounds = bounds.or(match solid.extent() {
            Extent::Unbounded => None,
            // Of a short period more than one is looked at.
            Extent::Periodic(period) => period.iter().all(|&n| n >= 16).then_some(([0; 3], period)),
            Extent::Bounded(origin, size) => Some((origin, size)),
        });
        Self { solid, bounds, maps, is_set: false }
    }

    /// Whether particles or regions are labelled.
    pub fn has_labels(&self) -> bool {
        self.maps.iter().any(|name| name == "label")
    }

    /// What is left out of the box that is shown, in words; nothing if it is whole.
    pub fn left_out(&self, edge: u32) -> String {
        let Some((_, [x, y, z])) = self.bounds else { return String::new() };
        if [x, y, z].iter().all(|&n| n <= edge) {
            return String::new();
        }
        format!("the middle of {x} × {y} × {z} voxels: Box shows more")
    }

    /// The box that is shown: its own up to `edge` voxels a side.
    pub fn shown(&self, edge: u32) -> ([i32; 3], [u32; 3]) {
        match self.bounds {
            Some((origin, size)) => {
                let cut = size.map(|n| n.clamp(1, edge.max(1)));
                let first =
                    |i: usize| origin[i].saturating_add_unsigned((size[i].saturating_sub(cut[i])) / 2);
                (std::array::from_fn(first), cut)
            }
            None => ([0; 3], [edge.max(1); 3]),
        }
    }
}

/// A value as it is looked at.
#[derive(Clone)]
pub enum Content {
    /// One picture, or several aligned ones with names.
    Images(Vec<(String, Arc<Image>)>),
    /// A solid, or a volume as one.
    Body(Body),
    /// A mesh.
    Mesh(Arc<Mesh>),
    /// Numbers.
    Report(Arc<Report>),
    /// Plots.
    Curves(Arc<Curves>),
    /// Anything else, and what cannot be shown: in words.
    Words(String),
}

impl Content {
    /// What a value is.
    pub fn of(value: &Value) -> Self {
        if let Some(image) = value.downcast::<Image>() {
            return Self::Images(vec![("color".to_owned(), image)]);
        }
        if let Some(solid) = value.downcast::<SolidValue>() {
            return Self::Body(Body::new(Arc::clone(&solid.0), None));
        }
        if let Some(volume) = value.downcast::<Volume>() {
            return of_volume(volume);
        }
        if let Some(mesh) = value.downcast::<Mesh>() {
            return Self::Mesh(mesh);
        }
        if let Some(report) = value.downcast::<Report>() {
            return Self::Report(report);
        }
        if let Some(curves) = value.downcast::<Curves>() {
            return Self::Curves(curves);
        }
        if let Some(set) = value.downcast::<VoxelSet>() {
            return match SetSolid::new(set) {
                Some(solid) => Self::Body(Body { is_set: true, ..Body::new(Arc::new(solid), None) }),
                None => Self::Words("an empty set of voxels".to_owned()),
            };
        }
        match value.downcast::<Exemplar>() {
            Some(exemplar) => of_exemplar(&exemplar),
            None => Self::Words(value.summary()),
        }
    }

    /// The solid, if it is one.
    pub fn body(&self) -> Option<&Body> {
        if let Self::Body(body) = self { Some(body) } else { None }
    }

    /// The mesh, if it is one.
    pub fn mesh(&self) -> Option<&Arc<Mesh>> {
        if let Self::Mesh(mesh) = self { Some(mesh) } else { None }
    }

    /// The pictures, if it is some.
    pub fn images(&self) -> &[(String, Arc<Image>)] {
        if let Self::Images(images) = self { images } else { &[] }
    }
}

fn of_volume(volume: Arc<Volume>) -> Content {
    let bounds = (volume.origin, volume.size.map(|n| u32::try_from(n).unwrap_or(u32::MAX)));
    let summary = volume.summary();
    match VolumeSolid::new(volume, Repeat::Clamp) {
        Ok(solid) => Content::Body(Body::new(Arc::new(solid), Some(bounds))),
        Err(error) => Content::Words(format!("{summary}\n{error}")),
    }
}

fn of_exemplar(exemplar: &Exemplar) -> Content {
    let several = exemplar.views.len() > 1;
    let mut images = Vec::new();
    for (number, view) in exemplar.views.iter().enumerate() {
        let name = |map: &str| if several { format!("{map}, view {}", number + 1) } else { map.to_owned() };
        images.extend(view.carried.iter().map(|(map, image)| (name(map), Arc::new(image.clone()))));
    }
    Content::Images(images)
}

/// Where a value lies in memory; as long as it is held, no other lies there. Types that are not looked at have no place.
fn place(value: &Value) -> Option<usize> {
    fn at<T: Data>(value: &Value) -> Option<usize> {
        value.downcast::<T>().map(|data| Arc::as_ptr(&data).cast::<()>() as usize)
    }
    at::<Image>(value)
        .or_else(|| at::<SolidValue>(value))
        .or_else(|| at::<Volume>(value))
        .or_else(|| at::<Mesh>(value))
        .or_else(|| at::<Report>(value))
        .or_else(|| at::<Curves>(value))
        .or_else(|| at::<Exemplar>(value))
        .or_else(|| at::<VoxelSet>(value))
}

/// Values up to this size are compared by content when they come anew.
const CHEAP: u64 = 16 << 20;

/// What is remembered of a subject from frame to frame.
#[derive(Default)]
pub struct Remembered {
    held: Option<Held>,
    /// Changes with the content.
    pub version: u64,
}

struct Held {
    value: Value,
    label: String,
    stale: bool,
    fit: Option<Fit>,
    content: Content,
}

impl Remembered {
    /// Takes a subject in; cheap while it stays the same.
    pub fn update(&mut self, subject: Option<&Subject>) {
        let Some(subject) = subject else {
            if self.held.take().is_some() {
                self.version += 1;
            }
            return;
        };
        if let Some(held) = &mut self.held {
            (held.stale, held.fit) = (subject.stale, subject.fit);
            let same = match (place(&held.value), place(&subject.value)) {
                (Some(a), Some(b)) => a == b,
                (None, None) => {
                    held.value.type_name() == subject.value.type_name()
                        && held.value.byte_size() == subject.value.byte_size()
                        && held.label == subject.label
                }
                _ => false,
            };
            if same {
                held.label.clone_from(&subject.label);
                return;
            }
            // A result that came out as before keeps what was made for it.
            let small = held.value.byte_size() <= CHEAP && subject.value.byte_size() <= CHEAP;
            if small
                && held.value.type_name() == subject.value.type_name()
                && held.value.digest() == subject.value.digest()
            {
                held.value = subject.value.clone();
                held.label.clone_from(&subject.label);
                return;
            }
        }
        self.version += 1;
        self.held = Some(Held {
            value: subject.value.clone(),
            label: subject.label.clone(),
            stale: subject.stale,
            fit: subject.fit,
            content: Content::of(&subject.value),
        });
    }

    /// What it is.
    pub fn content(&self) -> Option<&Content> {
        self.held.as_ref().map(|held| &held.content)
    }

    /// Whether a new one is on its way.
    pub fn is_stale(&self) -> bool {
        self.held.as_ref().is_some_and(|held| held.stale)
    }

    /// How it is fitted where it is baked.
    pub fn fit(&self) -> Option<Fit> {
        self.held.as_ref().and_then(|held| held.fit)
    }

    /// Its name.
    pub fn label(&self) -> &str {
        self.held.as_ref().map_or("", |held| &held.label)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn subject(value: Value) -> Subject {
        Subject { label: "node.image".to_owned(), value, stale: false, fit: None }
    }

    #[test]
    fn the_version_changes_with_the_content_alone() {
        let image = |grey: u8| Value::new(Image::from_fn(4, 4, |_, _| [grey]));
        let mut remembered = Remembered::default();
        remembered.update(Some(&subject(image(1))));
        assert_eq!(remembered.version, 1);
        let same = subject(image(1));
        remembered.update(Some(&same));
        remembered.update(Some(&Subject { stale: true, ..same }));
        assert!(remembered.version == 1 && remembered.is_stale());
        remembered.update(Some(&subject(image(2))));
        assert_eq!(remembered.version, 2);
        remembered.update(None);
        remembered.update(None);
        assert!(remembered.version == 3 && remembered.content().is_none());
    }

    #[test]
    fn a_box_without_an_end_is_shown_from_the_origin_and_a_large_one_in_its_middle() {
        let solid = Arc::new(breccia_nodes::solid::ConstantSolid { color: [1; 3] });
        assert_eq!(Body::new(solid.clone(), None).shown(32), ([0; 3], [32; 3]));
        let body = Body::new(solid, Some(([10, 0, -5], [8, 64, 40])));
        assert_eq!(body.shown(32), ([10, 16, -1], [8, 32, 32]));
    }
}
