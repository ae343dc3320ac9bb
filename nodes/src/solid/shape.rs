//! The node `solid.shape`.

use breccia_engine::{Context, Data, Digest, Node, NodeError, NodeSpec, ParamKind};

use super::evaluate_by;
use super::params::ints;
use crate::control::Control;
use crate::data::{Extent, MapInfo, SampleType, Solid, SolidError, SolidValue, VoxelMap, VoxelSet};

/// Which shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// An ellipsoid.
    Ball,
    /// A box.
    Box,
    /// A shell: the ellipsoid without one two voxels smaller.
    Shell,
}

/// White inside a shape, black outside: a mask.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShapeSolid {
    /// Which shape.
    pub shape: Shape,
    /// The voxel in its middle.
    pub center: [i32; 3],
    /// Voxels from the middle to the border along x, y and z.
    pub radius: [u32; 3],
}

impl ShapeSolid {
    /// Whether a voxel lies inside.
    fn holds(&self, voxel: [i32; 3]) -> bool {
        let d: [i128; 3] = std::array::from_fn(|a| (i128::from(voxel[a]) - i128::from(self.center[a])).abs());
        let ball = |shrink: u32| {
            let r = self.radius.map(|r| i128::from(r.saturating_sub(shrink)));
            // Σ (d / r)² ≤ 1 without fractions.
            let [x, y, z] = std::array::from_fn(|a| {
                let others = r[(a + 1) % 3] * r[(a + 2) % 3];
                d[a].min(1 << 20) * others
            })
            .map(|v: i128| v * v);
            x + y + z <= (r[0] * r[1] * r[2]).pow(2) && r.iter().all(|&r| r > 0)
        };
        match self.shape {
            Shape::Ball => ball(0),
            Shape::Shell => ball(0) && !ball(2),
            Shape::Box => (0..3).all(|a| d[a] <= i128::from(self.radius[a])),
        }
    }
}

impl Solid for ShapeSolid {
    fn maps(&self) -> Vec<MapInfo> {
        vec![MapInfo { name: "color".to_owned(), channels: 3, ty: SampleType::U8 }]
    }

    fn extent(&self) -> Extent {
        Extent::Unbounded
    }

    fn evaluate(&self, voxels: &VoxelSet, control: &dyn Control) -> Result<VoxelMap, SolidError> {
        evaluate_by(voxels, control, |voxel| if self.holds(voxel) { [255; 3] } else { [0; 3] })
    }

    fn digest(&self) -> Digest {
        Digest::of(format!("{self:?}").as_bytes())
    }

    fn summary(&self) -> String {
        format!("{:?} of radius {:?} around {:?}", self.shape, self.radius, self.center)
    }

    fn byte_size(&self) -> u64 {
        28
    }
}

/// A mask in the form of a ball, box or shell.
pub struct ShapeNode;

impl Node for ShapeNode {
    fn spec(&self) -> NodeSpec {
        let place = ParamKind::Ints { min_len: 3, max_len: 3, min: -1_000_000_000, max: 1_000_000_000 };
        NodeSpec::new(
            "solid.shape",
            1,
            "A ball, box or shell, white on black",
            "A mask: white inside, black outside. For constraints, and wherever a solid says where something is to happen.",
        )
        .memory_only()
        .output("solid", SolidValue::TYPE, "The mask.")
        .choice(
            "shape",
            &[
                ("ball", "A ball; an ellipsoid if the radii differ."),
                ("box", "A box."),
                ("shell", "The outermost two voxels of the ball."),
            ],
            "Which shape.",
        )
        .param("center", place, ints([32, 32, 32]), "voxels", "The voxel in its middle: x, y, z.")
        .param(
            "radius",
            ParamKind::Ints { min_len: 1, max_len: 3, min: 1, max: 65_536 },
            ints([16]),
            "voxels",
            "Voxels from the middle to the border along x, y and z; one number for all three.",
        )
    }

    fn run(&self, context: &mut Context<'_>) -> Result<(), NodeError> {
        let shape = match context.text("shape")? {
            "box" => Shape::Box,
            "shell" => Shape::Shell,
            _ => Shape::Ball,
        };
        let three = |numbers: Vec<i64>| match numbers[..] {
            [n] => Ok([n; 3]),
            [x, y, z] => Ok([x, y, z]),
            ref other => Err(NodeError::Failed(format!("expected 1 or 3 numbers, found {}", other.len()))),
        };
        let center = three(context.ints("center")?)?.map(|n| n as i32);
        let radius = three(context.ints("radius")?)?.map(|n| n as u32);
        context.set("solid", SolidValue(std::sync::Arc::new(ShapeSolid { shape, center, radius })));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(shape: Shape) -> usize {
        let solid = ShapeSolid { shape, center: [3, -2, 5], radius: [9, 6, 4] };
        let range = |c: i32| c - 20..c + 20;
        let all = range(5).flat_map(|z| range(-2).flat_map(move |y| range(3).map(move |x| [x, y, z])));
        all.filter(|&voxel| solid.holds(voxel)).count()
    }

    #[test]
    fn shapes_have_their_volumes() {
        let ball = 4.0 / 3.0 * std::f64::consts::PI * 9.0 * 6.0 * 4.0;
        assert!((count(Shape::Ball) as f64 / ball - 1.0).abs() < 0.05);
        assert_eq!(count(Shape::Box), 19 * 13 * 9);
        assert!(count(Shape::Shell) < count(Shape::Ball));
        assert!(count(Shape::Shell) > count(Shape::Ball) / 3);
    }
}
