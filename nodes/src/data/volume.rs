//! A dense box of voxels.

use breccia_engine::{Data, Digest};

use super::{Map, Reader, Writer};

/// A dense box of voxels with one or more maps. Sample order is Z, Y, X, channel (x fastest of the axes).
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Voxels along x, y and z.
    pub size: [usize; 3],
    /// The voxel coordinate of the first voxel.
    pub origin: [i32; 3],
    /// The edges of a voxel in world units.
    pub spacing: [f32; 3],
    /// The maps; `color` first where there is one.
    pub maps: Vec<Map>,
}

impl Volume {
    /// The index of a voxel, to be multiplied by a map's channels.
    pub fn index(&self, x: usize, y: usize, z: usize) -> usize {
        (z * self.size[1] + y) * self.size[0] + x
    }

    /// Voxels in all.
    pub fn voxels(&self) -> usize {
        self.size.iter().product()
    }

    /// The map of that name.
    pub fn map(&self, name: &str) -> Option<&Map> {
        self.maps.iter().find(|map| map.name == name)
    }
}

impl Data for Volume {
    const TYPE: &'static str = "volume";
    const DOCS: &'static str = "A dense box of voxels with one or more maps.";

    fn byte_size(&self) -> u64 {
        self.maps.iter().map(|map| map.samples.byte_size()).sum()
    }

    fn summary(&self) -> String {
        let [x, y, z] = self.size;
        let size = if x == y && y == z { format!("{x}³") } else { format!("{x} × {y} × {z}") };
        let names: Vec<_> = self.maps.iter().map(|map| map.name.as_str()).collect();
        format!("{size} voxels, {}, {:.1} MB", names.join(" + "), self.byte_size() as f64 / 1e6)
    }

    fn digest(&self) -> Digest {
        let mut hasher = blake3::Hasher::new();
        hasher.update(bytemuck::cast_slice(&self.size.map(|n| n as u64)));
        hasher.update(bytemuck::cast_slice(&self.origin));
        hasher.update(bytemuck::cast_slice(&self.spacing));
        for map in &self.maps {
            hasher.update(map.name.as_bytes()).update(&[0, map.channels as u8, map.samples.ty() as u8]);
            hasher.update(map.samples.bytes());
        }
        hasher.finalize().into()
    }

    fn encode(&self) -> Option<Vec<u8>> {
        let mut out = Writer::new();
        out.array(&self.size.map(|n| n as u64)).array(&self.origin).array(&self.spacing);
        out.u64(self.maps.len() as u64);
        self.maps.iter().for_each(|map| map.write(&mut out));
        Some(out.finish())
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        fn three<T>(items: Vec<T>) -> Result<[T; 3], String> {
            items.try_into().map_err(|_| "expected three numbers".to_owned())
        }
        let mut reader = Reader::new(bytes);
        let mut volume = Self {
            size: three(reader.array::<u64>()?)?.map(|n| n as usize),
            origin: three(reader.array()?)?,
            spacing: three(reader.array()?)?,
            maps: Vec::new(),
        };
        for _ in 0..reader.u64()? {
            volume.maps.push(Map::read(&mut reader)?);
        }
        reader.end()?;
        let voxels = volume.size.iter().try_fold(1usize, |n, &m| n.checked_mul(m));
        if volume
            .maps
            .iter()
            .any(|map| voxels.and_then(|n| n.checked_mul(map.channels)) != Some(map.samples.len()))
        {
            return Err("a map does not fit the size".to_owned());
        }
        Ok(volume)
    }
}
