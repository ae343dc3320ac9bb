//! Semiregular solids: particles reconstructed from cross-sections, packed, refined, in a matrix (Du, Hu & Martin, "Semiregular
//! Solid Texturing from 2D Image Exemplars", 2013).
//!
//! Data flows one way: [`Sections`] of each picture → [`ParticleSet`] → [`Neighbours`] → [`Packing`] (repelled, then filled) →
//! [`ParticleSolid`], whose matrix any other solid answers.

mod anatomy;
mod axes;
mod bits;
mod cells;
mod components;
mod deform;
mod deform_node;
mod deformation;
mod factors;
mod fft;
mod fill;
mod fill_node;
mod index;
mod labels_node;
mod likeness;
mod likeness_node;
mod list;
mod list_node;
mod mask;
mod mask_node;
mod mask_solid_node;
mod matrix_node;
mod neighbours;
mod neighbours_node;
mod pack;
mod pack_node;
mod packing;
mod particle;
mod profile;
mod quarter;
mod quota;
mod recolor;
mod recolor_node;
mod reconstruct;
mod reconstruct_node;
mod repel;
mod repel_node;
mod rigid;
mod room;
mod section;
mod sections_node;
mod select;
mod select_node;
mod solid;
mod solid_node;
#[cfg(test)]
mod tests;
mod triples;

pub use anatomy::Anatomy;
pub use bits::{Bits, Occupancy};
pub use cells::{Cells, cells};
pub use components::{Border, SectionSettings, find_sections};
pub use deform::{DeformedSolid, Part};
pub use deformation::{Deformation, Kind};
pub use factors::Factors;
pub use fill::{CellOf, FillSettings, fill};
pub use index::Index;
pub use likeness::likeness;
pub use list::{Entry, ParticleList};
pub use mask::{Classes, Inside, auto_mask};
pub use neighbours::{Near, Neighbours};
pub use pack::{Choice, Order, PackError, PackSettings, pack};
pub use packing::{Packing, Placed, Shape};
pub use particle::{NOTHING, Particle, ParticleSet};
pub use recolor::{RecolorSettings, RecolorSolid};
pub use reconstruct::{reconstruct, sweep};
pub use repel::{RepelSettings, repel};
pub use section::{Section, Sections};
pub use select::{SelectSettings, select};
pub use solid::{LABEL, Look, ParticleSolid};
pub use triples::{Triple, TripleCounts, TripleError, TripleSettings, find_triples};

use breccia_engine::{Node, TypeInfo};

/// The nodes of this family.
pub fn nodes() -> Vec<Box<dyn Node>> {
    vec![
        Box::new(mask_node::MaskNode),
        Box::new(sections_node::SectionsNode),
        Box::new(reconstruct_node::ReconstructNode),
        Box::new(neighbours_node::NeighboursNode),
        Box::new(pack_node::PackNode),
        Box::new(repel_node::RepelNode),
        Box::new(fill_node::FillNode),
        Box::new(matrix_node::MatrixNode),
        Box::new(mask_solid_node::MaskSolidNode),
        Box::new(solid_node::SolidNode),
        Box::new(select_node::SelectNode),
        Box::new(recolor_node::RecolorNode),
        Box::new(deform_node::DeformNode),
        Box::new(labels_node::LabelsNode),
        Box::new(list_node::ListNode),
        Box::new(likeness_node::LikenessNode),
    ]
}

/// The socket types of this family.
pub fn types() -> Vec<TypeInfo> {
    vec![
        TypeInfo::of::<Sections>(),
        TypeInfo::of::<ParticleSet>(),
        TypeInfo::of::<Neighbours>(),
        TypeInfo::of::<Packing>(),
        TypeInfo::of::<ParticleList>(),
    ]
}

/// A colour for a label that differs from those of its neighbours in the list.
pub(crate) fn palette(label: u32) -> [u8; 3] {
    // Hues at the golden ratio, three shades in turn.
    let hue = f64::from(label.wrapping_mul(2_654_435_769)) / 4_294_967_296.0 * 6.0;
    let value = [1.0, 0.72, 0.88][(label % 3) as usize];
    std::array::from_fn(|c| {
        let at = (hue + [0.0, 4.0, 2.0][c]) % 6.0;
        let ramp = ((at - 3.0).abs() - 1.0).clamp(0.0, 1.0);
        (255.0 * value * (0.25 + 0.75 * ramp)) as u8
    })
}
