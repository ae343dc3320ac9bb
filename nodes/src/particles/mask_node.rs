//! The node `particles.mask`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::mask::{Classes, Inside, auto_mask};
use crate::data::Image;
use crate::exemplar::Exemplar;

/// A mask for those who have none.
pub(super) struct MaskNode;

impl Node for MaskNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "particles.mask",
            1,
            "A mask of the particles in a picture, made automatically",
            "Divides the pixels by brightness or colour, smooths the division, and removes crumbs and pinholes. A \
             starting point: look at the overlay of `particles.sections` and draw a better mask where particles that \
             touch are of one colour, as crushed stones are.",
        )
        .paper("Du et al. 2013, section 3; Otsu 1979")
        .memory_only()
        .input("exemplar", Exemplar::TYPE, "The picture; of three views the first.")
        .output("mask", Image::TYPE, "White inside particles, black outside, of the exemplar's size.")
        .choice(
            "method",
            &[
                ("otsu", "A threshold on luminance (Otsu 1979)."),
                ("colors", "Clusters of colour (k-means), the brighter half against the darker."),
            ],
            "How pixels are divided.",
        )
        .int("clusters", 2..=8, 3, "count", "Clusters of colour, for the method `colors`.")
        .choice(
            "inside",
            &[
                ("thick", "Whichever lies together in the thicker pieces."),
                ("bright", "What is brighter."),
                ("dark", "What is darker."),
            ],
            "What is taken for particles.",
        )
        .int("least", 0..=4096, 12, "pixels", "Smaller pieces and holes are removed.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let exemplar = context.input::<Exemplar>("exemplar")?;
        let view = exemplar.view(0);
        let Some((_, color)) = view.carried.first() else {
            return Err(NodeError::failed("the exemplar carries no colour"));
        };
        let classes = match context.text("method")? {
            "colors" => Classes::Colors(context.int("clusters")? as usize),
            _ => Classes::Otsu,
        };
        let inside = match context.text("inside")? {
            "bright" => Inside::Bright,
            "dark" => Inside::Dark,
            _ => Inside::Thick,
        };
        let mask = auto_mask(view, color, classes, inside, context.int("least")? as usize);
        let width = view.width;
        let picture =
            Image::from_fn(width, view.height, |x, y| [u8::from(mask[(y * width + x) as usize]) * 255]);
        context.set("mask", picture);
        Ok(())
    }
}
