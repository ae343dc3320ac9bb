//! 3D candidates: triples of pixels, one in each exemplar, whose interleaved neighbourhoods agree where they
//! cross (Dong et al. 2008, sections 4.1 and 4.2).

use breccia_engine::{Context, Data, Digest, Node, NodeError, NodeSpec, Sizing};
use breccia_shaders::GpuError;
use rayon::prelude::*;

use super::coherence::refine;
use super::device::DeviceStrips;
use super::nearest::{Table, smallest};
use super::pyramid::{LevelView, N, Pixel, Pyramid, RADIUS};
use super::similarity::apart;
use crate::control::{Cancelled, Control, Stopped, check, on_device};
use crate::data::{Reader, Writer};

/// Largest number of triples kept a pixel.
pub const SET: usize = 12;

/// A triple without its first pixel, which is the one it is kept at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Triple {
    /// The pixel in the exemplar of the next direction.
    pub next: Pixel,
    /// The pixel in the exemplar of the direction after that.
    pub last: Pixel,
    /// Squared colour differences along the three lines of the crossbar.
    pub crossbar: u32,
}

/// How candidates are selected.
#[derive(Clone, Copy, Debug)]
pub struct CandidateSettings {
    /// Most similar strips considered in each of the two other exemplars (the paper's S = 65).
    pub strips: usize,
    /// Triples of least crossbar error kept before the coherence iterations (the paper's 100).
    pub best: usize,
    /// Triples left a pixel at most, 1 to [`SET`] (the paper's 12).
    pub keep: usize,
    /// Coherence iterations at most.
    pub iterations: usize,
    /// With one exemplar for all directions: strips of pixels nearer than this are no match, since a pixel that
    /// matches itself extrudes the picture diagonally. In pixels.
    pub exclusion: i32,
}

impl Default for CandidateSettings {
    fn default() -> Self {
        Self { strips: 65, best: 100, keep: 12, iterations: 4, exclusion: 3 }
    }
}

/// Candidate triples of every level, direction and pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidates {
    /// For each level (finest first) and view.
    pub levels: Vec<Vec<ViewCandidates>>,
}

/// Candidate triples of one exemplar view.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewCandidates {
    /// For each pixel, the triples in order of preference, the last one repeated to fill the set.
    pub triples: Vec<[Triple; SET]>,
    /// For each pixel, how many distinct triples the set holds (1 to [`SET`]).
    pub counts: Vec<u8>,
    /// Mean number of triples a pixel after each coherence iteration, times 1000.
    pub survivors: Vec<u32>,
}

/// Five pixels along a line, as bytes, padded to the width of a vector.
pub(super) type Strip = [u8; 32];
/// Bytes of a strip.
pub(super) const STRIP: usize = 4 * N;

/// The pixels along the columns' axis (a piece of a row) around a centre.
pub(super) fn row_strip(view: &LevelView, pixel: Pixel) -> Strip {
    let (x, y) = (i32::from(pixel & 255), i32::from(pixel >> 8));
    std::array::from_fn(|i| if i < STRIP { view.texel(x + i as i32 / 4 - RADIUS, y)[i % 4] } else { 0 })
}

/// The pixels along the rows' axis (a piece of a column) around a centre.
pub(super) fn column_strip(view: &LevelView, pixel: Pixel) -> Strip {
    let (x, y) = (i32::from(pixel & 255), i32::from(pixel >> 8));
    std::array::from_fn(|i| if i < STRIP { view.texel(x, y + i as i32 / 4 - RADIUS)[i % 4] } else { 0 })
}

/// Centres of a view with their strips along both axes.
struct Strips {
    centres: Vec<Pixel>,
    rows: Vec<Strip>,
    columns: Vec<Strip>,
    row_table: Table,
    column_table: Table,
}

impl Strips {
    fn of(view: &LevelView) -> Self {
        let centres = view.centres();
        let rows: Vec<Strip> = centres.iter().map(|&p| row_strip(view, p)).collect();
        let columns: Vec<Strip> = centres.iter().map(|&p| column_strip(view, p)).collect();
        let row_table = Table::new(rows.iter().copied(), STRIP);
        let column_table = Table::new(columns.iter().copied(), STRIP);
        Self { centres, rows, columns, row_table, column_table }
    }
}

/// The candidates of every level and view. A compute device selects the same triples; the coherence iterations are the
/// processor's.
///
/// # Errors
/// [`Stopped`].
pub fn make_candidates(
    pyramid: &Pyramid,
    settings: &CandidateSettings,
    control: &dyn Control,
) -> Result<Candidates, Stopped> {
    let on_cpu = |views: &[LevelView], strips: &[Strips], direction: usize, exclusion: i32| {
        let strips_of = |direction: usize| &strips[(direction % 3).min(strips.len() - 1)];
        let others = [strips_of(direction + 1), strips_of(direction + 2)];
        consistent_triples(&views[direction], others, settings, exclusion, control)
    };
    let strips = |views: &[LevelView]| views.iter().map(Strips::of).collect::<Vec<_>>();
    let found = on_device(control, |gpu| {
        let stopped = |Cancelled| GpuError::Cancelled;
        let on_device = |views: &[LevelView]| DeviceStrips::new(gpu, views);
        levels_of(pyramid, settings, control, stopped, on_device, |views, on_device, direction, exclusion| {
            match on_device.triples(gpu, &views[direction], direction, settings, exclusion, control)? {
                Some(triples) => Ok(triples),
                None => on_cpu(views, &strips(views), direction, exclusion).map_err(stopped),
            }
        })
    })?;
    match found {
        Some(candidates) => Ok(candidates),
        None => {
            let prepare = |views: &[LevelView]| Ok(strips(views));
            let triples = |views: &[LevelView], strips: &Vec<Strips>, direction, exclusion| {
                on_cpu(views, strips, direction, exclusion)
            };
            Ok(levels_of(pyramid, settings, control, |stopped| stopped, prepare, triples)?)
        }
    }
}

/// The candidates of every level and view: `prepare` makes of a level's views what `triples` needs to make the triples of a
/// direction with an exclusion.
fn levels_of<S, E>(
    pyramid: &Pyramid,
    settings: &CandidateSettings,
    control: &dyn Control,
    stopped: impl Fn(Cancelled) -> E,
    prepare: impl Fn(&[LevelView]) -> Result<S, E>,
    triples: impl Fn(&[LevelView], &S, usize, i32) -> Result<Vec<Vec<Triple>>, E>,
) -> Result<Candidates, E> {
    let total: usize = pyramid.levels.iter().flatten().map(|view| view.texels.len()).sum();
    let mut done = 0;
    let mut levels = Vec::new();
    for (level, views) in pyramid.levels.iter().enumerate() {
        let prepared = prepare(views)?;
        let mut of_level = Vec::new();
        for (direction, view) in views.iter().enumerate() {
            let exclusion = if views.len() == 1 { settings.exclusion } else { 0 };
            let sets = triples(views, &prepared, direction, exclusion)?;
            let sizes = [pyramid.view(level, (direction + 1) % 3), pyramid.view(level, (direction + 2) % 3)];
            of_level.push(refine(view, sizes, sets, settings, control).map_err(&stopped)?);
            done += view.texels.len();
            control.progress(done as f32 / total as f32);
        }
        levels.push(of_level);
    }
    Ok(Candidates { levels })
}

/// Section 4.1: for each pixel the triples of least crossbar error among the S × S pairs of its best strips.
fn consistent_triples(
    view: &LevelView,
    [next, last]: [&Strips; 2],
    settings: &CandidateSettings,
    exclusion: i32,
    control: &dyn Control,
) -> Result<Vec<Vec<Triple>>, Cancelled> {
    let rows: Vec<Vec<Vec<Triple>>> = (0..view.height)
        .into_par_iter()
        .map(|y| {
            let mut scratch = Vec::new();
            (0..view.width)
                .map(|x| {
                    check(control)?;
                    let pixel = view.pixel(x, y);
                    let excluded = |other: Pixel| exclusion > 0 && apart(view, pixel, other) < exclusion;
                    let best = |strip: &Strip, table: &Table, centres: &[Pixel], scratch: &mut Vec<u32>| {
                        table.distances(strip, scratch);
                        let spare = (2 * exclusion.max(0) as usize).pow(2);
                        let found = smallest(scratch, settings.strips + spare);
                        let kept = found.iter().filter(|(_, i)| !excluded(centres[*i as usize])).copied();
                        let kept: Vec<_> = kept.take(settings.strips).collect();
                        // A tiny level may hold nothing but the pixel's own surroundings.
                        if kept.is_empty() { found } else { kept }
                    };
                    // The rows' axis of one exemplar is the columns' axis of the next.
                    let nexts =
                        best(&column_strip(view, pixel), &next.row_table, &next.centres, &mut scratch);
                    let lasts =
                        best(&row_strip(view, pixel), &last.column_table, &last.centres, &mut scratch);
                    let last_rows = Table::new(lasts.iter().map(|&(_, i)| last.rows[i as usize]), STRIP);
                    let mut errors = Vec::with_capacity(nexts.len() * lasts.len());
                    for &(d_next, i) in &nexts {
                        last_rows.distances(&next.columns[i as usize], &mut scratch);
                        errors
                            .extend(scratch.iter().zip(&lasts).map(|(d, &(d_last, _))| d_next + d_last + d));
                    }
                    let triple = |(crossbar, i): (u32, u32)| Triple {
                        next: next.centres[nexts[i as usize / lasts.len()].1 as usize],
                        last: last.centres[lasts[i as usize % lasts.len()].1 as usize],
                        crossbar,
                    };
                    Ok(smallest(&errors, settings.best).into_iter().map(triple).collect())
                })
                .collect()
        })
        .collect::<Result<_, Cancelled>>()?;
    Ok(rows.concat())
}

impl Data for Candidates {
    const TYPE: &'static str = "candidates";
    const DOCS: &'static str =
        "For each exemplar pixel a few triples of pixels, one in each exemplar, that fit together.";

    fn byte_size(&self) -> u64 {
        self.levels.iter().flatten().map(|view| view.triples.len() as u64 * (8 * SET as u64 + 1)).sum()
    }

    fn summary(&self) -> String {
        let views = self.levels.first().map_or(0, Vec::len);
        format!("{} levels of {views} views, {:.1} MB", self.levels.len(), self.byte_size() as f64 / 1e6)
    }

    fn digest(&self) -> Digest {
        Digest::of(&self.encode().unwrap_or_default())
    }

    fn encode(&self) -> Option<Vec<u8>> {
        let mut out = Writer::new();
        out.u64(self.levels.len() as u64).u64(self.levels.first().map_or(0, Vec::len) as u64);
        for view in self.levels.iter().flatten() {
            out.array(view.triples.as_flattened()).array(&view.counts).array(&view.survivors);
        }
        Some(out.finish())
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = Reader::new(bytes);
        let (levels, views) = (reader.u64()?, reader.u64()?);
        let mut candidates = Self { levels: Vec::new() };
        for _ in 0..levels {
            let mut level = Vec::new();
            for _ in 0..views {
                let triples: Vec<Triple> = reader.array()?;
                let (triples, rest) = triples.as_chunks::<SET>();
                if !rest.is_empty() {
                    return Err("an incomplete candidate set".to_owned());
                }
                let triples = triples.to_vec();
                level.push(ViewCandidates { triples, counts: reader.array()?, survivors: reader.array()? });
            }
            candidates.levels.push(level);
        }
        reader.end()?;
        Ok(candidates)
    }
}

pub(super) struct CandidatesNode;

impl Node for CandidatesNode {
    fn spec(&self) -> NodeSpec {
        NodeSpec::new(
            "lazy.candidates",
            1,
            "3D candidates: triples of exemplar pixels that fit together",
            "For each pixel of each exemplar and level, the most similar strips of the two other exemplars are \
             combined to triples, ordered by their crossbar error (squared colour difference along the three lines \
             where their neighbourhoods meet), and thinned out to those that can continue the triples of neighbouring \
             pixels.",
        )
        .paper("Dong et al. 2008, sections 4.1 and 4.2")
        .on_device()
        .input("pyramid", "pyramid", "The exemplar pyramid.")
        .output("candidates", "candidates", "The triples.")
        .int("strips", 1..=256, 65, "count", "Most similar strips taken from each other exemplar (S).")
        .int("best", 1..=400, 100, "count", "Triples of least crossbar error that enter the coherence iterations.")
        .int("keep", 1..=SET as i64, SET as i64, "count", "Triples left a pixel at most.")
        .int("iterations", 0..=16, 4, "count", "Coherence iterations at most.")
        .int(
            "exclusion",
            0..=32,
            3,
            "pixels",
            "With one exemplar for all directions, strips nearer than this to the pixel itself are no match: matching \
             itself would extrude the picture along the diagonal.",
        )
    }

    fn estimate(&self, sizing: &Sizing<'_>) -> Option<u64> {
        // A pixel of the pyramid has four bytes, a set twelve triples of eight, and their count.
        Some(sizing.input("pyramid")? / 4 * 97)
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let pyramid = context.input::<Pyramid>("pyramid")?;
        let settings = CandidateSettings {
            strips: context.int("strips")? as usize,
            best: context.int("best")? as usize,
            keep: context.int("keep")? as usize,
            iterations: context.int("iterations")? as usize,
            exclusion: context.int("exclusion")? as i32,
        };
        let candidates = make_candidates(&pyramid, &settings, &*context)?;
        context.set("candidates", candidates);
        Ok(())
    }
}
