//! Samples at points, from bricks that stay on the device.

use breccia_shaders::kernels::SAMPLE_LAZY;
use breccia_shaders::{Buffer, Gpu, GpuError};
use bytemuck::{Pod, Zeroable};

use super::synthesis::DeviceState;
use super::tables::period;
use crate::control::Control;
use crate::data::{Map, MapInfo, Tap};
use crate::lazy::domain::Domain;
use crate::lazy::tables::Tables;
use crate::solid::device::{Part, sample_maps};

/// Finished bricks on the device, and the table in which their keys are looked up.
pub(in crate::lazy) struct Finished {
    state: Buffer,
    places: Buffer,
    mask: u32,
}

/// One of the exemplar's maps on the device.
pub(in crate::lazy) struct Carried {
    /// The map of every view, one behind the other.
    bytes: Buffer,
    /// For each direction the width of its view, and where the view's map begins.
    views: [[u32; 4]; 3],
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct SampleParams {
    period: [i32; 4],
    views: [[u32; 4]; 3],
    first: u32,
    points: u32,
    channels: u32,
    sums: u32,
    mask: u32,
    own: u32,
    rest: [u32; 2],
}

impl Finished {
    pub fn new(gpu: &Gpu, DeviceState { bricks, state }: DeviceState) -> Result<Self, GpuError> {
        let places = bricks.places();
        Ok(Self { state, mask: places.len() as u32 - 1, places: gpu.upload(&places)? })
    }

    /// The samples of maps at points, given the maps and, for each, whether bricks show a colour of their own in its place.
    pub fn sample(
        &self,
        gpu: &Gpu,
        infos: &[MapInfo],
        carried: &[(&Carried, bool)],
        taps: &[Tap],
        domain: &Domain,
        control: &dyn Control,
    ) -> Result<Vec<Map>, GpuError> {
        let params = |m: usize, part: Part| SampleParams {
            period: period(domain),
            views: carried[m].0.views,
            first: part.first,
            points: part.points,
            channels: infos[m].channels as u32,
            sums: part.sums,
            mask: self.mask,
            own: carried[m].1.into(),
            rest: [0; 2],
        };
        let buffers = |m: usize| vec![&self.places, &self.state, &carried[m].0.bytes];
        sample_maps(gpu, &SAMPLE_LAZY, infos, taps, &params, &buffers, control)
    }
}

impl Carried {
    /// The map of that number.
    pub fn new(gpu: &Gpu, tables: &Tables, map: usize) -> Result<Self, GpuError> {
        let mut bytes = Vec::new();
        let mut starts = Vec::new();
        for maps in &tables.carried {
            starts.push(bytes.len() as u32);
            bytes.extend_from_slice(maps[map].samples.bytes());
        }
        let view = |e: usize| {
            let width = tables.levels[0].view(e).view.width as u32;
            [width, starts[e.min(starts.len() - 1)], 0, 0]
        };
        Ok(Self { bytes: gpu.upload(&bytes)?, views: [view(0), view(1), view(2)] })
    }
}
