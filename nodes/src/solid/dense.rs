//! A dense volume as a solid: repeated periodically, or continued by its nearest voxel.

use std::sync::{Arc, OnceLock};

use breccia_engine::{Data, Digest};
use breccia_shaders::Gpu;
use breccia_shaders::kernels::SAMPLE_DENSE;
use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::device::{can_sample, sample_maps};
use crate::control::{Cancelled, Control, check};
use crate::data::{
    BRICK, BRICK_VOXELS, Extent, Map, MapInfo, SampleType, Samples, Solid, SolidError, Tap, Volume, VoxelMap,
    VoxelSet,
};

/// How a volume goes on beyond its box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repeat {
    /// It repeats along all three axes.
    Periodic,
    /// Voxels outside take the nearest voxel inside.
    Clamp,
}

/// Why a volume cannot serve as a solid.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotASolid {
    /// The volume has no colours.
    #[error("a solid needs a map `color`, the volume holds {0}")]
    NoColor(String),
    /// The volume has no voxels.
    #[error("a volume of {0} × {1} × {2} voxels is empty")]
    Empty(usize, usize, usize),
    /// An edge is longer than voxel coordinates reach.
    #[error("an edge of {0} voxels is longer than 2147483647")]
    TooLong(usize),
    /// A map's samples do not fit the box.
    #[error("map `{name}` holds {found} samples, the box needs {expected}")]
    WrongLength {
        /// The map's name.
        name: String,
        /// Samples found.
        found: usize,
        /// Samples needed.
        expected: usize,
    },
}

/// `Params` of `kernels/solid/sample.wgsl`.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct SampleParams {
    origin: [i32; 4],
    size: [i32; 4],
    first: u32,
    points: u32,
    channels: u32,
    sums: u32,
}

/// A dense volume as a solid.
#[derive(Clone, Debug)]
pub struct VolumeSolid {
    volume: Arc<Volume>,
    repeat: Repeat,
    /// Under what each map is kept on a device, once it was asked for.
    ids: Vec<OnceLock<[u8; 32]>>,
}

impl VolumeSolid {
    /// A solid of the volume's voxels. Colours become three u8 channels: grey is repeated, alpha dropped,
    /// floats are taken as sRGB fractions; `color` becomes the first map. Nothing is copied if that holds already.
    ///
    /// # Errors
    /// If there are no voxels or no colours, or a map does not fit the box.
    pub fn new(volume: Arc<Volume>, repeat: Repeat) -> Result<Self, NotASolid> {
        let [x, y, z] = volume.size;
        if volume.size.contains(&0) {
            return Err(NotASolid::Empty(x, y, z));
        }
        if let Some(&long) = volume.size.iter().find(|&&n| i32::try_from(n).is_err()) {
            return Err(NotASolid::TooLong(long));
        }
        for map in &volume.maps {
            let expected = volume.voxels().saturating_mul(map.channels);
            if map.samples.len() != expected || map.channels == 0 {
                let (name, found) = (map.name.clone(), map.samples.len());
                return Err(NotASolid::WrongLength { name, found, expected });
            }
        }
        let Some(at) = volume.maps.iter().position(|map| map.name == "color") else {
            let names: Vec<_> = volume.maps.iter().map(|map| format!("`{}`", map.name)).collect();
            let found = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
            return Err(NotASolid::NoColor(found));
        };
        let plain = |map: &Map| map.channels == 3 && map.samples.ty() == SampleType::U8;
        if at == 0 && volume.maps.first().is_some_and(plain) {
            return Ok(Self::of(volume, repeat));
        }
        let mut volume = Arc::unwrap_or_clone(volume);
        let mut color = volume.maps.remove(at);
        if !plain(&color) {
            let count = color.samples.len() / color.channels;
            let step = usize::from(color.channels > 2);
            let rgb = (0..count).flat_map(|i| [0, step, 2 * step].map(|c| i * color.channels + c));
            let rgb = rgb.map(|sample| color.samples.get_u8(sample)).collect();
            color = Map { name: color.name, channels: 3, samples: Samples::U8(rgb) };
        }
        volume.maps.insert(0, color);
        Ok(Self::of(Arc::new(volume), repeat))
    }

    fn of(volume: Arc<Volume>, repeat: Repeat) -> Self {
        Self { ids: vec![OnceLock::new(); volume.maps.len()], volume, repeat }
    }

    /// The volume, with its colours as u8 RGB in front.
    pub fn volume(&self) -> &Arc<Volume> {
        &self.volume
    }

    /// The indices along one axis of the eight voxels of a brick.
    fn places(&self, brick: i32, axis: usize) -> [usize; BRICK as usize] {
        let size = self.volume.size[axis] as i64;
        std::array::from_fn(|i| {
            let at = i64::from(brick) * i64::from(BRICK) + i as i64 - i64::from(self.volume.origin[axis]);
            let inside = match self.repeat {
                Repeat::Periodic => at.rem_euclid(size),
                Repeat::Clamp => at.clamp(0, size - 1),
            };
            inside as usize
        })
    }
}

impl Solid for VolumeSolid {
    fn maps(&self) -> Vec<MapInfo> {
        self.volume.maps.iter().map(Map::info).collect()
    }

    fn extent(&self) -> Extent {
        let size = self.volume.size.map(|n| n as u32);
        match self.repeat {
            Repeat::Periodic => Extent::Periodic(size),
            Repeat::Clamp => Extent::Bounded(self.volume.origin, size),
        }
    }

    fn evaluate(&self, voxels: &VoxelSet, control: &dyn Control) -> Result<VoxelMap, SolidError> {
        let bricks = voxels.bricks();
        let mut answer = VoxelMap::new(&bricks, &self.maps());
        for (to, from) in answer.maps.iter_mut().zip(&self.volume.maps) {
            let n = from.channels;
            match (&mut to.samples, &from.samples) {
                (Samples::U8(to), Samples::U8(from)) => self.gather(&bricks, from, to, n, control)?,
                (Samples::U32(to), Samples::U32(from)) => self.gather(&bricks, from, to, n, control)?,
                (Samples::F32(to), Samples::F32(from)) => self.gather(&bricks, from, to, n, control)?,
                (to, from) => debug_assert!(false, "{:?} answers {:?}", to.ty(), from.ty()),
            }
        }
        Ok(answer)
    }

    fn sample(
        &self,
        gpu: &Gpu,
        maps: &[MapInfo],
        taps: &[Tap],
        control: &dyn Control,
    ) -> Result<Option<Vec<Map>>, SolidError> {
        let (origin, size) = (self.volume.origin, self.volume.size);
        let within = |i: usize| size[i] < 1 << 30 && origin[i].checked_add(size[i] as i32).is_some();
        let fits = |map: &MapInfo| {
            can_sample(map)
                && self.bytes(map).is_some_and(|(_, bytes)| bytes.len() as u64 <= gpu.largest_binding())
        };
        if !(0..3).all(within) || !maps.iter().all(fits) {
            return Ok(None);
        }
        let sampled = gpu.scope(|| {
            let volume = |map: &MapInfo| {
                let (id, bytes) = self.bytes(map).unwrap_or_default();
                gpu.resident(id, || gpu.upload(bytes))
            };
            let volumes = maps.iter().map(volume).collect::<Result<Vec<_>, _>>()?;
            let params = |m: usize, part: super::device::Part| SampleParams {
                origin: [origin[0], origin[1], origin[2], (self.repeat == Repeat::Periodic).into()],
                size: [size[0] as i32, size[1] as i32, size[2] as i32, 0],
                first: part.first,
                points: part.points,
                channels: maps[m].channels as u32,
                sums: part.sums,
            };
            sample_maps(gpu, &SAMPLE_DENSE, maps, taps, &params, &|m| vec![&*volumes[m]], control)
        });
        Ok(Some(sampled?))
    }

    fn digest(&self) -> Digest {
        let mut hasher = blake3::Hasher::new();
        hasher.update(b"dense").update(&[self.repeat as u8]).update(&self.volume.digest().0);
        hasher.finalize().into()
    }

    fn summary(&self) -> String {
        let repeat = match self.repeat {
            Repeat::Periodic => "repeated",
            Repeat::Clamp => "bounded",
        };
        format!("{}, {repeat}", self.volume.summary())
    }

    fn byte_size(&self) -> u64 {
        self.volume.byte_size()
    }
}

impl VolumeSolid {
    /// The bytes of a map, if it has that form, and their digest: what a volume holds is the same under another name, and however
    /// it goes on.
    fn bytes(&self, info: &MapInfo) -> Option<([u8; 32], &[u8])> {
        let number = self.volume.maps.iter().position(|map| map.name == info.name)?;
        let map = self.volume.maps.get(number).filter(|map| map.info() == *info)?;
        match &map.samples {
            Samples::U8(bytes) => {
                Some((*self.ids.get(number)?.get_or_init(|| *blake3::hash(bytes).as_bytes()), bytes))
            }
            _ => None,
        }
    }

    /// Fills whole bricks of one map.
    fn gather<T: Copy + Send + Sync>(
        &self,
        bricks: &[[i32; 3]],
        from: &[T],
        to: &mut [T],
        channels: usize,
        control: &dyn Control,
    ) -> Result<(), Cancelled> {
        to.par_chunks_mut(BRICK_VOXELS * channels).zip(bricks).try_for_each(|(to, brick)| {
            check(control)?;
            let [xs, ys, zs]: [_; 3] = std::array::from_fn(|axis| self.places(brick[axis], axis));
            let mut pixels = to.chunks_exact_mut(channels);
            for z in zs {
                for y in ys {
                    for (x, to) in xs.into_iter().zip(&mut pixels) {
                        let at = self.volume.index(x, y, z) * channels;
                        to.copy_from_slice(&from[at..at + channels]);
                    }
                }
            }
            Ok(())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume(size: [usize; 3], origin: [i32; 3]) -> Arc<Volume> {
        let count: usize = size.iter().product();
        let color = (0..count * 3).map(|i| (i * 37 % 251) as u8).collect();
        let label = (0..count as u32).collect();
        let maps = vec![
            Map { name: "label".into(), channels: 1, samples: Samples::U32(label) },
            Map { name: "color".into(), channels: 3, samples: Samples::U8(color) },
        ];
        Arc::new(Volume { size, origin, spacing: [1.0; 3], maps })
    }

    fn label(solid: &VolumeSolid, voxel: [i32; 3]) -> u32 {
        let answer = solid.evaluate(&VoxelSet::from_iter([voxel]), &()).unwrap();
        let at = answer.index(voxel).unwrap();
        answer.map("label").unwrap().samples.get(at) as u32
    }

    #[test]
    fn a_periodic_volume_repeats_and_a_clamped_one_ends() {
        let (size, origin) = ([3, 5, 4], [-2, 7, 1]);
        let volume = volume(size, origin);
        let periodic = VolumeSolid::new(Arc::clone(&volume), Repeat::Periodic).unwrap();
        let clamped = VolumeSolid::new(Arc::clone(&volume), Repeat::Clamp).unwrap();
        for voxel in [[-2, 7, 1], [0, 11, 4], [1, 12, 5], [-3, 6, 0], [40, -40, 17], [i32::MAX, i32::MIN, 3]]
        {
            let local: [i64; 3] = std::array::from_fn(|i| i64::from(voxel[i]) - i64::from(origin[i]));
            let wrapped: [usize; 3] = std::array::from_fn(|i| local[i].rem_euclid(size[i] as i64) as usize);
            let nearest: [usize; 3] = std::array::from_fn(|i| local[i].clamp(0, size[i] as i64 - 1) as usize);
            let expected = |[x, y, z]: [usize; 3]| volume.index(x, y, z) as u32;
            assert_eq!(label(&periodic, voxel), expected(wrapped), "{voxel:?} periodic");
            assert_eq!(label(&clamped, voxel), expected(nearest), "{voxel:?} clamped");
        }
    }

    #[test]
    fn colours_come_first_as_three_bytes() {
        let grey = Map { name: "color".into(), channels: 1, samples: Samples::F32(vec![0.0, 1.0]) };
        let volume = Volume { size: [2, 1, 1], origin: [0; 3], spacing: [1.0; 3], maps: vec![grey] };
        let solid = VolumeSolid::new(Arc::new(volume), Repeat::Clamp).unwrap();
        assert_eq!(solid.volume().maps[0].samples, Samples::U8(vec![0, 0, 0, 255, 255, 255]));
        let both = VolumeSolid::new(self::volume([2, 2, 2], [0; 3]), Repeat::Clamp).unwrap();
        let names: Vec<_> = both.maps().into_iter().map(|map| map.name).collect();
        assert_eq!(names, ["color", "label"]);
    }

    #[test]
    fn on_the_device_samples_of_a_volume_are_the_same_bit_for_bit() {
        use crate::control::testing::OnDevice;
        use crate::data::Filter;
        use crate::solid::sample;

        let Some(device) = OnDevice::open(Default::default()) else { return };
        let (size, origin) = ([13, 5, 9], [-2, 7, -30]);
        let count = 13 * 5 * 9;
        let bytes =
            |n: usize, step: usize| Samples::U8((0..count * n).map(|i| (i * step % 251) as u8).collect());
        let maps =
            [("color", 3, 37), ("normal", 3, 101), ("roughness", 1, 11), ("flow", 2, 7), ("rest", 4, 67)];
        let maps = maps.map(|(name, channels, step)| Map {
            name: name.to_owned(),
            channels,
            samples: bytes(channels, step),
        });
        let volume = Arc::new(Volume { size, origin, spacing: [1.0; 3], maps: maps.to_vec() });
        for repeat in [Repeat::Periodic, Repeat::Clamp] {
            let solid = VolumeSolid::new(Arc::clone(&volume), repeat).unwrap();
            for filter in [Filter::Nearest, Filter::Trilinear] {
                let far = [[2e9, -2e9, 0.3], [-2_147_483_630.0, 2_147_483_630.0, 1.0]];
                let near =
                    (0..3000).map(|i| [0.373, 0.611, -0.437].map(|step| f64::from(i % 97) * step - 20.0));
                let taps: Vec<Tap> = near.chain(far).filter_map(|point| Tap::new(point, filter)).collect();
                assert_eq!(taps.len(), 3002);
                let on_cpu = sample(&solid, &solid.maps(), &taps, &()).unwrap();
                let on_gpu = solid.sample(&device.gpu, &solid.maps(), &taps, &device).unwrap();
                assert_eq!(on_gpu.expect("on the device"), on_cpu, "{repeat:?} {filter:?}");
            }
        }
        // The volume is uploaded once, whatever is asked of it.
        assert_eq!(device.gpu.traffic().resident, 5);
    }

    #[test]
    fn what_cannot_be_a_solid_is_refused() {
        let empty = Volume { size: [0, 1, 1], origin: [0; 3], spacing: [1.0; 3], maps: Vec::new() };
        assert_eq!(
            VolumeSolid::new(Arc::new(empty.clone()), Repeat::Clamp).unwrap_err(),
            NotASolid::Empty(0, 1, 1)
        );
        let bare = Volume { size: [1, 1, 1], ..empty };
        assert_eq!(
            VolumeSolid::new(Arc::new(bare), Repeat::Clamp).unwrap_err(),
            NotASolid::NoColor("none".into())
        );
    }
}
