//! Particles: reconstruction, packing and refinement, and how they grow with the domain.

use std::sync::Arc;

use breccia_nodes::exemplar::{MakeSettings, make_exemplar, otsu_mask};
use breccia_nodes::particles::{
    FillSettings, Neighbours, PackSettings, Packing, ParticleSet, RepelSettings, SectionSettings, Sections,
    TripleSettings, fill, find_sections, pack, reconstruct, repel,
};
use divan::Bencher;

use crate::material::cells;
use crate::sizes;

/// The cross-sections of a picture of cells, one for about 12 × 12 pixels.
fn sections(side: u32) -> Arc<Sections> {
    let picture = cells(side);
    let make = MakeSettings { max_size: 256, tileable: true, ..MakeSettings::default() };
    let exemplar = make_exemplar(&picture, None, None, &[], &make).expect("a usable picture");
    let mask = otsu_mask(&picture).expect("a picture of two classes");
    Arc::new(
        find_sections(exemplar.view(0), &mask, &SectionSettings::default(), &()).expect("nobody cancels"),
    )
}

fn set(side: u32) -> Arc<ParticleSet> {
    let (set, _) = reconstruct(vec![sections(side)], &TripleSettings::default(), &()).expect("particles");
    Arc::new(set)
}

fn packed(set: &Arc<ParticleSet>, size: u32) -> Packing {
    let neighbours = Neighbours::new(set, 10, &()).expect("nobody cancels");
    let settings = PackSettings { size: [size; 3], ..PackSettings::default() };
    pack(set, &neighbours, None, &settings, &()).expect("particles fit")
}

/// About 28, 113 and 450 cross-sections a view.
#[divan::bench(args = sizes(&[64, 128, 256], 64), max_time = 20)]
fn particles_reconstruct(bencher: Bencher<'_, '_>, side: u32) {
    let sections = sections(side);
    bencher.bench_local(|| reconstruct(vec![Arc::clone(&sections)], &TripleSettings::default(), &()));
}

#[divan::bench(args = sizes(&[64, 128, 256, 512], 48), max_time = 60)]
fn particles_pack(bencher: Bencher<'_, '_>, size: u32) {
    let set = set(128);
    bencher.bench_local(|| packed(&set, size).placed.len());
}

#[divan::bench(args = sizes(&[64, 128, 256], 48), max_time = 30)]
fn particles_repel(bencher: Bencher<'_, '_>, size: u32) {
    let packing = packed(&set(128), size);
    bencher.bench_local(|| repel(&packing, &RepelSettings::default(), &()));
}

#[divan::bench(args = sizes(&[64, 128, 256], 48), max_time = 60)]
fn particles_fill(bencher: Bencher<'_, '_>, size: u32) {
    let packing = packed(&set(128), size);
    bencher.bench_local(|| fill(&packing, &FillSettings::default(), &()));
}
