//! The node `render.translucent`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec, ParamKind, ParamValue, Sizing};

use super::Background;
use super::translucent::{Cut, Key, TranslucentSettings, translucent};
use crate::data::{Image, SolidValue};
use crate::solid::params::{box_of, picture_bytes, picture_of, with_box, with_picture};

const KEYS: &[(&str, &str)] = &[
    ("luminance", "The luminance of a voxel's colour."),
    ("label", "The map `label`; labels from 256 on begin at 0 again."),
];

/// A box, seen through.
pub(super) struct Translucent;

impl Node for Translucent {
    fn spec(&self) -> NodeSpec {
        let spec = NodeSpec::new(
            "render.translucent",
            2,
            "A picture of a box with what is marked opaque and the rest translucent",
            "Shows particles in a matrix of glass, or without it. The front face is the first layer across z, x to the right and \
             y down; z leads away from the viewer. `transfer` makes the opacity a function of luminance or label; up to three \
             planes cut parts off.",
        )
        .on_device()
        .input("solid", SolidValue::TYPE, "What is shown.")
        .optional("marked", SolidValue::TYPE, "White where voxels are opaque, such as particles.")
        .optional("inside", SolidValue::TYPE, "White where there is anything at all; without it in the whole box.")
        .output("image", Image::TYPE, "The picture.");
        let spec = with_box(spec, 64)
            .float("opacity", 0.0..=1.0, 0.0, "fraction a voxel", "How much a voxel that is not marked hides of what lies behind it: 0 leaves it out, 1 makes it opaque.")
            .param(
                "transfer",
                ParamKind::Floats { min_len: 0, max_len: 256, min: 0.0, max: 1.0 },
                ParamValue::List(Vec::new()),
                "fraction a voxel",
                "Opacities in place of `opacity`: by luminance, at even distances from black to white and linear between them; or by \
                 label, from label 0 on, the last for all others.",
            )
            .choice("transfer_by", KEYS, "What `transfer` is looked up by.")
            .param(
                "cuts",
                ParamKind::Floats { min_len: 0, max_len: 12, min: -1e9, max: 1e9 },
                ParamValue::List(Vec::new()),
                "1",
                "Up to three planes, each as the x, y and z of a normal that points to what is cut off, and where it cuts: 0 at the \
                 first of the box's corners along the normal, 1 at the last.",
            )
            .float("azimuth", -360.0..=360.0, 36.0, "degrees", "From how far to the right it is seen.")
            .float("elevation", -89.0..=89.0, 27.0, "degrees", "From how far above it is seen.");
        with_picture(spec, "picture", 640).choice(
            "background",
            Background::CHOICES,
            "What lies behind the box.",
        )
    }

    fn estimate(&self, sizing: &Sizing<'_>) -> Option<u64> {
        picture_bytes(sizing, "picture")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let solid = context.input::<SolidValue>("solid")?;
        let marked = context.optional::<SolidValue>("marked")?;
        let inside = context.optional::<SolidValue>("inside")?;
        let place = box_of(context)?;
        let key = if context.text("transfer_by")? == "label" { Key::Label } else { Key::Luminance };
        let settings = TranslucentSettings {
            picture: picture_of(context, "picture")?,
            opacities: key.opacities(&context.floats("transfer")?, context.float("opacity")?),
            cuts: cuts(&context.floats("cuts")?)?,
            view: [context.float("azimuth")?, context.float("elevation")?],
            background: Background::named(context.text("background")?),
        };
        let marked = marked.as_ref().map(|solid| &*solid.0);
        let inside = inside.as_ref().map(|solid| &*solid.0);
        let image = translucent(&*solid.0, marked, inside, place, key, &settings, context)?;
        context.set("image", image);
        Ok(())
    }
}

/// Planes from four numbers each.
fn cuts(numbers: &[f64]) -> Result<[Option<Cut>; 3], NodeError> {
    let mut cuts = [None; 3];
    if !numbers.len().is_multiple_of(4) || numbers.len() > 4 * cuts.len() {
        return Err(NodeError::Failed(format!(
            "parameter `cuts` takes 0, 4, 8 or 12 numbers, found {}",
            numbers.len()
        )));
    }
    for (to, plane) in cuts.iter_mut().zip(numbers.chunks_exact(4)) {
        if plane[..3].iter().all(|&c| c == 0.0) {
            return Err(NodeError::Failed("the normal of one of the `cuts` has no direction".to_owned()));
        }
        *to = Some(Cut { normal: [plane[0], plane[1], plane[2]], at: plane[3] });
    }
    Ok(cuts)
}
