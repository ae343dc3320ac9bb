//! Bases and descriptors of every level, and the node that makes them.

use breccia_engine::{Context, Data, Digest, Node, NodeError, NodeSpec, Sizing};

use super::basis::{Basis, Descriptor, LevelBases, level_bases};
use super::per_level;
use super::pyramid::Pyramid;
use crate::data::{Reader, Writer};

/// PCA bases of every level and the descriptors of every neighbourhood.
#[derive(Clone, Debug, PartialEq)]
pub struct Descriptors {
    /// Finest level first.
    pub levels: Vec<LevelDescriptors>,
}

/// Bases and descriptors of one level.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelDescriptors {
    /// The bases.
    pub bases: LevelBases,
    /// For each view, the descriptor of every pixel; those within the margin are those of clamped centres.
    pub descriptors: Vec<Vec<Descriptor>>,
}

/// Bases and descriptors with `dims` components a level, finest first; the last entry serves all coarser levels.
pub fn make_descriptors(pyramid: &Pyramid, dims: &[i64]) -> Descriptors {
    let level = |l: usize| {
        let bases = level_bases(pyramid, l, per_level(dims, l) as usize);
        let view = |v: usize| {
            let view = &pyramid.levels[l][v];
            let pixels = (0..view.height).flat_map(|y| (0..view.width).map(move |x| (x, y)));
            pixels.map(|(x, y)| bases.bases[v].project(&view.neighbourhood(view.pixel(x, y)))).collect()
        };
        let descriptors = (0..pyramid.levels[l].len()).map(view).collect();
        LevelDescriptors { bases, descriptors }
    };
    Descriptors { levels: (0..pyramid.levels.len()).map(level).collect() }
}

impl Data for Descriptors {
    const TYPE: &'static str = "descriptors";
    const DOCS: &'static str = "PCA bases and quantised descriptors of every level.";

    fn byte_size(&self) -> u64 {
        self.levels.iter().flat_map(|l| &l.descriptors).map(|d| d.len() as u64 * 16 + 1700).sum()
    }

    fn summary(&self) -> String {
        format!("{} levels, {:.0} kB", self.levels.len(), self.byte_size() as f64 / 1e3)
    }

    fn digest(&self) -> Digest {
        Digest::of(&self.encode().unwrap_or_default())
    }

    fn encode(&self) -> Option<Vec<u8>> {
        let mut out = Writer::new();
        out.u64(self.levels.len() as u64);
        for level in &self.levels {
            out.u64(level.bases.bases.len() as u64).u64(level.bases.scale.into());
            for (basis, descriptors) in level.bases.bases.iter().zip(&level.descriptors) {
                out.bytes(bytemuck::cast_slice(basis.weights.as_flattened().as_flattened()));
                out.array(&basis.bias).u64(basis.shift.into()).array(descriptors);
            }
        }
        Some(out.finish())
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = Reader::new(bytes);
        let mut levels = Vec::new();
        for _ in 0..reader.u64()? {
            let (views, scale) = (reader.u64()?, reader.u32()?);
            let mut level =
                LevelDescriptors { bases: LevelBases { bases: Vec::new(), scale }, descriptors: Vec::new() };
            for _ in 0..views {
                let mut basis = Basis { weights: Default::default(), bias: [0; 16], shift: 0 };
                let weights = reader.array::<i8>()?;
                let flat = basis.weights.as_flattened_mut().as_flattened_mut();
                if weights.len() != flat.len() {
                    return Err("a basis of another size".to_owned());
                }
                flat.copy_from_slice(&weights);
                basis.bias = reader.array()?.try_into().map_err(|_| "a bias of another size")?;
                basis.shift = reader.u32()?.min(31);
                level.bases.bases.push(basis);
                level.descriptors.push(reader.array()?);
            }
            levels.push(level);
        }
        reader.end()?;
        Ok(Self { levels })
    }
}

pub(super) struct DescriptorsNode;

impl Node for DescriptorsNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "lazy.descriptors",
            1,
            "PCA bases and quantised descriptors of the 5 × 5 neighbourhoods",
            "Every neighbourhood of every level is projected on the first principal components of that level and view, \
             with weights and results of 7 bits, so that matching is integer arithmetic and the same on every machine.",
        )
        .paper("Dong et al. 2008, sections 5.1 and 6.2")
        .input("pyramid", "pyramid", "The exemplar pyramid.")
        .output("descriptors", "descriptors", "Bases and descriptors.")
        .param(
            "dims",
            breccia_engine::ParamKind::Ints { min_len: 1, max_len: 8, min: 1, max: 16 },
            super::list(&[8, 16]),
            "count",
            "Components kept, finest level first; the last entry serves all coarser levels.",
        )
    }

    fn estimate(&self, sizing: &Sizing<'_>) -> Option<u64> {
        // A pixel of the pyramid has four bytes, a descriptor sixteen.
        Some(sizing.input("pyramid")? / 4 * 16)
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let pyramid = context.input::<Pyramid>("pyramid")?;
        let descriptors = make_descriptors(&pyramid, &context.ints("dims")?);
        context.set("descriptors", descriptors);
        Ok(())
    }
}
