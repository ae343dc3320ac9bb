//! How fast the syntheses are, stage by stage, on exemplars and meshes made here.
//!
//! `cargo bench --profile dev -p breccia-nodes` measures (the dev profile is an optimised one), with a filter such as
//! `-- slice_on_demand` a part of it. `cargo test -p breccia-nodes --bench speed` runs each benchmark once
//! at a small size, which takes seconds.

mod bake;
mod lazy_synthesis;
mod material;
mod optimize;
mod particles;
mod precompute;
mod slice_on_demand;

fn main() {
    divan::main();
}

/// The sizes to measure with, or those for a quick pass that shows that the benchmarks work.
///
/// Divan measures if cargo passes `--bench`, as `cargo bench` does, and nobody passes `--test`.
fn sizes(measured: &[u32], quick: u32) -> Vec<u32> {
    let passed = |flag: &str| std::env::args().any(|argument| argument == flag);
    if passed("--bench") && !passed("--test") { measured.to_vec() } else { vec![quick] }
}
