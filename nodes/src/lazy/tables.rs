//! Everything a correction looks up, laid out by level and view.

use super::basis::{Basis, DIMS, Descriptor};
use super::candidates::{Candidates, Strip, Triple, column_strip, row_strip};
use super::descriptors::Descriptors;
use super::isa::Edges;
use super::pyramid::{LevelView, Pixel, Pyramid};
use super::similarity::Similarity;
use super::usage::Usage;
use crate::data::Map;
use crate::exemplar::Exemplar;

/// The tables of a synthesis.
pub struct Tables {
    /// Finest level first. Not for others to change: the kernel reads without checks what [`Tables::new`] checked.
    pub(super) levels: Vec<LevelTables>,
    /// For each view of the exemplar, the maps looked up at the finest level's coordinates.
    pub carried: Vec<Vec<Map>>,
}

/// The tables of one level.
pub struct LevelTables {
    /// One view for all three directions, or one a direction.
    pub views: Vec<ViewTables>,
    /// Whether no descriptor has more than eight components.
    pub narrow: bool,
    /// Descriptor distance a squared colour difference of 1, times 65,536.
    pub scale: u32,
    /// Three times the mean colour of the views.
    pub middle: [i16; 4],
    /// How much contrast is restored where the three colours of a voxel become one, in 256ths.
    pub stretch: u32,
}

/// The tables of one view at one level. Arrays are indexed by [`LevelView::index`].
pub struct ViewTables {
    /// Size and texels.
    pub view: LevelView,
    /// The PCA basis.
    pub basis: Basis,
    /// What the search for the best pixel reads.
    pub records: Vec<Record>,
    /// 3D candidates, two of every pixel in each list, since corrections at the finest level read no more.
    pub triples: [Vec<[Triple; 2]>; super::candidates::SET / 2],
    /// Where steps from a pixel may lead.
    pub edges: Edges,
    /// Pieces of rows and columns, for the crossbar error of triples made on the fly.
    pub rows: Vec<Strip>,
    /// See `rows`.
    pub columns: Vec<Strip>,
}

/// What a search reads of a pixel together, so that it lies in one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Record {
    /// The descriptor of its neighbourhood; in a narrow level its eight components are the last eight bytes, so
    /// that one load gets them and the usage weight.
    pub descriptor: Descriptor,
    /// Usage weight.
    pub usage: i32,
    /// Zero, to fill the load.
    pub rest: u32,
    /// 2D candidates.
    pub similar: [Pixel; super::similarity::SET],
}

/// Three times the mean colour of some views.
fn triple_mean(views: &[LevelView]) -> [i16; 4] {
    let texels = || views.iter().flat_map(|view| &view.texels);
    let count = texels().count().max(1) as u64;
    std::array::from_fn(|c| (3 * texels().map(|texel| u64::from(texel[c])).sum::<u64>() / count) as i16)
}

/// A descriptor as a record keeps it.
fn placed(mut descriptor: Descriptor, narrow: bool) -> Descriptor {
    if narrow {
        descriptor.rotate_right(DIMS / 2);
    }
    descriptor
}

/// Tables that do not belong together.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the {what} do not belong to this exemplar pyramid ({found}, the pyramid has {expected})")]
pub struct TablesError {
    what: &'static str,
    found: String,
    expected: String,
}

impl LevelTables {
    /// The view of a direction.
    #[inline(always)]
    pub fn view(&self, direction: usize) -> &ViewTables {
        &self.views[if self.views.len() == 1 { 0 } else { direction }]
    }
}

impl Tables {
    /// Joins what the stages made; they must come from one exemplar.
    ///
    /// # Errors
    /// If sizes disagree.
    pub fn new(
        exemplar: &Exemplar,
        pyramid: &Pyramid,
        descriptors: &Descriptors,
        similarity: &Similarity,
        candidates: &Candidates,
        usage: Option<&Usage>,
    ) -> Result<Self, TablesError> {
        let expected: Vec<usize> = pyramid.levels.iter().flatten().map(|v| v.texels.len()).collect();
        let same = |what: &'static str, found: Vec<usize>| {
            let text = |sizes: &[usize]| format!("pixels by level and view: {sizes:?}");
            let error = TablesError { what, found: text(&found), expected: text(&expected) };
            if found == expected { Ok(()) } else { Err(error) }
        };
        same("descriptors", descriptors.levels.iter().flat_map(|l| &l.descriptors).map(Vec::len).collect())?;
        same("similarity sets", similarity.levels.iter().flatten().map(Vec::len).collect())?;
        same("candidates", candidates.levels.iter().flatten().map(|v| v.triples.len()).collect())?;
        if let Some(usage) = usage {
            same("usage weights", usage.levels.iter().flatten().map(Vec::len).collect())?;
        }
        let finest: Vec<usize> = exemplar.views.iter().map(|v| v.texels.len()).collect();
        same(
            "maps",
            finest.into_iter().chain(expected[exemplar.views.len().min(expected.len())..].to_vec()).collect(),
        )?;

        for (l, views) in pyramid.levels.iter().enumerate() {
            for (v, view) in views.iter().enumerate() {
                let others = [pyramid.view(l, (v + 1) % 3), pyramid.view(l, (v + 2) % 3)];
                let similar = similarity.levels[l][v].iter().flatten();
                let triples = candidates.levels[l][v].triples.iter().flatten();
                if similar.into_iter().any(|&p| !view.holds(p))
                    || triples.into_iter().any(|t| !others[0].holds(t.next) || !others[1].holds(t.last))
                {
                    return Err(TablesError {
                        what: "similarity sets or candidates",
                        found: format!("pixels outside {} × {}", view.width, view.height),
                        expected: "pixels inside".to_owned(),
                    });
                }
            }
        }

        let levels = pyramid.levels.iter().enumerate().map(|(l, views)| {
            let bases = &descriptors.levels[l].bases;
            let narrow = bases.bases.iter().all(|basis| basis.dims() <= DIMS / 2);
            let views = views.iter().enumerate().map(|(v, view)| {
                let pixels: Vec<Pixel> =
                    (0..view.height).flat_map(|y| (0..view.width).map(move |x| view.pixel(x, y))).collect();
                let m = view.margin();
                let record = |i: usize| Record {
                    descriptor: placed(descriptors.levels[l].descriptors[v][i], narrow),
                    rest: 0,
                    similar: similarity.levels[l][v][i],
                    usage: usage.map_or(0, |u| u.levels[l][v][i].clamp(0, 1 << 28)),
                };
                let triples = &candidates.levels[l][v].triples;
                ViewTables {
                    edges: Edges {
                        around: view.tileable.then_some([view.width as i16, view.height as i16]),
                        bounds: [m, view.width - 1 - m, m, view.height - 1 - m].map(|b| b as i16),
                    },
                    view: view.clone(),
                    basis: bases.bases[v].clone(),
                    records: (0..view.texels.len()).map(record).collect(),
                    triples: std::array::from_fn(|part| {
                        triples.iter().map(|set| std::array::from_fn(|k| set[2 * part + k])).collect()
                    }),
                    rows: pixels.iter().map(|&p| row_strip(view, p)).collect(),
                    columns: pixels.iter().map(|&p| column_strip(view, p)).collect(),
                }
            });
            LevelTables {
                views: views.collect(),
                narrow,
                scale: bases.scale,
                middle: triple_mean(&pyramid.levels[l]),
                stretch: usage.and_then(|usage| usage.stretch.get(l).copied()).unwrap_or(0),
            }
        });
        let levels = levels.collect();
        let carried = exemplar.views.iter().map(|view| {
            let map = |(name, image): &(String, crate::data::Image)| Map {
                name: name.clone(),
                channels: image.channels(),
                samples: image.samples().clone(),
            };
            view.carried.iter().map(map).collect()
        });
        Ok(Self { levels, carried: carried.collect() })
    }

    /// Bytes held.
    pub fn byte_size(&self) -> u64 {
        let views = self.levels.iter().flat_map(|l| &l.views);
        let tables = views.map(|v| v.view.texels.len() as u64 * (4 + 32 + 96 + 64)).sum::<u64>();
        tables + self.carried.iter().flatten().map(|map| map.samples.byte_size()).sum::<u64>()
    }
}
