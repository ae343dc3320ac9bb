//! Triple selection on the device: the same triples in the same order.

use breccia_shaders::kernels::TRIPLES;
use breccia_shaders::{Batch, Buffer, Gpu, GpuError, Groups};
use bytemuck::{Pod, Zeroable};

use crate::control::Control;
use crate::lazy::candidates::{CandidateSettings, STRIP, Triple, column_strip, row_strip};
use crate::lazy::pyramid::{LevelView, Pixel};

/// Strips and triples that the kernel has room for.
const MOST_STRIPS: usize = 256;
const MOST_TRIPLES: usize = 400;
/// Words of triples that are made at once.
const PORTION: usize = 16 << 20;

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Params {
    size: [i32; 4],
    next: [u32; 4],
    last: [u32; 4],
    strips: u32,
    most: u32,
    best: u32,
    exclusion: i32,
    start: u32,
    count: u32,
    first: u32,
    rest: u32,
}

/// The strips of a level's views on the device.
pub(in crate::lazy) struct DeviceStrips {
    strips: Buffer,
    centres: Buffer,
    /// For each view its width, where its strips and centres begin, and how many centres there are.
    views: Vec<[u32; 4]>,
}

impl DeviceStrips {
    pub fn new(gpu: &Gpu, views: &[LevelView]) -> Result<Self, GpuError> {
        let (mut strips, mut centres, mut places) = (Vec::<u8>::new(), Vec::<u32>::new(), Vec::new());
        for view in views {
            let own = view.centres();
            places.push([
                view.width as u32,
                (strips.len() / 4) as u32,
                centres.len() as u32,
                own.len() as u32,
            ]);
            centres.extend(own.iter().map(|&pixel| u32::from(pixel)));
            for y in 0..view.height {
                for x in 0..view.width {
                    let pixel = (x | y << 8) as Pixel;
                    strips.extend_from_slice(&row_strip(view, pixel)[..STRIP]);
                    strips.extend_from_slice(&column_strip(view, pixel)[..STRIP]);
                }
            }
        }
        Ok(Self { strips: gpu.upload(&strips)?, centres: gpu.upload(&centres)?, views: places })
    }

    /// The place of a direction's view.
    fn of(&self, direction: usize) -> [u32; 4] {
        self.views[(direction % 3).min(self.views.len() - 1)]
    }

    /// As `consistent_triples` of a direction's view; `None` if the kernel has no room for that many.
    pub fn triples(
        &self,
        gpu: &Gpu,
        view: &LevelView,
        direction: usize,
        settings: &CandidateSettings,
        exclusion: i32,
        control: &dyn Control,
    ) -> Result<Option<Vec<Vec<Triple>>>, GpuError> {
        let (next, last) = (self.of(direction + 1), self.of(direction + 2));
        // Where every centre might be excluded, the processor falls back to all of them.
        let crowd = (2 * i64::from(exclusion.max(0)) - 1).pow(2);
        let tiny = exclusion > 0 && i64::from(next[3].min(last[3])) <= crowd;
        let fits =
            (1..=MOST_STRIPS).contains(&settings.strips) && (1..=MOST_TRIPLES).contains(&settings.best);
        if tiny || !fits {
            return Ok(None);
        }
        let of_pixel = 1 + 2 * settings.best;
        let pixels = (view.width * view.height) as usize;
        let room = PORTION.min((gpu.largest_binding().min(gpu.memory_budget() / 2) / 4) as usize);
        let portion = (room / of_pixel).clamp(1, pixels);
        let out = gpu.zeros((portion * of_pixel * 4) as u64)?;
        let params = Params {
            size: [view.width, view.height, view.tileable.into(), view.margin()],
            next,
            last,
            strips: self.of(direction)[1],
            most: settings.strips as u32,
            best: settings.best as u32,
            exclusion,
            start: 0,
            count: 0,
            first: 0,
            rest: 0,
        };
        let mut batch = Batch::new(gpu);
        let mut sets = Vec::with_capacity(pixels);
        let mut words = vec![0u32; portion * of_pixel];
        // Keys that are looked at for every digit.
        let work = f64::from(next[3]) + f64::from(last[3]) + (settings.strips as f64).powi(2);
        for start in (0..pixels).step_by(portion) {
            let count = portion.min(pixels - start);
            batch.dispatch_weighed(
                &TRIPLES,
                work,
                |first| Params { start: start as u32, count: count as u32, first, ..params },
                &[&self.strips, &self.centres, &out],
                Groups(count as u32),
                &|| control.is_cancelled(),
            )?;
            let words = &mut words[..count * of_pixel];
            batch.read(&out, words)?;
            sets.extend(words.chunks_exact(of_pixel).map(|words| {
                let found = words[1..].chunks_exact(2).take(words[0] as usize);
                let triple =
                    |w: &[u32]| Triple { next: w[0] as Pixel, last: (w[0] >> 16) as Pixel, crossbar: w[1] };
                found.map(triple).collect()
            }));
        }
        Ok(Some(sets))
    }
}
