//! Samples of solids at points on a compute device: what the kernels that find them have in common.

use breccia_shaders::{Batch, Buffer, Gpu, GpuError, Groups, Kernel};
use bytemuck::NoUninit;

use super::sample::{is_unit, unit_bytes};
use crate::control::Control;
use crate::data::{Map, MapInfo, SampleType, Samples, Tap};

/// Points of a dispatch: 4 MB of points go to the device for 1 MB of bytes that come back.
const PART: usize = 1 << 18;

/// The points of a dispatch, as the kernels' parameters have them.
#[derive(Clone, Copy)]
pub(crate) struct Part {
    /// The first workgroup of a submission.
    pub first: u32,
    /// How many points there are.
    pub points: u32,
    /// Whether sums are wanted, not the bytes they stand for.
    pub sums: u32,
}

/// Whether kernels can sample such a map: bytes, at most four a voxel.
pub(crate) fn can_sample(info: &MapInfo) -> bool {
    info.ty == SampleType::U8 && (1..=4).contains(&info.channels)
}

/// Samples maps that [`can_sample`] allows: a dispatch of `kernel` for each map and part of the points. `params` and `buffers` are
/// told the number of the map; the buffers are those between the points and the answer.
pub(crate) fn sample_maps<'b, P: NoUninit>(
    gpu: &Gpu,
    kernel: &'static Kernel,
    infos: &[MapInfo],
    taps: &[Tap],
    params: &dyn Fn(usize, Part) -> P,
    buffers: &dyn Fn(usize) -> Vec<&'b Buffer>,
    control: &dyn Control,
) -> Result<Vec<Map>, GpuError> {
    let mut maps: Vec<Map> = infos.iter().map(|info| Map::zeros(info, taps.len())).collect();
    let mut words = Vec::new();
    for (part, taps) in taps.chunks(PART).enumerate() {
        let points = gpu.upload(taps)?;
        for (m, map) in maps.iter_mut().enumerate() {
            let sums = is_unit(&infos[m]);
            words.resize(taps.len() * if sums { 4 } else { 1 }, 0u32);
            let out = gpu.zeros(words.len() as u64 * 4)?;
            let mut all = vec![&points];
            all.extend(buffers(m));
            all.push(&out);
            let mut batch = Batch::new(gpu);
            batch.dispatch_long(
                kernel,
                |first| params(m, Part { first, points: taps.len() as u32, sums: sums.into() }),
                &all,
                Groups::for_threads(kernel, taps.len()),
                &|| control.is_cancelled(),
            )?;
            batch.read(&out, &mut words)?;
            if let Samples::U8(to) = &mut map.samples {
                let n = map.channels;
                let to = to[part * PART * n..].chunks_exact_mut(n);
                if sums {
                    let found = words.chunks_exact(4).zip(taps);
                    to.zip(found).for_each(|(to, (sums, tap))| {
                        let sums = [sums[0], sums[1], sums[2], sums[3]];
                        let bytes = if tap.is_single() {
                            sums.map(|sum| (sum >> 24) as u8)
                        } else {
                            unit_bytes(sums)
                        };
                        to.copy_from_slice(&bytes[..n]);
                    });
                } else {
                    to.zip(&words).for_each(|(to, word)| to.copy_from_slice(&word.to_le_bytes()[..n]));
                }
            }
        }
    }
    Ok(maps)
}
