//! Compute devices from the command line.

use crate::support::{Answer, FAST, Place};

const SMALL: [&str; 6] = ["--set", "volume.size=12", "--output", "volume=v.npy", "--seed", "3"];

/// The first adapter's line; without one says that the test is skipped, and fails where that is not allowed.
fn adapter(place: &Place) -> Option<String> {
    let listed = place.breccia(&["devices", "--no-test"]).stdout;
    let line = listed.lines().find(|line| line.starts_with("gpu")).unwrap_or_default().to_owned();
    if line.contains("no adapter") {
        assert!(std::env::var_os("BRECCIA_REQUIRE_DEVICE").is_none(), "{listed}");
        eprintln!("skipped: {}: {line}", std::thread::current().name().unwrap_or_default());
        return None;
    }
    Some(line)
}

#[test]
fn devices_name_the_processor_and_what_adapters_have() {
    let place = Place::new();
    let listed = place.breccia(&["devices", "--no-test"]).stdout;
    assert!(listed.starts_with("cpu"), "{listed}");
    if let Some(line) = adapter(&place) {
        assert!(line.contains("vulkan") || line.contains("metal") || line.contains("dx12"), "{line}");
        assert!(listed.contains("driver") && listed.contains("workgroups of"), "{listed}");
    }
}

#[test]
fn on_the_device_the_test_finds_no_difference() {
    let place = Place::new();
    if adapter(&place).is_none() {
        return;
    }
    let tested = place.breccia(&["devices", "--time", "2"]);
    tested.expect(0, &[]);
    assert!(
        tested.stdout.contains(" 0 of them differ") && tested.stdout.contains("16³"),
        "{}",
        tested.stdout
    );
}

#[test]
fn on_the_device_a_run_writes_the_same_file() {
    let place = Place::new();
    if adapter(&place).is_none() {
        return;
    }
    let mut files = Vec::new();
    for device in ["cpu", "gpu"] {
        let answer = place.run("lazy_volume", &[&SMALL[..], &["--device", device, "--no-cache"]].concat());
        answer.expect(0, &[]);
        assert_eq!(answer.stderr.contains("on the device"), device == "gpu", "{}", answer.stderr);
        files.push(place.read("v.npy"));
    }
    assert!(files[0] == files[1]);
}

#[test]
fn on_the_device_and_on_the_processor_results_share_a_cache() {
    let place = Place::new();
    if adapter(&place).is_none() {
        return;
    }
    place.run("lazy_volume", &[&SMALL[..], &["--device", "gpu"]].concat()).expect(0, &["on the device"]);
    place.run("lazy_volume", &[&SMALL[..], &["--device", "cpu"]].concat()).expect(0, &["computed 0 nodes"]);
}

#[test]
fn without_an_adapter_gpu_is_refused_with_advice_and_auto_says_what_it_does() {
    let place = Place::new();
    let run = |device: &str| {
        let args =
            [&["run", "lazy_volume", "--device", device, "--no-cache"], &FAST[..], &SMALL[..]].concat();
        Answer::from(place.without_adapters(&args).output().unwrap())
    };
    run("gpu").expect(2, &["no compute device", "mesa-vulkan-drivers", "`breccia devices`"]);
    assert_eq!(place.files(), [""; 0]);
    let auto = run("auto");
    auto.expect(0, &["no compute device, running on CPU threads"]);
    assert_eq!(auto.stderr.matches("running on CPU threads").count(), 1, "{}", auto.stderr);
    let listed = Answer::from(place.without_adapters(&["devices"]).output().unwrap());
    assert!(listed.stdout.contains("no adapter"), "{}", listed.stdout);
}

#[test]
fn a_plan_says_where_nodes_would_run() {
    let place = Place::new();
    let args = [&["run", "lazy_volume", "--explain"], &FAST[..]].concat();
    let plan = Answer::from(place.without_adapters(&args).output().unwrap());
    assert!(plan.stdout.contains("on CPU threads: no adapter"), "{}", plan.stdout);
}
