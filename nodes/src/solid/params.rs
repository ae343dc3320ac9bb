//! Parameters that several nodes declare alike: a box of voxels, and texts that stand for vectors.

use breccia_engine::{Context, NodeError, NodeSpec, ParamKind, ParamValue, Sizing};

/// The farthest voxel coordinate that parameters accept; leaves room for boxes and halos around it.
const FAR: i64 = 1_000_000_000;

/// A list of whole numbers as a parameter's value.
pub(crate) fn ints<const N: usize>(items: [i64; N]) -> ParamValue {
    ParamValue::List(items.into_iter().map(ParamValue::Int).collect())
}

/// A list of real numbers as a parameter's value.
pub(crate) fn floats<const N: usize>(items: [f64; N]) -> ParamValue {
    ParamValue::List(items.into_iter().map(ParamValue::Float).collect())
}

/// Declares the parameters `size` and `origin` of a box.
pub(crate) fn with_box(spec: NodeSpec, size: i64) -> NodeSpec {
    spec.param(
        "size",
        ParamKind::Ints { min_len: 1, max_len: 3, min: 1, max: 65_536 },
        ints([size]),
        "voxels",
        "Edges of the box along x, y and z; one number means a cube.",
    )
    .param(
        "origin",
        ParamKind::Ints { min_len: 3, max_len: 3, min: -FAR, max: FAR },
        ints([0, 0, 0]),
        "voxels",
        "The first voxel of the box: its x, y and z.",
    )
    .draft("size", 2, 64)
}

/// The origin and size declared by [`with_box`].
pub(crate) fn box_of(context: &Context<'_>) -> Result<([i32; 3], [u32; 3]), NodeError> {
    let origin = match context.ints("origin")?[..] {
        [x, y, z] => [coordinate("origin", x)?, coordinate("origin", y)?, coordinate("origin", z)?],
        ref other => return Err(wrong_count("origin", "3", other.len())),
    };
    let size = match context.ints("size")?[..] {
        [n] => [edge(n)?; 3],
        [x, y, z] => [edge(x)?, edge(y)?, edge(z)?],
        ref other => return Err(wrong_count("size", "1 or 3", other.len())),
    };
    Ok((origin, size))
}

/// Declares the picture parameter `picture`: width and height in pixels, one number for a square.
pub(crate) fn with_picture(spec: NodeSpec, name: &'static str, default: i64) -> NodeSpec {
    spec.param(
        name,
        ParamKind::Ints { min_len: 1, max_len: 2, min: 1, max: 16_384 },
        ints([default]),
        "pixels",
        "Width and height of the picture; one number means a square.",
    )
    .draft(name, 2, 128)
}

/// The width and height declared by [`with_picture`].
pub(crate) fn picture_of(context: &Context<'_>, name: &str) -> Result<[u32; 2], NodeError> {
    match context.ints(name)?[..] {
        [n] => Ok([edge(n)?; 2]),
        [w, h] => Ok([edge(w)?, edge(h)?]),
        ref other => Err(wrong_count(name, "1 or 2", other.len())),
    }
}

/// Roughly the bytes of the picture declared by [`with_picture`].
pub(crate) fn picture_bytes(sizing: &Sizing<'_>, name: &str) -> Option<u64> {
    let edges = sizing.ints(name)?;
    Some(3 * edges.first()?.unsigned_abs() * edges.last()?.unsigned_abs())
}

/// Roughly the bytes of the box declared by [`with_box`]; solids carry a colour of three bytes as a rule.
pub(crate) fn box_bytes(sizing: &Sizing<'_>) -> Option<u64> {
    match sizing.ints("size")?[..] {
        [n] => Some(3 * n.unsigned_abs().pow(3)),
        ref edges => Some(edges.iter().fold(3, |bytes, n| bytes * n.unsigned_abs())),
    }
}

/// Three real numbers.
pub(crate) fn vector(context: &Context<'_>, name: &str) -> Result<[f64; 3], NodeError> {
    let numbers = context.floats(name)?;
    numbers.try_into().map_err(|found: Vec<f64>| wrong_count(name, "3", found.len()))
}

fn wrong_count(name: &str, expected: &str, found: usize) -> NodeError {
    NodeError::Failed(format!("parameter `{name}` takes {expected} numbers, found {found}"))
}

fn coordinate(name: &str, value: i64) -> Result<i32, NodeError> {
    i32::try_from(value).map_err(|_| NodeError::Failed(format!("`{name}` {value} is no voxel coordinate")))
}

fn edge(value: i64) -> Result<u32, NodeError> {
    u32::try_from(value).map_err(|_| NodeError::Failed(format!("a size of {value} is out of range")))
}
