//! The node `solid.slice`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec, ParamKind, ParamValue, Sizing, Work};

use super::Plane;
use super::params::{floats, picture_bytes, picture_of, vector, with_picture};
use crate::data::{Filter, Image, SolidValue};

/// A plane slice of a solid.
pub struct Slice;

impl Node for Slice {
    fn spec(&self) -> NodeSpec {
        let vector = ParamKind::Floats { min_len: 3, max_len: 3, min: -1e9, max: 1e9 };
        let spec = NodeSpec::new(
            "solid.slice",
            2,
            "A plane slice at any position, orientation and resolution",
            "Asks the solid only for the voxels that the picture shows. Voxel (i, j, k) covers i to i + 1 and so on, \
             so a plane at a whole number shows the layer that starts there. Rows run along z projected into the \
             plane, or along y where the normal is closest to z: the slices across z, y and x are `volume[z]`, \
             `volume[:, y]` and `volume[:, :, x]` of an array in Z, Y, X order, unturned.",
        )
        .on_device()
        .input("solid", SolidValue::TYPE, "What is sliced.")
        .output("image", Image::TYPE, "The slice, in the number type of the map.")
        .param("center", vector.clone(), floats([0.0; 3]), "voxels", "The middle of the picture: x, y, z.")
        .param("normal", vector, floats([0.0, 0.0, 1.0]), "1", "The direction across the plane, of any length.")
        .float("rotation", -360.0..=360.0, 0.0, "degrees", "Turns the picture in its plane, rows towards columns.");
        with_picture(spec, "size", 256)
            .float("scale", 1e-3..=1e3, 1.0, "voxels a pixel", "How many voxels a pixel spans.")
            .choice(
                "filter",
                &[
                    ("nearest", "The voxel that holds the pixel's centre."),
                    ("trilinear", "Interpolated from the eight voxels around it."),
                ],
                "How a pixel gets its value.",
            )
            .param("map", ParamKind::Text, ParamValue::Text("color".into()), "", "The map that is shown.")
    }

    fn estimate(&self, sizing: &Sizing<'_>) -> Option<u64> {
        picture_bytes(sizing, "size")
    }

    fn work(&self, sizing: &Sizing<'_>) -> Option<Work> {
        let pixels = picture_bytes(sizing, "size")? / 3;
        // About eleven corrections a pixel, each of a microsecond; a word of each pixel comes back.
        Some(Work { seconds: pixels as f64 * 11e-6, bytes: 4 * pixels })
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let solid = context.input::<SolidValue>("solid")?;
        let (center, normal) = (vector(context, "center")?, vector(context, "normal")?);
        let plane = Plane::new(center, normal, context.float("rotation")?, context.float("scale")?)?;
        let size = picture_of(context, "size")?;
        let filter = if context.text("filter")? == "trilinear" { Filter::Trilinear } else { Filter::Nearest };
        let image = super::slice(&*solid.0, &plane, size, filter, context.text("map")?, context)?;
        context.set("image", image);
        Ok(())
    }
}
