//! `exemplar.make`: an exemplar of one view from a picture and aligned maps.

use breccia_engine::{Context, Node, NodeError, NodeSpec, Sizing};

use super::feature::{Feature, feature_channel, otsu_mask, signed_distance};
use super::resize::shrink;
use super::view::{Exemplar, ExemplarError, MAX_SIDE, View};
use crate::data::{Image, Samples};

/// How an exemplar is made.
#[derive(Clone, Copy, Debug)]
pub struct MakeSettings {
    /// Larger pictures are shrunk until their longest side has this many pixels (8 to [`MAX_SIDE`]).
    pub max_size: u32,
    /// Where the feature mask comes from.
    pub feature: Feature,
    /// Weight of the feature channel against one colour channel, 0 to 1.27.
    pub feature_weight: f32,
    /// Whether the picture continues at the opposite edge.
    pub tileable: bool,
}

impl Default for MakeSettings {
    fn default() -> Self {
        Self { max_size: 128, feature: Feature::Auto, feature_weight: 1.0, tileable: false }
    }
}

/// An exemplar of one view. `mask` marks features (bright = inside), `guide` is matched in place of the
/// feature distance, `maps` are carried along.
///
/// # Errors
/// If a map is not aligned with the colour, or the picture is too small.
pub fn make_exemplar(
    color: &Image,
    mask: Option<&Image>,
    guide: Option<&Image>,
    maps: &[(&str, &Image)],
    settings: &MakeSettings,
) -> Result<Exemplar, ExemplarError> {
    let (width, height) = (color.width(), color.height());
    let aligned = maps.iter().copied().chain(mask.map(|m| ("mask", m))).chain(guide.map(|g| ("guide", g)));
    for (name, map) in aligned.chain([("colour", color)]) {
        if let Samples::F32(samples) = map.samples()
            && let Some(at) = samples.iter().position(|sample| !sample.is_finite())
        {
            let pixel = at / map.channels();
            let (x, y) = (pixel % map.width() as usize, pixel / map.width() as usize);
            return Err(ExemplarError::NotFinite {
                name: name.to_owned(),
                value: samples[at].to_string(),
                x,
                y,
            });
        }
        if (map.width(), map.height()) != (width, height) {
            return Err(ExemplarError::Misaligned {
                name: name.to_owned(),
                found_width: map.width(),
                found_height: map.height(),
                width,
                height,
            });
        }
    }
    if width.min(height) < 8 {
        return Err(ExemplarError::TooSmall { width, height, least: 8, hint: "" });
    }
    let longest = width.max(height);
    let side = longest.min(settings.max_size.clamp(8, MAX_SIDE));
    let scaled = |n: u32| {
        ((u64::from(n) * u64::from(side) + u64::from(longest) / 2) / u64::from(longest)).max(1) as u32
    };
    let (w, h) = (scaled(width), scaled(height));
    if w.min(h) < 8 {
        let hint = " after shrinking; crop it closer to a square";
        return Err(ExemplarError::TooSmall { width: w, height: h, least: 8, hint });
    }
    let color = shrink(&to_rgb8(color), w, h);
    let feature = feature_of(&color, mask, guide, w, h, settings);
    let texels = (0..w * h)
        .map(|i| {
            let [r, g, b] = color.rgb8(i % w, i / w);
            [r, g, b, feature[i as usize]]
        })
        .collect();
    let carried = std::iter::once(("color".to_owned(), color.clone()))
        .chain(maps.iter().map(|(name, map)| ((*name).to_owned(), shrink(map, w, h))))
        .collect();
    let guided = guide.is_some() || mask.is_some() && settings.feature != Feature::None;
    let view = View {
        width: w,
        height: h,
        texels,
        carried,
        tileable: settings.tileable,
        guided,
        barred: Vec::new(),
    };
    Ok(Exemplar { views: vec![view] })
}

fn to_rgb8(image: &Image) -> Image {
    Image::from_fn(image.width(), image.height(), |x, y| image.rgb8(x, y))
}

/// The fourth channel: the guide as it is, the feature distance, or a constant.
fn feature_of(
    color: &Image,
    mask: Option<&Image>,
    guide: Option<&Image>,
    w: u32,
    h: u32,
    settings: &MakeSettings,
) -> Vec<u8> {
    let count = (w * h) as usize;
    if let Some(guide) = guide {
        let guide = shrink(guide, w, h);
        let level = |i: usize| guide.samples().get_u8(i * guide.channels());
        let weighted =
            |l: u8| (128.5 + (f32::from(l) - 128.0) * settings.feature_weight).clamp(0.0, 255.0) as u8;
        return (0..count).map(|i| weighted(level(i))).collect();
    }
    let features = match (settings.feature, mask) {
        (Feature::None, _) | (Feature::Mask, None) => None,
        (_, Some(mask)) => {
            let mask = shrink(mask, w, h);
            Some((0..count).map(|i| mask.samples().get(i * mask.channels()) > 0.5).collect())
        }
        (Feature::Auto, None) => otsu_mask(color),
    };
    let Some(features): Option<Vec<bool>> = features else { return vec![128; count] };
    if features.iter().all(|&f| f == features[0]) {
        return vec![128; count];
    }
    let distance = signed_distance(&features, w as usize, h as usize, settings.tileable);
    // A threshold is a guess, so it weighs half of a mask that somebody drew: more costs stochastic textures contrast.
    let amplitude = if mask.is_some() { 100.0 } else { 50.0 };
    feature_channel(&distance, amplitude * settings.feature_weight)
}

pub(super) struct MakeExemplar;

/// The carried maps that the node has a socket for.
const CARRIED: [(&str, &str); 6] = [
    ("normal", "Normal map, carried along as stored (tangent space of the exemplar)."),
    ("roughness", "Roughness, carried along."),
    ("metallic", "Metalness, carried along."),
    ("height", "Height, carried along."),
    ("occlusion", "Ambient occlusion, carried along."),
    ("emission", "Emitted light, carried along."),
];

impl Node for MakeExemplar {
    fn spec(&self) -> NodeSpec {
        let spec = NodeSpec::new(
            "exemplar.make",
            4,
            "An exemplar from a picture and its aligned maps",
            "The colour guides the matching. A mask (bright inside the features) is turned into a signed feature \
             distance that joins it as a fourth channel; so can any other map as `guide`. All further maps are carried: \
             they are looked up at the synthesised coordinates, so that a whole material goes in and a solid of the \
             whole material comes out. All maps must have the colour's size. Larger pictures are shrunk to `max_size`.",
        )
        .paper("Dong et al. 2008, section 6 (feature distance after Kopf et al. 2007)")
        .input("color", "image", "The picture that guides the matching.")
        .optional("mask", "image", "Feature mask: brighter than one half is inside.")
        .optional("guide", "image", "A map to match in place of the feature distance; its first channel counts.");
        CARRIED
            .iter()
            .fold(spec, |spec, (name, docs)| spec.optional(name, "image", docs))
            .output("exemplar", "exemplar", "One view that serves all three directions.")
            .output("color", "image", "The colour at the exemplar's size, to compare results with.")
            .int(
                "max_size",
                8..=i64::from(MAX_SIDE),
                128,
                "pixels",
                "Larger pictures are shrunk to this longest side.",
            )
            .choice(
                "feature",
                &[
                    ("auto", "The mask where one is linked, else a threshold on luminance (Otsu 1979)."),
                    ("mask", "The mask where one is linked, else none."),
                    ("none", "No feature channel."),
                ],
                "Where the feature distance comes from.",
            )
            .float(
                "feature_weight",
                0.0..=1.27,
                1.0,
                "1",
                "Weight of the feature channel or guide against one colour channel.",
            )
            .flag("tileable", false, "The picture continues at the opposite edge.")
    }

    fn estimate(&self, sizing: &Sizing<'_>) -> Option<u64> {
        // Colour and feature, and the carried colour; the picture may be smaller.
        Some((sizing.int("max_size")? as u64).pow(2) * 7)
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let color = context.input::<Image>("color")?;
        let mask = context.optional::<Image>("mask")?;
        let guide = context.optional::<Image>("guide")?;
        let mut carried = Vec::new();
        for (name, _) in CARRIED {
            carried.extend(context.optional::<Image>(name)?.map(|map| (name, map)));
        }
        let maps: Vec<_> = carried.iter().map(|(name, map)| (*name, &**map)).collect();
        let settings = MakeSettings {
            max_size: context.int("max_size")? as u32,
            feature: match context.text("feature")? {
                "mask" => Feature::Mask,
                "none" => Feature::None,
                _ => Feature::Auto,
            },
            feature_weight: context.float("feature_weight")? as f32,
            tileable: context.flag("tileable")?,
        };
        let exemplar = make_exemplar(&color, mask.as_deref(), guide.as_deref(), &maps, &settings)
            .map_err(NodeError::input)?;
        let color = exemplar.views[0].carried[0].1.clone();
        context.set("exemplar", exemplar);
        context.set("color", color);
        Ok(())
    }
}

/// A view with rows and columns exchanged.
pub(super) fn transpose(view: &View) -> View {
    let (w, h) = (view.width as usize, view.height as usize);
    let order: Vec<usize> = (0..w * h).map(|i| (i % h) * w + i / h).collect();
    let texels = order.iter().map(|&i| view.texels[i]).collect();
    let carried = view.carried.iter().map(|(name, image)| {
        let channels = image.channels();
        let mut samples = Samples::zeros(image.samples().ty(), image.samples().len());
        for (to, &from) in order.iter().enumerate() {
            samples.copy_from(to * channels, image.samples(), from * channels, channels);
        }
        let turned = Image::new(view.height, view.width, channels, samples).unwrap_or_else(|_| image.clone());
        (name.clone(), turned)
    });
    View {
        width: view.height,
        height: view.width,
        texels,
        carried: carried.collect(),
        tileable: view.tileable,
        guided: view.guided,
        barred: if view.barred.is_empty() {
            Vec::new()
        } else {
            order.iter().map(|&i| view.barred[i]).collect()
        },
    }
}
