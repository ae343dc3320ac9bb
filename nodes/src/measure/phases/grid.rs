//! Where a phase is.

/// The indicator of a phase on a picture (one layer) or a box, x fastest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Voxels along x, y and z; one along z for a picture.
    pub size: [usize; 3],
    /// Whether each voxel is of the phase.
    pub data: Vec<bool>,
}

impl Grid {
    /// From a function of the voxel.
    pub fn from_fn(size: [usize; 3], phase: impl Fn([usize; 3]) -> bool) -> Self {
        let [w, h, d] = size;
        let data = (0..w * h * d).map(|i| phase([i % w, i / w % h, i / w / h])).collect();
        Self { size, data }
    }

    pub(super) fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.size[1] + y) * self.size[0] + x
    }

    pub(super) fn get(&self, voxel: [usize; 3]) -> bool {
        self.data[self.index(voxel)]
    }

    /// The axes along which there is more than one voxel.
    pub(super) fn axes(&self) -> Vec<usize> {
        (0..3).filter(|&axis| self.size[axis] > 1).collect()
    }

    /// The box of `size` voxels from `from` on, which must be inside.
    pub(super) fn part(&self, from: [usize; 3], size: [usize; 3]) -> Self {
        Self::from_fn(size, |[x, y, z]| self.get([from[0] + x, from[1] + y, from[2] + z]))
    }

    /// The quadrants or octants, those of even parity before those of odd: two disjoint halves.
    pub(super) fn parts(&self) -> Vec<Self> {
        let half = self.size.map(|n| (n / 2).max(1));
        let corners = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2]);
        let flat = self.size[2] == 1;
        let mut corners: Vec<[usize; 3]> = corners.filter(|corner| !flat || corner[2] == 0).collect();
        corners.sort_by_key(|corner| corner.iter().sum::<usize>() % 2);
        corners.iter().map(|corner| self.part(std::array::from_fn(|i| corner[i] * half[i]), half)).collect()
    }

    /// The lines along an axis: start and stride in the data.
    pub(super) fn lines(&self, axis: usize) -> (impl Iterator<Item = usize> + '_, usize) {
        let strides = [1, self.size[0], self.size[0] * self.size[1]];
        let mut others = self.size;
        others[axis] = 1;
        let count = others.iter().product::<usize>();
        let start = move |i: usize| {
            let [w, h, _] = others;
            self.index([i % w.max(1), i / w.max(1) % h.max(1), i / w.max(1) / h.max(1)])
        };
        ((0..count).map(start), strides[axis])
    }
}
