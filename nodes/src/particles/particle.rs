//! Particles: voxels that belong together, each with the pixel of a picture that it shows.

use std::sync::Arc;

use breccia_engine::{Data, Digest};
use serde::{Deserialize, Serialize};

use super::bits::Bits;
use super::section::Sections;
use crate::data::{MapInfo, Reader, Writer, pack, unpack};
use crate::exemplar::View;

/// What a voxel outside the particle shows.
pub const NOTHING: u32 = u32::MAX;

/// One particle, voxel by voxel around its centre.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Particle {
    /// The cross-sections that it was made of, of the views normal to x, y and z.
    pub sections: [u32; 3],
    /// The pixel of each that lies at its centre.
    pub centers: [[i32; 2]; 3],
    /// How badly they fitted, 0 to 3.
    pub error: f32,
    /// The first voxel of its box, from the centre.
    pub low: [i32; 3],
    /// The edges of its box in voxels.
    pub size: [u32; 3],
    /// For each voxel of the box (x fastest) the view (upper two bits) and the pixel that it shows, or [`NOTHING`].
    pub source: Vec<u32>,
    /// Voxels.
    pub volume: u32,
}

impl Particle {
    /// The index of a voxel, given from the centre, in [`Particle::source`].
    #[inline]
    pub fn index(&self, voxel: [i32; 3]) -> Option<usize> {
        let at: [i32; 3] = std::array::from_fn(|a| voxel[a] - self.low[a]);
        let inside = (0..3).all(|a| at[a] >= 0 && (at[a] as u32) < self.size[a]);
        let [x, y, z] = at.map(|c| c as usize);
        inside.then(|| (z * self.size[1] as usize + y) * self.size[0] as usize + x)
    }

    /// Whether a voxel, given from the centre, belongs to the particle.
    #[inline]
    pub fn holds(&self, voxel: [i32; 3]) -> bool {
        self.index(voxel).is_some_and(|i| self.source[i] != NOTHING)
    }

    /// The voxels, from the centre, x fastest.
    pub fn voxels(&self) -> impl Iterator<Item = [i32; 3]> + '_ {
        let [w, h, _] = self.size.map(|n| n as usize);
        self.source.iter().enumerate().filter(|(_, source)| **source != NOTHING).map(move |(i, _)| {
            let at = [i % w, i / w % h, i / w / h];
            std::array::from_fn(|a| self.low[a] + at[a] as i32)
        })
    }

    /// The voxels as bits.
    pub fn bits(&self) -> Bits {
        Bits::from_fn(self.low, self.size, |v| self.holds(v))
    }

    /// The particle with its box cut to its voxels; `None` if it has none.
    pub fn trimmed(self) -> Option<Self> {
        let (mut low, mut high) = ([i32::MAX; 3], [i32::MIN; 3]);
        let mut volume = 0;
        for voxel in self.voxels() {
            volume += 1;
            for a in 0..3 {
                low[a] = low[a].min(voxel[a]);
                high[a] = high[a].max(voxel[a]);
            }
        }
        if volume == 0 {
            return None;
        }
        let size: [u32; 3] = std::array::from_fn(|a| high[a].abs_diff(low[a]) + 1);
        let mut source = Vec::with_capacity(size.iter().map(|&n| n as usize).product());
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                if let Some(from) = self.index([low[0], y, z]) {
                    source.extend_from_slice(&self.source[from..][..size[0] as usize]);
                }
            }
        }
        Some(Self { low, size, source, volume, ..self })
    }
}

/// Particles with the pictures that they show.
#[derive(Clone, Debug)]
pub struct ParticleSet {
    /// The cross-sections of one picture that serves all directions, or of the views normal to x, y and z.
    pub views: Vec<Arc<Sections>>,
    /// The particles.
    pub particles: Vec<Particle>,
    /// Triples that could not be made into a particle.
    pub discarded: u32,
}

impl ParticleSet {
    /// The cross-sections of a view (0 = normal to x).
    pub fn view(&self, view: usize) -> &Arc<Sections> {
        &self.views[view.min(self.views.len() - 1)]
    }

    /// The picture and the pixel that a voxel of a particle shows; `None` for [`NOTHING`].
    #[inline]
    pub fn shown(&self, source: u32) -> Option<(&View, usize)> {
        (source != NOTHING)
            .then(|| (&self.view((source >> 30) as usize).view, (source & 0x3fff_ffff) as usize))
    }

    /// The colour that a voxel of a particle shows; black for [`NOTHING`].
    pub fn color(&self, source: u32) -> [u8; 3] {
        let Some((view, pixel)) = self.shown(source) else { return [0; 3] };
        view.carried.first().map_or([0; 3], |(_, image)| {
            let i = pixel as u32;
            image.rgb8(i % view.width, i / view.width)
        })
    }

    /// The maps that voxels of particles have; `color` first.
    pub fn maps(&self) -> Vec<MapInfo> {
        self.views[0].view.map_infos()
    }

    /// The mean fraction of the pictures that particles cover.
    pub fn fraction(&self) -> f64 {
        self.views.iter().map(|v| f64::from(v.fraction)).sum::<f64>() / self.views.len() as f64
    }

    /// How thin the matrix is between neighbouring cross-sections, in pixels.
    pub fn thickness(&self) -> f64 {
        self.views.iter().map(|v| f64::from(v.thickness)).sum::<f64>() / self.views.len() as f64
    }
}

impl Data for ParticleSet {
    const TYPE: &'static str = "particles";
    const DOCS: &'static str = "Particles of voxels with the pictures that they show.";

    fn byte_size(&self) -> u64 {
        let particles = self.particles.iter().map(|p| 80 + 4 * p.source.len() as u64).sum::<u64>();
        particles + self.views.iter().map(|v| v.byte_size()).sum::<u64>()
    }

    fn summary(&self) -> String {
        let mean = self.particles.iter().map(|p| f64::from(p.volume)).sum::<f64>()
            / self.particles.len().max(1) as f64;
        format!("{} particles of {mean:.0} voxels in the mean", self.particles.len())
    }

    fn digest(&self) -> Digest {
        Digest::of(&self.encode().unwrap_or_default())
    }

    fn encode(&self) -> Option<Vec<u8>> {
        let mut out = Writer::new();
        out.u64(self.views.len() as u64);
        for view in &self.views {
            out.bytes(&view.encode()?);
        }
        out.bytes(&pack(&self.particles)?).u64(self.discarded.into());
        Some(out.finish())
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = Reader::new(bytes);
        let count = reader.u64()?;
        if count != 1 && count != 3 {
            return Err("not one or three views".to_owned());
        }
        let views: Vec<Arc<Sections>> = (0..count)
            .map(|_| Sections::decode(reader.bytes()?).map(Arc::new))
            .collect::<Result<_, String>>()?;
        let particles: Vec<Particle> = unpack(reader.bytes()?)?;
        let discarded = reader.u32()?;
        reader.end()?;
        let view = |v: usize| &views[v.min(views.len() - 1)];
        for particle in &particles {
            let voxels = particle.size.iter().try_fold(1usize, |n, &m| n.checked_mul(m as usize));
            let in_views = (0..3).all(|v| (particle.sections[v] as usize) < view(v).sections.len());
            let shows = |&s: &u32| {
                s == NOTHING
                    || s >> 30 < 3 && ((s & 0x3fff_ffff) as usize) < view((s >> 30) as usize).mask.len()
            };
            let near = (0..3).all(|a| particle.low[a].unsigned_abs() < 1 << 16 && particle.size[a] < 1 << 16);
            if voxels != Some(particle.source.len())
                || !in_views
                || !near
                || !particle.source.iter().all(shows)
            {
                return Err("a particle does not fit its pictures".to_owned());
            }
        }
        Ok(Self { views, particles, discarded })
    }
}
