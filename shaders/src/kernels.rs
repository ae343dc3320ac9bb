//! All kernels, and the modules that they import.

/// Declares kernels: a constant, the file, the function mirrored, threads of a workgroup, and the buffers in order.
macro_rules! kernels {
    ($($(#[$docs:meta])* $id:ident = $file:literal mirrors $mirrors:literal, $workgroup:literal, [$($access:ident $name:literal),*];)*) => {
        $(
            $(#[$docs])*
            pub static $id: crate::Kernel = crate::Kernel {
                name: $file,
                mirrors: $mirrors,
                source: include_str!(concat!("../kernels/", $file, ".wgsl")),
                workgroup: $workgroup,
                bindings: &[$(crate::Binding::$access($name)),*],
            };
        )*
        /// Every kernel.
        pub static ALL: &[&crate::Kernel] = &[$(&$id),*];
    };
}

/// What kernels import, in an order that lets each import those before it.
pub(crate) const MODULES: &[(&str, &str)] = &[
    ("modules/random.wgsl", include_str!("../kernels/modules/random.wgsl")),
    ("modules/bricks.wgsl", include_str!("../kernels/modules/bricks.wgsl")),
    ("modules/level.wgsl", include_str!("../kernels/modules/level.wgsl")),
    ("modules/box.wgsl", include_str!("../kernels/modules/box.wgsl")),
    ("modules/matching.wgsl", include_str!("../kernels/modules/matching.wgsl")),
    ("modules/nearest.wgsl", include_str!("../kernels/modules/nearest.wgsl")),
    ("modules/taps.wgsl", include_str!("../kernels/modules/taps.wgsl")),
];

kernels! {
    /// The bricks around every brick.
    LINK = "lazy/link" mirrors "lazy::field::Field::fill_window", 128,
        [uniform "params", read "places", read "keys", write "links"];
    /// What must be known before a sub-pass.
    DILATE = "lazy/dilate" mirrors "lazy::dependency::dilate", 64,
        [uniform "params", read "links", write "masks"];
    /// The voxels of the next coarser level that a set descends from.
    PARENTS = "lazy/parents" mirrors "lazy::dependency::parents", 64,
        [uniform "params", read "children", read "masks", write "coarse_masks"];
    /// How many voxels of every brick a sub-pass corrects.
    COUNT = "lazy/count" mirrors "data::voxels::indices", 64,
        [uniform "params", read "masks", write "counts"];
    /// Where the voxels of every brick begin in the list.
    SCAN = "lazy/scan" mirrors "data::voxels::indices", 256,
        [uniform "params", write "counts"];
    /// The list of the voxels that a sub-pass corrects.
    SCATTER = "lazy/scatter" mirrors "data::voxels::indices", 64,
        [uniform "params", read "masks", read "starts", write "list"];
    /// The start level before its first correction.
    START = "lazy/start" mirrors "lazy::field::Field::start", 64,
        [uniform "params", constant "level", read "tables", read "links", read "masks", read "slab", read "gaussians",
         read "ranges", write "state"];
    /// A level before its first correction, from the next coarser one.
    UPSAMPLE = "lazy/upsample" mirrors "lazy::field::Field::upsample", 64,
        [uniform "params", constant "level", read "tables", read "links", read "masks", read "ancestors", read "coarse",
         write "state"];
    /// One sub-pass.
    CORRECT = "lazy/correct" mirrors "lazy::kernel::correct", 64,
        [uniform "params", constant "level", read "tables", read "links", read "list", read "before", write "after"];
    /// The states of some bricks, for the host.
    GATHER = "lazy/gather" mirrors "lazy::field::Field::of", 128,
        [uniform "params", read "slots", read "state", write "out"];
    /// The triples of least crossbar error.
    TRIPLES = "lazy/triples" mirrors "lazy::candidates::consistent_triples", 256,
        [uniform "params", read "strips", read "centres", write "triples"];
    /// The coefficients of the windows around voxels.
    PROJECT = "search/project" mirrors "search::nearest::project", 64,
        [uniform "params", read "basis", read "colors", read "list", write "queries"];
    /// Similarity sets.
    SIMILAR = "search/similar" mirrors "search::similar::similar_sets", 64,
        [uniform "params", read "coefficients", read "centres", read "own", write "sets"];
    /// The nearest neighbourhood among those that voxels propose.
    COHERENT = "optimize/coherent" mirrors "optimize::coherence::matches", 64,
        [uniform "params", read "coefficients", read "sets", read "weights", read "sources", read "list", read "queries",
         write "found"];
    /// The nearest of all neighbourhoods.
    EXHAUSTIVE = "optimize/exhaustive" mirrors "search::nearest::PatchTable::nearest", 64,
        [uniform "params", read "coefficients", read "weights", read "queries", write "found"];
    /// Colours of voxels from the matches around them; rounds as the device does.
    SOLVE = "optimize/solve" mirrors "optimize::solve::solve_voxels", 64,
        [uniform "params", read "weights", read "matches", read "texels", read "pixels", read "list", write "solved"];
    /// A map of a lazy solid at points.
    SAMPLE_LAZY = "lazy/sample" mirrors "solid::sample::sample, lazy::solid::LazySolid::look_up", 128,
        [uniform "params", read "taps", read "places", read "state", read "map", write "out"];
    /// A map of a dense volume at points.
    SAMPLE_DENSE = "solid/sample" mirrors "solid::sample::sample, solid::dense::VolumeSolid::gather", 128,
        [uniform "params", read "taps", read "map", write "out"];
    /// A picture of a box, seen through.
    MARCH = "render/march" mirrors "render::march::Scene::look", 64,
        [uniform "params", read "tables", read "voxels", read "flags", write "out"];
}

#[cfg(test)]
mod tests {
    use naga::back::{hlsl, msl, spv};
    use naga::valid::{Capabilities, ValidationFlags, Validator};

    use super::ALL;
    use crate::compose;

    #[test]
    fn every_kernel_is_valid_and_binds_what_it_declares() {
        for kernel in ALL {
            let composed =
                compose(kernel, kernel.source).unwrap_or_else(|error| panic!("{}: {error}", kernel.name));
            Validator::new(ValidationFlags::all(), Capabilities::empty())
                .validate(&composed.module)
                .unwrap_or_else(|error| panic!("{}: {}", kernel.name, error.into_inner()));
            composed.agrees_with(kernel).unwrap();
            assert!(composed.shared_bytes() <= 16 << 10, "{} shares too much", kernel.name);
        }
    }

    #[test]
    fn every_kernel_can_be_told_to_vulkan_metal_and_dx12() {
        for kernel in ALL {
            let module = compose(kernel, kernel.source).unwrap().module;
            let info =
                Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module).unwrap();
            let told = std::panic::catch_unwind(|| {
                spv::write_vec(&module, &info, &spv::Options::default(), None).unwrap();
                let options = msl::Options { fake_missing_bindings: true, ..Default::default() };
                msl::write_string(&module, &info, &options, &msl::PipelineOptions::default()).unwrap();
                let options = hlsl::Options { fake_missing_bindings: true, ..Default::default() };
                let mut text = String::new();
                hlsl::Writer::new(&mut text, &options, &hlsl::PipelineOptions::default())
                    .write(&module, &info, None)
                    .unwrap();
            });
            assert!(told.is_ok(), "{}", kernel.name);
        }
    }
}
