//! Which axes of space the columns and rows of each view run along.
//!
//! The views are cuts as pictures show them: the one normal to x has rows z and columns y, the one normal to y
//! rows z and columns x, the one normal to z rows y and columns x. A single picture serves all three in this way.

/// For each view, the axes of its columns and rows.
pub(super) const AXES: [[usize; 2]; 3] = [[1, 2], [0, 2], [0, 1]];

/// The coordinate of a view (0 column, 1 row) that runs along an axis of space other than the view's normal.
pub(super) fn coordinate(view: usize, axis: usize) -> usize {
    usize::from(AXES[view][1] == axis)
}

/// The two views that hold an axis, in ascending order.
pub(super) fn views_with(axis: usize) -> [usize; 2] {
    match axis {
        0 => [1, 2],
        1 => [0, 2],
        _ => [0, 1],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_axis_lies_in_two_views() {
        for axis in 0..3 {
            for view in views_with(axis) {
                assert_ne!(view, axis);
                assert_eq!(AXES[view][coordinate(view, axis)], axis);
            }
        }
    }
}
