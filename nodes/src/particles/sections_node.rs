//! The node `particles.sections`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec};

use super::components::{Border, SectionSettings, find_sections};
use super::mask::{Classes, Inside, auto_mask};
use super::section::Sections;
use crate::data::Image;
use crate::exemplar::{Exemplar, View, shrink};

/// The mask in the view's size, by the rule that shrank the view's own picture.
pub(super) fn aligned_mask(view: &View, mask: &Image) -> Result<Vec<bool>, NodeError> {
    let (w, h) = (view.width, view.height);
    let longest = mask.width().max(mask.height());
    let side = longest.min(w.max(h));
    let scaled =
        |n: u32| ((u64::from(n) * u64::from(side) + u64::from(longest) / 2) / u64::from(longest)).max(1);
    if (scaled(mask.width()), scaled(mask.height())) != (w.into(), h.into()) {
        return Err(NodeError::Input(format!(
            "the mask is {} × {} pixels, the picture {w} × {h}: expected a mask of the picture's size",
            mask.width(),
            mask.height()
        )));
    }
    let mask = shrink(mask, w, h);
    let bright = |i: usize| mask.samples().get(i * mask.channels()) > 0.5;
    Ok((0..mask.pixels()).map(bright).collect())
}

/// Finds the cross-sections of particles.
pub(super) struct SectionsNode;

impl Node for SectionsNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "particles.sections",
            1,
            "The cross-sections of particles in a picture",
            "Connected pieces of the mask, holes filled, touching ones split along the watershed. The overlay shows each \
             piece in a colour of its own, and in red what was left out.",
        )
        .paper("Du et al. 2013, section 3.1")
        .input("exemplar", Exemplar::TYPE, "The picture with the maps that particles carry; of three views the first.")
        .optional("mask", Image::TYPE, "Bright inside particles, of the picture's size. Without one a threshold on luminance is used.")
        .output("sections", Sections::TYPE, "The cross-sections.")
        .output("overlay", Image::TYPE, "The picture with every cross-section tinted, three pixels a pixel.")
        .choice(
            "border",
            &[
                ("drop", "They are left out."),
                ("keep", "They stay as they are, cut straight."),
                ("complete", "Those that one edge cuts are completed by their mirror image, others are left out."),
            ],
            "What becomes of cross-sections that the border of a picture cuts (a tileable picture has none).",
        )
        .float(
            "split",
            0.0..=1.0,
            SectionSettings::default().split,
            "fraction",
            "Touching particles are split where the neck between them is thinner than this fraction of the thinner one; 0 never splits.",
        )
        .int("least", 1..=65_536, 12, "pixels", "Smaller cross-sections are left out.")
        .float("most", 0.0..=1.0, 0.25, "fraction of the picture", "Larger cross-sections are left out.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let exemplar = context.input::<Exemplar>("exemplar")?;
        let view = exemplar.view(0);
        let Some((_, color)) = view.carried.first() else {
            return Err(NodeError::failed("the exemplar carries no colour"));
        };
        let mask = match context.optional::<Image>("mask")? {
            Some(mask) => aligned_mask(view, &mask)?,
            None => auto_mask(view, color, Classes::Otsu, Inside::Thick, 12),
        };
        let settings = SectionSettings {
            border: match context.text("border")? {
                "keep" => Border::Keep,
                "complete" => Border::Complete,
                _ => Border::Drop,
            },
            split: context.float("split")?,
            least: context.int("least")? as u32,
            most: context.float("most")?,
        };
        let sections = find_sections(view, &mask, &settings, context)?;
        if sections.sections.is_empty() {
            let covered = 100.0 * f64::from(sections.fraction);
            let why = match sections.left_out {
                0 => "it is black everywhere; expected white inside particles".to_owned(),
                1 if covered > 99.9 => "it is white everywhere; expected black between particles".to_owned(),
                n => format!(
                    "{n} pieces that cover {covered:.1} % of it are cut by the border, have fewer than {} pixels or more than \
                     {:.0} % of the picture; change `border`, `least` or `most`",
                    settings.least,
                    100.0 * settings.most
                ),
            };
            return Err(NodeError::Input(format!("the mask has no cross-section to use: {why}")));
        }
        context.set("overlay", overlay(&sections));
        context.set("sections", sections);
        Ok(())
    }
}

/// The picture, three times enlarged, with every section tinted and outlined and what was left out in red.
fn overlay(sections: &Sections) -> Image {
    let (w, h) = (sections.view.width, sections.view.height);
    let mut labels = vec![0u32; (w * h) as usize];
    for (section, label) in sections.sections.iter().zip(1..) {
        section.pixels().for_each(|[x, y]| {
            let inside = (0..w as i32).contains(&x) && (0..h as i32).contains(&y);
            if inside || sections.view.tileable {
                labels[sections.pixel(x, y)] = label;
            }
        });
    }
    let color = sections.view.carried.first().map(|(_, image)| image);
    Image::from_fn(3 * w, 3 * h, |x, y| {
        let at = |x: u32, y: u32| labels[((y.min(3 * h - 1) / 3) * w + x.min(3 * w - 1) / 3) as usize];
        let here = at(x, y);
        let base = color.map_or([128; 3], |image| image.rgb8(x / 3, y / 3));
        let tint = if here > 0 {
            super::palette(here)
        } else if sections.mask[((y / 3) * w + x / 3) as usize] {
            [220, 30, 30]
        } else {
            return base;
        };
        let outline = at(x + 1, y) != here || at(x, y + 1) != here;
        let weight = if outline { 4 } else { 2 };
        std::array::from_fn(|c| ((u32::from(base[c]) * (4 - weight) + u32::from(tint[c]) * weight) / 4) as u8)
    })
}
