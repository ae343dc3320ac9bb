//! The exemplar: one view for all three directions, or one a direction.

use breccia_engine::{Data, Digest};

use crate::data::{Image, MapInfo, Reader, Writer};

/// Pixels along the longest side of a view: pixel coordinates are two bytes.
pub const MAX_SIDE: u32 = 256;

/// What is wrong with an exemplar.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ExemplarError {
    /// A map of another size than the colour.
    #[error(
        "the {name} is {found_width} × {found_height} pixels, the colour is {width} × {height}: they must be aligned"
    )]
    Misaligned {
        /// The map's name.
        name: String,
        /// Its width.
        found_width: u32,
        /// Its height.
        found_height: u32,
        /// The colour's width.
        width: u32,
        /// The colour's height.
        height: u32,
    },
    /// Too few pixels for a synthesis.
    #[error("the exemplar is {width} × {height} pixels; at least {least} × {least} are needed{hint}")]
    TooSmall {
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
        /// Smallest side that would do.
        least: u32,
        /// What else would help.
        hint: &'static str,
    },
    /// A sample that is no number.
    #[error("the {name} holds {value} at pixel ({x}, {y}); expected finite numbers")]
    NotFinite {
        /// The map's name.
        name: String,
        /// What was found.
        value: String,
        /// Its column.
        x: usize,
        /// Its row.
        y: usize,
    },
    /// Views that carry different maps.
    #[error("the views carry different maps: {first} against {other}")]
    DifferentMaps {
        /// Maps of the first view.
        first: String,
        /// Maps of the other view.
        other: String,
    },
}

/// One picture with its aligned maps.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// What is matched: sRGB colour and one feature channel, already weighted.
    pub texels: Vec<[u8; 4]>,
    /// Maps looked up at the synthesised coordinates, aligned with the texels; `color` first.
    pub carried: Vec<(String, Image)>,
    /// Whether the picture continues at the opposite edge.
    pub tileable: bool,
    /// Whether the feature channel comes from a mask or a guide that somebody made, not from a threshold.
    pub guided: bool,
    /// Texels that a synthesis must not copy, row by row; empty if it may copy all of them.
    pub barred: Vec<bool>,
}

impl View {
    /// The maps that a solid made from this view answers.
    pub fn map_infos(&self) -> Vec<MapInfo> {
        let info = |(name, image): &(String, Image)| MapInfo {
            name: name.clone(),
            channels: image.channels(),
            ty: image.samples().ty(),
        };
        self.carried.iter().map(info).collect()
    }
}

/// Aligned maps that guide a synthesis: one view that serves all three directions, or three.
///
/// With three, they are the cuts normal to x, y and z. The cut normal to x has rows z and columns y, the one
/// normal to y rows z and columns x, the one normal to z rows y and columns x. Inside, every view has its
/// columns along the next axis and its rows along the one after (cyclic order), so the second view is kept
/// transposed. A single view is used as it is in cyclic order, which puts its columns along y, z and x.
#[derive(Clone, Debug, PartialEq)]
pub struct Exemplar {
    /// One or three views.
    pub views: Vec<View>,
}

impl Exemplar {
    /// The view of a direction (0 = x, 1 = y, 2 = z).
    pub fn view(&self, direction: usize) -> &View {
        &self.views[direction.min(self.views.len() - 1)]
    }
}

impl Data for Exemplar {
    const TYPE: &'static str = "exemplar";
    const DOCS: &'static str = "Aligned maps that guide a synthesis: one view for all directions, or three.";

    fn byte_size(&self) -> u64 {
        let view = |view: &View| {
            view.texels.len() as u64 * 4
                + view.barred.len() as u64
                + view.carried.iter().map(|(_, image)| image.byte_size()).sum::<u64>()
        };
        self.views.iter().map(view).sum()
    }

    fn summary(&self) -> String {
        let view = &self.views[0];
        let names: Vec<_> = view.carried.iter().map(|(name, _)| name.as_str()).collect();
        let count = if self.views.len() == 1 { "one view" } else { "three views" };
        format!("{count} of {} × {}, {}", view.width, view.height, names.join(" + "))
    }

    fn digest(&self) -> Digest {
        Digest::of(&self.encode().unwrap_or_default())
    }

    fn encode(&self) -> Option<Vec<u8>> {
        let mut out = Writer::new();
        out.u64(self.views.len() as u64);
        for view in &self.views {
            out.u64(view.width.into())
                .u64(view.height.into())
                .u64(view.tileable.into())
                .u64(view.guided.into());
            let barred: Vec<u8> = view.barred.iter().map(|&b| u8::from(b)).collect();
            out.array(&view.texels).bytes(&barred).u64(view.carried.len() as u64);
            for (name, image) in &view.carried {
                out.text(name).bytes(&image.encode()?);
            }
        }
        Some(out.finish())
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = Reader::new(bytes);
        let mut views = Vec::new();
        for _ in 0..reader.u64()? {
            let (width, height) = (reader.u32()?, reader.u32()?);
            let (tileable, guided) = (reader.u64()? != 0, reader.u64()? != 0);
            let texels: Vec<[u8; 4]> = reader.array()?;
            let barred: Vec<bool> = reader.bytes()?.iter().map(|&b| b != 0).collect();
            let mut carried = Vec::new();
            for _ in 0..reader.u64()? {
                carried.push((reader.text()?, Image::decode(reader.bytes()?)?));
            }
            if width == 0 || texels.len() as u64 != u64::from(width) * u64::from(height) {
                return Err("a view's texels do not fit its size".to_owned());
            }
            if !barred.is_empty() && barred.len() != texels.len() {
                return Err("a view's barred texels do not fit its size".to_owned());
            }
            views.push(View { width, height, texels, carried, tileable, guided, barred });
        }
        reader.end()?;
        if views.len() == 1 || views.len() == 3 {
            Ok(Self { views })
        } else {
            Err("not one or three views".to_owned())
        }
    }
}
