//! The Euler number of a phase.

use super::grid::Grid;

/// Which voxels of the phase touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Neighbours {
    /// Those that share a face (6 in a box, 4 in a picture); the rest then touches at corners too.
    Faces,
    /// Those that share a face, an edge or a corner (26 in a box, 8 in a picture); the rest then touches at faces alone.
    All,
}

/// The Euler number of a phase in a window: objects minus tunnels plus cavities in a box, objects minus holes in a picture.
///
/// It counts cells of the cubical complex (vertices − edges + faces − cubes), of the voxels as closed cubes for
/// [`Neighbours::All`], of their centres and what these span for [`Neighbours::Faces`]. Cells of the window's lower borders are
/// left out, so that the number over the window's size estimates the density of a homogeneous medium without bias
/// (Ohser & Mücklich 2000, section 4.2); for what stays off the border it is exact. Of a picture all z-cells are left out.
pub fn euler_number(grid: &Grid, neighbours: Neighbours) -> i64 {
    let depth = grid.size[2];
    // Cells of a picture span x and y alone.
    let kinds = if depth == 1 { 4 } else { 8 };
    let [w, h, _] = grid.size;
    let from = |n: usize| usize::from(n > 1);
    let mut number = 0;
    for z in from(depth)..depth {
        for y in from(h)..h {
            for x in from(w)..w {
                // The 2 × 2 × 2 voxels around the corner before this voxel.
                let around = |corner: usize| {
                    let back = |axis: usize, at: usize| {
                        at - usize::from(corner >> axis & 1 == 0 && grid.size[axis] > 1)
                    };
                    grid.get([back(0, x), back(1, y), back(2, z)])
                };
                let mut cells = [false; 8];
                (0..kinds)
                    .for_each(|corner| cells[corner] = around(if depth == 1 { corner | 4 } else { corner }));
                for kind in 0..kinds {
                    // `kind` names the axes that the cell spans; voxels that differ in the others share it.
                    let shared = (0..kinds).filter(|corner| match neighbours {
                        Neighbours::All => corner & kind == kind,
                        Neighbours::Faces => corner | kind == kinds - 1,
                    });
                    let there = match neighbours {
                        Neighbours::All => shared.clone().any(|corner| cells[corner]),
                        Neighbours::Faces => shared.clone().all(|corner| cells[corner]),
                    };
                    if there {
                        number += if kind.count_ones() % 2 == 0 { 1 } else { -1 };
                    }
                }
            }
        }
    }
    number
}
