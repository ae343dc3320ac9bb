//! Prints a table of all kernels: `cargo run -p breccia-shaders --example kernels`.
#![allow(clippy::print_stdout, reason = "that is its purpose")]

use breccia_shaders::{Access, compose, kernels};

fn main() -> Result<(), String> {
    println!("| kernel | mirrors | workgroup | shared bytes | variables of a thread, bytes | buffers |");
    println!("|---|---|---|---|---|---|");
    for kernel in kernels::ALL {
        let composed = compose(kernel, kernel.source)?;
        let buffers = kernel.bindings.iter().filter(|binding| binding.access != Access::Uniform).count();
        println!(
            "| `{}` | `{}` | {} | {} | {} | {buffers} |",
            kernel.name,
            kernel.mirrors,
            kernel.workgroup,
            composed.shared_bytes(),
            composed.thread_bytes(),
        );
    }
    Ok(())
}
