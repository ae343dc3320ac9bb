//! Pictures as bytes that can be shown: any channel of any number type.

use breccia_nodes::data::{Image, SampleType, Samples};

/// What of a picture is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Channel {
    /// Its colour.
    #[default]
    Color,
    /// One of its channels, in grey.
    One(usize),
}

impl Channel {
    /// Its name in a list.
    pub fn name(self, channels: usize) -> &'static str {
        match (self, channels) {
            (Self::Color, _) => "Colour",
            (Self::One(0), 1 | 2) => "Grey",
            (Self::One(1), 2) | (Self::One(3), _) => "Alpha",
            (Self::One(0), _) => "Red",
            (Self::One(1), _) => "Green",
            (Self::One(_), _) => "Blue",
        }
    }
}

/// A rectangle of a picture as opaque sRGB bytes with alpha, row by row. Floats are taken as linear light, labels get a colour each.
pub fn rgba(image: &Image, channel: Channel, at: [u32; 2], size: [u32; 2]) -> Vec<u8> {
    let labels = image.samples().ty() == SampleType::U32;
    let right = at[0].saturating_add(size[0]).min(image.width());
    let bottom = at[1].saturating_add(size[1]).min(image.height());
    let mut out = Vec::with_capacity(4 * size[0] as usize * size[1] as usize);
    for y in at[1]..bottom {
        for x in at[0]..right {
            let [r, g, b] = match channel {
                Channel::Color if labels => label_color(image.get(x, y, 0) as u32),
                Channel::Color => image.rgb8(x, y),
                Channel::One(c) => [byte(image, x, y, c.min(image.channels() - 1)); 3],
            };
            out.extend_from_slice(&[r, g, b, 255]);
        }
    }
    out
}

/// All of a picture.
pub fn rgba_of(image: &Image, channel: Channel) -> Vec<u8> {
    rgba(image, channel, [0, 0], [image.width(), image.height()])
}

fn byte(image: &Image, x: u32, y: u32, c: usize) -> u8 {
    let value = image.get(x, y, c);
    match image.samples() {
        Samples::F32(_) => breccia_nodes::data::linear_to_srgb(value),
        Samples::U32(_) => value.clamp(0.0, 255.0) as u8,
        Samples::U8(_) => (value * 255.0 + 0.5) as u8,
    }
}

/// A colour for a label: black for 0, apart from each other for neighbours.
fn label_color(label: u32) -> [u8; 3] {
    if label == 0 {
        return [0; 3];
    }
    let mixed = label.wrapping_mul(0x9e37_79b9);
    let mixed = (mixed ^ mixed >> 15).wrapping_mul(0x85eb_ca6b);
    [mixed >> 24, mixed >> 16 & 255, mixed >> 8 & 255].map(|c| (70 + c * 175 / 255) as u8)
}

/// What a pixel holds, for people to read.
pub fn describe(image: &Image, x: u32, y: u32) -> String {
    if x >= image.width() || y >= image.height() {
        return String::new();
    }
    let channels = image.channels();
    let names = ["", "v", "va", "rgb", "rgba"][channels.min(4)];
    let values = names.chars().enumerate().map(|(c, name)| {
        let value = image.get(x, y, c);
        match image.samples() {
            Samples::U8(_) => format!("{} {}", name.to_ascii_uppercase(), (value * 255.0).round()),
            Samples::U32(_) => format!("{value}"),
            Samples::F32(_) => format!("{} {value:.4}", name.to_ascii_uppercase()),
        }
    });
    let text = values.collect::<Vec<_>>().join("  ");
    let [r, g, b] = image.rgb8(x, y);
    match image.samples() {
        Samples::U32(_) => format!("label {text}"),
        _ => format!("{text}   #{r:02X}{g:02X}{b:02X}"),
    }
}

/// Bytes of a texture, and of each half as large one down to a single pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Pixels {
    /// Width and height.
    pub size: [u32; 2],
    /// Rows of RGBA, of the whole size first.
    pub levels: Vec<Vec<u8>>,
}

impl Pixels {
    /// The levels of a picture given as RGBA; black if the bytes do not fit the size.
    pub fn new([width, height]: [u32; 2], mut bytes: Vec<u8>) -> Self {
        let size = [width.max(1), height.max(1)];
        bytes.resize(4 * size[0] as usize * size[1] as usize, 255);
        let mut levels = vec![bytes];
        let mut now = size;
        while now != [1, 1] {
            let next = now.map(|n| (n / 2).max(1));
            let Some(last) = levels.last() else { break };
            let half = halve(last, now, next);
            levels.push(half);
            now = next;
        }
        Self { size, levels }
    }

    /// A single pixel.
    pub fn flat(color: [u8; 3]) -> Self {
        let [r, g, b] = color;
        Self { size: [1, 1], levels: vec![vec![r, g, b, 255]] }
    }

    /// The mean colour.
    pub fn mean(&self) -> [u8; 3] {
        match self.levels.last().map(Vec::as_slice) {
            Some([r, g, b, ..]) => [*r, *g, *b],
            _ => [128; 3],
        }
    }
}

fn halve(from: &[u8], [w, h]: [u32; 2], [to_w, to_h]: [u32; 2]) -> Vec<u8> {
    let at = |x: u32, y: u32, c: usize| -> u32 {
        let index = 4 * (y.min(h - 1) as usize * w as usize + x.min(w - 1) as usize) + c;
        from.get(index).copied().unwrap_or(0).into()
    };
    let mut out = Vec::with_capacity(4 * to_w as usize * to_h as usize);
    for y in 0..to_h {
        for x in 0..to_w {
            for c in 0..4 {
                let sum = at(2 * x, 2 * y, c)
                    + at(2 * x + 1, 2 * y, c)
                    + at(2 * x, 2 * y + 1, c)
                    + at(2 * x + 1, 2 * y + 1, c);
                out.push(((sum + 2) / 4) as u8);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_are_shown_as_linear_light_and_labels_apart() {
        let half = Image::new(1, 1, 3, Samples::F32(vec![0.5; 3])).unwrap();
        assert_eq!(rgba_of(&half, Channel::Color), [188, 188, 188, 255]);
        let labels = Image::new(3, 1, 1, Samples::U32(vec![0, 1, 2])).unwrap();
        let shown = rgba_of(&labels, Channel::Color);
        assert_eq!(shown[..3], [0; 3]);
        assert_ne!(shown[4..7], shown[8..11]);
    }

    #[test]
    fn a_channel_is_shown_in_grey_and_a_pixel_is_told() {
        let image = Image::from_fn(2, 1, |x, _| [10 + x as u8, 20, 255]);
        assert_eq!(rgba(&image, Channel::One(1), [1, 0], [1, 1]), [20, 20, 20, 255]);
        assert_eq!(describe(&image, 1, 0), "R 11  G 20  B 255   #0B14FF");
        assert_eq!(describe(&image, 2, 0), "");
    }

    #[test]
    fn levels_end_in_the_mean() {
        let pixels = Pixels::new([4, 2], [[0, 100, 200, 255], [100, 200, 0, 255]].concat().repeat(4));
        assert_eq!(pixels.levels.iter().map(Vec::len).collect::<Vec<_>>(), [32, 8, 4]);
        assert_eq!(pixels.mean(), [50, 150, 100]);
    }
}
