use super::patch::CELLS_A_SIDE;

/// Triangles of a patch in all ways to join its neighbours: one list after the other.
pub struct PatchTriangles {
    /// Numbers of a patch's vertices, three a triangle, counter-clockwise as seen from outside.
    pub indices: Vec<u16>,
    starts: [u32; Self::WAYS + 1],
}

impl PatchTriangles {
    /// Every edge may border on coarser patches: a bit each.
    const WAYS: usize = 16;

    /// All lists.
    pub fn new() -> Self {
        let mut indices = Vec::new();
        let mut starts = [0; Self::WAYS + 1];
        for coarse_edges in 0..Self::WAYS as u8 {
            add_triangles(&mut indices, coarse_edges);
            starts[usize::from(coarse_edges) + 1] = indices.len() as u32;
        }
        Self { indices, starts }
    }

    /// Where the list is for a patch whose edges (bit n for the n-th of
    /// [`PatchEdge::ALL`](super::PatchEdge::ALL)) border on a coarser one.
    pub fn range(&self, coarse_edges: u8) -> std::ops::Range<u32> {
        let way = usize::from(coarse_edges) % Self::WAYS;
        self.starts[way]..self.starts[way + 1]
    }
}

impl Default for PatchTriangles {
    fn default() -> Self {
        Self::new()
    }
}

fn add_triangles(indices: &mut Vec<u16>, coarse_edges: u8) {
    for row in 0..CELLS_A_SIDE {
        for column in 0..CELLS_A_SIDE {
            let corner = |right, up| joined(coarse_edges, column + right, row + up);
            let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
            for triangle in [[a, b, d], [a, d, c]] {
                let [first, second, third] = triangle;
                // A triangle between two vertices is none.
                if first != second && second != third && third != first {
                    indices.extend(triangle);
                }
            }
        }
    }
}

/// The number of a vertex, or along an edge that borders on a coarser patch of the one before it that both have.
fn joined(coarse_edges: u8, column: u32, row: u32) -> u16 {
    let last = CELLS_A_SIDE;
    let is_coarse = |bit: u8, is_on_edge: bool| is_on_edge && coarse_edges >> bit & 1 == 1;
    let along_column = is_coarse(0, column == 0) || is_coarse(1, column == last);
    let along_row = is_coarse(2, row == 0) || is_coarse(3, row == last);
    let row = if along_column { row & !1 } else { row };
    let column = if along_row { column & !1 } else { column };
    (row * (CELLS_A_SIDE + 1) + column) as u16
}
