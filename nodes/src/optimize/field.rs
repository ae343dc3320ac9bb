//! The state of an optimisation: colours, and where they came from.

use breccia_engine::{Data, Digest};

use crate::data::{Reader, Writer};
use crate::lazy::Pixel;

/// A box of voxels at one level, repeating along all axes. Voxels are in the order z, y, x, x fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Voxels along x, y and z.
    pub size: [usize; 3],
    /// The level, 0 the finest.
    pub level: usize,
    /// The colour and feature of every voxel.
    pub colors: Vec<[u8; 4]>,
    /// For each view of the exemplar and each voxel the texel of that view that is nearest to the voxel's colour among
    /// those that overlap there.
    pub sources: Vec<Vec<Pixel>>,
    /// For each voxel the view that its colour came from; empty if there is one view only.
    pub chosen: Vec<u8>,
    /// For each view and pixel how many neighbourhoods matched there when the field was solved: the index histogram. Empty
    /// if nothing has been matched yet.
    pub index: Vec<Vec<u32>>,
}

/// The size of a box at a level: each level halves it, rounding up.
pub fn level_size(size: [usize; 3], level: usize) -> [usize; 3] {
    size.map(|n| n.div_ceil(1 << level).max(1))
}

impl Field {
    /// Voxels in all.
    pub fn voxels(&self) -> usize {
        self.size.iter().product()
    }

    /// The view that a voxel's colour came from.
    pub fn view_of(&self, voxel: usize) -> usize {
        self.chosen.get(voxel).map_or(0, |&view| usize::from(view))
    }
}

impl Data for Field {
    const TYPE: &'static str = "field";
    const DOCS: &'static str =
        "Voxels of an optimisation at one level, and where in the exemplar their colours came from.";

    fn byte_size(&self) -> u64 {
        let sources: usize = self.sources.iter().map(Vec::len).sum();
        let index: usize = self.index.iter().map(Vec::len).sum();
        (self.colors.len() * 4 + sources * 2 + self.chosen.len() + index * 4) as u64
    }

    fn summary(&self) -> String {
        let [x, y, z] = self.size;
        format!("{x} × {y} × {z} voxels of level {}, {:.1} MB", self.level, self.byte_size() as f64 / 1e6)
    }

    fn digest(&self) -> Digest {
        let mut hasher = blake3::Hasher::new();
        hasher
            .update(bytemuck::cast_slice(&self.size.map(|n| n as u64)))
            .update(&(self.level as u64).to_le_bytes());
        hasher.update(bytemuck::cast_slice(&self.colors));
        for sources in &self.sources {
            hasher.update(bytemuck::cast_slice(sources));
        }
        hasher.update(&self.chosen);
        for index in &self.index {
            hasher.update(bytemuck::cast_slice(index));
        }
        hasher.finalize().into()
    }

    fn encode(&self) -> Option<Vec<u8>> {
        let mut out = Writer::new();
        out.array(&self.size.map(|n| n as u64)).u64(self.level as u64).array(&self.colors);
        out.u64(self.sources.len() as u64);
        self.sources.iter().for_each(|sources| {
            out.array(sources);
        });
        out.array(&self.chosen).u64(self.index.len() as u64);
        self.index.iter().for_each(|index| {
            out.array(index);
        });
        Some(out.finish())
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = Reader::new(bytes);
        let size: Vec<u64> = reader.array()?;
        let size: [u64; 3] = size.try_into().map_err(|_| "expected three numbers".to_owned())?;
        let size = size.map(|n| n as usize);
        let level = reader.u64()? as usize;
        let colors: Vec<[u8; 4]> = reader.array()?;
        let sources = (0..reader.u64()?).map(|_| reader.array()).collect::<Result<Vec<_>, _>>()?;
        let chosen: Vec<u8> = reader.array()?;
        let index = (0..reader.u64()?).map(|_| reader.array()).collect::<Result<Vec<_>, _>>()?;
        reader.end()?;
        let voxels = size.iter().try_fold(1usize, |n, &m| n.checked_mul(m));
        let fits = voxels == Some(colors.len())
            && !sources.is_empty()
            && sources.iter().all(|s| s.len() == colors.len())
            && (chosen.is_empty() || chosen.len() == colors.len())
            && chosen.iter().all(|&view| usize::from(view) < sources.len());
        if !fits {
            return Err("the voxels do not fit the size".to_owned());
        }
        Ok(Self { size, level, colors, sources, chosen, index })
    }
}
