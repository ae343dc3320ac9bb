//! Every preset gives the same on the compute device as on CPU threads.

mod support;

use std::any::Any;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock};

use breccia_engine::{
    CancelToken, ComputeDevice, Device, DeviceChoice, DeviceProfile, Digest, Engine, Event,
};
use breccia_nodes::data::Volume;
use breccia_nodes::device::{AdapterKind, Gpu, GpuDevice, GpuSettings};
use breccia_shaders::{kernels, testing};

use support::small;

/// A device that claims to be fast, so that `auto` sends all nodes there whose results are the same.
struct Fast(GpuDevice);

impl ComputeDevice for Fast {
    fn name(&self) -> String {
        self.0.name()
    }
    fn profile(&self) -> DeviceProfile {
        DeviceProfile { speedup: 1e9, start: 0.0, bytes_per_second: 1e18 }
    }
    fn lost(&self) -> Option<String> {
        self.0.lost()
    }
    fn as_any(&self) -> &dyn Any {
        self.0.as_any()
    }
}

/// Where nodes go that can use the device.
enum Place {
    Processor,
    /// Those whose results are the same there.
    Device(Gpu),
    /// Those too that round otherwise there.
    DeviceInFloats(Gpu),
}

/// What a run gave, and which nodes used the device.
struct Outcome {
    outputs: BTreeMap<String, Digest>,
    volume: Option<Arc<Volume>>,
    on_device: Vec<String>,
    warnings: Vec<String>,
}

/// Runs a preset for some of its outputs, or for all.
fn run(name: &str, place: Place, outputs: &[&str]) -> Outcome {
    let registry = Arc::new(breccia_nodes::registry());
    let graph = small(name, &registry);
    let names: Vec<_> = graph.outputs().map(|output| output.name.to_owned()).collect();
    let all: Vec<_> = names.iter().map(String::as_str).collect();
    let names = if outputs.is_empty() { &all } else { outputs };
    let builder = Engine::builder().files(Arc::new(breccia_graphs::Sources::default())).threads(2);
    let on = |choice, gpu| {
        let device: Arc<dyn ComputeDevice> = Arc::new(Fast(GpuDevice(gpu)));
        (choice, Some(device))
    };
    let (choice, device) = match place {
        Place::Processor => (DeviceChoice::Cpu, None),
        Place::Device(gpu) => on(DeviceChoice::Auto, gpu),
        Place::DeviceInFloats(gpu) => on(DeviceChoice::Gpu, gpu),
    };
    let open = move || device.clone().ok_or_else(|| "none".to_owned());
    let builder = builder.device(choice).compute(Box::new(open));
    let engine = builder.build(registry).unwrap();
    let (on_device, warnings) = (Mutex::new(Vec::new()), Mutex::new(Vec::new()));
    let result = engine.run(&Arc::new(graph), names, &CancelToken::default(), &|event| match event {
        Event::NodeFinished { node, device: Device::Gpu, .. } => on_device.lock().unwrap().push(node.clone()),
        Event::Warning { message, .. } => warnings.lock().unwrap().push(message.clone()),
        _ => {}
    });
    let result = result.unwrap();
    assert_eq!(result.failures, []);
    Outcome {
        volume: result.outputs.get("volume").and_then(|value| value.downcast()),
        outputs: result.outputs.iter().map(|(name, value)| (name.clone(), value.digest())).collect(),
        on_device: on_device.into_inner().unwrap(),
        warnings: warnings.into_inner().unwrap(),
    }
}

/// One device for the tests of a process.
fn device() -> Option<Gpu> {
    static DEVICE: OnceLock<Option<Gpu>> = OnceLock::new();
    DEVICE.get_or_init(|| testing::gpu(GpuSettings::default())).clone()
}

/// Runs a preset on both; says which nodes used the device.
fn same(name: &str, gpu: Gpu) -> Outcome {
    let there = run(name, Place::Device(gpu), &[]);
    let here = run(name, Place::Processor, &[]);
    assert!(here.on_device.is_empty());
    assert_eq!(there.outputs, here.outputs, "{name}");
    there
}

macro_rules! same_on_the_device {
    ($($name:ident = $preset:literal),* $(,)?) => {
        $(#[test] fn $name() {
            let Some(gpu) = device() else { return };
            let there = same($preset, gpu);
            assert!(!there.on_device.is_empty(), "no node of {} uses the device", $preset);
            assert_eq!(there.warnings, [""; 0]);
        })*

        #[test]
        fn every_preset_is_compared() {
            let compared = [$($preset),*];
            let names: Vec<_> = breccia_graphs::presets().iter().map(|preset| preset.name).collect();
            // A volume that is read from a file leaves a device nothing to do.
            let names: Vec<_> = names.into_iter().filter(|name| *name != "compare_volume").collect();
            assert_eq!(names, compared);
        }
    };
}

same_on_the_device![
    on_the_device_lazy_volume = "lazy_volume",
    on_the_device_lazy_mesh = "lazy_mesh",
    on_the_device_lazy_slice = "lazy_slice",
    on_the_device_pbr_mesh = "pbr_mesh",
    on_the_device_wood_views = "wood_views",
    on_the_device_cut_mesh = "cut_mesh",
    on_the_device_optimize_volume = "optimize_volume",
    on_the_device_optimize_painted = "optimize_painted",
    on_the_device_optimize_ablations = "optimize_ablations",
    on_the_device_kopf_volume = "kopf_volume",
    on_the_device_particles_volume = "particles_volume",
    on_the_device_hybrid_mesh = "hybrid_mesh",
    on_the_device_hybrid_slice = "hybrid_slice",
    on_the_device_brick_wall = "brick_wall",
    on_the_device_recolour = "recolour",
    on_the_device_bent_bar = "bent_bar",
];

#[test]
fn on_the_device_a_wrong_kernel_is_noticed() {
    if device().is_none() {
        return;
    }
    let right_volume = run("lazy_volume", Place::Processor, &["volume"]).outputs;
    // Each with a mistake of the kind that slips in: ties to the last, a neighbour missed, a sum not rounded.
    for (kernel, right, wrong) in [
        (
            &kernels::CORRECT,
            "if c < least {\n                least = c;\n                best = p;",
            "if c <= least {\n                least = c;\n                best = p;",
        ),
        (&kernels::CORRECT, "let dv = i32(k / 5u) - 2;", "let dv = i32(k / 5u) - 1;"),
        (&kernels::START, "(sum + (1 << 17u)) >> vec3<u32>(18u)", "sum >> vec3<u32>(18u)"),
        (&kernels::UPSAMPLE, "(local[(e + 1u) % 3u] & 1)", "(local[(e + 2u) % 3u] & 1)"),
        (&kernels::DILATE, "dy < 8", "dy < 6"),
    ] {
        let text = kernel.source.replace(right, wrong);
        assert_ne!(text, kernel.source, "the mistake in {} has no place", kernel.name);
        let settings = GpuSettings { texts: [(kernel.name, text)].into(), ..Default::default() };
        let Some(gpu) = testing::gpu(settings) else { return };
        let there = run("lazy_volume", Place::Device(gpu), &["volume"]).outputs;
        assert_ne!(there, right_volume, "{}: {wrong}", kernel.name);
    }
}

#[test]
fn on_the_device_that_is_lost_half_way_the_run_goes_on() {
    let Some(gpu) = testing::gpu(GpuSettings::default()) else { return };
    run("lazy_volume", Place::Device(gpu.clone()), &[]);
    let half = gpu.traffic().dispatches / 2;
    let Some(gpu) = testing::gpu(GpuSettings::default()) else { return };
    gpu.lose_after(half as u32);
    let there = same("lazy_volume", gpu.clone());
    assert!(gpu.lost().is_some());
    assert!(there.warnings.iter().any(|warning| warning.contains("lost")), "{:?}", there.warnings);
}

#[test]
fn on_the_device_in_floats_an_optimised_volume_is_nearly_the_same() {
    let Some(gpu) = device() else { return };
    let there = run("optimize_volume", Place::DeviceInFloats(gpu.clone()), &["volume"]);
    assert!(there.on_device.iter().any(|node| node.contains("solve")), "{:?}", there.on_device);
    let here = run("optimize_volume", Place::Processor, &["volume"]);
    let (there, here) = (there.volume.unwrap(), here.volume.unwrap());
    let colors = |volume: &Volume| -> Vec<u8> { volume.maps[0].samples.bytes().to_vec() };
    let (a, b) = (colors(&there), colors(&here));
    let different = a.chunks(3).zip(b.chunks(3)).filter(|(a, b)| a != b).count();
    assert_eq!(a.len(), b.len());
    // A texel that is chosen otherwise leads the sweeps after it another way, so a card may end elsewhere; what draws on the
    // processor rounds nearly as it does.
    if gpu.report().kind == AdapterKind::Software {
        assert!(different * 20 <= a.len() / 3, "{different} of {} voxels", a.len() / 3);
    }
}

/// The names of all tests that do nothing without a device, from the sources.
fn tests_of_the_device(folder: &Path, found: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() && path.file_name() != Some("target".as_ref()) {
            tests_of_the_device(&path, found);
        } else if path.extension() == Some("rs".as_ref()) {
            let text = std::fs::read_to_string(&path).unwrap();
            let names = text.lines().filter_map(|line| {
                let line = line.trim_start();
                let name = line.strip_prefix("fn ").or(Some(line))?;
                let end = name.find(|c: char| !c.is_ascii_alphanumeric() && c != '_')?;
                name.starts_with("on_the_device_").then(|| name[..end].to_owned())
            });
            found.extend(names);
        }
    }
}

#[test]
fn tests_of_the_device_run_or_are_skipped_by_name() {
    let mut tests = Vec::new();
    for folder in ["shaders", "nodes", "cli", "tests"] {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        tests_of_the_device(&root.join(folder), &mut tests);
    }
    assert!(tests.len() > 50, "{tests:?}");
    match device() {
        Some(gpu) => eprintln!("{} tests run on {}", tests.len(), gpu.report().name),
        None => {
            tests.iter().for_each(|test| eprintln!("skipped: {test}"));
            eprintln!("{} tests are skipped for want of a compute device", tests.len());
        }
    }
}
