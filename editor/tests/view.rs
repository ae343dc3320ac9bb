//! The viewport as a user sees it: driven by names, looked at by its pixels.
//!
//! With `BRECCIA_VIEW_PICTURES` set, every view is also written as a PNG into the system's folder for temporary files, and shows a
//! solid that is synthesised from the cobbles instead of a checkerboard.

use std::io;
use std::path::Path;
use std::sync::Arc;

use breccia_editor::run::Fit;
use breccia_editor::view::{Scene, Show, Subject, ViewAction, Viewport};
use breccia_engine::{CancelToken, Document, Engine, FileSource, Graph, Value};
use breccia_nodes::data::{
    Curves, Filter, Image, Map, Mesh, Plot, Report, Samples, Series, SolidValue, Volume, VoxelSet,
};
use breccia_nodes::solid::{CheckerSolid, ConstantSolid};
use breccia_shaders::{GpuSettings, testing};
use eframe::egui::{self, accesskit::Role};
use eframe::egui_wgpu::RendererOptions;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable};
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};

struct State {
    viewport: Viewport,
    main: Option<Subject>,
    mesh: Option<Subject>,
    exemplar: Option<Subject>,
    inside: Option<Subject>,
    coming: Option<&'static str>,
    actions: Vec<ViewAction>,
}

type Window = Harness<'static, State>;

fn subject(label: &str, value: Value) -> Option<Subject> {
    Some(Subject { label: label.to_owned(), value, stale: false, fit: None })
}

/// A window with a viewport alone; `None` where there is no adapter.
fn window(main: Value, mesh: Option<Value>, exemplar: Option<Value>) -> Option<Window> {
    let gpu = testing::gpu(GpuSettings::default())?;
    let render = create_render_state(default_wgpu_setup(), RendererOptions::PREDICTABLE);
    let mut viewport = Viewport::new(render.clone(), Some(Arc::new(gpu)));
    if !pictures() {
        viewport.set_detail(128, 32);
    }
    let state = State {
        viewport,
        main: subject("node.main", main),
        mesh: mesh.and_then(|mesh| subject("node.mesh", mesh)),
        exemplar: exemplar.and_then(|image| subject("node.exemplar", image)),
        inside: None,
        coming: None,
        actions: Vec::new(),
    };
    let draw = |ui: &mut egui::Ui, state: &mut State| {
        let (main, mesh) = (state.main.as_ref(), state.mesh.as_ref());
        let (exemplar, inside) = (state.exemplar.as_ref(), state.inside.as_ref());
        state.actions.extend(state.viewport.go_on(ui.ctx()));
        state
            .actions
            .extend(state.viewport.ui(ui, &Scene { main, mesh, exemplar, inside, coming: state.coming }));
    };
    let builder = Harness::builder().with_size(egui::vec2(900.0, 620.0)).with_step_dt(1.0 / 60.0);
    Some(builder.renderer(WgpuTestRenderer::from_render_state(render)).build_ui_state(draw, state))
}

/// Lets frames pass until no work goes on.
fn settle(window: &mut Window) {
    window.run_steps(3);
    while window.state().viewport.is_working() {
        std::thread::sleep(std::time::Duration::from_millis(4));
        window.step();
    }
    window.run_steps(2);
}

fn pictures() -> bool {
    std::env::var_os("BRECCIA_VIEW_PICTURES").is_some()
}

/// The picture of the window, kept for people to look at if they ask for it.
fn look(window: &mut Window, name: &str) -> image::RgbaImage {
    let picture = window.render().unwrap();
    if pictures() {
        picture.save(std::env::temp_dir().join(format!("breccia_view_{name}.png"))).unwrap();
    }
    picture
}

/// How many clearly different colours there are in the middle of a picture.
fn colors(picture: &image::RgbaImage) -> usize {
    let (w, h) = picture.dimensions();
    let inside = |x: u32, y: u32| (w / 4..3 * w / 4).contains(&x) && (h / 4..3 * h / 4).contains(&y);
    let middle = picture.enumerate_pixels().filter(|(x, y, _)| inside(*x, *y));
    middle.map(|(_, _, pixel)| pixel.0.map(|c| c / 32)).collect::<std::collections::HashSet<_>>().len()
}

struct Builtin;

impl FileSource for Builtin {
    fn read(&self, path: &str) -> io::Result<Arc<Vec<u8>>> {
        let bytes = path.strip_prefix("builtin:").and_then(breccia_graphs::asset);
        bytes.map(|asset| Arc::new(asset.to_vec())).ok_or_else(|| io::ErrorKind::NotFound.into())
    }
}

/// The solid that is looked at.
fn solid() -> Value {
    if !pictures() {
        let colors = [[210, 170, 110], [70, 60, 90]];
        return Value::new(SolidValue(Arc::new(CheckerSolid { colors, cell: 5, noise: 30, seed: 4 })));
    }
    let registry = Arc::new(breccia_nodes::registry());
    let preset = breccia_graphs::preset("lazy_slice").unwrap().ron.replace(
        "\"slice\": (node: \"slice\", socket: \"image\"",
        "\"slice\": (node: \"synthesis\", socket: \"solid\"",
    );
    let mut document = Document::parse(&preset.replace("_128.png", "_64.png")).unwrap();
    document.include(Path::new(""), &Builtin).unwrap();
    let graph = Graph::new(&document, &registry).unwrap();
    let cache = std::env::temp_dir().join("breccia_view_cache");
    let builder = Engine::builder().files(Arc::new(Builtin)).cache_dir(Some(cache));
    let engine = builder.build(registry).unwrap();
    let result = engine.run(&Arc::new(graph), &["slice"], &CancelToken::default(), &|_| {}).unwrap();
    result.outputs["slice"].clone()
}

fn spot() -> Value {
    let bytes = breccia_graphs::asset("spot/spot.glb").unwrap();
    let mesh = breccia_nodes::mesh::decode_mesh(bytes, "glb").unwrap();
    Value::new(mesh)
}

fn image(color: [u8; 3]) -> Value {
    Value::new(Image::from_fn(64, 64, |_, _| color))
}

#[test]
fn every_way_to_show_a_solid_shows_something() {
    let Some(mut window) = window(solid(), Some(spot()), None) else { return };
    for (button, name) in [
        ("Slice", "slice"),
        ("On mesh", "mesh"),
        ("Cube", "cube"),
        ("Planes", "planes"),
        ("Translucent", "translucent"),
    ] {
        window.get_by_label(button).click();
        settle(&mut window);
        let picture = look(&mut window, name);
        assert!(colors(&picture) > 3, "{name}: {} colours", colors(&picture));
    }
    // A narrow place in a light window.
    window.set_size(egui::vec2(460.0, 520.0));
    window.ctx.set_theme(egui::Theme::Light);
    for (button, name) in [("Slice", "narrow_slice"), ("On mesh", "narrow_mesh")] {
        window.get_by_label(button).click();
        settle(&mut window);
        let picture = look(&mut window, name);
        assert!(colors(&picture) > 3, "{name}: {} colours", colors(&picture));
    }
}

#[test]
fn a_cut_shows_the_inside() {
    let Some(mut window) = window(solid(), Some(spot()), None) else { return };
    window.state_mut().viewport.show_as(Show::Mesh);
    settle(&mut window);
    let whole = window.render().unwrap();
    window.get_by_label("Cut").click();
    window.run_steps(2);
    look(&mut window, "cut_at_once");
    settle(&mut window);
    let cut = look(&mut window, "cut");
    assert!(differing(&whole, &cut) > 5_000, "{}", differing(&whole, &cut));
    window.get_by_label("Other side").click();
    settle(&mut window);
    let other = look(&mut window, "cut_other");
    assert!(differing(&cut, &other) > 5_000);
}

#[test]
fn a_cut_through_a_baked_mesh_shows_the_solid_in_it_and_one_through_any_other_says_that_it_has_none() {
    const NOTE: &str = "The inside shows no texture: no solid was baked into this mesh";
    let Some(mut window) = window(spot(), None, None) else { return };
    window.get_by_label("Cut").click();
    settle(&mut window);
    window.get_by_label(NOTE);
    let plain = window.render().unwrap();
    // The mesh stays as it is, and has green inside.
    let green = Value::new(SolidValue(Arc::new(ConstantSolid { color: [20, 220, 20] })));
    let state = window.state_mut();
    state.inside = subject("node.solid", green);
    let fit = Fit { resolution: 40, origin: [5, -6, 7], filter: Filter::Nearest };
    state.main.as_mut().unwrap().fit = Some(fit);
    settle(&mut window);
    assert!(window.query_by_label(NOTE).is_none());
    let filled = look(&mut window, "baked_cut");
    let count = |picture: &image::RgbaImage| {
        let is_green = |p: &&image::Rgba<u8>| p.0[1] > p.0[0].max(p.0[2]).saturating_add(60);
        picture.pixels().filter(is_green).count()
    };
    assert!(count(&plain) < 100 && count(&filled) > 3_000, "{} {}", count(&plain), count(&filled));
}

#[test]
fn a_solid_is_shown_as_it_is_baked_until_another_resolution_is_chosen() {
    let Some(mut window) = window(solid(), Some(spot()), None) else { return };
    window.get_by_label("On mesh").click();
    settle(&mut window);
    let usual = window.render().unwrap();
    let fit = Fit { resolution: 2000, origin: [0; 3], filter: Filter::Trilinear };
    window.state_mut().main.as_mut().unwrap().fit = Some(fit);
    settle(&mut window);
    assert!(differing(&usual, &look(&mut window, "as_baked")) > 5_000);
    assert!(window.query_by_label("As baked").is_none(), "nothing was chosen, though the slider ends before");
    let voxels = |window: &Window| {
        window.get_by_role_and_label(Role::Slider, "Voxels").accesskit_node().numeric_value()
    };
    assert_eq!(voxels(&window), Some(2000.0));
    window.get_by_role_and_label(Role::Slider, "Voxels").focus();
    window.run_steps(2);
    window.key_press(egui::Key::ArrowLeft);
    settle(&mut window);
    assert!(voxels(&window).is_some_and(|voxels| voxels <= 1024.0), "{:?}", voxels(&window));
    window.get_by_label("As baked").click();
    settle(&mut window);
    assert_eq!(voxels(&window), Some(2000.0));
}

/// Drags from the middle of what has a name.
fn drag(window: &mut Window, name: &str, by: egui::Vec2) {
    let from = window.get_by_label(name).rect().center();
    window.hover_at(from);
    window.run_steps(2);
    window.drag_at(from);
    window.run_steps(1);
    for step in 1..=4 {
        window.hover_at(from + by * (step as f32 / 4.0));
        window.run_steps(1);
    }
    window.drop_at(from + by);
    window.run_steps(1);
}

fn differing(a: &image::RgbaImage, b: &image::RgbaImage) -> usize {
    a.pixels().zip(b.pixels()).filter(|(a, b)| a != b).count()
}

#[test]
fn dragging_turns_the_object_and_reset_turns_it_back() {
    let Some(mut window) = window(spot(), None, None) else { return };
    settle(&mut window);
    let before = window.render().unwrap();
    let object = "Object: drag to turn, Shift and drag to move, wheel to zoom, arrow keys turn";
    drag(&mut window, object, egui::vec2(120.0, 30.0));
    let turned = look(&mut window, "turned");
    assert!(differing(&before, &turned) > 10_000);
    window.key_press(egui::Key::ArrowLeft);
    window.run_steps(2);
    assert!(differing(&turned, &window.render().unwrap()) > 5_000);
    window.get_by_label("Reset view").click();
    window.run_steps(2);
    // The pointer and the button that has it look otherwise than at first.
    let reset = window.render().unwrap();
    assert!(differing(&before, &reset) < 3_000, "{}", differing(&before, &reset));
}

#[test]
fn handles_move_the_cut_and_the_corner() {
    let Some(mut window) = window(solid(), Some(spot()), None) else { return };
    window.get_by_label("Cut").click();
    settle(&mut window);
    let before = window.render().unwrap();
    drag(&mut window, "Move the cut", egui::vec2(40.0, 0.0));
    look(&mut window, "cut_dragged");
    settle(&mut window);
    let after = look(&mut window, "cut_moved");
    assert!(differing(&before, &after) > 5_000, "{}", differing(&before, &after));
    window.get_by_label("Cube").click();
    settle(&mut window);
    let before = window.render().unwrap();
    drag(&mut window, "Move the cut along y", egui::vec2(0.0, 60.0));
    settle(&mut window);
    let after = look(&mut window, "cube_dragged");
    assert!(differing(&before, &after) > 5_000, "{}", differing(&before, &after));
}

#[test]
fn a_new_solid_replaces_the_old_one_on_the_mesh() {
    let plain = |color| Value::new(SolidValue(Arc::new(ConstantSolid { color })));
    let Some(mut window) = window(plain([200, 40, 40]), Some(spot()), None) else { return };
    settle(&mut window);
    let red =
        |picture: &image::RgbaImage| picture.pixels().filter(|p| p.0[0] > p.0[2].saturating_add(40)).count();
    let blue =
        |picture: &image::RgbaImage| picture.pixels().filter(|p| p.0[2] > p.0[0].saturating_add(40)).count();
    let before = window.render().unwrap();
    assert!(red(&before) > 10_000, "{}", red(&before));
    window.state_mut().main = subject("node.main", plain([40, 40, 200]));
    // Until there is something of the new one, the old one stays.
    window.step();
    assert!(red(&window.render().unwrap()) + blue(&window.render().unwrap()) > 10_000);
    settle(&mut window);
    let after = window.render().unwrap();
    assert!(blue(&after) > 10_000 && red(&after) < 1_000, "{} {}", blue(&after), red(&after));
}

#[test]
fn wiping_shows_the_left_of_one_and_the_right_of_the_other() {
    let (red, blue) = (image([220, 20, 20]), image([20, 20, 220]));
    let Some(mut window) = window(red, None, Some(blue)) else { return };
    settle(&mut window);
    window.get_by_label("Wipe").click();
    settle(&mut window);
    let picture = look(&mut window, "wipe");
    let middle = window.get_by_label("Picture").rect().center();
    let at = |dx: f32| picture.get_pixel((middle.x + dx) as u32, middle.y as u32 + 60).0;
    assert_eq!(at(-40.0)[..3], [220, 20, 20]);
    assert_eq!(at(40.0)[..3], [20, 20, 220]);
    window.get_by_label("Side by side").click();
    settle(&mut window);
    let picture = look(&mut window, "beside");
    let rect = window.get_by_label("Picture").rect();
    let at = |t: f32| picture.get_pixel((rect.left() + t * rect.width()) as u32, rect.center().y as u32).0;
    assert_eq!((at(0.25)[0], at(0.75)[2]), (220, 220));
}

#[test]
fn the_pixel_under_the_pointer_is_told() {
    let Some(mut window) = window(image([1, 171, 205]), None, None) else { return };
    settle(&mut window);
    let middle = window.get_by_label("Picture").rect().center();
    window.hover_at(middle + egui::vec2(2.0, 2.0));
    window.run_steps(2);
    window.get_by_label("32, 32   R 1  G 171  B 205   #01ABCD");
}

#[test]
fn a_mesh_of_its_own_and_a_volume_of_labels_are_shown() {
    let Some(mut window) = window(spot(), None, None) else { return };
    settle(&mut window);
    assert!(colors(&look(&mut window, "own_mesh")) > 3);
    let n = 24usize;
    let ball = |at: usize| {
        let d = [at % n, at / n % n, at / n / n].map(|c| (c % 12) as f64 - 5.5);
        d.iter().map(|c| c * c).sum::<f64>() < 22.0
    };
    let color = (0..n * n * n).flat_map(|at| if ball(at) { [220, 120, 60] } else { [90, 90, 100] }).collect();
    let label = (0..n * n * n).map(|at| u32::from(ball(at)) * (1 + at as u32 / 6000)).collect();
    let map = |name: &str, channels, samples| Map { name: name.to_owned(), channels, samples };
    let maps = vec![map("color", 3, Samples::U8(color)), map("label", 1, Samples::U32(label))];
    let volume = Volume { size: [n; 3], origin: [0; 3], spacing: [1.0; 3], maps };
    window.state_mut().main = subject("node.volume", Value::new(volume));
    window.run_steps(2);
    window.get_by_label("Particles").click();
    settle(&mut window);
    assert!(colors(&look(&mut window, "particles")) > 3);
    let set: VoxelSet =
        (0..4000).map(|i| [i % 20, i / 400, (i / 20) % 20]).filter(|v| v[0] != v[1]).collect();
    window.state_mut().main = subject("node.voxels", Value::new(set));
    settle(&mut window);
    assert!(colors(&look(&mut window, "voxel_set")) > 3);
}

#[test]
fn thin_volumes_and_odd_pictures_do_no_harm() {
    let color = |count: usize| Map {
        name: "color".to_owned(),
        channels: 3,
        samples: Samples::U8((0..3 * count).map(|i| (i * 37) as u8).collect()),
    };
    let volume = |size: [usize; 3]| {
        let maps = vec![color(size.iter().product())];
        Value::new(Volume { size, origin: [-2, 7, i32::MAX - 40], spacing: [1.0; 3], maps })
    };
    let Some(mut window) = window(volume([5, 4, 1]), None, None) else { return };
    for size in [[5, 4, 1], [1, 1, 1], [1, 30, 2]] {
        window.state_mut().main = subject("node.volume", volume(size));
        for show in [Show::Slice, Show::Cube, Show::Planes, Show::Translucent, Show::Particles, Show::Mesh] {
            window.state_mut().viewport.show_as(show);
            settle(&mut window);
        }
    }
    for samples in [Samples::F32(vec![f32::NAN, f32::INFINITY, -1.0]), Samples::U32(vec![u32::MAX, 0, 7])] {
        let image = Image::new(3, 1, 1, samples).unwrap();
        window.state_mut().main = subject("node.image", Value::new(image));
        settle(&mut window);
    }
    let words = Value::new(Volume { size: [0; 3], origin: [0; 3], spacing: [1.0; 3], maps: Vec::new() });
    window.state_mut().main = subject("node.empty", words);
    window.state_mut().mesh = subject("node.mesh", Value::new(Mesh::default()));
    settle(&mut window);
    window.state_mut().main = subject("node.solid", solid());
    window.state_mut().viewport.show_as(Show::Mesh);
    settle(&mut window);
    window.get_by_label_contains("no triangles");
}

#[test]
fn numbers_curves_and_words_are_shown() {
    let mut report = Report::new("Quality");
    report.row("Largest particle", 41.5, "voxels");
    let Some(mut window) = window(Value::new(report), None, None) else { return };
    window.run_steps(2);
    window.get_by_label("Largest particle");
    look(&mut window, "report");
    let points = (0..40).map(|i| [f64::from(i), (f64::from(i) / 6.0).sin()]).collect();
    let series = vec![Series { name: "measured".to_owned(), points }];
    let mut curves = Curves::new("Correlation");
    curves.plots.push(Plot::new("Two points", "distance / voxels", "probability", series));
    window.state_mut().main = subject("node.curves", Value::new(curves));
    window.run_steps(2);
    window.get_by_label("Two points: probability over distance / voxels");
    look(&mut window, "curves");
    window.state_mut().main = None;
    window.run_steps(2);
    window.get_by_label("Nothing to look at yet: pick a node, or run the graph.");
    window.state_mut().coming = Some("Computing node.curves");
    window.run_steps(2);
    window.get_by_label("Computing node.curves");
}

#[test]
fn errors_of_workers_are_told() {
    let damaged = Mesh { positions: vec![[0.0; 3]; 3], triangles: vec![[0, 1, 9]], ..Mesh::default() };
    let Some(mut window) = window(solid(), Some(Value::new(damaged)), None) else { return };
    settle(&mut window);
    look(&mut window, "error");
    window.get_by_label_contains("names vertex 9 of 3");
}

#[test]
fn a_screenshot_is_a_picture_of_the_object() {
    let Some(mut window) = window(spot(), None, None) else { return };
    settle(&mut window);
    window.get_by_label("Light").click();
    window.run_steps(2);
    window.get_by_label("Gradient").click();
    window.run_steps(2);
    look(&mut window, "light_menu");
    window.key_press(egui::Key::Escape);
    window.run_steps(2);
    window.get_by_label("Export").click();
    window.run_steps(2);
    look(&mut window, "export_menu");
    window.get_by_label("Screenshot (PNG)").click();
    settle(&mut window);
    let saved = window.state().actions.iter().find_map(|action| match action {
        ViewAction::Save { files, .. } => files.first(),
        ViewAction::Say(_) => None,
    });
    let picture = image::load_from_memory(&saved.unwrap().1).unwrap().to_rgba8();
    assert!(colors(&picture) > 3);
}

#[test]
fn a_screenshot_puts_no_end_to_a_turntable() {
    let Some(mut window) = window(spot(), None, None) else { return };
    settle(&mut window);
    for name in ["Turntable (GIF)", "Screenshot (PNG)"] {
        window.get_by_label("Export").click();
        window.run_steps(2);
        window.get_by_label(name).click();
        window.run_steps(2);
    }
    settle(&mut window);
    let mut saved: Vec<_> = window
        .state()
        .actions
        .iter()
        .filter_map(|action| match action {
            ViewAction::Save { files, .. } => files.first().map(|(name, _)| name.as_str()),
            ViewAction::Say(_) => None,
        })
        .collect();
    saved.sort_unstable();
    assert_eq!(saved, ["screenshot.png", "turntable.gif"]);
}
