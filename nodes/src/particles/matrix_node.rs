//! The node `particles.matrix`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::section::Sections;
use crate::exemplar::{Exemplar, View, combine, feature_channel, signed_distance};

/// The picture of a matrix: pixels of particles are barred, and look alike. Their colour is the matrix's mean, so that it is the feature
/// channel, the distance to the particles, that tells where they are.
pub(super) fn matrix_view(sections: &Sections) -> View {
    let view = &sections.view;
    let matrix = || view.texels.iter().zip(&sections.mask).filter(|(_, inside)| !**inside);
    let count = matrix().count().max(1) as u64;
    let mean: [u8; 3] =
        std::array::from_fn(|c| (matrix().map(|(t, _)| u64::from(t[c])).sum::<u64>() / count) as u8);
    let (w, h) = (view.width as usize, view.height as usize);
    let distance = signed_distance(&sections.mask, w, h, view.tileable);
    let outside: Vec<f32> = distance.iter().map(|d| d.min(0.0)).collect();
    let feature = feature_channel(&outside, 100.0);
    let texels = (0..w * h).map(|i| {
        let [r, g, b, _] = view.texels[i];
        if sections.mask[i] { [mean[0], mean[1], mean[2], 228] } else { [r, g, b, feature[i]] }
    });
    View { texels: texels.collect(), barred: sections.mask.clone(), guided: true, ..view.clone() }
}

/// An exemplar of what lies between particles.
pub(super) struct MatrixNode;

impl Node for MatrixNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "particles.matrix",
            1,
            "An exemplar of what lies between the particles",
            "Bars the pixels of particles, so that a lazy synthesis copies none of them. Give that synthesis one level, \
             random start, and `taken` from `particles.mask_solid`: it then corrects nothing but voxels of the matrix.",
        )
        .paper("Du et al. 2013, section 3.3")
        .memory_only()
        .input("sections", Sections::TYPE, "Cross-sections of the view normal to z, or of the only picture.")
        .optional("sections_x", Sections::TYPE, "Cross-sections of the view normal to x.")
        .optional("sections_y", Sections::TYPE, "Cross-sections of the view normal to y.")
        .output("exemplar", Exemplar::TYPE, "The exemplar of the matrix.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let z = context.input::<Sections>("sections")?;
        let x = context.optional::<Sections>("sections_x")?;
        let y = context.optional::<Sections>("sections_y")?;
        if let Some(full) =
            [Some(&z), x.as_ref(), y.as_ref()].into_iter().flatten().find(|s| !s.mask.contains(&false))
        {
            let (w, h) = (full.view.width, full.view.height);
            return Err(NodeError::Input(format!(
                "a mask of {w} × {h} pixels is white everywhere: there is no matrix to copy; use a constant matrix"
            )));
        }
        let one = |sections: &Sections| Exemplar { views: vec![matrix_view(sections)] };
        let exemplar = if x.is_none() && y.is_none() {
            one(&z)
        } else {
            let views = [x.as_deref().unwrap_or(&z), y.as_deref().unwrap_or(&z), &*z].map(one);
            combine(&views[0], &views[1], &views[2]).map_err(NodeError::input)?
        };
        context.set("exemplar", exemplar);
        Ok(())
    }
}
