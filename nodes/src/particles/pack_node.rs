//! The node `particles.pack`.

use breccia_engine::{Context, Data, Node, NodeError, NodeSpec, ParamKind};

use super::neighbours::Neighbours;
use super::pack::{Choice, Order, PackError, PackSettings, pack};
use super::packing::Packing;
use super::particle::ParticleSet;
use super::room::check_room;
use crate::control::Control;
use crate::data::{Solid, SolidValue};
use crate::exemplar::luminance;
use crate::solid::params::ints;
use crate::solid::{available_memory, box_volume};

/// Packs particles into a domain.
pub(super) struct PackNode;

impl Node for PackNode {
    fn spec(&self) -> NodeSpec {
        let defaults = PackSettings::default();
        NodeSpec::new(
            "particles.pack",
            1,
            "Particles packed into a domain",
            "Starts with a particle in the middle and adds others next to those that are there, where the pictures show \
             neighbours, as long as they fit. `layered` completes layers before it begins new ones, as walls are built.",
        )
        .paper("Du et al. 2013, section 3.2, Algorithm 1")
        .on_device()
        .input("particles", ParticleSet::TYPE, "The particles.")
        .input("neighbours", Neighbours::TYPE, "Their neighbour sets.")
        .optional("region", SolidValue::TYPE, "Where particles may be: white, nowhere black, in between with that probability; looked up at their centres.")
        .output("packing", Packing::TYPE, "The particles in their places.")
        .param(
            "size",
            ParamKind::Ints { min_len: 1, max_len: 3, min: 4, max: 4096 },
            ints([defaults.size[0].into()]),
            "voxels",
            "Edges of the domain along x, y and z; one number for a cube.",
        )
        .flag("wrap", true, "What leaves the domain comes in again on the other side, so that it can be tiled; else the domain cuts it.")
        .choice(
            "order",
            &[
                ("isotropic", "Nearest to the middle of the domain first."),
                ("layered", "Layers are completed first."),
            ],
            "In which order candidates are tried.",
        )
        .choice("axis", &[("z", "Layers lie across z."), ("y", "Layers lie across y."), ("x", "Layers lie across x.")], "Which way layers lie, for the order `layered`.")
        .float("tolerance", 0.0..=0.5, defaults.tolerance, "fraction", "How much of a particle others may already have taken; `particles.fill` clears it up.")
        .float("gap", 0.0..=16.0, defaults.gap, "voxels", "What must stay free around a particle.")
        .int("starts", 1..=4096, defaults.starts as i64, "count", "Particles to start from.")
        .choice(
            "choice",
            &[("large", "The largest, which packs more densely."), ("random", "Any, drawn for each place.")],
            "Which of the particles of a cross-section are tried first.",
        )
        .float("slack", -1.0..=16.0, defaults.slack, "fraction", "By how much particles of one size may exceed their share, which the cross-sections tell; negative: however many fit.")
        .int("tries", 1..=64, defaults.tries as i64, "count", "Particles that are tried in one place.")
        .int("seed", 0..=i64::MAX, 1, "count", "Every seed gives another packing.")
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let set = context.input::<ParticleSet>("particles")?;
        let neighbours = context.input::<Neighbours>("neighbours")?;
        let fits = (0..3).all(|v| {
            let count = set.view(v).sections.len();
            neighbours.near[v].len() == count && neighbours.made[v].len() == count
        });
        let known = neighbours.made.iter().flatten().flatten().all(|&p| (p as usize) < set.particles.len());
        let near = neighbours.near.iter().all(|v| v.iter().flatten().all(|n| (n.section as usize) < v.len()));
        if !fits || !known || !near {
            return Err(NodeError::failed("the neighbour sets are those of other particles"));
        }
        let size = match context.ints("size")?[..] {
            [n] => [n as u32; 3],
            [x, y, z] => [x, y, z].map(|n| n as u32),
            ref other => {
                return Err(NodeError::Failed(format!("a size takes 1 or 3 numbers, found {}", other.len())));
            }
        };
        let axis = match context.text("axis")? {
            "x" => 0,
            "y" => 1,
            _ => 2,
        };
        let settings = PackSettings {
            size,
            wrap: context.flag("wrap")?,
            order: if context.text("order")? == "layered" { Order::Layered(axis) } else { Order::Isotropic },
            tolerance: context.float("tolerance")?,
            gap: context.float("gap")?,
            starts: context.int("starts")? as usize,
            tries: context.int("tries")? as usize,
            choice: if context.text("choice")? == "random" { Choice::Random } else { Choice::Large },
            slack: match context.float("slack")? {
                none if none < 0.0 => f64::INFINITY,
                slack => slack,
            },
            seed: context.int("seed")? as u64,
        };
        // A bit a voxel, a byte where there is a region.
        let region = context.optional::<SolidValue>("region")?;
        check_room(size, if region.is_some() { 1.125 } else { 0.125 })?;
        let region = match region {
            Some(solid) => Some(lightness(&*solid.0, size, context)?),
            None => None,
        };
        let at = |voxel: [i32; 3]| {
            let [x, y, z] = voxel.map(|c| c as usize);
            region.as_ref().map_or(255, |of| of[(z * size[1] as usize + y) * size[0] as usize + x])
        };
        let lookup: &(dyn Fn([i32; 3]) -> u8 + Sync) = &at;
        let found = pack(&set, &neighbours, region.is_some().then_some(lookup), &settings, &*context);
        let packing = found.map_err(|error| match error {
            PackError::Cancelled => NodeError::Cancelled,
            other => NodeError::input(other),
        })?;
        context.set("packing", packing);
        Ok(())
    }
}

/// How light a solid is over a domain, layer by layer.
fn lightness(solid: &dyn Solid, size: [u32; 3], control: &dyn Control) -> Result<Vec<u8>, NodeError> {
    let mut light = Vec::with_capacity(size.iter().map(|&n| n as usize).product());
    for z in (0..size[2]).step_by(8) {
        let layers = (size[2] - z).min(8);
        let volume =
            box_volume(solid, [0, 0, z as i32], [size[0], size[1], layers], available_memory(), control)?;
        let Some(map) = volume.map("color") else { continue };
        light.extend((0..volume.voxels()).map(|i| {
            luminance([0, 1, 2].map(|c| map.samples.get_u8(i * map.channels + c.min(map.channels - 1))))
        }));
    }
    light.resize(size.iter().map(|&n| n as usize).product(), 0);
    Ok(light)
}
