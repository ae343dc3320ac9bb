//! `breccia devices`.

use std::time::Duration;

use breccia_nodes::device::{AdapterKind, AdapterReport, Gpu, GpuSettings, SelfTest, adapters, self_test};
use breccia_nodes::lazy::available_instruction_sets;

use crate::exit::{Code, Failure};
use crate::sizes::human;

/// Say what computations run on, and test the compute device.
///
/// Lists the processor and every adapter that can compute; `run --device gpu` takes the first. Then tests that one for about ten
/// seconds: how fast data move, whether voxels synthesised there equal those of the processor, and how many a second there are.
#[derive(clap::Args)]
pub struct Devices {
    /// Only list, do not test
    #[arg(long)]
    no_test: bool,

    /// Seconds that the test may take; the more, the larger its cubes, up to 512³
    #[arg(long, value_name = "SECONDS", default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..=3600))]
    time: u16,
}

impl Devices {
    /// Prints what there is, then tests the first adapter.
    pub fn run(&self) -> Result<(), Failure> {
        let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let sets: Vec<_> = available_instruction_sets().iter().map(|isa| format!("{isa:?}")).collect();
        super::answer(&format!(
            "cpu  {threads} threads; code paths of lazy synthesis that run here: {}\n",
            sets.join(", ")
        ))?;
        let found = adapters();
        if found.is_empty() {
            return super::answer(
                "gpu  no adapter for Vulkan, Metal or DX12 was found; install the graphics driver of your card, or on Linux the\n     \
                 software adapter of Mesa (Debian: mesa-vulkan-drivers). Everything runs on the processor too.\n",
            );
        }
        found.iter().try_for_each(|adapter| super::answer(&describe(adapter)))?;
        if self.no_test {
            return Ok(());
        }
        super::answer(&format!("test of {}, about {} s …\n", found[0].name, self.time))?;
        let pipeline_cache = breccia_graphs::default_cache().map(|folder| folder.join("pipelines"));
        let gpu = Gpu::open(GpuSettings { pipeline_cache, ..Default::default() })
            .map_err(|error| Failure::new(Code::Node, error.to_string()))?;
        let test = self_test(&gpu, Duration::from_secs(self.time.into()))
            .map_err(|error| Failure::new(Code::Node, error.to_string()))?;
        super::answer(&outcome(&test))?;
        if test.different > 0 {
            return Err(Failure::new(
                Code::Node,
                format!(
                    "{} of {} voxels differ from the processor's; do not use this device, and report its name and driver",
                    test.different, test.voxels
                ),
            ));
        }
        Ok(())
    }
}

fn describe(adapter: &AdapterReport) -> String {
    let kind = match adapter.kind {
        AdapterKind::Software => "software on the processor: right answers, no speed; `auto` leaves it aside",
        AdapterKind::Other => "of unknown kind",
        AdapterKind::Integrated => "integrated",
        AdapterKind::Discrete => "a card of its own",
    };
    let list = |wanted: bool| {
        let names: Vec<_> = adapter.features.iter().filter(|f| f.1 == wanted).map(|f| f.0).collect();
        if names.is_empty() { "none".to_owned() } else { names.join(", ") }
    };
    format!(
        "gpu  {} ({}), {kind}\n     driver {}\n     buffers to {}, {} a kernel, each to {}; workgroups of {} threads sharing {}; \
         subgroups of {} to {}\n     has {}; lacks {}\n",
        adapter.name,
        adapter.backend,
        adapter.driver,
        human(adapter.largest_buffer),
        adapter.bindings,
        human(adapter.largest_binding),
        adapter.workgroup_threads,
        human(adapter.workgroup_memory.into()),
        adapter.subgroup[0],
        adapter.subgroup[1],
        list(true),
        list(false),
    )
}

fn outcome(test: &SelfTest) -> String {
    let rate = |bytes: f64| format!("{:.1} GB/s", bytes * 1e-9);
    let mut out = format!(
        "     moves {} there and {} back\n     parity: {} random subsets and {} tasks, {} voxels, {} of them differ\n",
        rate(test.upload),
        rate(test.download),
        test.subsets,
        test.tasks.len(),
        test.voxels,
        test.different,
    );
    out.push_str(
        "     task            device       cpu  reading back  dispatches      sent  received  device memory\n",
    );
    for task in &test.tasks {
        let traffic = &task.traffic;
        out.push_str(&format!(
            "     {:12} {:>8.4} s {:>7.4} s  {:>10.1} %  {:>10} {:>9} {:>9}  {:>13}\n",
            task.name,
            task.device,
            task.cpu,
            traffic.download_us as f64 * 1e-4 / task.device,
            traffic.dispatches,
            human(traffic.uploaded),
            human(traffic.downloaded),
            human(traffic.peak_memory),
        ));
    }
    out
}
