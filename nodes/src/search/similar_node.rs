//! `search.similar`: similarity sets.

use breccia_engine::{Context, Node, NodeError, NodeSpec};

use super::patches::Patches;
use super::similar::similar_sets;

pub(super) struct SimilarNode;

impl Node for SimilarNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "search.similar",
            1,
            "For every pixel the pixels with the most similar neighbourhoods",
            "The candidates that a k-coherence search proposes. The sets are exact. Up to 4096 pixels every one is compared with \
             every other; of more a tree compares only what can be near, which finds the same sets (24 components: at 128 × 128 \
             pixels in half the time, at 256 × 256 in a third, about 2 seconds).",
        )
        .paper("Tong et al. 2002; Chen & Wang 2010, section 4.3 (k = 5)")
        .on_device()
        .input("patches", "patches", "The neighbourhoods.")
        .output("similar", "similar_sets", "The sets.")
        .int("k", 1..=32, 5, "count", "Pixels in a set, the pixel itself included; no more than the exemplar has.")
        .int(
            "spread",
            1..=16,
            1,
            "pixels",
            "How far apart the members of a set are at least, along columns or rows: more makes them more different.",
        )
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let patches = context.input::<Patches>("patches")?;
        let k = context.int("k")? as usize;
        let window = patches.window();
        for view in &patches.views {
            let edge = |n: i32| if view.tileable { n } else { n - window.size + 1 };
            let centres = edge(view.width).max(0) * edge(view.height).max(0);
            if k as i64 > i64::from(centres) {
                return Err(NodeError::Failed(format!(
                    "found k = {k}, expected at most {centres}: so many neighbourhoods of {0} × {0} pixels lie in an \
                     exemplar of {1} × {2}",
                    window.size, view.width, view.height
                )));
            }
        }
        let sets = similar_sets(&patches, k, context.int("spread")? as i32, context)?;
        context.set("similar", sets);
        Ok(())
    }
}
