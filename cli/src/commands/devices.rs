//! `breccia devices`.

use std::time::Duration;

use breccia_nodes::device::{AdapterKind, AdapterReport, Gpu, GpuSettings, SelfTest, adapters, self_test};
use breccia_nodes::lazy::available_instruction_sets;

use crate::exit::{Code, Failure};
use crate::folders;
use crate::sizes::human;

/// How long the test of a device takes.
const TEST: Duration = Duration::from_secs(10);

/// Say what computations run on, and test the compute device.
///
/// Lists the processor and every adapter that can compute; `run --device gpu` takes the first. Then tests that one for about ten
/// seconds: how fast data move, whether voxels synthesised there equal those of the processor, and how many a second there are.
#[derive(clap::Args)]
pub struct Devices {
    /// Only list, do not test
    #[arg(long)]
    no_test: bool,
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
        super::answer(&format!("test of {}, about {} s …\n", found[0].name, TEST.as_secs()))?;
        let pipeline_cache = folders::default_cache().map(|folder| folder.join("pipelines"));
        let gpu = Gpu::open(GpuSettings { pipeline_cache, ..Default::default() })
            .map_err(|error| Failure::new(Code::Node, error.to_string()))?;
        let test = self_test(&gpu, TEST).map_err(|error| Failure::new(Code::Node, error.to_string()))?;
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
    format!(
        "     moves {} there and {} back\n     parity: {} random subsets and cubes, {} voxels, {} of them differ\n     \
         {}³ voxels: {:.2} million a second there, {:.2} on CPU threads; {:.1} % of the time there went into reading back\n",
        rate(test.upload),
        rate(test.download),
        test.subsets,
        test.voxels,
        test.different,
        test.cube,
        test.device * 1e-6,
        test.cpu * 1e-6,
        100.0 * test.transfer_share,
    )
}
