//! Synthesises one exemplar, prints timings, and writes a contact picture: exemplar, three faces, oblique cut.
#![allow(clippy::print_stdout, clippy::expect_used, reason = "a tool for developers")]

use std::sync::Arc;
use std::time::Instant;

use breccia_nodes::data::{Image, Samples, Solid, VoxelSet};
use breccia_nodes::exemplar::{Feature, MakeSettings, make_exemplar};
use breccia_nodes::lazy::*;

fn load(path: &str) -> Image {
    let picture = image::open(path).expect("a readable picture").to_rgb8();
    Image::new(picture.width(), picture.height(), 3, Samples::U8(picture.into_raw())).expect("pixels")
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let get = |name: &str| args.iter().position(|a| a == name).and_then(|i| args.get(i + 1)).cloned();
    let num = |name: &str, default: f64| get(name).and_then(|v| v.parse().ok()).unwrap_or(default);
    let color = load(&get("--exemplar").expect("--exemplar"));
    let mask = get("--mask").map(|p| load(&p));
    let feature = match get("--feature").as_deref() {
        Some("none") => Feature::None,
        Some("mask") => Feature::Mask,
        _ => Feature::Auto,
    };
    let tileable = get("--tileable").is_some();
    let make = MakeSettings { feature, tileable, max_size: 256, feature_weight: num("--fw", 1.0) as f32 };
    let exemplar = make_exemplar(&color, mask.as_ref(), None, &[], &make).expect("exemplar");
    let start = Instant::now();
    let lap = |what: &str, from: Instant| println!("{what:12} {:.3} s", from.elapsed().as_secs_f64());
    let pyramid = Pyramid::new(&exemplar, num("--levels", 0.0) as usize).expect("pyramid");
    let t = Instant::now();
    let descriptors = make_descriptors(&pyramid, &[num("--dims", 8.0) as i64, 16]);
    lap("descriptors", t);
    let t = Instant::now();
    let similarity = similarity_sets(&pyramid, &descriptors, num("--spread", 3.0) as i32, &()).expect("sets");
    lap("similarity", t);
    let t = Instant::now();
    let cs = CandidateSettings { exclusion: num("--exclusion", 3.0) as i32, ..Default::default() };
    let candidates = make_candidates(&pyramid, &cs, &()).expect("candidates");
    lap("candidates", t);
    let mut initial = make_slab(&pyramid, &candidates);
    if get("--random").is_some() {
        initial.slab.clear();
    }
    initial.jitter =
        Some(Jitter { amount: num("--jitter", 0.1), sigma_min: 0.3, sigma_max: 1.2, density: 3.0 });
    let size = num("--size", 64.0) as u32;
    let sched = |n: f64| match n as i64 {
        0 => Schedule::Jacobi,
        1 => Schedule::Parity,
        _ => Schedule::Octants,
    };
    let settings = Settings {
        seed: num("--seed", 1.0) as u64,
        period: if get("--unbounded").is_some() { None } else { Some([size; 3]) },
        coherence: num("--kappa", 0.4),
        crossbar: num("--lambda", 3.0),
        passes: vec![num("--passes", 2.0) as i64, num("--coarse-passes", 2.0) as i64],
        similar: vec![num("--k2", 2.0) as i64, 4],
        triples: vec![num("--k3", 2.0) as i64, 12],
        schedule: vec![sched(num("--fine", 0.0)), sched(num("--coarse", 0.0))],
        color: if get("--mean").is_some() { ColorRule::Mean } else { ColorRule::Nearest },
    };
    let tables =
        || Tables::new(&exemplar, &pyramid, &descriptors, &similarity, &candidates, None).expect("tables");
    let t = Instant::now();
    let us = UsageSettings {
        rounds: num("--rounds", 3.0) as usize,
        rate: num("--rate", 0.3),
        contrast: num("--contrast", 0.95),
        ..Default::default()
    };
    let usage = balance_usage(&pyramid, tables(), &initial, &settings, &us, &()).expect("usage");
    lap("usage", t);
    lap("precompute", start);
    let tables = Tables::new(&exemplar, &pyramid, &descriptors, &similarity, &candidates, Some(&usage))
        .expect("tables");
    let tables = Arc::new(tables);
    let all = VoxelSet::from_box([0; 3], [size; 3]);
    let isa = match get("--isa").as_deref() {
        Some("avx2") => Isa::Avx2,
        Some("portable") => Isa::Portable,
        _ => available_instruction_sets().pop().expect("one"),
    };
    let digest = breccia_engine::Digest([0; 32]);
    let mut map = None;
    for _ in 0..num("--repeat", 1.0) as usize {
        let solid =
            LazySolid::new(Arc::clone(&tables), initial.clone(), settings.clone(), digest).with_isa(isa);
        let t = Instant::now();
        map = Some(solid.evaluate(&all, &()).expect("voxels"));
        lap("synthesis", t);
    }
    let map = map.expect("one run");
    let at = |v: [i32; 3]| -> [u8; 3] {
        let i = map.index(v.map(|c| c.clamp(0, size as i32 - 1))).expect("inside");
        std::array::from_fn(|c| map.maps[0].samples.get_u8(i * 3 + c))
    };
    if get("--measure").is_some() {
        let volume = breccia_nodes::data::Volume {
            size: [size as usize; 3],
            origin: [0; 3],
            spacing: [1.0; 3],
            maps: vec![breccia_nodes::data::Map {
                name: "color".into(),
                channels: 3,
                samples: Samples::U8(
                    (0..size.pow(3))
                        .flat_map(|i| at([i % size, i / size % size, i / size / size].map(|c| c as i32)))
                        .collect(),
                ),
            }],
        };
        let m = breccia_nodes::measure::QualitySettings::default();
        let q = breccia_nodes::measure::measure_quality(&volume, &color, &m, &()).expect("measures");
        println!(
            "kl {:.3} cov {:.2} con {:.2} fine {:.2} dist {:.2}/{:.2} compl {:.2}",
            q.axis.color_kl,
            q.axis.coverage,
            q.axis.contrast,
            q.axis.fine_contrast,
            q.axis.distance,
            q.oblique.distance,
            q.axis.completeness
        );
    }
    let Some(out) = get("--out") else { return };
    let n = size as i32;
    let zoom = (256 / n).max(1);
    let side = n * zoom;
    let ezoom = (side / color.width().max(color.height()) as i32).max(1);
    let picture = Image::from_fn((side * 5 + 16) as u32, side as u32, |x, y| {
        let (panel, px, py) = (x as i32 / (side + 4), x as i32 % (side + 4), y as i32);
        if px >= side {
            return [255; 3];
        }
        let (u, v) = (px / zoom, py / zoom);
        match panel {
            0 => {
                let (u, v) = (px / ezoom, py / ezoom);
                if u < color.width() as i32 && v < color.height() as i32 {
                    color.rgb8(u as u32, v as u32)
                } else {
                    [255; 3]
                }
            }
            1 => at([u, v, n / 2]),
            2 => at([u, n / 2, v]),
            3 => at([n / 2, u, v]),
            _ => {
                // The plane through the centre with normal (1, 1, 1).
                let (a, b) =
                    (f64::from(px - side / 2) / f64::from(zoom), f64::from(py - side / 2) / f64::from(zoom));
                let c = f64::from(n) / 2.0;
                let (s2, s6) = (std::f64::consts::FRAC_1_SQRT_2, (1.0f64 / 6.0).sqrt());
                let p = [c + a * s2 + b * s6, c - a * s2 + b * s6, c - b * 2.0 * s6];
                if p.iter().all(|&q| q >= 0.0 && q < f64::from(n)) {
                    at(p.map(|q| q as i32))
                } else {
                    [128; 3]
                }
            }
        }
    });
    let Samples::U8(bytes) = picture.samples() else { return };
    image::save_buffer(out, bytes, picture.width(), picture.height(), image::ExtendedColorType::Rgb8)
        .expect("written");
}
