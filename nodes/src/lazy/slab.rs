//! The candidate slab: the best triple of every pixel of one exemplar, thickened along its normal (Dong et al.
//! 2008, section 4.3).

use breccia_engine::{Context, Node, NodeError, NodeSpec};

use super::candidates::Candidates;
use super::initial::{Initial, LAYERS};
use super::pyramid::Pyramid;

/// The slab of the exemplar normal to z at the coarsest level.
///
/// The two other neighbourhoods of a triple stand upright on the exemplar, so their pixels along the normal give
/// the layers above and below; the pixel in the exemplar's own direction is taken from the best triple there.
pub fn make_slab(pyramid: &Pyramid, candidates: &Candidates) -> Initial {
    let level = pyramid.levels.len() - 1;
    let views: [_; 3] = std::array::from_fn(|e| pyramid.view(level, e));
    let triples = |e: usize| {
        let of_level = &candidates.levels[level];
        &of_level[e.min(of_level.len() - 1)].triples
    };
    let z = views[2];
    let m = z.margin();
    let size = [z.width - 2 * m, z.height - 2 * m];
    let mut slab = Vec::with_capacity((size[0] * size[1] * LAYERS) as usize);
    for layer in 0..LAYERS {
        let t = layer - LAYERS / 2;
        for y in 0..size[1] {
            for x in 0..size[0] {
                let pixel = z.pixel(x + m, y + m);
                let best = triples(2)[z.index(pixel)][0];
                // Direction z is followed by x, whose rows run along z, and y, whose columns do.
                let in_x = views[0].shifted(best.next, 0, t);
                let in_y = views[1].shifted(best.last, t, 0);
                let in_z = if t == 0 { pixel } else { triples(0)[views[0].index(in_x)][0].last };
                slab.push([in_x, in_y, in_z]);
            }
        }
    }
    Initial { size, slab, aligned: false, jitter: None }
}

pub(super) struct SlabNode;

impl Node for SlabNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "lazy.slab",
            2,
            "What synthesis starts from: a candidate slab, or random pixels",
            "The best triple of every pixel of the exemplar normal to z, thickened to five layers. It is tiled through \
             the coarsest level, every layer of tiles shifted by a hash of the seed so that no columns appear.",
        )
        .paper("Dong et al. 2008, section 4.3")
        .memory_only()
        .input("pyramid", "pyramid", "The exemplar pyramid.")
        .input("candidates", "candidates", "The candidate triples.")
        .output("initial", "initial", "What synthesis starts from.")
        .choice(
            "start",
            &[
                ("slab", "Tiles of the candidate slab, every layer shifted."),
                ("aligned", "Tiles of the candidate slab, layers exactly above each other: for structures that run along z, as in a trunk."),
                ("random", "Pixels chosen at random, for comparison."),
            ],
            "What fills the coarsest level.",
        )
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let pyramid = context.input::<Pyramid>("pyramid")?;
        let candidates = context.input::<Candidates>("candidates")?;
        let initial = match context.text("start")? {
            "random" => Initial { size: [1, 1], slab: Vec::new(), aligned: false, jitter: None },
            "aligned" => Initial { aligned: true, ..make_slab(&pyramid, &candidates) },
            _ => make_slab(&pyramid, &candidates),
        };
        context.set("initial", initial);
        Ok(())
    }
}
