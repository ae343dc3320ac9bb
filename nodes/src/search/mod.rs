//! Searching for neighbourhoods: windows of any size, their principal components, similarity sets, and the
//! nearest neighbourhood by exhaustive or k-coherence search (Tong et al. 2002; Chen & Wang 2010, section 4.3).

mod basis;
mod basis_node;
mod device;
mod nearest;
mod patches;
mod patches_node;
mod similar;
mod similar_node;
mod tree;
mod window;

pub use basis::{BasisError, Keep, PatchBasis, SCALE, patch_basis};
pub(crate) use device::SimilarityJob;
pub use nearest::{PatchTable, distance, project};
pub(crate) use nearest::{is_wide, nearest_of};
pub use patches::{PatchView, Patches, patches};
pub use similar::{SimilarSets, similar_sets};
pub use window::Window;

use breccia_engine::{Node, TypeInfo};

/// The nodes of this family.
pub fn nodes() -> Vec<Box<dyn Node>> {
    vec![
        Box::new(basis_node::BasisNode),
        Box::new(patches_node::PatchesNode),
        Box::new(similar_node::SimilarNode),
    ]
}

/// The socket types of this family.
pub fn types() -> Vec<TypeInfo> {
    vec![TypeInfo::of::<PatchBasis>(), TypeInfo::of::<Patches>(), TypeInfo::of::<SimilarSets>()]
}
