/// No triangle.
pub(super) const NONE: u32 = u32::MAX;

/// A triangle of the bisection, cut or not.
#[derive(Clone, Debug)]
pub(super) struct Triangle {
    /// Vertices: apex, left, right; see [`RightTriangle`](super::right_triangle::RightTriangle).
    pub corners: [u32; 3],
    /// The triangle this is a half of.
    pub parent: u32,
    /// The first of the two halves, the second follows it; [`NONE`] while the triangle is not cut.
    pub children: u32,
    /// The triangle across the longest edge. Of a triangle that is cut, the one cut with it.
    pub base: u32,
    /// The triangle across the edge from the apex to the left corner, while this is not cut.
    pub left: u32,
    /// The triangle across the edge from the apex to the right corner, while this is not cut.
    pub right: u32,
    /// Cuts since the root's halves.
    pub depth: u8,
    /// A bit a cut, the last one lowest: 1 for the second child.
    pub path: u64,
    /// Bit `l`: which half of its tile of level `l` the triangle lies in.
    pub halves: u32,
}

/// The triangles of the mesh, how they came of one another and which lie side by side. Two triangles
/// share whole edges or none.
///
/// Cutting is that of M. Duchaineau et al., "ROAMing Terrain: Real-time Optimally Adapting Meshes",
/// 1997: two triangles that share their longest edge are cut together, at its middle.
#[derive(Default)]
pub(super) struct Bisection {
    triangles: Vec<Triangle>,
    /// First triangles of pairs that are no more.
    free_pairs: Vec<u32>,
}

/// What a cut made or took away: the triangles that were cut, and the first of each one's two children.
/// The second of a pair is absent at the border.
pub(super) type CutPairs = [Option<(u32, u32)>; 2];

impl Bisection {
    /// The root's two halves, given their vertices, as triangles 0 and 1.
    pub fn of_halves(corners: [[u32; 3]; 2]) -> Self {
        let half = |index: u32| Triangle {
            corners: corners[index as usize],
            parent: NONE,
            children: NONE,
            base: 1 - index,
            left: NONE,
            right: NONE,
            depth: 0,
            path: 0,
            halves: index,
        };
        Self { triangles: vec![half(0), half(1)], free_pairs: Vec::new() }
    }

    /// How many triangles there is room for; ids are below.
    pub fn capacity(&self) -> usize {
        self.triangles.len()
    }

    /// A triangle.
    pub fn get(&self, id: u32) -> &Triangle {
        &self.triangles[id as usize]
    }

    /// Notes which half of its tile the triangle, of even depth, is.
    pub fn set_half(&mut self, id: u32, half: u32) {
        let triangle = &mut self.triangles[id as usize];
        let bit = u32::from(triangle.depth / 2);
        triangle.halves = (triangle.halves & !(1 << bit)) | (half << bit);
    }

    /// Whether the triangle is not cut.
    pub fn is_leaf(&self, id: u32) -> bool {
        self.get(id).children == NONE
    }

    /// The triangle that is cut together with this one, [`NONE`] at the border; `Err` with the one
    /// across the longest edge where that is larger and must be cut first.
    pub fn partner(&self, id: u32) -> Result<u32, u32> {
        let base = self.get(id).base;
        if base == NONE || self.get(base).base == id { Ok(base) } else { Err(base) }
    }

    /// The name of a pair of triangles that are cut together: the lower id.
    pub fn pair_name(&self, id: u32) -> u32 {
        id.min(self.get(id).base)
    }

    /// Whether the triangle and its partner are cut, and none of their children is.
    pub fn can_join(&self, id: u32) -> bool {
        let has_leaves = |id: u32| {
            let children = self.get(id).children;
            children != NONE && self.is_leaf(children) && self.is_leaf(children + 1)
        };
        let base = self.get(id).base;
        has_leaves(id) && (base == NONE || has_leaves(base))
    }

    /// Cuts the triangle, which is a leaf, and its partner, a leaf or [`NONE`], at a new vertex.
    pub fn cut(&mut self, id: u32, partner: u32, middle: u32) -> CutPairs {
        let first = self.halve(id, middle);
        if partner == NONE {
            return [Some((id, first)), None];
        }
        let other = self.halve(partner, middle);
        // Across the cut edge, left and right change places.
        self.triangles[first as usize].right = other + 1;
        self.triangles[other as usize + 1].left = first;
        self.triangles[first as usize + 1].left = other;
        self.triangles[other as usize].right = first + 1;
        [Some((id, first)), Some((partner, other))]
    }

    fn halve(&mut self, id: u32, middle: u32) -> u32 {
        let parent = self.get(id).clone();
        let [apex, left, right] = parent.corners;
        let first = self.free_pairs.pop().unwrap_or(self.triangles.len() as u32);
        let child = |second: u32| Triangle {
            corners: if second == 0 { [middle, apex, left] } else { [middle, right, apex] },
            parent: id,
            children: NONE,
            base: if second == 0 { parent.left } else { parent.right },
            left: if second == 0 { first + 1 } else { NONE },
            right: if second == 0 { NONE } else { first },
            depth: parent.depth + 1,
            path: (parent.path << 1) | u64::from(second),
            halves: parent.halves,
        };
        let children = [child(0), child(1)];
        for (at, child) in (first as usize..).zip(children) {
            if at < self.triangles.len() {
                self.triangles[at] = child;
            } else {
                self.triangles.push(child);
            }
        }
        self.renew_neighbour(parent.left, id, first);
        self.renew_neighbour(parent.right, id, first + 1);
        self.triangles[id as usize].children = first;
        first
    }

    /// Takes a cut back where [`Self::can_join`]; returns what went with the vertex that goes too.
    pub fn join(&mut self, id: u32) -> (CutPairs, u32) {
        let base = self.get(id).base;
        let middle = self.get(self.get(id).children).corners[0];
        let first = self.rejoin(id);
        let second = (base != NONE).then(|| (base, self.rejoin(base)));
        ([Some((id, first)), second], middle)
    }

    fn rejoin(&mut self, id: u32) -> u32 {
        let first = self.get(id).children;
        let [left, right] = [first, first + 1].map(|child| self.get(child).base);
        self.renew_neighbour(left, first, id);
        self.renew_neighbour(right, first + 1, id);
        let triangle = &mut self.triangles[id as usize];
        (triangle.left, triangle.right, triangle.children) = (left, right, NONE);
        self.free_pairs.push(first);
        first
    }

    /// Tells a triangle that another one lies across an edge now.
    fn renew_neighbour(&mut self, id: u32, old: u32, new: u32) {
        if id == NONE {
            return;
        }
        let triangle = &mut self.triangles[id as usize];
        for neighbour in [&mut triangle.base, &mut triangle.left, &mut triangle.right] {
            if *neighbour == old {
                *neighbour = new;
            }
        }
    }
}
