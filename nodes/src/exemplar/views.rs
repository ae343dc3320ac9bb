//! `exemplar.views`: three exemplars, one a direction.

use breccia_engine::{Context, Node, NodeError, NodeSpec};

use super::make::transpose;
use super::view::{Exemplar, ExemplarError};

/// Joins three exemplars, cuts normal to x, y and z, to one (see [`Exemplar`] for rows and columns).
///
/// # Errors
/// If they carry different maps.
pub(crate) fn combine(x: &Exemplar, y: &Exemplar, z: &Exemplar) -> Result<Exemplar, ExemplarError> {
    let views = vec![x.view(0).clone(), transpose(y.view(1)), z.view(2).clone()];
    let names = |i: usize| {
        let infos = views[i].map_infos();
        infos
            .iter()
            .map(|m| format!("{} ({} channels, {:?})", m.name, m.channels, m.ty))
            .collect::<Vec<_>>()
            .join(", ")
    };
    for other in 1..3 {
        if views[other].map_infos() != views[0].map_infos() {
            return Err(ExemplarError::DifferentMaps { first: names(0), other: names(other) });
        }
    }
    Ok(Exemplar { views })
}

pub(super) struct CombineViews;

impl Node for CombineViews {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "exemplar.views",
            2,
            "Three exemplars, one for each direction",
            "For anisotropic materials such as wood. `x` is the cut normal to x (rows z, columns y), `y` the one normal \
             to y (rows z, columns x), `z` the one normal to z (rows y, columns x). Sizes may differ, the carried maps \
             must agree. An exemplar that has three views already gives its own view of that direction.",
        )
        .paper("Dong et al. 2008, section 3, Fig. 9")
        .memory_only()
        .input("x", "exemplar", "The cut normal to x: rows z, columns y.")
        .input("y", "exemplar", "The cut normal to y: rows z, columns x.")
        .input("z", "exemplar", "The cut normal to z: rows y, columns x.")
        .output("exemplar", "exemplar", "Three views.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let [x, y, z] = ["x", "y", "z"].map(|name| context.input::<Exemplar>(name));
        let exemplar = combine(&*x?, &*y?, &*z?).map_err(NodeError::input)?;
        context.set("exemplar", exemplar);
        Ok(())
    }
}
