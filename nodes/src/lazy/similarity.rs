//! 2D similarity sets: for each pixel the pixels with the most similar neighbourhoods (k-coherence after
//! Tong et al. 2002; the 2D candidates of Dong et al. 2008, section 5.1).

use breccia_engine::{Context, Data, Digest, Node, NodeError, NodeSpec, Sizing};
use rayon::prelude::*;

use super::basis::{DIMS, Descriptor};
use super::descriptors::Descriptors;
use super::nearest::{Table, smallest};
use super::pyramid::{LevelView, Pixel, Pyramid};
use crate::control::{Cancelled, Control, check};
use crate::data::{Reader, Writer};

/// Pixels in a similarity set, the pixel itself first.
pub const SET: usize = 4;

/// Similarity sets of every level and view, finest level first.
#[derive(Clone, Debug, PartialEq)]
pub struct Similarity {
    /// For each level and view, the set of every pixel.
    pub levels: Vec<Vec<Vec<[Pixel; SET]>>>,
}

/// The exact similarity sets by descriptor distance. Members lie at least `spread` pixels apart from each
/// other along x or y, so that they are different places rather than neighbours; ties go to the first pixel.
///
/// # Errors
/// [`Cancelled`].
pub fn similarity_sets(
    pyramid: &Pyramid,
    descriptors: &Descriptors,
    spread: i32,
    control: &dyn Control,
) -> Result<Similarity, Cancelled> {
    let mut levels = Vec::new();
    for (views, level) in pyramid.levels.iter().zip(&descriptors.levels) {
        let sets =
            views.iter().zip(&level.descriptors).map(|(view, table)| view_sets(view, table, spread, control));
        levels.push(sets.collect::<Result<_, _>>()?);
    }
    Ok(Similarity { levels })
}

fn view_sets(
    view: &LevelView,
    table: &[Descriptor],
    spread: i32,
    control: &dyn Control,
) -> Result<Vec<[Pixel; SET]>, Cancelled> {
    let centres = view.centres();
    let candidates = Table::new(centres.iter().map(|&p| table[view.index(p)]), DIMS);
    // Enough of the nearest that some are left when those too close to each other are passed over.
    let keep = 64.min(centres.len());
    let rows: Vec<Vec<[Pixel; SET]>> = (0..view.height)
        .into_par_iter()
        .map(|y| {
            check(control)?;
            let mut distances = Vec::new();
            Ok((0..view.width)
                .map(|x| {
                    let pixel = view.pixel(x, y);
                    candidates.distances(&table[view.index(pixel)], &mut distances);
                    let order = smallest(&distances, keep);
                    let mut set = [pixel; SET];
                    // A pixel that must not be copied is no candidate for its own place either.
                    let mut count = usize::from(view.is_free(pixel));
                    for (_, i) in order {
                        let other = centres[i as usize];
                        if count < SET
                            && set[..count].iter().all(|&member| apart(view, member, other) >= spread.max(1))
                        {
                            set[count] = other;
                            count += 1;
                        }
                    }
                    let first = set[0];
                    set[count.max(1)..].fill(first);
                    set
                })
                .collect())
        })
        .collect::<Result<_, Cancelled>>()?;
    Ok(rows.concat())
}

/// The larger of the distances along x and y, around the edges if the picture continues there.
pub(crate) fn apart(view: &LevelView, a: Pixel, b: Pixel) -> i32 {
    let along = |a: Pixel, b: Pixel, n: i32| {
        let d = (i32::from(a) - i32::from(b)).abs();
        if view.tileable { d.min(n - d) } else { d }
    };
    along(a & 255, b & 255, view.width).max(along(a >> 8, b >> 8, view.height))
}

impl Data for Similarity {
    const TYPE: &'static str = "similarity";
    const DOCS: &'static str = "For each exemplar pixel the pixels with the most similar neighbourhoods.";

    fn byte_size(&self) -> u64 {
        self.levels.iter().flatten().map(|sets| sets.len() as u64 * 8).sum()
    }

    fn summary(&self) -> String {
        format!("{} levels, sets of {SET}", self.levels.len())
    }

    fn digest(&self) -> Digest {
        Digest::of(&self.encode().unwrap_or_default())
    }

    fn encode(&self) -> Option<Vec<u8>> {
        let mut out = Writer::new();
        out.u64(self.levels.len() as u64).u64(self.levels.first().map_or(0, Vec::len) as u64);
        self.levels.iter().flatten().for_each(|sets| {
            out.array(sets);
        });
        Some(out.finish())
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = Reader::new(bytes);
        let (levels, views) = (reader.u64()?, reader.u64()?);
        let level =
            |reader: &mut Reader<'_>| (0..views).map(|_| reader.array()).collect::<Result<Vec<_>, _>>();
        let levels = (0..levels).map(|_| level(&mut reader)).collect::<Result<_, _>>()?;
        reader.end()?;
        Ok(Self { levels })
    }
}

pub(super) struct SimilarityNode;

impl Node for SimilarityNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "lazy.similarity",
            1,
            "2D candidates: the most similar neighbourhoods of each pixel",
            "For every pixel of every level, the four pixels (itself included) with the most similar descriptors, \
             found exactly. Synthesis uses the first of them, by level.",
        )
        .paper("Dong et al. 2008, section 5.1; k-coherence after Tong et al. 2002")
        .input("pyramid", "pyramid", "The exemplar pyramid.")
        .input("descriptors", "descriptors", "Its descriptors.")
        .output("similarity", "similarity", "The similarity sets.")
        .int("spread", 1..=16, 3, "pixels", "Least distance along x or y between members of a set.")
    }

    fn estimate(&self, sizing: &Sizing<'_>) -> Option<u64> {
        // A pixel of the pyramid has four bytes, a set four pixels of two.
        Some(sizing.input("pyramid")? / 4 * 8)
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let pyramid = context.input::<Pyramid>("pyramid")?;
        let descriptors = context.input::<Descriptors>("descriptors")?;
        let spread = context.int("spread")? as i32;
        let sets = similarity_sets(&pyramid, &descriptors, spread, &*context)?;
        context.set("similarity", sets);
        Ok(())
    }
}
