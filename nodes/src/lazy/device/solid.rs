//! The lazily synthesised solid on a device: how it asks, and what it does if there is no answer.

use breccia_engine::Data;
use breccia_shaders::{Gpu, GpuError};

use super::{Carried, DeviceTables, Finished, Request};
use crate::control::Control;
use crate::data::{Map, MapInfo, SolidError, Tap, VoxelSet};
use crate::lazy::field::Field;
use crate::lazy::solid::{LazySolid, Work};
use crate::solid::voxels_of;

/// Points whose bricks must fit into a device's memory at once, or are found on the processor.
const FEW_POINTS: usize = 64;

impl LazySolid {
    /// As [`Self::synthesise`] of the finest level, on a device; on the processor after all if the device is lost.
    pub(in crate::lazy) fn synthesise_on(
        &self,
        gpu: &Gpu,
        wanted: &VoxelSet,
        work: &mut Work,
        control: &dyn Control,
    ) -> Result<Field, SolidError> {
        match self.request_on(gpu, wanted, control, |request, tables| request.run(gpu, tables, control)) {
            Err(SolidError::Device(error @ GpuError::Lost(_))) => {
                control.device_lost(&error);
                self.synthesise(0, wanted, work, control)
            }
            answer => answer,
        }
    }

    /// Puts a request for voxels (wrapped) to a device.
    fn request_on<T>(
        &self,
        gpu: &Gpu,
        wanted: &VoxelSet,
        control: &dyn Control,
        ask: impl FnOnce(&Request<'_>, &DeviceTables) -> Result<T, GpuError>,
    ) -> Result<T, SolidError> {
        let mut free = self.taken.as_ref().map(|(taken, _)| taken.free(control));
        let before = match &mut free {
            Some(free) => self.depend_among(free, 0, wanted)?.before,
            None => VoxelSet::new(),
        };
        let weights = |level: usize| self.weights(level);
        let request = Request {
            tables: &self.tables,
            initial: &self.initial,
            settings: &self.settings,
            weights: &weights,
            wanted,
            taken: free
                .as_ref()
                .zip(self.taken.as_ref())
                .map(|(free, (_, marker))| (&before, &free.free, *marker)),
        };
        let tables =
            gpu.resident(self.digest.0, || gpu.scope(|| DeviceTables::new(gpu, &self.tables, &self.initial)));
        Ok(ask(&request, &*tables?)?)
    }

    /// Samples maps by their numbers, in portions where the bricks do not fit into the device's memory at once.
    pub(in crate::lazy) fn sample_on(
        &self,
        gpu: &Gpu,
        infos: &[MapInfo],
        numbers: &[usize],
        taps: &[Tap],
        control: &dyn Control,
    ) -> Result<Vec<Map>, SolidError> {
        let wanted = self.domain(0).wrap_set(&voxels_of(taps));
        // Bricks stay, since the same points are often asked for again, with another map or filter.
        let id = self.id(b"bricks", &wanted.digest().0);
        let finished = self.request_on(gpu, &wanted, control, |request, tables| {
            gpu.resident(id, || gpu.scope(|| Finished::new(gpu, request.resident(gpu, tables, control)?)))
        });
        let finished = match finished {
            Err(SolidError::Device(GpuError::OutOfMemory(_))) if taps.len() > FEW_POINTS => {
                let mut maps: Vec<Map> = infos.iter().map(|info| Map::zeros(info, taps.len())).collect();
                let mut at = 0;
                for taps in taps.chunks(taps.len().div_ceil(2)) {
                    for (map, part) in
                        maps.iter_mut().zip(self.sample_on(gpu, infos, numbers, taps, control)?)
                    {
                        map.samples.copy_from(at * map.channels, &part.samples, 0, part.samples.len());
                    }
                    at += taps.len();
                }
                return Ok(maps);
            }
            found => found?,
        };
        let carried = |&number: &usize| {
            let id = self.id(b"map", &(number as u64).to_le_bytes());
            gpu.resident(id, || gpu.scope(|| Carried::new(gpu, &self.tables, number)))
        };
        let carried = numbers.iter().map(carried).collect::<Result<Vec<_>, _>>()?;
        let mean = |number: usize| number == 0 && !self.color(0).takes_one();
        let carried: Vec<_> =
            carried.iter().zip(numbers).map(|(map, &number)| (&**map, mean(number))).collect();
        Ok(gpu.scope(|| finished.sample(gpu, infos, &carried, taps, &self.domain(0), control))?)
    }

    /// What is kept on a device under this solid's digest and a name.
    fn id(&self, kind: &[u8], name: &[u8]) -> [u8; 32] {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&self.digest.0).update(kind).update(name);
        *hasher.finalize().as_bytes()
    }
}
