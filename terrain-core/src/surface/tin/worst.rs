use std::cmp::Ordering;

use spade::handles::FixedVertexHandle;

/// A triangle's worst sample: what greedy insertion queues. The largest error is the greatest.
pub struct Worst {
    /// Distance above or below the triangle.
    pub error_m: f64,
    /// The sample's number.
    pub sample: usize,
    /// The triangle's number.
    pub face: usize,
    /// The state of the triangle it was found in; a later one makes this entry void.
    pub version: u32,
    /// A corner of the triangle: where to begin to look for it.
    pub corner: FixedVertexHandle,
}

impl Ord for Worst {
    fn cmp(&self, other: &Self) -> Ordering {
        // Equal errors: the first sample first, whatever the triangles' numbers are.
        self.error_m.total_cmp(&other.error_m).then(other.sample.cmp(&self.sample))
    }
}

impl PartialOrd for Worst {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Worst {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Worst {}

/// How often each triangle has been looked at.
#[derive(Default)]
pub struct Versions(Vec<u32>);

impl Versions {
    /// A new state of a triangle: what was found in older ones is void.
    pub fn renew(&mut self, face: usize) -> u32 {
        if self.0.len() <= face {
            self.0.resize(face + 1, 0);
        }
        self.0[face] = self.0[face].wrapping_add(1);
        self.0[face]
    }

    /// Whether an entry is of its triangle's present state.
    pub fn holds(&self, worst: &Worst) -> bool {
        self.0.get(worst.face) == Some(&worst.version)
    }
}
