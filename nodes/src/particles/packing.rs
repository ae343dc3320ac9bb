//! A packing: particles placed in a domain.

use std::sync::Arc;

use breccia_engine::{Data, Digest};
use serde::{Deserialize, Serialize};

use super::bits::Bits;
use super::factors::Factors;
use super::particle::{NOTHING, Particle, ParticleSet};
use crate::data::{Reader, Writer, pack, unpack};

/// A particle in its place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Placed {
    /// Which particle of the set.
    pub particle: u32,
    /// The voxel at its centre.
    pub center: [i32; 3],
    /// Its shape, if that is not the particle's own.
    pub shape: Option<Arc<Shape>>,
}

/// A particle's shape after scaling.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shape {
    /// Its voxels.
    pub bits: Bits,
    /// How far it was scaled in each direction.
    pub factors: Factors,
}

/// Particles placed in a domain.
#[derive(Clone, Debug)]
pub struct Packing {
    /// The particles to choose from.
    pub set: Arc<ParticleSet>,
    /// Edges of the domain along x, y and z in voxels.
    pub size: [u32; 3],
    /// Whether the domain repeats; else it ends.
    pub wrap: bool,
    /// The particles in it. Where two overlap, voxels belong to the first.
    pub placed: Vec<Placed>,
}

impl Packing {
    /// The particle that a placed one is a copy of.
    pub fn particle(&self, placed: &Placed) -> &Particle {
        &self.set.particles[placed.particle as usize]
    }

    /// The box of a placed particle, from its centre: first voxel and edges.
    pub fn bounds(&self, placed: &Placed) -> ([i32; 3], [u32; 3]) {
        match &placed.shape {
            Some(shape) => (shape.bits.low, shape.bits.size),
            None => {
                let particle = self.particle(placed);
                (particle.low, particle.size)
            }
        }
    }

    /// Whether a placed particle has a voxel, given from its centre.
    #[inline]
    pub fn holds(&self, placed: &Placed, voxel: [i32; 3]) -> bool {
        match &placed.shape {
            Some(shape) => shape.bits.holds(voxel),
            None => self.particle(placed).holds(voxel),
        }
    }

    /// The voxels of a placed particle as bits.
    pub fn bits(&self, placed: &Placed) -> Bits {
        placed.shape.as_ref().map_or_else(|| self.particle(placed).bits(), |shape| shape.bits.clone())
    }

    /// The voxels of a placed particle, from its centre.
    pub fn voxels(&self, placed: &Placed) -> Vec<[i32; 3]> {
        match &placed.shape {
            Some(shape) => shape.bits.voxels().collect(),
            None => self.particle(placed).voxels().collect(),
        }
    }

    /// What a voxel of a placed particle shows: a view in the upper two bits and a pixel, or [`NOTHING`] far outside.
    #[inline]
    pub fn source(&self, placed: &Placed, voxel: [i32; 3]) -> u32 {
        let particle = self.particle(placed);
        let own = match &placed.shape {
            Some(shape) => {
                let factor = shape.factors.at(voxel.map(f64::from));
                voxel.map(|c| libm::round(f64::from(c) / factor) as i32)
            }
            None => voxel,
        };
        // Where scaling left the particle by a voxel, the next one towards the centre is shown.
        for step in 0..=16 {
            let scaled = own.map(|c| (c * (16 - step) + 8 * c.signum()) / 16);
            let at = if step == 0 { own } else { scaled };
            if let Some(i) = particle.index(at)
                && particle.source[i] != NOTHING
            {
                return particle.source[i];
            }
        }
        NOTHING
    }

    /// A number from 1 on for every placed particle: its place in the list.
    pub fn id(index: usize) -> u32 {
        index as u32 + 1
    }
}

impl Data for Packing {
    const TYPE: &'static str = "packing";
    const DOCS: &'static str = "Particles placed in a domain.";

    fn byte_size(&self) -> u64 {
        let shapes: u64 = self
            .placed
            .iter()
            .flat_map(|p| &p.shape)
            .map(|s| s.bits.byte_size() + s.factors.byte_size())
            .sum();
        self.set.byte_size() + shapes + 24 * self.placed.len() as u64
    }

    fn summary(&self) -> String {
        let [x, y, z] = self.size;
        let refined = if self.placed.iter().any(|p| p.shape.is_some()) { ", shapes refined" } else { "" };
        format!("{} particles in {x} × {y} × {z} voxels{refined}", self.placed.len())
    }

    fn digest(&self) -> Digest {
        Digest::of(&self.encode().unwrap_or_default())
    }

    fn encode(&self) -> Option<Vec<u8>> {
        let mut out = Writer::new();
        out.bytes(&self.set.encode()?).array(&self.size).u64(self.wrap.into()).bytes(&pack(&self.placed)?);
        Some(out.finish())
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = Reader::new(bytes);
        let set = Arc::new(ParticleSet::decode(reader.bytes()?)?);
        let size: [u32; 3] = reader.array()?.try_into().map_err(|_| "a domain has three edges")?;
        let wrap = reader.u64()? != 0;
        let placed: Vec<Placed> = unpack(reader.bytes()?)?;
        reader.end()?;
        for one in &placed {
            let whole = one.shape.as_ref().is_none_or(|s| s.bits.is_whole() && s.factors.is_whole());
            let near = one.center.iter().all(|c| c.unsigned_abs() < 1 << 24);
            if one.particle as usize >= set.particles.len() || !whole || !near {
                return Err("a placed particle does not fit the set".to_owned());
            }
        }
        if size.iter().any(|n| !(1..=1 << 20).contains(n)) {
            return Err("a domain's edge is out of range".to_owned());
        }
        Ok(Self { set, size, wrap, placed })
    }
}
