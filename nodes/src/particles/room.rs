//! Whether a computation over every voxel of a domain fits into memory, said before it allocates anything.

use breccia_engine::NodeError;

use crate::solid::available_memory;

/// Checks that `bytes` for each voxel of a domain are free.
///
/// # Errors
/// Says how much is needed and free, and how large a cube would fit.
pub(super) fn check_room(size: [u32; 3], bytes: f64) -> Result<(), NodeError> {
    let (needed, free) =
        (size.iter().map(|&n| f64::from(n)).product::<f64>() * bytes, available_memory() as f64);
    if needed <= free {
        return Ok(());
    }
    let [x, y, z] = size;
    Err(NodeError::Failed(format!(
        "a domain of {x} × {y} × {z} voxels needs {:.1} GB here, {:.1} GB are free; expected at most a cube of about {}³",
        needed / 1e9,
        free / 1e9,
        libm::cbrt(free / bytes) as u64
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_with_a_size_that_does() {
        assert!(check_room([64; 3], 20.0).is_ok());
        let error = check_room([1 << 20; 3], 20.0).unwrap_err().to_string();
        assert!(error.contains("expected at most a cube"), "{error}");
    }
}
