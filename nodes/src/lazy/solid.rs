//! The lazily synthesised solid: it computes the voxels asked for and those they depend on, nothing else.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use breccia_engine::{Data, Digest};
use breccia_shaders::Gpu;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::color::{Contrast, OneColor};
use super::dependency::{Dependency, dependency, dependency_among, parents};
use super::domain::Domain;
use super::field::{Brick, Correction, Field};
use super::initial::Initial;
use super::isa::{Isa, available};
use super::kernel::Weights;
use super::per_level;
use super::pyramid::{LevelView, Pixel};
use super::schedule::Settings;
use super::tables::Tables;
use super::taken::{Free, Taken};
use crate::control::{Cancelled, Control, check};
use crate::data::{
    BRICK_VOXELS, Extent, Map, MapInfo, Solid, SolidError, Tap, VoxelMap, VoxelSet, indices, voxel_at,
};
use crate::solid::device::can_sample;

/// Finished bricks of all levels are kept up to this many (5.6 kB each), so that neighbouring requests share work.
const CACHED_BRICKS: usize = 24_000;

/// A solid texture synthesised on demand (Dong et al. 2008, section 5).
pub struct LazySolid {
    pub(super) tables: Arc<Tables>,
    pub(super) initial: Initial,
    pub(super) settings: Settings,
    isa: Isa,
    pub(super) digest: Digest,
    pub(super) taken: Option<(Taken, [Pixel; 3])>,
    cache: Mutex<Vec<Cache>>,
    /// How many bricks the cache holds, to be told without waiting for it.
    held: AtomicUsize,
}

/// Finished voxels of one level.
#[derive(Default)]
struct Cache {
    known: VoxelSet,
    bricks: FxHashMap<[i32; 3], Arc<Brick>>,
}

/// What a test volume uses.
pub(super) struct Counted {
    /// How often each pixel of each view is used.
    pub counts: Vec<Vec<u32>>,
    /// The contrast of its colours.
    pub contrast: Contrast,
    /// The mean cost of a voxel.
    pub cost: i64,
}

/// What a synthesis did, for tests, benchmarks and the usage weights.
#[derive(Clone, Debug, Default)]
pub struct Work {
    /// For each level, finest first: corrections made.
    pub corrections: Vec<u64>,
    /// For each level: the sum of the costs of the last pass's corrections.
    pub costs: Vec<i64>,
}

impl LazySolid {
    /// A solid from its tables. `digest` must determine `tables`; the rest is added to it here.
    pub fn new(tables: Arc<Tables>, initial: Initial, settings: Settings, digest: Digest) -> Self {
        let mut hasher = blake3::Hasher::new();
        // Raised when the same settings give another solid.
        hasher.update(b"lazy solid 2");
        hasher.update(&digest.0);
        hasher.update(&initial.digest().0);
        hasher.update(format!("{settings:?}").as_bytes());
        let levels = tables.levels.len();
        Self {
            tables,
            initial,
            settings,
            isa: available().last().copied().unwrap_or(Isa::Portable),
            digest: hasher.finalize().into(),
            taken: None,
            cache: Mutex::new((0..levels).map(|_| Cache::default()).collect()),
            held: AtomicUsize::new(0),
        }
    }

    /// Leaves voxels to another solid, white where it has them: they are never corrected, and to their neighbours they look like the
    /// exemplar's barred pixels do.
    ///
    /// # Errors
    /// If there is more than one level, or the exemplar bars no pixel.
    pub fn with_taken(mut self, taken: Arc<dyn Solid>) -> Result<Self, TakenError> {
        if self.tables.levels.len() > 1 {
            return Err(TakenError::Levels(self.tables.levels.len()));
        }
        let marker = [0, 1, 2].map(|e| marker(&self.tables.levels[0].view(e).view));
        let [Some(x), Some(y), Some(z)] = marker else { return Err(TakenError::NothingBarred) };
        let mut hasher = blake3::Hasher::new();
        hasher.update(&self.digest.0).update(&taken.digest().0);
        self.digest = hasher.finalize().into();
        self.taken = Some((Taken(taken), [x, y, z]));
        Ok(self)
    }

    /// Uses another instruction set; the answers stay the same.
    pub fn with_isa(mut self, isa: Isa) -> Self {
        self.isa = if available().contains(&isa) { isa } else { Isa::Portable };
        self
    }

    /// The tables.
    pub fn tables(&self) -> &Tables {
        &self.tables
    }

    /// Forgets all finished bricks.
    pub fn clear_cache(&self) {
        let mut cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        cache.iter_mut().for_each(|level| *level = Cache::default());
        self.held.store(0, Ordering::Relaxed);
    }

    pub(super) fn domain(&self, level: usize) -> Domain {
        Domain::at_level(self.settings.period, level)
    }

    pub(super) fn color(&self, level: usize) -> OneColor {
        OneColor::new(self.settings.color, &self.tables.levels[level])
    }

    pub(super) fn weights(&self, level: usize) -> Weights {
        let fixed = |x: f64| libm::round(x.clamp(0.0, 15.0) * 256.0) as u32;
        Weights {
            similar: per_level(&self.settings.similar, level).clamp(1, super::similarity::SET as i64)
                as usize,
            triples: per_level(&self.settings.triples, level).clamp(0, super::candidates::SET as i64)
                as usize,
            incoherent: 256 + fixed(self.settings.coherence) as i32,
            crossbar: fixed(self.settings.crossbar).into(),
        }
    }

    /// The finished state of a level over `wanted` (wrapped), from the cache as far as it goes.
    fn finished(
        &self,
        level: usize,
        wanted: &VoxelSet,
        work: &mut Work,
        control: &dyn Control,
    ) -> Result<Field, SolidError> {
        let keys = wanted.bricks();
        let mut missing = VoxelSet::new();
        let known: Vec<Option<Arc<Brick>>> = {
            let cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
            let cache = &cache[level];
            let find = |&key: &[i32; 3]| {
                let mask = wanted.mask(key)?;
                let known = cache.known.mask(key).copied().unwrap_or_default();
                missing.insert_mask(key, &std::array::from_fn(|z| mask[z] & !known[z]));
                cache.bricks.get(&key).cloned()
            };
            keys.iter().map(find).collect()
        };
        let computed = if missing.is_empty() {
            Field::of(Vec::new(), Vec::new())
        } else {
            let field = match control.gpu().filter(|_| level == 0) {
                Some(gpu) => self.synthesise_on(gpu, &missing, work, control)?,
                None => self.synthesise(level, &missing, work, control)?,
            };
            self.remember(level, &missing, &field);
            field
        };
        if known.iter().all(Option::is_none) {
            return Ok(computed);
        }
        let merge = |(key, known): (&[i32; 3], &Option<Arc<Brick>>)| {
            let mut brick = known.as_ref().map_or_else(Brick::empty, |known| (**known).clone());
            if let (Some(new), Some(mask)) = (computed.brick(*key), missing.mask(*key)) {
                brick.copy_masked(new, mask);
            }
            brick
        };
        let bricks = keys.iter().zip(&known).map(merge).collect();
        Ok(Field::of(keys, bricks))
    }

    fn remember(&self, level: usize, set: &VoxelSet, field: &Field) {
        let mut cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        let held: usize = cache.iter().map(|level| level.bricks.len()).sum();
        if held + set.brick_count() > CACHED_BRICKS {
            // Values are the same whenever they are computed, so dropping all of them changes nothing but time.
            cache.iter_mut().for_each(|level| *level = Cache::default());
            self.held.store(0, Ordering::Relaxed);
        }
        if set.brick_count() > CACHED_BRICKS / 2 {
            return;
        }
        let level = &mut cache[level];
        for key in set.bricks() {
            let (Some(mask), Some(brick)) = (set.mask(key), field.brick(key)) else { continue };
            match level.bricks.entry(key) {
                std::collections::hash_map::Entry::Occupied(mut entry) => {
                    let mut merged = (**entry.get()).clone();
                    merged.copy_masked(brick, mask);
                    entry.insert(Arc::new(merged));
                }
                std::collections::hash_map::Entry::Vacant(entry) => {
                    entry.insert(Arc::new(brick.clone()));
                }
            }
            level.known.insert_mask(key, mask);
        }
        self.held.store(cache.iter().map(|level| level.bricks.len()).sum(), Ordering::Relaxed);
    }

    /// What a level must compute where another solid has some of the voxels; all of what is needed is known to `free` then.
    pub(super) fn depend_among(
        &self,
        free: &mut Free<'_>,
        level: usize,
        wanted: &VoxelSet,
    ) -> Result<Dependency, SolidError> {
        let domain = self.domain(level);
        let need = dependency_among(&self.settings, &domain, level, wanted, |step| free.of(&step))?;
        free.of(&need.before)?;
        Ok(need)
    }

    /// Computes a level over `wanted`, and the coarser levels that it needs.
    pub(super) fn synthesise(
        &self,
        level: usize,
        wanted: &VoxelSet,
        work: &mut Work,
        control: &dyn Control,
    ) -> Result<Field, SolidError> {
        check(control)?;
        let (domain, tables, color) = (self.domain(level), &self.tables.levels[level], self.color(level));
        let mut free = self.taken.as_ref().map(|(taken, _)| taken.free(control));
        let need = match &mut free {
            Some(free) => self.depend_among(free, level, wanted)?,
            None => dependency(&self.settings, &domain, level, wanted),
        };
        let correction =
            Correction { domain: &domain, level: tables, weights: self.weights(level), color, isa: self.isa };
        let mut field = if level + 1 == self.tables.levels.len() {
            let free =
                free.as_ref().zip(self.taken.as_ref()).map(|(free, (_, marker))| (&free.free, *marker));
            Field::start(&need.before, &self.initial, self.settings.seed, free, &correction, control)?
        } else {
            let coarse = self.finished(level + 1, &parents(&need.before), work, control)?;
            Field::upsample(&need.before, &coarse, tables, color, control)?
        };
        let steps = need.corrected.len();
        let last_pass = steps - self.settings.schedule_at(level).steps().min(steps);
        for (step, set) in need.corrected.iter().enumerate() {
            let cost = field.correct(set, &correction, control)?;
            work.corrections[level] += set.len() as u64;
            if step >= last_pass {
                work.costs[level] += cost;
            }
            if level == 0 {
                control.progress((step + 1) as f32 / steps as f32);
            }
        }
        Ok(field)
    }

    /// The pixel triples of the voxels asked for (Z, Y, X order is the set's own), with the work done.
    pub(super) fn field(
        &self,
        voxels: &VoxelSet,
        control: &dyn Control,
    ) -> Result<(Field, Work), SolidError> {
        let levels = self.tables.levels.len();
        let mut work = Work { corrections: vec![0; levels], costs: vec![0; levels] };
        let wrapped = self.domain(0).wrap_set(voxels);
        let field = self.finished(0, &wrapped, &mut work, control)?;
        Ok((field, work))
    }

    /// What the finished voxels of a level use.
    pub(super) fn count_usage(
        &self,
        level: usize,
        wanted: &VoxelSet,
        control: &dyn Control,
    ) -> Result<Counted, Cancelled> {
        let levels = self.tables.levels.len();
        let mut work = Work { corrections: vec![0; levels], costs: vec![0; levels] };
        // Without another solid in it, all that can stop a synthesis is cancellation.
        let field = self.synthesise(level, wanted, &mut work, control).map_err(|_| Cancelled)?;
        let tables = &self.tables.levels[level];
        let mut counts: Vec<Vec<u32>> = tables.views.iter().map(|v| vec![0; v.view.texels.len()]).collect();
        let mut contrast = Contrast::default();
        for (key, brick) in field.bricks() {
            for at in indices(wanted.mask(key).unwrap_or(&[0; 8])) {
                for e in 0..3 {
                    counts[e.min(tables.views.len() - 1)][tables.view(e).view.index(brick.pixels[e][at])] +=
                        1;
                }
                contrast.add(brick.color[at].to_le_bytes());
            }
        }
        Ok(Counted { counts, contrast, cost: work.costs[level] / wanted.len().max(1) as i64 })
    }

    /// [`Solid::evaluate`], and how much was computed for it.
    ///
    /// # Errors
    /// As there.
    pub fn evaluate_counting(
        &self,
        voxels: &VoxelSet,
        control: &dyn Control,
    ) -> Result<(VoxelMap, Work), SolidError> {
        let infos = self.maps();
        let bricks = voxels.bricks();
        let bytes: usize = infos.iter().map(|m| m.channels * m.ty.byte_size()).sum();
        let total = bricks.len() as u64 * (BRICK_VOXELS * bytes) as u64;
        if total > 1 << 36 {
            return Err(SolidError::TooLarge(format!(
                "{} voxels in {} bricks need {} GB at once; ask for less at a time",
                voxels.len(),
                bricks.len(),
                total >> 30
            )));
        }
        let (field, work) = self.field(voxels, control)?;
        let mut out = VoxelMap::new(&bricks, &infos);
        for (m, map) in out.maps.iter_mut().enumerate() {
            let sources: Vec<&Map> = self.tables.carried.iter().map(|maps| &maps[m]).collect();
            self.look_up(map, &sources, m == 0, voxels, &bricks, &field);
        }
        Ok((out, work))
    }

    /// Fills one map of the answer from the exemplar's maps.
    fn look_up(
        &self,
        map: &mut Map,
        sources: &[&Map],
        is_color: bool,
        voxels: &VoxelSet,
        bricks: &[[i32; 3]],
        field: &Field,
    ) {
        let (domain, level) = (self.domain(0), &self.tables.levels[0]);
        let mean = is_color && !self.color(0).takes_one();
        let item = map.channels * map.samples.ty().byte_size();
        let sources: Vec<&[u8]> = sources.iter().map(|source| source.samples.bytes()).collect();
        let out = map.samples.bytes_mut().par_chunks_mut(BRICK_VOXELS * item);
        out.zip(bricks).for_each(|(out, &key)| {
            let Some(mask) = voxels.mask(key) else { return };
            // A brick of the request lies in one of the field, unless a period cuts it.
            let mut found: Option<([i32; 3], &Brick)> = None;
            for at in indices(mask) {
                let asked = voxel_at(key, at);
                let voxel: [i32; 3] = std::array::from_fn(|i| domain.wrap(i, asked[i]));
                let home = crate::data::brick_of(voxel);
                if found.is_none_or(|(key, _)| key != home) {
                    found = field.brick(home).map(|brick| (home, brick));
                }
                let Some((_, brick)) = found else { continue };
                let from = crate::data::local_index(voxel);
                let to = &mut out[at * item..][..item];
                if mean {
                    to.copy_from_slice(&brick.color[from].to_le_bytes()[..item]);
                    continue;
                }
                let e = usize::from(brick.shown[from]);
                let index = level.view(e).view.index(brick.pixels[e][from]);
                let source = &sources[e.min(sources.len() - 1)][index * item..][..item];
                // A colour's three bytes without a call.
                match (<&mut [u8; 3]>::try_from(&mut *to), <&[u8; 3]>::try_from(source)) {
                    (Ok(to), Ok(source)) => *to = *source,
                    _ => to.copy_from_slice(source),
                }
            }
        });
    }
}

/// Why a synthesis cannot leave voxels to another solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TakenError {
    /// Coarser levels do not know which voxels are taken.
    #[error(
        "voxels can be left to another solid only where there is one level; the pyramid has {0}, expected `levels` 1"
    )]
    Levels(usize),
    /// There is nothing that taken voxels could look like.
    #[error(
        "the exemplar bars no pixel that taken voxels could look like; expected one from `particles.matrix`"
    )]
    NothingBarred,
}

/// The barred pixel furthest from those that may be copied, the first of equals.
fn marker(view: &LevelView) -> Option<Pixel> {
    let (w, h) = (view.width as usize, view.height as usize);
    let mut barred = view.barred.clone();
    barred.resize(w * h, false);
    let depth = crate::exemplar::signed_distance(&barred, w, h, view.tileable);
    let m = view.margin();
    let inner = (m..view.height - m).flat_map(|y| (m..view.width - m).map(move |x| (x, y)));
    let barred = inner.filter(|&(x, y)| barred[y as usize * w + x as usize]);
    let deepest = barred.max_by(|&a, &b| {
        let at = |(x, y): (i32, i32)| depth[y as usize * w + x as usize];
        at(a).total_cmp(&at(b)).then(b.cmp(&a))
    });
    deepest.map(|(x, y)| (x | y << 8) as Pixel)
}

impl Solid for LazySolid {
    fn maps(&self) -> Vec<MapInfo> {
        self.tables.carried[0].iter().map(Map::info).collect()
    }

    fn extent(&self) -> Extent {
        self.settings.period.map_or(Extent::Unbounded, Extent::Periodic)
    }

    fn evaluate(&self, voxels: &VoxelSet, control: &dyn Control) -> Result<VoxelMap, SolidError> {
        self.evaluate_counting(voxels, control).map(|(map, _)| map)
    }

    fn sample(
        &self,
        gpu: &Gpu,
        maps: &[MapInfo],
        taps: &[Tap],
        control: &dyn Control,
    ) -> Result<Option<Vec<Map>>, SolidError> {
        let number = |info: &MapInfo| {
            let number = self.tables.carried[0].iter().position(|map| map.info() == *info)?;
            let everywhere = self
                .tables
                .carried
                .iter()
                .all(|maps| maps.get(number).is_some_and(|map| map.info() == *info));
            (can_sample(info) && everywhere).then_some(number)
        };
        let Some(numbers) = maps.iter().map(number).collect::<Option<Vec<_>>>() else { return Ok(None) };
        self.sample_on(gpu, maps, &numbers, taps, control).map(Some)
    }

    fn digest(&self) -> Digest {
        self.digest
    }

    fn summary(&self) -> String {
        let extent = match self.settings.period {
            Some([x, y, z]) => format!("periodic {x} × {y} × {z}"),
            None => "unbounded".to_owned(),
        };
        format!("lazy solid, {extent}, {} levels", self.tables.levels.len())
    }

    /// The tables, and the finished bricks that are kept: it grows as voxels are asked for.
    fn byte_size(&self) -> u64 {
        self.tables.byte_size() + (self.held.load(Ordering::Relaxed) * size_of::<Brick>()) as u64
    }
}
