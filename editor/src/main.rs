//! The window.

use std::path::PathBuf;
use std::process::ExitCode;

use breccia_editor::app::{NativePicker, Settings};
use breccia_editor::window::{self, Window};
use clap::Parser;
use eframe::egui;

/// Opens the visual node editor of Breccia.
#[derive(Parser)]
#[command(name = "breccia-editor", version)]
struct Arguments {
    /// A graph document, a bundle, or the name of a preset
    graph: Option<String>,

    /// Number of threads that compute; 0 means one for each processor
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: u16,

    /// Mebibytes of memory that the program may take; results are kept in what the rest of it leaves
    #[arg(long, value_name = "MIB", default_value_t = 2048)]
    memory: u64,

    /// Folder of the disk cache [default: breccia in the user's cache folder]
    #[arg(long, value_name = "DIR")]
    cache_dir: Option<PathBuf>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let settings = Settings {
        threads: usize::from(arguments.threads),
        memory: arguments.memory << 20,
        cache: arguments.cache_dir.or_else(breccia_graphs::default_cache),
        ..Settings::default()
    };
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("Breccia")
            .with_app_id("breccia")
            .with_inner_size([1280.0, 720.0])
            .with_min_inner_size([800.0, 500.0])
            .with_drag_and_drop(true),
        renderer: eframe::Renderer::Wgpu,
        wgpu_options: window::wgpu_options(),
        ..Default::default()
    };
    // Pictures are made on threads of their own; they give way to the window as well. If there is a pool already it serves.
    let _ = rayon::ThreadPoolBuilder::new()
        .num_threads(settings.threads)
        .start_handler(|_| breccia_editor::app::yield_to_the_window())
        .build_global();
    let graph = arguments.graph;
    let result = eframe::run_native(
        "breccia",
        options,
        Box::new(move |creation| {
            let window = Window::new(creation, settings, Box::new(NativePicker), graph.as_deref())?;
            // A surface that converts colours would clear with another one.
            if creation.wgpu_render_state.as_ref().is_some_and(|render| !render.target_format.is_srgb()) {
                breccia_editor::theme::leave_panels(&creation.egui_ctx);
            }
            Ok(Box::new(window))
        }),
    );
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}
