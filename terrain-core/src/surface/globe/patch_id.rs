use glam::DVec3;

/// The address of a patch: a square of one of the six faces of a cube that is blown up to the globe.
///
/// Level 0 is a whole face; each further level halves the side. The cube keeps all patches of a level within
/// about a factor of 1.4 of each other in size, and has neither poles nor a date line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PatchId {
    /// 0 is a whole face.
    pub level: u8,
    /// 0 to 5: towards +x, -x, +y, -y, +z, -z.
    pub face: u8,
    /// Counts along the face's first axis.
    pub column: u32,
    /// Counts along the face's second axis.
    pub row: u32,
}

/// The edges of a patch, in the order in which bits and neighbours are numbered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PatchEdge {
    /// Column 0 of the grid.
    First,
    /// The last column.
    Last,
    /// Row 0.
    Low,
    /// The last row.
    High,
}

impl PatchEdge {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::First, Self::Last, Self::Low, Self::High];
}

impl PatchId {
    /// The deepest level: patches of about 10 m, cells of less than a metre.
    pub const FINEST_LEVEL: u8 = 20;

    /// The six faces.
    pub fn faces() -> [Self; 6] {
        [0, 1, 2, 3, 4, 5].map(|face| Self { level: 0, face, column: 0, row: 0 })
    }

    /// The patch that holds this one; `None` for a face.
    pub fn parent(self) -> Option<Self> {
        (self.level > 0).then(|| Self {
            level: self.level - 1,
            column: self.column / 2,
            row: self.row / 2,
            ..self
        })
    }

    /// The four patches it is made of.
    pub fn children(self) -> [Self; 4] {
        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(right, up)| Self {
            level: self.level + 1,
            column: 2 * self.column + right,
            row: 2 * self.row + up,
            ..self
        })
    }

    /// The direction from the cube's centre through a place of the patch: (0, 0) to (1, 1) across it, and a little
    /// beyond. The same bit for bit wherever patches share the place. Of any length but 0.
    pub fn direction(self, across: f64, up: f64) -> DVec3 {
        let [normal, first, second] = axes(self.face);
        let on_face = |index: u32, part: f64| {
            // Exact for parts that are whole numbers of 2^-n.
            let patches = f64::from(1_u32 << self.level);
            widened(2.0 * (f64::from(index) + part) / patches - 1.0)
        };
        // Adding 0 makes 0 of -0, which angles would tell apart.
        normal + first * on_face(self.column, across) + second * on_face(self.row, up) + DVec3::ZERO
    }

    /// The patch of this level behind an edge.
    pub fn neighbour(self, edge: PatchEdge) -> Self {
        // Far enough to be beyond the edge, too near for the bend at the cube's edges to matter.
        const BEYOND: f64 = 1.0 / 64.0;
        let (across, up) = match edge {
            PatchEdge::First => (-BEYOND, 0.5),
            PatchEdge::Last => (1.0 + BEYOND, 0.5),
            PatchEdge::Low => (0.5, -BEYOND),
            PatchEdge::High => (0.5, 1.0 + BEYOND),
        };
        Self::holding(self.direction(across, up), self.level)
    }

    /// The patch of a level that a direction goes through.
    pub fn holding(direction: DVec3, level: u8) -> Self {
        let size = direction.abs();
        let axis = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let face = 2 * axis as u8 + u8::from(direction[axis] < 0.0);
        let [normal, first, second] = axes(face);
        let along = direction.dot(normal).max(f64::MIN_POSITIVE);
        let index = |component: f64| {
            let patches = f64::from(1_u32 << level);
            let part = 0.5 + 0.5 * narrowed(component / along);
            (part * patches).floor().clamp(0.0, patches - 1.0) as u32
        };
        Self { level, face, column: index(direction.dot(first)), row: index(direction.dot(second)) }
    }
}

/// Normal and axes of a face; the axes turn about the normal as seen from outside against the clock.
fn axes(face: u8) -> [DVec3; 3] {
    use DVec3 as V;
    match face {
        0 => [V::X, V::Y, V::Z],
        1 => [-V::X, -V::Y, V::Z],
        2 => [V::Y, -V::X, V::Z],
        3 => [-V::Y, V::X, V::Z],
        4 => [V::Z, V::X, V::Y],
        _ => [-V::Z, V::Y, V::X],
    }
}

/// Places on a face, -1 to 1, moved so that equal steps are equal angles: exact at the ends and the middle, and
/// the same on either side of it.
fn widened(place: f64) -> f64 {
    if place.abs() == 1.0 { place } else { (place * std::f64::consts::FRAC_PI_4).tan() }
}

/// The reverse of [`widened`].
fn narrowed(place: f64) -> f64 {
    place.atan() / std::f64::consts::FRAC_PI_4
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn any_patch() -> impl Strategy<Value = PatchId> {
        (0_u8..=PatchId::FINEST_LEVEL, 0_u8..6, any::<u32>(), any::<u32>()).prop_map(
            |(level, face, column, row)| {
                let mask = (1 << level) - 1;
                PatchId { level, face, column: column & mask, row: row & mask }
            },
        )
    }

    /// The ends of an edge, in whichever order.
    fn ends(patch: PatchId, edge: PatchEdge) -> [DVec3; 2] {
        let ends = match edge {
            PatchEdge::First => [(0.0, 0.0), (0.0, 1.0)],
            PatchEdge::Last => [(1.0, 0.0), (1.0, 1.0)],
            PatchEdge::Low => [(0.0, 0.0), (1.0, 0.0)],
            PatchEdge::High => [(0.0, 1.0), (1.0, 1.0)],
        };
        ends.map(|(across, up)| patch.direction(across, up).normalize())
    }

    #[test]
    fn faces_are_seen_from_outside_against_the_clock() {
        for face in PatchId::faces() {
            let [a, b, c] = [(0.2, 0.3), (0.8, 0.3), (0.8, 0.9)].map(|(x, y)| face.direction(x, y));
            assert!((b - a).cross(c - a).dot(a) > 0.0, "{face:?}");
        }
    }

    proptest! {
        #[test]
        fn neighbours_share_an_edge_bit_for_bit(patch in any_patch()) {
            for edge in PatchEdge::ALL {
                let neighbour = patch.neighbour(edge);
                prop_assert_eq!(neighbour.level, patch.level);
                prop_assert!(neighbour != patch);
                let theirs = PatchEdge::ALL
                    .into_iter()
                    .find(|&theirs| neighbour.neighbour(theirs) == patch);
                let Some(theirs) = theirs else { return Err(TestCaseError::fail("not mutual")) };
                let (mine, theirs) = (ends(patch, edge), ends(neighbour, theirs));
                let same = mine == theirs || mine == [theirs[1], theirs[0]];
                prop_assert!(same, "{:?} {:?}: {:?} {:?}", patch, edge, mine, theirs);
            }
        }

        #[test]
        fn a_patch_holds_what_lies_in_it(patch in any_patch(), x in 0.01..0.99, y in 0.01..0.99) {
            let direction = patch.direction(x, y);
            prop_assert_eq!(PatchId::holding(direction * 7.0, patch.level), patch);
            if let Some(parent) = patch.parent() {
                prop_assert!(parent.children().contains(&patch));
                prop_assert_eq!(PatchId::holding(direction, parent.level), parent);
            }
        }
    }
}
