use bytemuck::{Pod, Zeroable};

/// A block of a ring, as the vertex stage takes it: the twin of `ClipBlock` in `common/clip_mesh.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct ClipBlock {
    /// North-west vertex in units of the mesh, east and south of its reference.
    pub corner: [i32; 2],
    /// Cells from west to east in the low half, from north to south in the high.
    pub cells: u32,
    /// The ring's number in the low byte, 0 the finest; [`Self::WEST`] and so on above.
    pub ring_and_flags: u32,
}

impl ClipBlock {
    /// The block's west side lies on the ring's outer border.
    pub const WEST: u32 = 1 << 8;
    /// So does its north side.
    pub const NORTH: u32 = 1 << 9;
    /// So does its east side.
    pub const EAST: u32 = 1 << 10;
    /// So does its south side.
    pub const SOUTH: u32 = 1 << 11;
    /// Its west side runs between two columns of the next ring's grid.
    pub const ODD_COLUMN: u32 = 1 << 12;
    /// Its north side runs between two rows of the next ring's grid.
    pub const ODD_ROW: u32 = 1 << 13;
    /// The ring is the outermost: nothing lies beyond its border, which blends into nothing.
    pub const OUTERMOST: u32 = 1 << 14;

    /// Cells from west to east and from north to south.
    pub fn size(&self) -> [u32; 2] {
        [self.cells & 0xffff, self.cells >> 16]
    }

    /// The ring's number, 0 the finest.
    pub fn ring(&self) -> u32 {
        self.ring_and_flags & 0xff
    }

    /// Triangles it is drawn with.
    pub fn triangles(&self) -> u64 {
        let [columns, rows] = self.size();
        2 * u64::from(columns) * u64::from(rows)
    }
}
