//! The presets of Breccia and the exemplars and meshes they use, embedded in the binary.
//!
//! A preset is a graph document; it names the files it starts from as `builtin:NAME`, and [`asset`] has
//! their contents:
//!
//! ```
//! let mesh = breccia_graphs::preset("lazy_mesh").expect("a preset");
//! assert!(mesh.ron.contains("builtin:spot/spot.glb"));
//! assert!(breccia_graphs::asset("spot/spot.glb").is_some());
//! ```
//!
//! Presets of the same purpose have the same interface names (`exemplar`, `size`, `seed`, `volume`,
//! `preview`, …), so that one can take the place of another.

mod folders;
mod reading;
mod sources;

pub use folders::{default_cache, default_state};
pub use reading::{ReadError, read};
pub use sources::{SCHEME, Sources, set_of};

/// A graph that comes with the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    /// The name it is run by.
    pub name: &'static str,
    /// The document.
    pub ron: &'static str,
    /// What it makes, 320 × 240 pixels, as JPEG.
    pub picture: &'static [u8],
}

/// A file that comes with the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Asset {
    /// What follows `builtin:` in a path, with a folder for each set of files that belong together.
    pub name: &'static str,
    /// The contents.
    pub bytes: &'static [u8],
}

macro_rules! presets {
    ($($name:literal),* $(,)?) => {
        &[$(Preset {
            name: $name,
            ron: include_str!(concat!("presets/", $name, ".ron")),
            picture: include_bytes!(concat!("pictures/", $name, ".jpg")),
        }),*]
    };
}

macro_rules! assets {
    ($($name:literal),* $(,)?) => {
        &[$(Asset { name: $name, bytes: include_bytes!(concat!("assets/", $name)) }),*]
    };
}

const PRESETS: &[Preset] = presets![
    "lazy_volume",
    "lazy_mesh",
    "lazy_slice",
    "pbr_mesh",
    "wood_views",
    "cut_mesh",
    "compare_volume",
    "optimize_volume",
    "optimize_painted",
    "optimize_ablations",
    "kopf_volume",
    "particles_volume",
    "hybrid_mesh",
    "hybrid_slice",
    "brick_wall",
    "recolour",
    "bent_bar",
];

const ASSETS: &[Asset] = assets![
    "bricks/end_128.png",
    "bricks/end_mask_128.png",
    "bricks/front_128.png",
    "bricks/front_mask_128.png",
    "caustics/color_128.png",
    "caustics/color_64.png",
    "caustics/mask_128.png",
    "caustics/mask_64.png",
    "cobbles/color_128.png",
    "cobbles/color_64.png",
    "cobbles/height_128.png",
    "cobbles/mask_128.png",
    "cobbles/mask_64.png",
    "cobbles/normal_128.png",
    "cobbles/roughness_128.png",
    "granite/color_128.png",
    "granite/volume_32.nrrd",
    "groups/optimize_level.ron",
    "spot/spot.glb",
    "wood/view_x_128.png",
    "wood/view_y_128.png",
    "wood/view_z_128.png",
];

/// All presets, the simplest first.
pub fn presets() -> &'static [Preset] {
    PRESETS
}

/// The preset of that name.
pub fn preset(name: &str) -> Option<&'static Preset> {
    PRESETS.iter().find(|preset| preset.name == name)
}

/// All embedded files, by name.
pub fn assets() -> &'static [Asset] {
    ASSETS
}

/// The contents of the embedded file of that name (without `builtin:`).
pub fn asset(name: &str) -> Option<&'static [u8]> {
    ASSETS.iter().find(|asset| asset.name == name).map(|asset| asset.bytes)
}
