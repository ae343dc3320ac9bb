//! Screenshots and turntables as files, encoded behind the window.

use std::borrow::Cow;
use std::io::Cursor;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::time::Duration;

use breccia_nodes::control::Control;
use breccia_nodes::data::Image;
use breccia_nodes::render::Scene;
use breccia_shaders::Gpu;
use eframe::egui;
use image::ImageEncoder;

use super::camera::Orbit;
use super::layer::{Patch, together};
use super::stage::{Props, Stage};
use super::translucent::{Glass, picture};
use super::worker::{Job, Worker};
use super::{ViewAction, pixels};

/// As what a turntable is saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Film {
    /// One file that plays anywhere, of 256 colours a frame.
    Gif,
    /// A numbered file a frame.
    Pngs,
}

/// How a turntable turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnSettings {
    /// Frames in a turn.
    pub frames: u32,
    /// Pixels a side.
    pub side: u32,
    /// Seconds a turn.
    pub seconds: f32,
}

impl Default for TurnSettings {
    fn default() -> Self {
        Self { frames: 48, side: 512, seconds: 4.0 }
    }
}

type Rgba = ([u32; 2], Vec<u8>);

/// Frames that the window still has to draw, and where they go.
struct Reel {
    frames: SyncSender<Rgba>,
    /// Drawn, but not yet taken.
    waiting: Option<Rgba>,
    next: u32,
    settings: TurnSettings,
    start: Orbit,
    props: Props,
}

/// What is being saved.
pub struct Export {
    films: Worker<u64, ViewAction>,
    /// Beside the other, so that a picture ends no film.
    pictures: Worker<u64, ViewAction>,
    number: u64,
    reel: Option<Reel>,
    /// How turntables turn.
    pub settings: TurnSettings,
}

impl Export {
    /// Nothing yet.
    pub fn new(gpu: Option<&Arc<Gpu>>) -> Self {
        Self {
            films: Worker::new("film", gpu.cloned()),
            pictures: Worker::new("picture", None),
            number: 0,
            reel: None,
            settings: TurnSettings::default(),
        }
    }

    fn start_film(
        &mut self,
        ctx: &egui::Context,
        work: impl FnOnce(&Job<ViewAction>) -> Result<(), String> + Send + 'static,
    ) {
        self.number += 1;
        self.reel = None;
        self.films.want(ctx, self.number, work);
    }

    /// Saves a picture.
    pub fn screenshot(&mut self, ctx: &egui::Context, (size, bytes): Rgba) {
        self.number += 1;
        self.pictures.want(ctx, self.number, move |job| {
            job.send(one_file("screenshot.png", png(size, &bytes)?));
            Ok(())
        });
    }

    /// Saves a flat picture, put together from its pieces.
    pub fn flat(&mut self, ctx: &egui::Context, (size, pieces): ([u32; 2], Vec<Patch>)) {
        self.number += 1;
        self.pictures.want(ctx, self.number, move |job| {
            job.send(one_file("picture.png", png(size, &together(size, &pieces))?));
            Ok(())
        });
    }

    /// Saves a full turn of what is on the stage; frames are drawn one a call of [`Export::update`].
    pub fn turntable(&mut self, ctx: &egui::Context, (start, props): (Orbit, Props), film: Film) {
        let settings = self.settings;
        let (frames, taken) = sync_channel(2);
        self.start_film(ctx, move |job| {
            let next = |_| next_frame(&taken, job);
            job.send(encode(film, settings, next, job)?);
            Ok(())
        });
        self.reel = Some(Reel { frames, waiting: None, next: 0, settings, start, props });
    }

    /// Saves a full turn of a scene that is seen through.
    pub fn glass_turntable(
        &mut self,
        ctx: &egui::Context,
        scene: Arc<Scene>,
        glass: Glass,
        start: Orbit,
        film: Film,
    ) {
        let settings = self.settings;
        self.start_film(ctx, move |job| {
            let frame = |i: u32| {
                let view = [f64::from(azimuth(start, i, settings)), f64::from(start.elevation)];
                let image = picture(&scene, glass, view, [settings.side; 2], job)?;
                Ok(Some(([settings.side; 2], rgba_with_alpha(&image))))
            };
            job.send(encode(film, settings, frame, job)?);
            Ok(())
        });
    }

    /// Draws the next frame if one is wanted, and returns files that are finished.
    pub fn update(&mut self, ctx: &egui::Context, stage: &Stage) -> Vec<ViewAction> {
        if let Some(reel) = &mut self.reel {
            if reel.waiting.is_none() && reel.next < reel.settings.frames {
                let camera = Orbit { azimuth: azimuth(reel.start, reel.next, reel.settings), ..reel.start };
                match stage.picture(&reel.props, camera, [reel.settings.side; 2]) {
                    Ok(frame) => reel.waiting = Some(frame),
                    Err(error) => {
                        self.cancel();
                        return vec![ViewAction::Say(format!("The turntable stopped: {error}"))];
                    }
                }
                reel.next += 1;
            }
            if let Some(frame) = reel.waiting.take()
                && let Err(TrySendError::Full(frame)) = reel.frames.try_send(frame)
            {
                reel.waiting = Some(frame);
            }
            if reel.next >= reel.settings.frames && reel.waiting.is_none() {
                self.reel = None;
            }
            ctx.request_repaint();
        }
        let mut files = self.films.poll();
        files.extend(self.pictures.poll());
        files
    }

    /// Gives up the turntable that is being made.
    pub fn cancel(&mut self) {
        self.reel = None;
        self.films.cancel();
    }

    /// Whether a turntable is being made.
    pub fn is_filming(&self) -> bool {
        self.films.is_running()
    }

    /// Whether something is being saved.
    pub fn is_running(&self) -> bool {
        self.films.is_running() || self.pictures.is_running()
    }

    /// The fraction of the turntable that is done.
    pub fn progress(&self) -> f32 {
        self.films.progress()
    }

    /// What went wrong.
    pub fn error(&self) -> Option<&str> {
        self.films.error().or_else(|| self.pictures.error())
    }
}

fn azimuth(start: Orbit, frame: u32, settings: TurnSettings) -> f32 {
    start.azimuth - 360.0 * frame as f32 / settings.frames.max(1) as f32
}

/// Waits for a frame that the window draws; `None` if there is none to come.
fn next_frame(frames: &Receiver<Rgba>, control: &dyn Control) -> Result<Option<Rgba>, String> {
    loop {
        match frames.recv_timeout(Duration::from_millis(30)) {
            Ok(frame) => return Ok(Some(frame)),
            Err(RecvTimeoutError::Disconnected) => return Ok(None),
            Err(RecvTimeoutError::Timeout) if control.is_cancelled() => return Err("cancelled".to_owned()),
            Err(RecvTimeoutError::Timeout) => {}
        }
    }
}

fn one_file(name: &str, bytes: Vec<u8>) -> ViewAction {
    ViewAction::Save { what: "a picture", files: vec![(name.to_owned(), bytes)] }
}

/// Encodes a turn, frame by frame.
fn encode(
    film: Film,
    settings: TurnSettings,
    mut frame: impl FnMut(u32) -> Result<Option<Rgba>, String>,
    control: &dyn Control,
) -> Result<ViewAction, String> {
    let mut files = Vec::new();
    let mut gif = None;
    let delay = (settings.seconds * 100.0 / settings.frames.max(1) as f32).round().clamp(2.0, 1000.0) as u16;
    for i in 0..settings.frames {
        let Some((size, mut bytes)) = frame(i)? else { break };
        match film {
            Film::Pngs => files.push((format!("turntable_{i:04}.png"), png(size, &bytes)?)),
            Film::Gif => {
                let [width, height] = size.map(|n| u16::try_from(n).unwrap_or(u16::MAX));
                let told = |error: gif::EncodingError| error.to_string();
                if gif.is_none() {
                    let mut encoder = gif::Encoder::new(Vec::new(), width, height, &[]).map_err(told)?;
                    encoder.set_repeat(gif::Repeat::Infinite).map_err(told)?;
                    gif = Some(encoder);
                }
                if bytes.len() != 4 * usize::from(width) * usize::from(height) {
                    return Err(format!("a frame of {width} × {height} pixels has {} bytes", bytes.len()));
                }
                let mut frame = gif::Frame::from_rgba_speed(width, height, &mut bytes, 10);
                frame.delay = delay;
                frame.dispose = gif::DisposalMethod::Background;
                if let Some(encoder) = &mut gif {
                    encoder.write_frame(&frame).map_err(told)?;
                }
            }
        }
        control.progress((i + 1) as f32 / settings.frames.max(1) as f32);
    }
    if let Some(encoder) = gif {
        files.push(("turntable.gif".to_owned(), encoder.into_inner().map_err(|error| error.to_string())?));
    }
    Ok(ViewAction::Save { what: "a turntable", files })
}

/// A PNG of RGBA; without alpha where all of it is opaque.
///
/// # Errors
/// If the bytes do not fit the size.
pub fn png([width, height]: [u32; 2], rgba: &[u8]) -> Result<Vec<u8>, String> {
    let opaque = rgba.chunks_exact(4).all(|pixel| pixel.last() == Some(&255));
    let (bytes, kind) = if opaque {
        let rgb = rgba.chunks_exact(4).flat_map(|pixel| pixel.iter().take(3)).copied().collect();
        (Cow::<[u8]>::Owned(rgb), image::ExtendedColorType::Rgb8)
    } else {
        (Cow::Borrowed(rgba), image::ExtendedColorType::Rgba8)
    };
    let expected = u64::from(width) * u64::from(height) * if opaque { 3 } else { 4 };
    if bytes.len() as u64 != expected {
        return Err(format!("{width} × {height} pixels need {expected} bytes, found {}", bytes.len()));
    }
    let mut out = Cursor::new(Vec::new());
    image::codecs::png::PngEncoder::new(&mut out)
        .write_image(&bytes, width, height, kind)
        .map_err(|error| error.to_string())?;
    Ok(out.into_inner())
}

/// A picture as RGBA with its own alpha, where it has one.
pub fn rgba_with_alpha(image: &Image) -> Vec<u8> {
    let mut bytes = pixels::rgba_of(image, pixels::Channel::Color);
    if image.channels() == 4 {
        for (at, pixel) in bytes.chunks_exact_mut(4).enumerate() {
            if let [_, _, _, alpha] = pixel {
                *alpha = image.samples().get_u8(4 * at + 3);
            }
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turn(film: Film) -> Vec<(String, Vec<u8>)> {
        let settings = TurnSettings { frames: 5, side: 8, seconds: 1.0 };
        let frame = |i: u32| Ok(Some(([8, 8], [(40 * i) as u8, 90, 20, 255].repeat(64))));
        match encode(film, settings, frame, &()).unwrap() {
            ViewAction::Save { files, .. } => files,
            ViewAction::Say(text) => panic!("{text}"),
        }
    }

    #[test]
    fn a_turn_of_five_frames_is_five_files_or_a_film_of_five() {
        let files = turn(Film::Pngs);
        assert_eq!(files.len(), 5);
        let third = image::load_from_memory(&files[2].1).unwrap().to_rgb8();
        assert_eq!((third.width(), third.get_pixel(3, 3).0), (8, [80, 90, 20]));
        let film = turn(Film::Gif);
        assert_eq!(film.len(), 1);
        let mut decoder = gif::DecodeOptions::new().read_info(&film[0].1[..]).unwrap();
        let mut frames = 0;
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            assert_eq!((frame.delay, frame.width), (20, 8));
            frames += 1;
        }
        assert_eq!(frames, 5);
    }

    #[test]
    fn a_png_keeps_alpha_only_where_there_is_some() {
        let opaque = png([2, 1], &[1, 2, 3, 255, 4, 5, 6, 255]).unwrap();
        assert_eq!(image::load_from_memory(&opaque).unwrap().color(), image::ColorType::Rgb8);
        let clear = png([1, 1], &[1, 2, 3, 0]).unwrap();
        assert_eq!(image::load_from_memory(&clear).unwrap().color(), image::ColorType::Rgba8);
        assert!(png([2, 2], &[0; 4]).is_err());
    }

    #[test]
    fn frames_are_drawn_one_a_call_and_make_a_film() {
        let Some(state) = super::super::testing::render_state() else { return };
        let (ctx, stage) = (egui::Context::default(), Stage::new(state));
        let mut export = Export::new(None);
        export.settings = TurnSettings { frames: 6, side: 24, seconds: 2.0 };
        export.turntable(&ctx, (Orbit::default(), Props::default()), Film::Pngs);
        let mut files = Vec::new();
        while export.is_running() {
            for action in export.update(&ctx, &stage) {
                if let ViewAction::Save { files: saved, .. } = action {
                    files.extend(saved);
                }
            }
            std::thread::yield_now();
        }
        assert_eq!(export.error(), None);
        let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names.len(), 6);
        assert_eq!((names[0], names[5]), ("turntable_0000.png", "turntable_0005.png"));
    }

    #[test]
    fn a_cancelled_film_leaves_nothing() {
        let Some(state) = super::super::testing::render_state() else { return };
        let (ctx, stage) = (egui::Context::default(), Stage::new(state));
        let mut export = Export::new(None);
        export.turntable(&ctx, (Orbit::default(), Props::default()), Film::Gif);
        export.cancel();
        assert!(!export.is_running() && export.update(&ctx, &stage).is_empty());
    }
}
