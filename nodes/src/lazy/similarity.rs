//! 2D similarity sets: for each pixel the pixels with the most similar neighbourhoods (k-coherence after
//! Tong et al. 2002; the 2D candidates of Dong et al. 2008, section 5.1).

use breccia_engine::{Context, Data, Digest, Node, NodeError, NodeSpec, Sizing};
use breccia_shaders::{Gpu, GpuError};
use rayon::prelude::*;

use super::basis::{DIMS, Descriptor};
use super::descriptors::Descriptors;
use super::nearest::{Table, smallest};
use super::pyramid::{LevelView, Pixel, Pyramid};
use crate::control::{Cancelled, Control, Stopped, check, on_device};
use crate::data::{Reader, Writer};
use crate::search::SimilarityJob;

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
/// A compute device finds the same.
///
/// # Errors
/// [`Stopped`].
pub fn similarity_sets(
    pyramid: &Pyramid,
    descriptors: &Descriptors,
    spread: i32,
    control: &dyn Control,
) -> Result<Similarity, Stopped> {
    let found = on_device(control, |gpu| {
        levels_of(pyramid, descriptors, |view, table| view_sets_on(gpu, view, table, spread, control))
    })?;
    match found {
        Some(levels) => Ok(Similarity { levels }),
        None => {
            let sets = |view: &LevelView, table: &[Descriptor]| view_sets(view, table, spread, control);
            Ok(Similarity { levels: levels_of::<Cancelled>(pyramid, descriptors, sets)? })
        }
    }
}

/// The sets of every pixel of a view.
type Sets = Vec<[Pixel; SET]>;

/// What `of` makes of the views of every level.
fn levels_of<E>(
    pyramid: &Pyramid,
    descriptors: &Descriptors,
    mut of: impl FnMut(&LevelView, &[Descriptor]) -> Result<Sets, E>,
) -> Result<Vec<Vec<Sets>>, E> {
    let levels = pyramid.levels.iter().zip(&descriptors.levels);
    let level = levels.map(|(views, level)| {
        views.iter().zip(&level.descriptors).map(|(view, table)| of(view, table)).collect()
    });
    level.collect()
}

/// Enough of the nearest that some are left when those too close to each other are passed over.
const KEEP: usize = 64;

fn view_sets_on(
    gpu: &Gpu,
    view: &LevelView,
    table: &[Descriptor],
    spread: i32,
    control: &dyn Control,
) -> Result<Sets, GpuError> {
    let coefficients: Vec<i16> = table.as_flattened().iter().map(|&d| d.into()).collect();
    let places = (0..view.height).flat_map(|y| (0..view.width).map(move |x| view.pixel(x, y)));
    let own: Vec<(Pixel, bool)> = places.map(|pixel| (pixel, view.is_free(pixel))).collect();
    let job = SimilarityJob {
        size: [view.width, view.height],
        tileable: view.tileable,
        coefficients: &coefficients,
        dims: DIMS,
        centres: &view.centres(),
        own: &own,
        members: SET,
        spread,
        keep: KEEP,
    };
    let found = job.run(gpu, control)?;
    let sets = found.as_chunks::<SET>().0.iter().zip(&own);
    // The first is left out where nothing was found: the pixel itself then.
    Ok(sets.map(|(set, &(own, _))| set.map(|member| member.or(set[0]).unwrap_or(own))).collect())
}

fn view_sets(
    view: &LevelView,
    table: &[Descriptor],
    spread: i32,
    control: &dyn Control,
) -> Result<Sets, Cancelled> {
    let centres = view.centres();
    let candidates = Table::new(centres.iter().map(|&p| table[view.index(p)]), DIMS);
    let keep = KEEP.min(centres.len());
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
        .on_device()
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
