//! The family as a whole, on pictures of known particles.

use std::collections::BTreeMap;
use std::sync::Arc;

use breccia_engine::{Data, Digest};

use super::*;
use crate::control::Control;
use crate::data::{Image, Solid, SolidError, VoxelMap, VoxelSet};
use crate::exemplar::View;
use crate::lazy;
use crate::solid::ConstantSolid;

/// A tileable picture of discs of several sizes on a lattice with moved points, and their mask.
fn discs(side: u32) -> Sections {
    let pitch = 16;
    let n = (side / pitch) as i32;
    let disc = |i: i32, j: i32| {
        let h = lazy::random::hash(5, 1, [i.rem_euclid(n), j.rem_euclid(n), 0]);
        let moved = |cell: i32, bits: u32| (cell * pitch as i32 + 8 + (bits % 5) as i32 - 2) as f64;
        (moved(i, h), moved(j, h >> 8), 4.0 + f64::from((h >> 16) % 4))
    };
    let inside = |x: u32, y: u32| {
        let (ci, cj) = ((x / pitch) as i32, (y / pitch) as i32);
        (0..9).any(|k| {
            let (cx, cy, r) = disc(ci + k % 3 - 1, cj + k / 3 - 1);
            (f64::from(x) - cx).powi(2) + (f64::from(y) - cy).powi(2) <= r * r
        })
    };
    let grain = |x: u32, y: u32| (lazy::random::hash(9, 2, [x as i32, y as i32, 0]) % 40) as u8;
    let color = Image::from_fn(side, side, |x, y| {
        if inside(x, y) { [200 - grain(x, y); 3] } else { [40 + grain(x, y), 50, 30] }
    });
    let texels = (0..side * side)
        .map(|i| {
            let [r, g, b] = color.rgb8(i % side, i / side);
            [r, g, b, 128]
        })
        .collect();
    let mask: Vec<bool> = (0..side * side).map(|i| inside(i % side, i / side)).collect();
    let carried = vec![("color".to_owned(), color)];
    let view =
        View { width: side, height: side, texels, carried, tileable: true, guided: true, barred: Vec::new() };
    find_sections(&view, &mask, &SectionSettings::default(), &()).unwrap()
}

fn settings(size: [u32; 3], seed: u64) -> PackSettings {
    PackSettings { size, seed, ..PackSettings::default() }
}

fn set() -> Arc<ParticleSet> {
    let (set, _) = reconstruct(vec![Arc::new(discs(64))], &TripleSettings::default(), &()).unwrap();
    Arc::new(set)
}

fn packed(set: &Arc<ParticleSet>, settings: &PackSettings) -> Packing {
    let neighbours = Neighbours::new(set, 10, &()).unwrap();
    pack(set, &neighbours, None, settings, &()).unwrap()
}

/// How many particles claim each voxel of the domain.
fn claims(packing: &Packing) -> BTreeMap<[i32; 3], u32> {
    let mut claims = BTreeMap::new();
    for placed in &packing.placed {
        for voxel in packing.voxels(placed) {
            let at: [i32; 3] = std::array::from_fn(|a| placed.center[a] + voxel[a]);
            let at = if packing.wrap {
                std::array::from_fn(|a| at[a].rem_euclid(packing.size[a] as i32))
            } else {
                at
            };
            // Beyond a domain that ends nothing is ever shown.
            if (0..3).all(|a| (0..packing.size[a] as i32).contains(&at[a])) {
                *claims.entry(at).or_insert(0) += 1;
            }
        }
    }
    claims
}

#[test]
fn neighbour_sets_are_the_union_of_those_of_the_sections() {
    let set = set();
    let neighbours = Neighbours::new(&set, 4, &()).unwrap();
    let particle = 3;
    let found: Vec<_> = neighbours.of(&set, particle).collect();
    let mut expected = Vec::new();
    for v in 0..3 {
        let section = set.particles[particle as usize].sections[v] as usize;
        for near in &neighbours.near[v][section] {
            for (other, p) in set.particles.iter().enumerate() {
                if p.sections[v] == near.section {
                    expected.push((other as u32, v));
                }
            }
        }
    }
    let mut names: Vec<_> = found.iter().map(|(p, _, v)| (*p, *v)).collect();
    names.sort_unstable();
    expected.sort_unstable();
    // Sections without particles have stand-ins besides.
    assert!(expected.iter().all(|e| names.binary_search(e).is_ok()));
    assert!(found.iter().all(|(_, offset, v)| offset[*v] == 0.0 && offset.iter().any(|&c| c != 0.0)));
}

#[test]
fn without_tolerance_no_particles_overlap() {
    let set = set();
    let packing = packed(&set, &PackSettings { tolerance: 0.0, ..settings([48, 40, 56], 3) });
    assert!(packing.placed.len() > 10, "{}", packing.placed.len());
    assert!(claims(&packing).values().all(|&n| n == 1));
}

#[test]
fn after_filling_no_two_particles_overlap_or_touch() {
    let set = set();
    for wrap in [true, false] {
        let loose = packed(
            &set,
            &PackSettings { tolerance: 0.3, wrap, slack: f64::INFINITY, ..settings([48; 3], 1) },
        );
        assert!(claims(&loose).values().any(|&n| n > 1), "the test needs overlap to begin with");
        for cells in [CellOf::Surface, CellOf::Center] {
            let filled =
                fill(&loose, &FillSettings { cells, clearance: 1.0, fraction: 0.0, alpha: 0.1 }, &())
                    .unwrap();
            let claims = claims(&filled);
            assert!(claims.len() > 2000 && claims.values().all(|&n| n == 1));
            // No voxel of one lies beside a voxel of another.
            let solid = ParticleSolid::new(Arc::new(filled), None, Look::Mask, true);
            let answer = solid.evaluate(&VoxelSet::from_box([0; 3], [48; 3]), &()).unwrap();
            let label = |v: [i32; 3]| answer.map(LABEL).unwrap().samples.get(answer.index(v).unwrap()) as u32;
            for v in VoxelSet::from_box([0; 3], [47; 3]).voxels() {
                for a in 0..3 {
                    let mut next = v;
                    next[a] += 1;
                    let (one, other) = (label(v), label(next));
                    assert!(one == other || one == 0 || other == 0, "{v:?}: {one} beside {other}");
                }
            }
        }
    }
}

#[test]
fn filling_meets_the_fraction_of_the_picture() {
    let set = set();
    let packing = packed(&set, &settings([64; 3], 2));
    let filled = fill(&packing, &FillSettings::default(), &()).unwrap();
    let fraction = claims(&filled).len() as f64 / 64f64.powi(3);
    assert!((fraction - set.fraction()).abs() < 0.03, "{fraction} {}", set.fraction());
}

#[test]
fn sizes_of_sections_are_those_of_the_picture() {
    let set = set();
    let packing = packed(&set, &settings([96; 3], 2));
    let filled = fill(&packing, &FillSettings::default(), &()).unwrap();
    let (report, _) = likeness(&filled, &()).unwrap();
    assert!(report.get("section_size_ks").unwrap() < 0.3, "{report:?}");
    assert!(report.get("sphericity").unwrap() > 0.8, "{report:?}");
    // Without shares of sizes there are too many small ones.
    let flooded = packed(&set, &PackSettings { slack: f64::INFINITY, ..settings([96; 3], 2) });
    assert!(flooded.placed.len() > packing.placed.len());
}

#[test]
fn repulsion_evens_out_distances() {
    let set = set();
    let few = settings([64; 3], 4);
    let mut packing = packed(&set, &few);
    // All particles of one half, crowded.
    packing.placed.retain(|p| p.center[0] < 32);
    let moved = repel(&packing, &RepelSettings { step: 4.0, ..RepelSettings::default() }, &()).unwrap();
    let far = moved.placed.iter().filter(|p| (36..60).contains(&p.center[0])).count();
    assert!(far > 0, "nobody moved into the empty half");
    assert!(moved.placed.iter().all(|p| p.center.iter().all(|c| (0..64).contains(c))));
    let two = |a: [i32; 3], b: [i32; 3]| Packing {
        placed: [a, b].map(|center| Placed { particle: 0, center, shape: None }).to_vec(),
        ..packing.clone()
    };
    // Two particles move straight apart, by symmetry.
    let apart = repel(&two([28, 32, 32], [36, 32, 32]), &RepelSettings::default(), &()).unwrap();
    let [a, b] = [apart.placed[0].center, apart.placed[1].center];
    assert!(a[0] < 28 && b[0] > 36, "{a:?} {b:?}");
}

#[test]
fn all_stages_are_the_same_for_any_number_of_threads() {
    let all = || {
        let set = set();
        let packing = packed(&set, &settings([48; 3], 7));
        let moved = repel(&packing, &RepelSettings::default(), &()).unwrap();
        fill(&moved, &FillSettings::default(), &()).unwrap().digest()
    };
    let digest = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(all);
    assert_eq!(digest(1), digest(3));
}

#[test]
fn values_come_back_from_their_bytes_and_damage_is_an_error() {
    let set = set();
    let packing = fill(&packed(&set, &settings([32; 3], 1)), &FillSettings::default(), &()).unwrap();
    let bytes = packing.encode().unwrap();
    assert_eq!(Packing::decode(&bytes).unwrap().digest(), packing.digest());
    for cut in [0, 9, bytes.len() / 2, bytes.len() - 1] {
        assert!(Packing::decode(&bytes[..cut]).is_err());
    }
    let list = ParticleList::of(&packing);
    assert_eq!(ParticleList::decode(&list.encode().unwrap()).unwrap(), list);
    assert_eq!(list.csv().lines().count(), list.entries.len() + 1);
    let near = |i: usize| &list.entries[i].neighbours;
    for entry in &list.entries {
        assert!(
            entry.neighbours.iter().all(|&n| near(n as usize - 1).contains(&entry.id)),
            "neighbours are mutual"
        );
    }
}

/// The lazy matrix around a packing, and the solid of both.
fn hybrid(packing: &Arc<Packing>, sections: &Sections) -> (Arc<lazy::LazySolid>, ParticleSolid) {
    let exemplar = crate::exemplar::Exemplar { views: vec![matrix_node::matrix_view(sections)] };
    let pyramid = lazy::Pyramid::new(&exemplar, 1).unwrap();
    let descriptors = lazy::make_descriptors(&pyramid, &[8]);
    let similarity = lazy::similarity_sets(&pyramid, &descriptors, 3, &()).unwrap();
    let strips = lazy::CandidateSettings { strips: 16, best: 24, ..Default::default() };
    let candidates = lazy::make_candidates(&pyramid, &strips, &()).unwrap();
    let tables =
        lazy::Tables::new(&exemplar, &pyramid, &descriptors, &similarity, &candidates, None).unwrap();
    let initial = lazy::Initial { size: [1, 1], slab: Vec::new(), aligned: false, jitter: None };
    let settings = lazy::Settings { period: Some(packing.size), ..Default::default() };
    let mask: Arc<dyn Solid> = Arc::new(ParticleSolid::new(Arc::clone(packing), None, Look::Mask, false));
    let matrix =
        lazy::LazySolid::new(Arc::new(tables), initial, settings, Digest([1; 32])).with_taken(mask).unwrap();
    let matrix = Arc::new(matrix);
    let shared: Arc<dyn Solid> = Arc::<lazy::LazySolid>::clone(&matrix);
    (matrix, ParticleSolid::new(Arc::clone(packing), Some(shared), Look::Pictures, false))
}

fn color(map: &VoxelMap, voxel: [i32; 3]) -> [u8; 3] {
    let at = map.index(voxel).unwrap() * 3;
    [0, 1, 2].map(|c| map.maps[0].samples.get_u8(at + c))
}

#[test]
fn the_hybrid_answers_the_same_in_any_portions_and_copies_no_particle_into_the_matrix() {
    let set = set();
    let packing =
        Arc::new(fill(&packed(&set, &settings([40; 3], 5)), &FillSettings::default(), &()).unwrap());
    let sections = Arc::clone(set.view(0));
    let (_, solid) = hybrid(&packing, &sections);
    let whole = VoxelSet::from_box([0; 3], [40; 3]);
    let full = solid.evaluate(&whole, &()).unwrap();
    let free = solid.matrix_voxels(&whole);
    // Colours of the matrix are those of its pixels: discs are lighter than 160 in the red channel, the matrix darker than 80.
    for voxel in whole.voxels() {
        let [r, _, _] = color(&full, voxel);
        assert_eq!(free.contains(voxel), r < 100, "{voxel:?} {r}");
    }
    for round in 0..12u32 {
        let (_, solid) = hybrid(&packing, &sections);
        let pick = |k: u32| (lazy::random::hash(3, 4, [round as i32, k as i32, 0]) % 120) as i32 - 40;
        let part: VoxelSet = (0..40).map(|k| [pick(3 * k), pick(3 * k + 1), pick(3 * k + 2)]).collect();
        let answer = solid.evaluate(&part, &()).unwrap();
        for voxel in part.voxels() {
            assert_eq!(color(&answer, voxel), color(&full, voxel.map(|c| c.rem_euclid(40))), "{voxel:?}");
        }
    }
}

#[test]
fn only_voxels_of_the_matrix_are_ever_corrected() {
    let set = set();
    let packing =
        Arc::new(fill(&packed(&set, &settings([40; 3], 5)), &FillSettings::default(), &()).unwrap());
    let (matrix, solid) = hybrid(&packing, set.view(0));
    let wanted = solid.matrix_voxels(&VoxelSet::from_box([0; 3], [40, 40, 1]));
    let (_, work) = matrix.evaluate_counting(&wanted, &()).unwrap();
    // Two passes: the slice itself, and before that what it sees, two layers to each side.
    let around: VoxelSet = VoxelSet::from_box([0, 0, -2], [40, 40, 5]);
    let most = wanted.len() + solid.matrix_voxels(&around).len();
    assert!(work.corrections[0] as usize <= most, "{} {most}", work.corrections[0]);
    assert!(work.corrections[0] as usize >= wanted.len());
}

#[test]
fn recolouring_touches_what_it_is_asked_to() {
    let set = set();
    let packing = Arc::new(packed(&set, &settings([32; 3], 5)));
    let base: Arc<dyn Solid> = Arc::new(ParticleSolid::new(
        Arc::clone(&packing),
        Some(Arc::new(ConstantSolid { color: [9; 3] })),
        Look::Pictures,
        false,
    ));
    let red: Arc<dyn Solid> = Arc::new(ConstantSolid { color: [200, 20, 20] });
    let settings = RecolorSettings { whole: true, strength: 1.0, detail: 0.0 };
    let recolored = RecolorSolid::new(Arc::clone(&packing), base, Some(red), None, settings, &()).unwrap();
    let all = VoxelSet::from_box([-8; 3], [40; 3]);
    let answer = recolored.evaluate(&all, &()).unwrap();
    let mut seen = [0; 2];
    for voxel in all.voxels() {
        match color(&answer, voxel) {
            [200, 20, 20] => seen[0] += 1,
            [9, 9, 9] => seen[1] += 1,
            other => panic!("{other:?}"),
        }
    }
    assert!(seen.iter().all(|&n| n > 1000), "{seen:?}");
}

#[test]
fn rigid_particles_keep_their_volume_and_soft_ones_are_squeezed() {
    let set = set();
    let mut packing = packed(&set, &PackSettings { wrap: false, ..settings([64, 48, 48], 5) });
    packing
        .placed
        .retain(|p| p.center.iter().zip(packing.size).all(|(&c, n)| (10..n as i32 - 10).contains(&c)));
    packing.placed.truncate(1);
    let packing = Arc::new(packing);
    let own = packing.voxels(&packing.placed[0]).len() as f64;
    let volume = |rigidity: f64| {
        let deformation = Deformation { kind: Kind::Taper(0.3), axis: 0, size: [64.0, 48.0, 48.0] };
        let solid = DeformedSolid::new(Arc::clone(&packing), None, deformation, rigidity, Part::Particles);
        let box_ = VoxelSet::from_box([-8; 3], [80, 64, 64]);
        let answer = solid.evaluate(&box_, &()).unwrap();
        box_.voxels().filter(|&v| color(&answer, v) == [255; 3]).count() as f64
    };
    assert!((volume(1.0) / own - 1.0).abs() < 0.05, "{} {own}", volume(1.0));
    assert!(volume(0.0) < 0.85 * own, "{} {own}", volume(0.0));
}

#[test]
fn selecting_removes_thins_out_and_scales() {
    let set = set();
    let packing = packed(&set, &settings([64; 3], 5));
    let all = SelectSettings { keep: 1.0, least: 0, most: u64::MAX, remove: Vec::new(), scale: 1.0, seed: 1 };
    assert_eq!(select(&packing, &all).placed, packing.placed);
    let half = select(&packing, &SelectSettings { keep: 0.5, ..all.clone() });
    let share = half.placed.len() as f64 / packing.placed.len() as f64;
    assert!((0.3..0.7).contains(&share), "{share}");
    assert_eq!(
        select(&packing, &SelectSettings { remove: vec![1, 3], ..all.clone() }).placed.len(),
        packing.placed.len() - 2
    );
    let small = select(&packing, &SelectSettings { scale: 0.5, ..all });
    for (one, other) in small.placed.iter().zip(&packing.placed) {
        let ratio = small.voxels(one).len() as f64 / packing.voxels(other).len() as f64;
        assert!((ratio * 8.0 - 1.0).abs() < 0.35, "{ratio}");
    }
}

#[test]
fn a_region_without_room_and_a_domain_too_small_are_errors() {
    let set = set();
    let neighbours = Neighbours::new(&set, 10, &()).unwrap();
    let black = |_: [i32; 3]| 0u8;
    let error = pack(&set, &neighbours, Some(&black), &settings([48; 3], 1), &()).unwrap_err().to_string();
    assert!(error.contains("black wherever"), "{error}");
    let error = pack(&set, &neighbours, None, &settings([4; 3], 1), &()).unwrap_err().to_string();
    assert!(error.contains("does not fit into a domain of 4 × 4 × 4"), "{error}");
    // Half a region holds particles in that half only.
    let half = |v: [i32; 3]| if v[0] < 24 { 255 } else { 0 };
    let packing = pack(&set, &neighbours, Some(&half), &settings([48; 3], 1), &()).unwrap();
    assert!(packing.placed.len() > 3 && packing.placed.iter().all(|p| p.center[0] < 24));
}

#[test]
fn everything_can_be_cancelled() {
    struct Cancelled;
    impl Control for Cancelled {
        fn is_cancelled(&self) -> bool {
            true
        }
    }
    let set = set();
    let packing = packed(&set, &settings([48; 3], 1));
    assert!(matches!(
        reconstruct(vec![Arc::clone(set.view(0))], &TripleSettings::default(), &Cancelled),
        Err(TripleError::Cancelled)
    ));
    assert!(Neighbours::new(&set, 10, &Cancelled).is_err());
    assert!(repel(&packing, &RepelSettings::default(), &Cancelled).is_err());
    assert!(fill(&packing, &FillSettings::default(), &Cancelled).is_err());
    assert!(likeness(&packing, &Cancelled).is_err());
    let solid = ParticleSolid::new(Arc::new(packing), None, Look::Mask, false);
    let asked = solid.evaluate(&VoxelSet::from_box([0; 3], [16; 3]), &Cancelled);
    assert!(matches!(asked, Err(SolidError::Cancelled)));
}
