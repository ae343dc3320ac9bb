//! Baking a solid into the textures of a mesh: each texel asks the solid for the voxels at its place on
//! the surface, so that only voxels near the surface are ever synthesised.
//!
//! A `normal` map is passed through as the solid answers it. Its vectors stand in the tangent frame of the
//! exemplar, not of the mesh's UVs, and are not turned into the latter: on a statistically isotropic material
//! that makes no visible difference, on a strongly directed one lighting may turn from chart to chart.

use rayon::prelude::*;

use super::sample::{Filter, SampleError, sample_solid};
use super::space::{Space, SpaceError};
use super::texels::{NONE, cover, nearest_covered, position};
use super::unwrap::{UnwrapError, UnwrapSettings, ensure_uvs};
use crate::control::{Cancelled, Control, check};
use crate::data::{Image, Map, Mesh, Samples, Solid, SolidError, linear_to_srgb};

/// Largest texture that can be baked, texels a side.
pub const MAX_TEXTURE: u32 = 1 << 14;

/// How a solid is baked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeSettings {
    /// Voxels along the longest side of the mesh's bounding box (see [`Space`]).
    pub resolution: u32,
    /// Texels along a side of the square textures.
    pub texture_size: u32,
    /// How samples between voxel centres are found.
    pub filter: Filter,
    /// Texels by which charts are widened, so that filtering does not reach beyond them.
    pub gutter: u32,
    /// The voxel at the bounding box's smallest corner.
    pub origin: [i32; 3],
    /// Voxels along the edge of the blocks that are asked for at a time; bounds memory, not the result.
    pub block: u32,
}

impl Default for BakeSettings {
    fn default() -> Self {
        Self {
            resolution: 512,
            texture_size: 2048,
            filter: Filter::Trilinear,
            gutter: 8,
            origin: [0; 3],
            block: 256,
        }
    }
}

/// Why a mesh could not be baked.
#[derive(Clone, Debug, thiserror::Error)]
pub enum BakeError {
    /// Cancelled.
    #[error("cancelled")]
    Cancelled,
    /// Voxel space cannot be laid over the mesh.
    #[error(transparent)]
    Space(#[from] SpaceError),
    /// The mesh has no usable texture coordinates, and none could be made.
    #[error(transparent)]
    Unwrap(#[from] UnwrapError),
    /// The solid gave no samples.
    #[error(transparent)]
    Sample(SampleError),
    /// The texture's size is out of range.
    #[error("a texture of {0} texels a side is not from 1 to {MAX_TEXTURE}")]
    TextureSize(u32),
}

impl From<Cancelled> for BakeError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<SampleError> for BakeError {
    fn from(error: SampleError) -> Self {
        match error {
            SampleError::Solid(SolidError::Cancelled) => Self::Cancelled,
            error => Self::Sample(error),
        }
    }
}

impl From<BakeError> for breccia_engine::NodeError {
    fn from(error: BakeError) -> Self {
        match error {
            BakeError::Cancelled => Self::Cancelled,
            error => Self::failed(error),
        }
    }
}

/// The mesh with all maps of the solid but labels baked into its textures, in place of those it had.
///
/// The mesh's own UVs are used where they lie inside 0 to 1, else an atlas is made. Voxel space is that of
/// the mesh, or of the whole that it was cut from ([`Mesh::space_bounds`]). Texels beyond the gutter hold
/// the mean of all others, so that small mip levels do not darken.
///
/// # Errors
/// See [`BakeError`].
pub fn bake_solid(
    mesh: &Mesh,
    solid: &dyn Solid,
    settings: BakeSettings,
    control: &dyn Control,
) -> Result<Mesh, BakeError> {
    if settings.texture_size == 0 || settings.texture_size > MAX_TEXTURE {
        return Err(BakeError::TextureSize(settings.texture_size));
    }
    let space = Space::of_mesh(mesh, settings.resolution, settings.origin)?;
    let size = settings.texture_size as usize;
    let unwrap = UnwrapSettings {
        texture_size: settings.texture_size,
        padding: settings.gutter.div_ceil(2).max(1),
        ..UnwrapSettings::default()
    };
    let mut mesh = ensure_uvs(mesh, unwrap)?;
    let mut owner = cover(&mesh.uvs, &mesh.triangles, size);
    check(control)?;
    let covered: Vec<u32> = (0..owner.len() as u32).filter(|&texel| owner[texel as usize] != NONE).collect();
    let at = |i: usize| {
        let texel = covered[i] as usize;
        space.to_voxels(position(&mesh, owner[texel], texel, size))
    };
    let sampled = sample_solid(solid, covered.len(), &at, settings.filter, settings.block, control)?;
    // From here on a texel's owner is the place of its samples.
    for (&texel, &rank) in covered.iter().zip(&sampled.rank) {
        owner[texel as usize] = rank;
    }
    drop(covered);
    let nearest = nearest_covered(&owner, size, settings.gutter.min(256));
    check(control)?;
    let source = |texel: usize| owner.get(*nearest.get(texel)? as usize).map(|&rank| rank as usize);
    mesh.textures = sampled
        .maps
        .iter()
        .filter_map(|map| Some((map.name.clone(), paint(map, settings.texture_size, &source)?)))
        .collect();
    Ok(mesh)
}

/// A texture of a map whose entry for each texel `source` names.
fn paint(map: &Map, size: u32, source: &(dyn Fn(usize) -> Option<usize> + Sync)) -> Option<Image> {
    let (width, channels) = (size as usize, map.channels);
    let samples = match &map.samples {
        Samples::U8(from) => {
            let mean = mean(from, channels, |&v| f64::from(v)).map(|m| (m + 0.5) as u8);
            Samples::U8(gather(from, channels, width, mean, source))
        }
        Samples::F32(from) => {
            let mean = mean(from, channels, |&v| f64::from(v)).map(|m| m as f32);
            Samples::F32(gather(from, channels, width, mean, source))
        }
        Samples::U32(_) => return None,
    };
    Image::new(size, size, channels, samples).ok()
}

fn mean<T>(samples: &[T], channels: usize, read: impl Fn(&T) -> f64) -> [f64; 4] {
    let mut sums = [0.0; 4];
    for voxel in samples.chunks_exact(channels) {
        sums.iter_mut().zip(voxel).for_each(|(sum, v)| *sum += read(v));
    }
    let count = (samples.len() / channels).max(1) as f64;
    sums.map(|sum| sum / count)
}

fn gather<T: Copy + Default + Send + Sync>(
    from: &[T],
    channels: usize,
    width: usize,
    elsewhere: [T; 4],
    source: &(dyn Fn(usize) -> Option<usize> + Sync),
) -> Vec<T> {
    let mut out = vec![T::default(); width * width * channels];
    out.par_chunks_mut(width * channels).enumerate().for_each(|(y, row)| {
        for (x, texel) in row.chunks_exact_mut(channels).enumerate() {
            let found = source(y * width + x).and_then(|at| from.get(at * channels..(at + 1) * channels));
            texel.copy_from_slice(found.unwrap_or(&elsewhere[..channels]));
        }
    });
    out
}

/// The mesh with the solid's colours at its vertices. A grey map is repeated; alpha is full.
///
/// # Errors
/// See [`BakeError`].
pub fn bake_vertices(
    mesh: &Mesh,
    solid: &dyn Solid,
    settings: BakeSettings,
    control: &dyn Control,
) -> Result<Mesh, BakeError> {
    let space = Space::of_mesh(mesh, settings.resolution, settings.origin)?;
    let at = |i: usize| space.to_voxels(mesh.positions[i].map(f64::from));
    let count = mesh.positions.len();
    let sampled = sample_solid(solid, count, &at, settings.filter, settings.block, control)?;
    let color = sampled.maps.iter().find(|map| map.name == "color");
    let color = color.ok_or_else(|| SampleError::Solid(SolidError::Incomplete("map `color`".to_owned())))?;
    let byte = |at: usize| match &color.samples {
        Samples::F32(linear) => linear_to_srgb(linear[at]),
        samples => samples.get_u8(at),
    };
    let rgba = |&rank: &u32| {
        let at = rank as usize * color.channels;
        let [r, g, b] = if color.channels < 3 { [at; 3] } else { [at, at + 1, at + 2] };
        [byte(r), byte(g), byte(b), 255]
    };
    Ok(Mesh { colors: sampled.rank.iter().map(rgba).collect(), ..mesh.clone() })
}
