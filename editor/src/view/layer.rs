//! A flat picture that appears piece by piece, coarse pieces first.

use std::sync::Arc;

use breccia_nodes::control::Control;
use breccia_nodes::data::Image;
use breccia_shaders::Gpu;
use eframe::egui::{self, Color32, Painter, Rect, TextureHandle, pos2, vec2};

use super::pixels::{Channel, describe, rgba};
use super::worker::{Job, Worker};

/// Pixels along the edge of a piece of a picture that is known already.
const PIECE: u32 = 512;

/// Pieces that are taken in a frame, so that large pictures do not hold the window up.
const AT_ONCE: usize = 12;

/// A piece of a picture.
#[derive(Clone)]
pub struct Patch {
    /// Its first pixel, and how many pixels it covers.
    pub at: [u32; 2],
    /// See `at`.
    pub size: [u32; 2],
    /// How many pixels along a side one of `image` stands for.
    pub step: u32,
    /// The samples.
    pub image: Arc<Image>,
    /// The first of them.
    pub first: [u32; 2],
    /// What of them is shown.
    pub channel: Channel,
}

impl Patch {
    /// Width and height in samples.
    fn samples(&self) -> [u32; 2] {
        let left = [self.image.width(), self.image.height()];
        std::array::from_fn(|i| {
            self.size[i].div_ceil(self.step.max(1)).min(left[i].saturating_sub(self.first[i]))
        })
    }

    fn bytes(&self) -> Vec<u8> {
        rgba(&self.image, self.channel, self.first, self.samples())
    }
}

/// A picture of which pieces come from behind the window.
pub struct Layer<K> {
    worker: Worker<K, (Patch, Vec<u8>)>,
    size: [u32; 2],
    next_size: [u32; 2],
    fresh: bool,
    patches: Vec<(Patch, TextureHandle)>,
}

impl<K: PartialEq> Layer<K> {
    /// Nothing yet.
    pub fn new(name: &'static str, gpu: Option<&Arc<Gpu>>) -> Self {
        Self {
            worker: Worker::new(name, gpu.cloned()),
            size: [0, 0],
            next_size: [0, 0],
            fresh: false,
            patches: Vec::new(),
        }
    }

    /// Asks for a picture, unless it was the last that was asked for. What is shown stays until the first piece comes.
    pub fn want(
        &mut self,
        ctx: &egui::Context,
        key: K,
        size: [u32; 2],
        work: impl FnOnce(&Pieces<'_>) -> Result<(), String> + Send + 'static,
    ) {
        if self.worker.want(ctx, key, move |job| work(&Pieces(job))) {
            self.next_size = size;
            self.fresh = true;
        }
        let came = self.worker.poll_up_to(AT_ONCE);
        if came.len() == AT_ONCE {
            ctx.request_repaint();
        }
        for (patch, bytes) in came {
            if std::mem::take(&mut self.fresh) {
                self.patches.clear();
                self.size = self.next_size;
            }
            let samples = patch.samples().map(|n| n as usize);
            if bytes.len() != 4 * samples[0] * samples[1] || samples.contains(&0) {
                continue;
            }
            let shown = egui::ColorImage::from_rgba_unmultiplied(samples, &bytes);
            let options = egui::TextureOptions {
                magnification: egui::TextureFilter::Nearest,
                minification: egui::TextureFilter::Linear,
                ..egui::TextureOptions::default()
            };
            let texture = ctx.load_texture("viewport", shown, options);
            let covers = |old: &Patch| {
                (0..2).all(|i| {
                    patch.at[i] <= old.at[i] && patch.at[i] + patch.size[i] >= old.at[i] + old.size[i]
                })
            };
            self.patches.retain(|(old, _)| !covers(old));
            self.patches.push((patch, texture));
        }
    }

    /// Asks for a picture that is known already.
    pub fn want_image(&mut self, ctx: &egui::Context, key: K, image: &Arc<Image>, channel: Channel) {
        let (image, size) = (Arc::clone(image), [image.width(), image.height()]);
        self.want(ctx, key, size, move |pieces| {
            for y in (0..size[1]).step_by(PIECE as usize) {
                for x in (0..size[0]).step_by(PIECE as usize) {
                    if pieces.control().is_cancelled() {
                        return Ok(());
                    }
                    let piece = [PIECE.min(size[0] - x), PIECE.min(size[1] - y)];
                    let image = Arc::clone(&image);
                    pieces.send(Patch { at: [x, y], size: piece, step: 1, image, first: [x, y], channel });
                }
            }
            Ok(())
        });
    }

    /// Width and height of what is shown.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Whether there is something to be seen.
    pub fn is_empty(&self) -> bool {
        self.patches.is_empty()
    }

    /// Paints it into its place, as far as that lies in the painter's.
    pub fn paint(&self, painter: &Painter, place: Rect) {
        let scale =
            vec2(place.width() / self.size[0].max(1) as f32, place.height() / self.size[1].max(1) as f32);
        let corner = |[x, y]: [u32; 2]| place.min + vec2(x as f32, y as f32) * scale;
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        for (patch, texture) in &self.patches {
            let end = [patch.at[0] + patch.size[0], patch.at[1] + patch.size[1]];
            let rect = Rect::from_min_max(corner(patch.at), corner(end));
            if painter.clip_rect().intersects(rect) {
                painter.image(texture.id(), rect, whole, Color32::WHITE);
            }
        }
    }

    /// What the finest known sample at a pixel holds.
    pub fn describe(&self, x: u32, y: u32) -> Option<String> {
        let here = |patch: &Patch| {
            [x, y]
                .iter()
                .zip(patch.at.iter().zip(&patch.size))
                .all(|(p, (at, size))| p >= at && p - at < *size)
        };
        let found = self.patches.iter().map(|(patch, _)| patch).filter(|patch| here(patch));
        let patch = found.min_by_key(|patch| patch.step)?;
        let at = |i: usize, p: u32| patch.first[i] + (p - patch.at[i]) / patch.step.max(1);
        Some(describe(&patch.image, at(0, x), at(1, y)))
    }

    /// The pieces, for a picture that is saved.
    pub fn pieces(&self) -> ([u32; 2], Vec<Patch>) {
        (self.size, self.patches.iter().map(|(patch, _)| patch.clone()).collect())
    }

    /// Gives up what is on its way.
    pub fn rest(&mut self) {
        self.worker.rest();
    }

    /// Whether pieces are on their way.
    pub fn is_running(&self) -> bool {
        self.worker.is_running()
    }

    /// What went wrong.
    pub fn error(&self) -> Option<&str> {
        self.worker.error()
    }
}

/// Where the work on a picture hands its pieces over.
pub struct Pieces<'a>(&'a Job<(Patch, Vec<u8>)>);

impl Pieces<'_> {
    /// Hands a piece over, ready to be shown.
    pub fn send(&self, patch: Patch) {
        let bytes = patch.bytes();
        self.0.send((patch, bytes));
    }

    /// Cancellation and the device.
    pub fn control(&self) -> &dyn Control {
        self.0
    }
}

/// Puts the finest pieces together: RGBA.
pub fn together([width, height]: [u32; 2], patches: &[Patch]) -> Vec<u8> {
    let mut out = vec![0; 4 * width as usize * height as usize];
    // Fine pieces come after coarse ones and lie over them.
    for patch in patches {
        let [columns, _] = patch.samples();
        let bytes = patch.bytes();
        for y in 0..patch.size[1] {
            for x in 0..patch.size[0] {
                let step = patch.step.max(1);
                let from = 4 * ((y / step) as usize * columns as usize + (x / step) as usize);
                let to = 4 * ((patch.at[1] + y) as usize * width as usize + (patch.at[0] + x) as usize);
                if let (Some(to), Some(from)) = (out.get_mut(to..to + 4), bytes.get(from..from + 4)) {
                    to.copy_from_slice(from);
                }
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_come_together_with_fine_ones_over_coarse_ones() {
        let grey = |side: u32, v: u8| Arc::new(Image::from_fn(side, side, |_, _| [v]));
        let patch =
            |at, size, step, image| Patch { at, size, step, image, first: [0; 2], channel: Channel::Color };
        let patches = [patch([0, 0], [4, 4], 2, grey(2, 9)), patch([2, 0], [2, 2], 1, grey(2, 200))];
        let bytes = together([4, 4], &patches);
        let at = |x: usize, y: usize| bytes[4 * (4 * y + x)];
        assert_eq!([at(0, 0), at(1, 3), at(2, 0), at(3, 1), at(3, 2)], [9, 9, 200, 200, 9]);
    }
}
