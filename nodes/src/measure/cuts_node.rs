//! The node `measure.cuts`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::compare::read_voxels;
use super::cuts::middle_cuts;
use super::views::Pixels;
use crate::data::{Image, Volume};

const DOCS: &str = "The slices through the middle of a volume across x, y and z, and the squares through its middle across (1, 1, 1), \
     (1, −1, 1) and (1, 2, −1), of the nearest voxels and 9/16 of the shortest edge wide: to be looked at next to the numbers of \
     `measure.volume`. Rows and columns are those of `solid.slice`.";

/// Pictures of a volume's inside.
pub struct MeasureCuts;

const OUTPUTS: [(&str, &str); 6] = [
    ("x", "The middle slice across x: rows z, columns y."),
    ("y", "The middle slice across y: rows z, columns x."),
    ("z", "The middle slice across z: rows y, columns x."),
    ("a", "The square across (1, 1, 1)."),
    ("b", "The square across (1, −1, 1)."),
    ("c", "The square across (1, 2, −1)."),
];

impl Node for MeasureCuts {
    fn spec(&self) -> NodeSpec {
        let spec =
            NodeSpec::new("measure.cuts", 1, "Slices and oblique cuts through the middle of a volume", DOCS)
                .memory_only()
                .input(
                    "volume",
                    Volume::TYPE,
                    "What is cut, with a map `color`, at least 16 voxels along each axis.",
                );
        OUTPUTS.into_iter().fold(spec, |spec, (name, docs)| spec.output(name, Image::TYPE, docs))
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let volume = context.input::<Volume>("volume")?;
        let voxels = read_voxels(&volume)?;
        for ((name, _), cut) in OUTPUTS.into_iter().zip(middle_cuts(&voxels)) {
            context.set(name, picture(&cut));
        }
        Ok(())
    }
}

fn picture(cut: &Pixels) -> Image {
    Image::from_fn(cut.width as u32, cut.height as u32, |x, y| cut.get(x as usize, y as usize))
}
