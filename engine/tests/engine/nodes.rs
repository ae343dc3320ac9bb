//! Tiny node types.

use std::any::Any;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::time::{Duration, Instant};

use breccia_engine::flow::Flag;
use breccia_engine::{
    ComputeDevice, Context, Data, DeviceProfile, Digest, Node, NodeError, NodeSpec, ParamKind, ParamValue,
    Registry, Sizing, TypeInfo, Work,
};

/// A number, stored on disk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Number(pub i64);

impl Data for Number {
    const TYPE: &'static str = "number";
    const DOCS: &'static str = "A whole number.";
    fn byte_size(&self) -> u64 {
        100
    }
    fn summary(&self) -> String {
        format!("number {}", self.0)
    }
    fn digest(&self) -> Digest {
        Digest::of(&self.0.to_le_bytes())
    }
    fn encode(&self) -> Option<Vec<u8>> {
        Some(self.0.to_le_bytes().to_vec())
    }
    fn decode(bytes: &[u8]) -> Result<Self, String> {
        bytes.try_into().map(|b| Self(i64::from_le_bytes(b))).map_err(|_| "not eight bytes".to_owned())
    }
}

/// A number that never goes to disk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Opaque(pub i64);

impl Data for Opaque {
    const TYPE: &'static str = "opaque";
    const DOCS: &'static str = "A number that stays in memory.";
    fn byte_size(&self) -> u64 {
        100
    }
    fn summary(&self) -> String {
        format!("opaque {}", self.0)
    }
    fn digest(&self) -> Digest {
        Digest::of(&self.0.to_le_bytes())
    }
}

/// A compute device that computes nothing, and may be lost while a node uses it.
pub struct Pretended {
    pub speedup: f64,
    pub loses: bool,
    pub lost: AtomicBool,
}

impl Pretended {
    fn lose(&self) -> bool {
        self.loses && !self.lost.swap(true, Ordering::Relaxed)
    }
}

impl ComputeDevice for Pretended {
    fn name(&self) -> String {
        "pretended".to_owned()
    }
    fn profile(&self) -> DeviceProfile {
        DeviceProfile { speedup: self.speedup, start: 0.01, bytes_per_second: 1e9 }
    }
    fn lost(&self) -> Option<String> {
        self.lost.load(Ordering::Relaxed).then(|| "unplugged".to_owned())
    }
    fn as_any(&self) -> &dyn Any {
        self
    }
}

type Run = fn(&mut Context<'_>) -> Result<(), NodeError>;

struct Tiny(fn() -> NodeSpec, Run);

impl Node for Tiny {
    fn spec(&self) -> NodeSpec {
        (self.0)()
    }
    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        (self.1)(context)
    }
    /// A hundredth of a second for each of `value`, and a kilobyte; below zero not known.
    fn work(&self, sizing: &Sizing<'_>) -> Option<Work> {
        let value = sizing.int("value").filter(|&value| value >= 0)?;
        Some(Work { seconds: value as f64 * 0.01, bytes: 1000 })
    }
}

fn spec(id: &'static str) -> NodeSpec {
    NodeSpec::new(id, 1, "A test node", "A node for tests.")
}

fn value(spec: NodeSpec) -> NodeSpec {
    spec.int("value", -1000..=1000, 0, "count", "A number.")
}

fn input(context: &Context<'_>, name: &str) -> Result<i64, NodeError> {
    context.input::<Number>(name).map(|n| n.0)
}

static CALLS: AtomicI64 = AtomicI64::new(0);

pub fn registry() -> Registry {
    let nodes = [
        Tiny(
            || value(spec("test.constant")).output("out", "number", "It."),
            |c| {
                c.set("out", Number(c.int("value")?));
                Ok(())
            },
        ),
        Tiny(
            || {
                spec("test.add")
                    .many("terms", "number", "What to add.")
                    .float("scale", 0.0..=100.0, 1.0, "1", "A factor.")
                    .output("sum", "number", "The sum.")
            },
            |c| {
                let sum: i64 = c.many::<Number>("terms")?.iter().map(|n| n.0).sum();
                c.set("sum", Number((sum as f64 * c.float("scale")?) as i64));
                Ok(())
            },
        ),
        Tiny(
            || {
                spec("test.pair")
                    .input("a", "number", "The first.")
                    .optional("b", "number", "The second.")
                    .output("list", "number", "The first digit and the second.")
            },
            |c| {
                let b = c.optional::<Number>("b")?.map_or(-1, |n| n.0);
                c.set("list", Number(input(c, "a")? * 10 + b));
                Ok(())
            },
        ),
        Tiny(
            || spec("test.halve").input("in", "number", "A number.").output("out", "number", "Half of it."),
            |c| {
                c.set("out", Number(input(c, "in")?.div_euclid(2)));
                Ok(())
            },
        ),
        Tiny(
            || spec("test.wrap").input("in", "number", "A number.").output("out", "opaque", "It."),
            |c| {
                c.set("out", Opaque(input(c, "in")?));
                Ok(())
            },
        ),
        Tiny(
            || spec("test.unwrap").input("in", "opaque", "A number.").output("out", "number", "It."),
            |c| {
                c.set("out", Number(c.input::<Opaque>("in")?.0));
                Ok(())
            },
        ),
        Tiny(
            || {
                spec("test.split")
                    .input("in", "number", "A number.")
                    .output("tens", "number", "The tens.")
                    .output("ones", "number", "The ones.")
            },
            |c| {
                let n = input(c, "in")?;
                c.set("tens", Number(n / 10));
                c.set("ones", Number(n % 10));
                Ok(())
            },
        ),
        Tiny(
            || spec("test.length").file("path", &["txt"], "A file.").output("out", "number", "Its length."),
            |c| {
                let length = c.file("path")?.len();
                c.set("out", Number(length as i64));
                Ok(())
            },
        ),
        Tiny(
            || {
                spec("test.slow")
                    .optional("in", "number", "A number.")
                    .int("millis", 0..=60_000, 50, "milliseconds", "How long it takes.")
                    .flag("stubborn", false, "Whether it ignores cancellation.")
                    .output("out", "number", "The number.")
            },
            |c| {
                let start = Instant::now();
                let millis = c.int("millis")?;
                while start.elapsed() < Duration::from_millis(millis as u64) {
                    if c.is_cancelled() && !c.flag("stubborn")? {
                        return Err(NodeError::Cancelled);
                    }
                    c.progress(start.elapsed().as_millis() as f32 / millis as f32);
                    std::thread::sleep(Duration::from_millis(2));
                }
                c.set("out", Number(c.optional::<Number>("in")?.map_or(millis, |n| n.0)));
                Ok(())
            },
        ),
        Tiny(
            || {
                spec("test.fail")
                    .optional("in", "number", "A number.")
                    .param(
                        "how",
                        ParamKind::Choice(&[
                            ("failed", "Fails."),
                            ("input", "Blames the input."),
                            ("panic", "Panics."),
                            ("unset", "Sets no output."),
                            ("wrong", "Sets an output of another type."),
                            ("cancelled", "Claims that it was cancelled."),
                        ]),
                        ParamValue::Text("failed".into()),
                        "",
                        "How it fails.",
                    )
                    .output("out", "number", "Nothing.")
            },
            |c| match c.text("how")? {
                "input" => Err(NodeError::input("bad bytes")),
                "panic" => panic!("on purpose"),
                "unset" => Ok(()),
                "cancelled" => Err(NodeError::Cancelled),
                "wrong" => {
                    c.set("out", Opaque(1));
                    Ok(())
                }
                _ => Err(NodeError::failed("does not converge")),
            },
        ),
        Tiny(
            || {
                spec("test.below")
                    .input("in", "number", "A number.")
                    .int("limit", -1000..=1000, 3, "count", "What to be below.")
                    .output("out", "flag", "Whether the number is below the limit.")
            },
            |c| {
                c.set("out", Flag(input(c, "in")? < c.int("limit")?));
                Ok(())
            },
        ),
        Tiny(
            || value(spec("test.anywhere").on_device()).output("out", "number", "It."),
            |c| {
                // What comes out must not depend on where it is computed; which device it was, the events tell.
                if let Some(device) = c.device() {
                    let pretended = device.as_any().downcast_ref::<Pretended>();
                    if pretended.is_some_and(Pretended::lose) {
                        c.warn("the device was lost, going on without");
                    }
                }
                c.set("out", Number(c.int("value")?));
                Ok(())
            },
        ),
        Tiny(
            || {
                value(spec("test.rounding").on_device_apart()).output(
                    "out",
                    "number",
                    "It, one more on a device.",
                )
            },
            |c| {
                let lost = |device: &dyn ComputeDevice| {
                    device.as_any().downcast_ref::<Pretended>().is_some_and(Pretended::lose)
                };
                let more = match c.device_for_floats() {
                    Some(device) if lost(device) => 0,
                    Some(_) => 1,
                    None => 0,
                };
                c.set("out", Number(c.int("value")? + more));
                Ok(())
            },
        ),
        Tiny(
            || value(spec("test.impure")).output("out", "number", "Another one each time."),
            |c| {
                c.set("out", Number(CALLS.fetch_add(1, Ordering::Relaxed)));
                Ok(())
            },
        ),
    ];
    let mut registry = Registry::default();
    registry.add_nodes(nodes.map(|node| Box::new(node) as Box<dyn Node>));
    registry.add_nodes(breccia_engine::flow::nodes());
    registry.add_types(breccia_engine::flow::types());
    registry.add_types([TypeInfo::of::<Number>(), TypeInfo::of::<Opaque>()]);
    registry
}
