//! How connected a phase is.

use super::grid::Grid;

/// The share of the phase that is in its largest component, voxels sharing faces (6 neighbours, in a picture 4): 1 is connected
/// throughout. 0 if there is none of the phase. It grows as windows shrink, so equal sizes are to be compared.
pub fn connectivity(grid: &Grid) -> f64 {
    let mut left: Vec<bool> = grid.data.clone();
    let strides = [1, grid.size[0], grid.size[0] * grid.size[1]];
    let (mut largest, mut open) = (0usize, Vec::new());
    for start in 0..left.len() {
        if !std::mem::take(&mut left[start]) {
            continue;
        }
        open.push(start);
        let mut size = 0;
        while let Some(at) = open.pop() {
            size += 1;
            for (stride, n) in strides.into_iter().zip(grid.size) {
                let place = at / stride % n;
                let before = (place > 0).then(|| at - stride);
                let after = (place + 1 < n).then(|| at + stride);
                for other in before.into_iter().chain(after) {
                    if std::mem::take(&mut left[other]) {
                        open.push(other);
                    }
                }
            }
        }
        largest = largest.max(size);
    }
    largest as f64 / grid.data.iter().filter(|&&phase| phase).count().max(1) as f64
}
