//! Small pictures of results, for the nodes on the canvas.

use breccia_engine::Value;
use breccia_nodes::control::Control;
use breccia_nodes::data::{Image, Mesh, Solid, SolidValue, Volume};
use breccia_nodes::exemplar::Exemplar;
use breccia_nodes::render::{Background, PortraitSettings, portrait};
use breccia_nodes::solid::{Filter, Plane, Repeat, VolumeSolid, slice};

/// Edge of the largest thumbnail, in pixels.
pub const EDGE: u32 = 128;

/// A small picture, 8 bits a channel, four channels.
#[derive(Clone)]
pub struct Thumbnail {
    /// Width and height.
    pub size: [usize; 2],
    /// RGBA, row by row, not multiplied by alpha.
    pub rgba: Vec<u8>,
}

/// A small picture of a value, if it can be shown as one.
pub fn thumbnail(value: &Value, control: &dyn Control) -> Option<Thumbnail> {
    if let Some(image) = value.downcast::<Image>() {
        return Some(shrunk(&image));
    }
    if let Some(exemplar) = value.downcast::<Exemplar>() {
        let maps = exemplar.views.first().map(|view| &view.carried)?;
        return maps.iter().find(|(name, _)| name == "color").map(|(_, image)| shrunk(image));
    }
    if let Some(solid) = value.downcast::<SolidValue>() {
        return cut(&*solid.0, control);
    }
    if let Some(volume) = value.downcast::<Volume>() {
        return cut(&VolumeSolid::new(volume, Repeat::Clamp).ok()?, control);
    }
    if let Some(mesh) = value.downcast::<Mesh>() {
        let settings = PortraitSettings {
            picture: [EDGE, EDGE],
            azimuth: 145.0,
            elevation: 20.0,
            zoom: 1.0,
            background: Background::Transparent,
        };
        return portrait(&mesh, &settings, control).ok().map(|image| shrunk(&image));
    }
    None
}

/// A slice of a solid at right angles to z.
fn cut(solid: &dyn Solid, control: &dyn Control) -> Option<Thumbnail> {
    let infos = solid.maps();
    let map = infos.iter().find(|info| info.name == "color").or(infos.first())?;
    let plane = Plane::new([EDGE as f64 / 2.0, EDGE as f64 / 2.0, 0.5], [0.0, 0.0, 1.0], 0.0, 1.0).ok()?;
    slice(solid, &plane, [EDGE, EDGE], Filter::Nearest, &map.name, control).ok().map(|image| shrunk(&image))
}

/// A picture no larger than a thumbnail: the mean of the pixels that fall together.
fn shrunk(image: &Image) -> Thumbnail {
    let longest = image.width().max(image.height()).max(1);
    let edge = |n: u32| {
        if longest <= EDGE { n } else { (u64::from(n) * u64::from(EDGE) / u64::from(longest)).max(1) as u32 }
    };
    let (width, height) = (edge(image.width()), edge(image.height()));
    let span = |i: u32, n: u32, of: u32| {
        let at = |i: u32| (u64::from(i) * u64::from(of) / u64::from(n)) as u32;
        at(i)..at(i + 1).max(at(i) + 1)
    };
    let mut rgba = Vec::with_capacity(width as usize * height as usize * 4);
    for y in 0..height {
        for x in 0..width {
            let (mut sum, mut count) = ([0u32; 4], 0u32);
            for v in span(y, height, image.height()) {
                for u in span(x, width, image.width()) {
                    let [r, g, b] = image.rgb8(u, v);
                    let alpha = if image.channels() == 4 {
                        (image.get(u, v, 3).clamp(0.0, 1.0) * 255.0 + 0.5) as u8
                    } else {
                        255
                    };
                    for (sum, byte) in sum.iter_mut().zip([r, g, b, alpha]) {
                        *sum += u32::from(byte);
                    }
                    count += 1;
                }
            }
            rgba.extend(sum.map(|sum| ((sum + count / 2) / count.max(1)) as u8));
        }
    }
    Thumbnail { size: [width as usize, height as usize], rgba }
}
