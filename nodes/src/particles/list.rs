//! The particles of a packing as a table.

use std::fmt::Write as _;

use breccia_engine::{Data, Digest};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::anatomy::Anatomy;
use super::packing::Packing;
use crate::data::{pack, unpack};

/// One particle of a packing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// Its number, as in label volumes: from 1 on.
    pub id: u32,
    /// The voxel at its centre: x, y, z.
    pub center: [i32; 3],
    /// Voxels.
    pub volume: u64,
    /// Lengths in voxels of the axes of the ellipsoid with the same second moments, longest first.
    pub axes: [f32; 3],
    /// How like a ball it is, 0 to 1.
    pub sphericity: f32,
    /// The cross-sections that it was made of, of the views normal to x, y and z; from 0 on.
    pub sections: [u32; 3],
    /// The numbers of the particles beside it: those whose boxes, grown by how thin the matrix is between neighbours, meet its own.
    pub neighbours: Vec<u32>,
}

/// The particles of a packing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ParticleList {
    /// By number.
    pub entries: Vec<Entry>,
}

impl ParticleList {
    /// The table of a packing.
    pub fn of(packing: &Packing) -> Self {
        let gap = libm::ceil(packing.set.thickness()) as i32;
        let boxes: Vec<([i32; 3], [i32; 3])> = packing
            .placed
            .iter()
            .map(|placed| {
                let (low, size) = packing.bounds(placed);
                let first: [i32; 3] = std::array::from_fn(|a| placed.center[a] + low[a]);
                (first, size.map(|n| n as i32))
            })
            .collect();
        // Boxes by cells as large as the largest of them, so that only neighbouring cells matter.
        let edge = boxes.iter().flat_map(|(_, size)| size).copied().max().unwrap_or(1) + gap;
        let domain = packing.size.map(|n| n as i32);
        let counts = domain.map(|n| (n / edge).max(1));
        let cell = |center: [i32; 3]| -> [i32; 3] {
            std::array::from_fn(|a| {
                (i64::from(center[a].clamp(0, domain[a] - 1)) * i64::from(counts[a]) / i64::from(domain[a]))
                    as i32
            })
        };
        let mut cells: std::collections::BTreeMap<[i32; 3], Vec<usize>> = std::collections::BTreeMap::new();
        for (i, placed) in packing.placed.iter().enumerate() {
            cells.entry(cell(placed.center)).or_default().push(i);
        }
        let meet = |i: usize, j: usize| {
            (0..3).all(|a| {
                let ((p, m), (q, n)) = ((boxes[i].0[a], boxes[i].1[a]), (boxes[j].0[a], boxes[j].1[a]));
                let apart = |shift: i32| q + shift < p + m + gap && p < q + shift + n + gap;
                apart(0) || packing.wrap && (apart(domain[a]) || apart(-domain[a]))
            })
        };
        let one = |i: usize| {
            let placed = &packing.placed[i];
            let anatomy = Anatomy::of(&packing.bits(placed));
            let here = cell(placed.center);
            let mut neighbours: Vec<u32> = (0..27)
                .filter_map(|k| {
                    let near = [here[0] + k % 3 - 1, here[1] + k / 3 % 3 - 1, here[2] + k / 9 - 1];
                    let near = if packing.wrap {
                        std::array::from_fn(|a| near[a].rem_euclid(counts[a]))
                    } else {
                        near
                    };
                    cells.get(&near)
                })
                .flatten()
                .filter(|&&j| j != i && meet(i, j))
                .map(|&j| Packing::id(j))
                .collect();
            neighbours.sort_unstable();
            neighbours.dedup();
            Entry {
                id: Packing::id(i),
                center: placed.center,
                volume: anatomy.map_or(0, |a| a.volume as u64),
                axes: anatomy.map_or([0.0; 3], |a| a.axes.map(|c| c as f32)),
                sphericity: anatomy.map_or(0.0, |a| a.sphericity() as f32),
                sections: packing.particle(placed).sections,
                neighbours,
            }
        };
        Self { entries: (0..packing.placed.len()).into_par_iter().map(one).collect() }
    }

    /// The table as CSV (RFC 4180) with a header line; neighbours are separated by spaces.
    pub fn csv(&self) -> String {
        let mut text =
            "id,x,y,z,volume,axis_1,axis_2,axis_3,sphericity,section_x,section_y,section_z,neighbours\r\n"
                .to_owned();
        for e in &self.entries {
            let ([x, y, z], [a, b, c], [u, v, w]) = (e.center, e.axes, e.sections);
            let near: Vec<String> = e.neighbours.iter().map(u32::to_string).collect();
            let _ = write!(
                text,
                "{},{x},{y},{z},{},{a:.3},{b:.3},{c:.3},{:.4},{u},{v},{w},{}\r\n",
                e.id,
                e.volume,
                e.sphericity,
                near.join(" ")
            );
        }
        text
    }

    /// The table as a JSON array of objects.
    pub fn json(&self) -> String {
        let entries = self.entries.iter().map(|e| {
            let round = |v: f32| (f64::from(v) * 1000.0).round() / 1000.0;
            json!({
                "id": e.id,
                "center": e.center,
                "volume": e.volume,
                "axes": e.axes.map(round),
                "sphericity": round(e.sphericity),
                "sections": e.sections,
                "neighbours": e.neighbours,
            })
        });
        format!("{:#}\n", serde_json::Value::from(entries.collect::<Vec<_>>()))
    }
}

impl Data for ParticleList {
    const TYPE: &'static str = "particle_list";
    const DOCS: &'static str = "A table of particles: places, sizes, shapes, neighbours.";

    fn byte_size(&self) -> u64 {
        self.entries.iter().map(|e| 80 + 4 * e.neighbours.len() as u64).sum()
    }

    fn summary(&self) -> String {
        let mean =
            self.entries.iter().map(|e| e.volume as f64).sum::<f64>() / self.entries.len().max(1) as f64;
        format!("{} particles of {mean:.0} voxels in the mean", self.entries.len())
    }

    fn digest(&self) -> Digest {
        Digest::of(&self.encode().unwrap_or_default())
    }

    fn encode(&self) -> Option<Vec<u8>> {
        pack(self)
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        unpack(bytes)
    }
}
