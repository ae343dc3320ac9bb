//! A deformed object whose particles stay as rigid as wanted, while the matrix takes the deformation (Du et al. 2013, section
//! 4.2, Fig. 14).

use std::sync::Arc;

use breccia_engine::{Data, Digest};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::deformation::{Deformation, apply, inverted, rotation};
use super::packing::Packing;
use super::solid::copy_masked;
use crate::control::{Cancelled, Control, check};
use crate::data::{
    BRICK_VOXELS, Extent, MapInfo, SampleType, Samples, Solid, SolidError, VoxelMap, VoxelSet, indices,
    voxel_at,
};

/// What a deformed solid shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Particles in the matrix.
    All,
    /// White where particles are.
    Particles,
    /// White where the material's box is after the deformation.
    Box,
}

/// A deformed box of particles in a matrix.
pub struct DeformedSolid {
    packing: Arc<Packing>,
    matrix: Option<Arc<dyn Solid>>,
    deformation: Deformation,
    part: Part,
    /// For each particle: its place in the packing, its centre after the deformation, and the way back from there to its own voxels.
    poses: Vec<(u32, [f64; 3], [[f64; 3]; 3])>,
    cells: FxHashMap<[i32; 3], Vec<u32>>,
    digest: Digest,
}

/// A placed particle at a voxel, and which of its own voxels that is; nothing in the matrix.
type Hit = Option<(usize, [i32; 3])>;

/// Edge of the index's cells in voxels.
const CELL: i32 = 16;

impl DeformedSolid {
    /// A packing's domain under a deformation. Particles that reach into it from its repetitions belong to it. With `rigidity` 1 particles are moved and turned only, with 0 they deform like the matrix.
    pub fn new(
        packing: Arc<Packing>,
        matrix: Option<Arc<dyn Solid>>,
        deformation: Deformation,
        rigidity: f64,
        part: Part,
    ) -> Self {
        let mut cells: FxHashMap<[i32; 3], Vec<u32>> = FxHashMap::default();
        let mut poses = Vec::with_capacity(packing.placed.len());
        for (i, center) in within(&packing) {
            let placed = &packing.placed[i as usize];
            let center = center.map(|c| f64::from(c) + 0.5);
            let full = deformation.jacobian(center);
            let turn = rotation(full);
            let pose: [[f64; 3]; 3] = std::array::from_fn(|r| {
                std::array::from_fn(|c| full[r][c] * (1.0 - rigidity) + turn[r][c] * rigidity)
            });
            let moved = deformation.forward(center);
            let pose_index = poses.len() as u32;
            poses.push((i, moved, inverted(pose).unwrap_or([[0.0; 3]; 3])));
            let (low, size) = packing.bounds(placed);
            let reach: [f64; 3] = std::array::from_fn(|r| {
                (0..3)
                    .map(|c| pose[r][c].abs() * f64::from(low[c].abs().max(low[c] + size[c] as i32) + 1))
                    .sum()
            });
            let cell = |c: f64| (libm::floor(c) as i32).div_euclid(CELL);
            let span: [std::ops::RangeInclusive<i32>; 3] =
                std::array::from_fn(|a| cell(moved[a] - reach[a])..=cell(moved[a] + reach[a]));
            for z in span[2].clone() {
                for y in span[1].clone() {
                    for x in span[0].clone() {
                        cells.entry([x, y, z]).or_default().push(pose_index);
                    }
                }
            }
        }
        let mut hasher = blake3::Hasher::new();
        hasher.update(b"deformed").update(&packing.digest().0).update(&[part as u8]);
        hasher.update(format!("{deformation:?} {rigidity}").as_bytes());
        if let Some(matrix) = &matrix {
            hasher.update(&matrix.digest().0);
        }
        Self { packing, matrix, deformation, part, poses, cells, digest: hasher.finalize().into() }
    }

    /// The placed particle at a voxel, and which of its own voxels that is: the first of those that meet there.
    fn at(&self, voxel: [i32; 3]) -> Hit {
        let near = self.cells.get(&voxel.map(|c| c.div_euclid(CELL)))?;
        near.iter().find_map(|&i| {
            let (i, center, back) = &self.poses[i as usize];
            let offset = std::array::from_fn(|a| f64::from(voxel[a]) + 0.5 - center[a]);
            let own = apply(back, offset).map(|c| libm::round(c) as i32);
            self.packing.holds(&self.packing.placed[*i as usize], own).then_some((*i as usize, own))
        })
    }

    /// The voxel of the material that came to a voxel.
    fn material(&self, voxel: [i32; 3]) -> [i32; 3] {
        let found = self.deformation.inverse(voxel.map(|c| f64::from(c) + 0.5));
        found.map(|c| libm::floor(c.clamp(-1e8, 1e8)) as i32)
    }
}

/// The particles that reach into a packing's domain: their places in the packing, and their centres, repeated where the domain is.
fn within(packing: &Packing) -> Vec<(u32, [i32; 3])> {
    let mut found = Vec::new();
    for (placed, i) in packing.placed.iter().zip(0..) {
        let (low, size) = packing.bounds(placed);
        let shifts = if packing.wrap { -1..=1 } else { 0..=0 };
        for z in shifts.clone() {
            for y in shifts.clone() {
                for x in shifts.clone() {
                    let shift = [x, y, z];
                    let center: [i32; 3] =
                        std::array::from_fn(|a| placed.center[a] + shift[a] * packing.size[a] as i32);
                    let reaches = (0..3).all(|a| {
                        let first = center[a] + low[a];
                        first < packing.size[a] as i32 && first + size[a] as i32 > 0
                    });
                    if reaches {
                        found.push((i, center));
                    }
                }
            }
        }
    }
    found
}

impl Solid for DeformedSolid {
    fn maps(&self) -> Vec<MapInfo> {
        match self.part {
            Part::All => self.packing.set.maps(),
            _ => vec![MapInfo { name: "color".to_owned(), channels: 3, ty: SampleType::U8 }],
        }
    }

    fn extent(&self) -> Extent {
        Extent::Unbounded
    }

    fn evaluate(&self, voxels: &VoxelSet, control: &dyn Control) -> Result<VoxelMap, SolidError> {
        let bricks = voxels.bricks();
        let mut answer = VoxelMap::new(&bricks, &self.maps());
        let found: Vec<Vec<Hit>> = bricks
            .par_iter()
            .map(|&brick| {
                check(control)?;
                let mut hits = vec![None; BRICK_VOXELS];
                let asked = voxels.mask(brick).copied().unwrap_or_default();
                indices(&asked).for_each(|at| hits[at] = self.at(voxel_at(brick, at)));
                Ok(hits)
            })
            .collect::<Result<_, Cancelled>>()?;
        if self.part != Part::All {
            let inside = |voxel: [i32; 3], found: Hit| match self.part {
                Part::Particles => found.is_some(),
                _ => {
                    let p = self.material(voxel);
                    (0..3).all(|a| p[a] >= 0 && (p[a] as u32) < self.packing.size[a])
                }
            };
            if let Some(Samples::U8(samples)) = answer.maps.first_mut().map(|map| &mut map.samples) {
                let slabs = samples.par_chunks_mut(3 * BRICK_VOXELS).zip(&bricks).zip(&found);
                slabs.for_each(|((samples, &brick), found)| {
                    for (at, pixel) in samples.chunks_exact_mut(3).enumerate() {
                        pixel.fill(if inside(voxel_at(brick, at), found[at]) { 255 } else { 0 });
                    }
                });
            }
            return Ok(answer);
        }
        let set = &self.packing.set;
        let mut rest = VoxelSet::new();
        let mut masks = Vec::with_capacity(bricks.len());
        for (slot, (&brick, found)) in bricks.iter().zip(&found).enumerate() {
            let asked = voxels.mask(brick).copied().unwrap_or_default();
            let mut mask = [0u64; 8];
            for at in indices(&asked) {
                let Some((i, own)) = found[at] else {
                    mask[at >> 6] |= 1 << (at & 63);
                    rest.insert(self.material(voxel_at(brick, at)));
                    continue;
                };
                let source = self.packing.source(&self.packing.placed[i], own);
                let Some((view, pixel)) = set.shown(source) else { continue };
                for (map, (_, image)) in answer.maps.iter_mut().zip(&view.carried) {
                    let n = map.channels;
                    map.samples.copy_from((slot * BRICK_VOXELS + at) * n, image.samples(), pixel * n, n);
                }
            }
            masks.push(mask);
        }
        let matrix = match &self.matrix {
            Some(matrix) if !rest.is_empty() => matrix.evaluate(&rest, control)?,
            _ => return Ok(answer),
        };
        for map in &mut answer.maps {
            let Some(from) = matrix.map(&map.name).filter(|from| from.info() == map.info()) else {
                for (slot, mask) in masks.iter().enumerate() {
                    copy_masked(map, slot, None, mask);
                }
                continue;
            };
            let n = map.channels;
            for (slot, (&brick, mask)) in bricks.iter().zip(&masks).enumerate() {
                for at in indices(mask) {
                    if let Some(other) = matrix.index(self.material(voxel_at(brick, at))) {
                        map.samples.copy_from((slot * BRICK_VOXELS + at) * n, &from.samples, other * n, n);
                    }
                }
            }
        }
        Ok(answer)
    }

    fn digest(&self) -> Digest {
        self.digest
    }

    fn summary(&self) -> String {
        format!("{}, {:?}", self.packing.summary(), self.deformation.kind)
    }

    fn byte_size(&self) -> u64 {
        let cells: u64 = self.cells.values().map(|cell| 48 + 4 * cell.capacity() as u64).sum();
        self.packing.byte_size() + 104 * self.poses.len() as u64 + cells
    }
}
