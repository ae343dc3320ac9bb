//! Similarity sets: for every pixel those whose neighbourhoods are most like its own (Tong et al. 2002; Chen & Wang 2010,
//! section 4.3).

use breccia_engine::{Data, Digest};
use breccia_shaders::{Gpu, GpuError};
use rayon::prelude::*;

use super::device::SimilarityJob;
use super::nearest::PatchTable;
use super::patches::{PatchView, Patches};
use super::tree::{Room, Tree};
use crate::control::{Cancelled, Control, Stopped, check, on_device};
use crate::data::{Reader, Writer};
use crate::lazy::{Isa, LevelView, Pixel, apart, available_instruction_sets};

/// The similarity sets of all views at one level.
#[derive(Clone, Debug, PartialEq)]
pub struct SimilarSets {
    /// Pixels in a set.
    pub k: usize,
    /// For each view and pixel, row by row, its set: the pixel itself (or the nearest centre) first, then the others by
    /// distance.
    pub views: Vec<Vec<Pixel>>,
}

/// From so many neighbourhoods on a tree finds the sets faster than comparing all.
const MANY: usize = 4096;

/// The exact sets by distance of coefficients. Members lie at least `spread` pixels apart along columns or rows; ties
/// go to the first pixel. A set that runs out of pixels repeats its last.
/// A compute device finds the same.
///
/// # Errors
/// [`Stopped`].
pub fn similar_sets(
    patches: &Patches,
    k: usize,
    spread: i32,
    control: &dyn Control,
) -> Result<SimilarSets, Stopped> {
    let found = on_device(control, |gpu| {
        let views = patches.views.iter().map(|view| sets_on(gpu, patches, view, k, spread, control));
        views.collect::<Result<Option<Vec<_>>, _>>()
    })?;
    match found.flatten() {
        Some(views) => Ok(SimilarSets { k, views }),
        None => Ok(similar_sets_with(patches, k, spread, MANY, control)?),
    }
}

/// A view without its colours.
fn level_of(view: &PatchView) -> LevelView {
    let (width, height, tileable) = (view.width, view.height, view.tileable);
    LevelView { width, height, tileable, texels: Vec::new(), barred: Vec::new() }
}

/// The sets of a view on a device; `None` if its kernel has no room for them.
fn sets_on(
    gpu: &Gpu,
    patches: &Patches,
    view: &PatchView,
    k: usize,
    spread: i32,
    control: &dyn Control,
) -> Result<Option<Vec<Pixel>>, GpuError> {
    let (level, window) = (level_of(view), patches.window());
    let centres = window.pixels_of(&level);
    let places = (0..view.height).flat_map(|y| (0..view.width).map(move |x| (x, y)));
    let own: Vec<(Pixel, bool)> = places.map(|(x, y)| (window.centre(&level, x, y), true)).collect();
    let job = SimilarityJob {
        size: [view.width, view.height],
        tileable: view.tileable,
        coefficients: &view.table,
        dims: view.dims,
        centres: &centres,
        own: &own,
        members: k,
        spread,
        // The processor keeps as many as it can need.
        keep: centres.len(),
    };
    if !job.fits() {
        return Ok(None);
    }
    let mut sets = Vec::with_capacity(own.len() * k);
    for (set, &(own, _)) in job.run(gpu, control)?.chunks_exact(k).zip(&own) {
        let mut last = own;
        sets.extend(set.iter().map(|member| {
            last = member.unwrap_or(last);
            last
        }));
    }
    Ok(Some(sets))
}

fn similar_sets_with(
    patches: &Patches,
    k: usize,
    spread: i32,
    many: usize,
    control: &dyn Control,
) -> Result<SimilarSets, Cancelled> {
    let isa = available_instruction_sets().last().copied().unwrap_or(Isa::Portable);
    let mut views = Vec::new();
    for view in &patches.views {
        let level = level_of(view);
        let window = patches.window();
        let centres = window.pixels_of(&level);
        let vectors: Vec<&[i16]> = centres.iter().map(|&p| view.coefficients(level.index(p))).collect();
        let mut numbers = vec![0; (view.width * view.height) as usize];
        centres.iter().enumerate().for_each(|(number, &p)| numbers[level.index(p)] = number);
        let tree = (centres.len() >= many).then(|| Tree::new(&vectors, view.dims));
        let table = PatchTable::new(vectors.into_iter(), view.dims);
        // So many of the nearest can be too close to members taken before.
        let crowd = (2 * spread - 1).pow(2) as usize;
        let keep = (k * crowd).max(2 * k).min(centres.len());
        let rows: Vec<Vec<Pixel>> = (0..view.height)
            .into_par_iter()
            .map(|y| {
                check(control)?;
                let (mut distances, mut nearest, mut room) = (Vec::new(), Vec::new(), Room::default());
                let mut sets = Vec::with_capacity(view.width as usize * k);
                for x in 0..view.width {
                    let own = window.centre(&level, x, y);
                    let query = view.coefficients(level.index(own));
                    match &tree {
                        Some(tree) => {
                            let number = numbers[level.index(own)];
                            tree.nearest(number, query, keep, isa, &mut room, &mut nearest);
                        }
                        None => {
                            table.distances(query, &mut distances, isa);
                            smallest(&distances[..centres.len()], keep, &mut nearest);
                        }
                    }
                    let start = sets.len();
                    sets.push(own);
                    for &(_, i) in &nearest {
                        let other = centres[i as usize];
                        if sets.len() - start < k
                            && sets[start..]
                                .iter()
                                .all(|&member| apart(&level, member, other) >= spread.max(1))
                        {
                            sets.push(other);
                        }
                    }
                    let last = sets.last().copied().unwrap_or(own);
                    sets.resize(start + k, last);
                }
                Ok(sets)
            })
            .collect::<Result<_, Cancelled>>()?;
        views.push(rows.concat());
    }
    Ok(SimilarSets { k, views })
}

/// The `count` smallest distances with their indices, smallest first, ties to the first.
fn smallest(distances: &[u32], count: usize, out: &mut Vec<(u32, u32)>) {
    out.clear();
    let mut worst = u32::MAX;
    // A buffer of twice the count is cut in half whenever it is full: most distances are then passed over by one comparison.
    for (i, &distance) in distances.iter().enumerate() {
        if distance < worst {
            out.push((distance, i as u32));
            if out.len() >= 2 * count + 16 {
                out.select_nth_unstable(count - 1);
                out.truncate(count);
                worst = out.iter().map(|o| o.0).max().unwrap_or(u32::MAX);
            }
        }
    }
    out.sort_unstable();
    out.truncate(count);
}

impl Data for SimilarSets {
    const TYPE: &'static str = "similar_sets";
    const DOCS: &'static str =
        "For every exemplar pixel those with the most similar neighbourhoods, at one level.";

    fn byte_size(&self) -> u64 {
        self.views.iter().map(|view| view.len() as u64 * 2).sum()
    }

    fn summary(&self) -> String {
        let count: usize = self.views.iter().map(Vec::len).sum();
        format!("{} sets of {}", count / self.k.max(1), self.k)
    }

    fn digest(&self) -> Digest {
        Digest::of(&self.encode().unwrap_or_default())
    }

    fn encode(&self) -> Option<Vec<u8>> {
        let mut out = Writer::new();
        out.u64(self.k as u64).u64(self.views.len() as u64);
        self.views.iter().for_each(|view| {
            out.array(view);
        });
        Some(out.finish())
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = Reader::new(bytes);
        let (k, views) = (reader.u64()? as usize, reader.u64()?);
        let mut sets = Self { k, views: Vec::new() };
        for _ in 0..views {
            let view: Vec<Pixel> = reader.array()?;
            if k == 0 || !view.len().is_multiple_of(k) {
                return Err("there are no whole sets".to_owned());
            }
            sets.views.push(view);
        }
        reader.end()?;
        Ok(sets)
    }
}

#[cfg(test)]
mod tests {
    use breccia_shaders::GpuSettings;
    use proptest::prelude::*;

    use super::*;
    use crate::control::testing::{OnDevice, cases};
    use crate::lazy::{LevelView, Pyramid, random::hash};
    use crate::search::{Keep, Window, patch_basis, patches};

    #[test]
    fn sets_are_those_of_a_full_sort() {
        let texels = (0..400i32)
            .map(|i| {
                let h = i.wrapping_mul(668_265_263) as u32;
                [(h >> 11) as u8, (h >> 17) as u8, (h >> 23) as u8, 7]
            })
            .collect();
        let pyramid = Pyramid {
            levels: vec![vec![LevelView {
                width: 20,
                height: 20,
                tileable: false,
                texels,
                barred: Vec::new(),
            }]],
        };
        let window = Window { size: 4 };
        let basis = patch_basis(&pyramid, 0, window, Keep { dims: 16, variance: 1.0 }, &()).unwrap();
        let patches = patches(&pyramid, &basis, &()).unwrap();
        let sets = similar_sets(&patches, 5, 1, &()).unwrap();
        let view = &pyramid.levels[0][0];
        let centres = window.pixels_of(view);
        let of = |p: Pixel| patches.views[0].coefficients(view.index(p));
        for (i, set) in sets.views[0].chunks_exact(5).enumerate() {
            let own = window.centre(view, i as i32 % 20, i as i32 / 20);
            let gap = |p: Pixel| {
                of(own).iter().zip(of(p)).map(|(a, b)| (i64::from(*a) - i64::from(*b)).pow(2)).sum::<i64>()
            };
            let mut order = centres.clone();
            order.sort_by_key(|&p| (gap(p), p));
            assert_eq!(set[0], own);
            let expected: Vec<i64> = order.iter().filter(|&&p| p != own).take(4).map(|&p| gap(p)).collect();
            let found: Vec<i64> = set[1..].iter().map(|&p| gap(p)).collect();
            assert_eq!(found, expected);
        }
        for spread in [1, 3] {
            let by_tree = similar_sets_with(&patches, 5, spread, 0, &()).unwrap();
            assert_eq!(by_tree, similar_sets_with(&patches, 5, spread, usize::MAX, &()).unwrap());
        }
        let far = similar_sets(&patches, 5, 3, &()).unwrap();
        for set in far.views[0].chunks_exact(5) {
            assert!((0..5).all(|i| (0..i).all(|j| apart(view, set[i], set[j]) >= 3)), "{set:?}");
        }
    }

    /// Neighbourhoods of a picture of few colours, so that many are equal.
    fn some_patches() -> impl Strategy<Value = Patches> {
        let view = (9..34i32, 9..34i32, any::<bool>(), any::<u64>());
        (prop::collection::vec(view, 1..3), 1..9i32, prop_oneof![Just(8usize), Just(24), Just(64)]).prop_map(
            |(views, size, dims)| {
                let view = |(width, height, tileable, seed): (i32, i32, bool, u64)| {
                    let texel = |i: i32| {
                        let grey = (hash(seed, 1, [i % width / 3, i / width / 2, 0]) % 3) as u8;
                        [grey * 120, grey * 60, 200 - grey * 90, 0]
                    };
                    let texels = (0..width * height).map(texel).collect();
                    LevelView { width, height, tileable, texels, barred: Vec::new() }
                };
                let pyramid = Pyramid { levels: vec![views.into_iter().map(view).collect()] };
                let keep = Keep { dims, variance: 1.0 };
                let basis = patch_basis(&pyramid, 0, Window { size }, keep, &()).unwrap();
                patches(&pyramid, &basis, &()).unwrap()
            },
        )
    }

    #[test]
    fn on_the_device_sets_are_the_same() {
        let Some(device) = OnDevice::open(GpuSettings::default()) else { return };
        let result = cases(40).run(&(some_patches(), 1..12usize, 1..6i32), |(patches, k, spread)| {
            let on_cpu = similar_sets(&patches, k, spread, &()).unwrap();
            prop_assert_eq!(similar_sets(&patches, k, spread, &device).unwrap(), on_cpu);
            Ok(())
        });
        result.unwrap();
        assert_eq!(device.losses(), 0);
        assert!(device.gpu.traffic().dispatches > 40);
    }
}
