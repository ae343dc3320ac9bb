//! The nearest neighbourhoods: for each voxel and direction a pixel of the exemplar.

use breccia_engine::{Data, Digest};

use crate::data::{Reader, Writer};
use crate::lazy::Pixel;
use crate::search::Window;

/// The matches of one direction.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DirectionMatches {
    /// For every voxel the centre of the nearest neighbourhood.
    pub pixels: Vec<Pixel>,
    /// For every voxel how far that is, as the logarithm of the squared distance in steps of 1/64 of an octave at most.
    pub codes: Vec<u16>,
}

/// For each voxel and direction the exemplar's neighbourhood that is nearest to the one around the voxel.
#[derive(Clone, Debug, PartialEq)]
pub struct Matches {
    /// Voxels along x, y and z.
    pub size: [usize; 3],
    /// The level, 0 the finest.
    pub level: usize,
    /// The neighbourhood.
    pub window: Window,
    /// The directions x, y and z; those that are not matched are empty.
    pub directions: [DirectionMatches; 3],
}

/// Codes that a distance can have.
pub const CODES: usize = 2048;

/// A squared distance as a code: six binary digits after the first. Codes are in the order of distances.
#[inline(always)]
pub fn code(distance: u32) -> u16 {
    let d = distance.max(1);
    let exponent = 31 - d.leading_zeros();
    let digits = (u64::from(d) << 6 >> exponent) as u32 & 63;
    (exponent << 6 | digits) as u16
}

/// A squared distance that has this code.
pub fn decode(code: usize) -> f64 {
    let (exponent, digits) = (code >> 6, code & 63);
    (1.0 + digits as f64 / 64.0) * (1u64 << exponent) as f64
}

impl Data for Matches {
    const TYPE: &'static str = "matches";
    const DOCS: &'static str = "For each voxel and direction the exemplar's nearest neighbourhood.";

    fn byte_size(&self) -> u64 {
        self.directions.iter().map(|d| d.pixels.len() as u64 * 4).sum()
    }

    fn summary(&self) -> String {
        let [x, y, z] = self.size;
        let names = ["x", "y", "z"].into_iter().zip(&self.directions).filter(|(_, d)| !d.pixels.is_empty());
        let names: Vec<_> = names.map(|(name, _)| name).collect();
        let bytes = self.byte_size() as f64 / 1e6;
        format!(
            "{x} × {y} × {z} voxels of level {}, directions {}, {bytes:.1} MB",
            self.level,
            names.join(", ")
        )
    }

    fn digest(&self) -> Digest {
        let mut hasher = blake3::Hasher::new();
        let [x, y, z] = self.size.map(|n| n as u64);
        hasher.update(bytemuck::cast_slice(&[x, y, z, self.level as u64, self.window.size as u64]));
        for direction in &self.directions {
            hasher.update(&(direction.pixels.len() as u64).to_le_bytes());
            hasher.update(bytemuck::cast_slice(&direction.pixels));
            hasher.update(bytemuck::cast_slice(&direction.codes));
        }
        hasher.finalize().into()
    }

    fn encode(&self) -> Option<Vec<u8>> {
        let mut out = Writer::new();
        out.array(&self.size.map(|n| n as u64)).u64(self.level as u64).u64(self.window.size as u64);
        for direction in &self.directions {
            out.array(&direction.pixels).array(&direction.codes);
        }
        Some(out.finish())
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = Reader::new(bytes);
        let size: Vec<u64> = reader.array()?;
        let size: [u64; 3] = size.try_into().map_err(|_| "expected three numbers".to_owned())?;
        let size = size.map(|n| n as usize);
        let (level, window) = (reader.u64()? as usize, Window { size: reader.u64()?.min(64) as i32 });
        let mut directions = <[DirectionMatches; 3]>::default();
        for direction in &mut directions {
            *direction = DirectionMatches { pixels: reader.array()?, codes: reader.array()? };
            let voxels = size.iter().try_fold(1usize, |n, &m| n.checked_mul(m));
            let filled = voxels == Some(direction.pixels.len()) || direction.pixels.is_empty();
            if !filled || direction.codes.len() != direction.pixels.len() {
                return Err("the matches do not fit the size".to_owned());
            }
        }
        reader.end()?;
        Ok(Self { size, level, window, directions })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_keep_order_and_two_digits() {
        let mut last = 0;
        for d in (1..70_000).chain((0..2000).map(|i| 70_000 + i * 2_000_000)) {
            let c = code(d);
            assert!(c >= last && usize::from(c) < CODES);
            last = c;
            let ratio = decode(usize::from(c)) / f64::from(d);
            assert!(ratio <= 1.0 && ratio > 0.984, "{d}: {ratio}");
        }
        assert_eq!(code(0), code(1));
    }
}
