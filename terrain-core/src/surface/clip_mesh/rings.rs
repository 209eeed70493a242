use glam::{DVec2, dvec2};

use super::ClipBlock;
use crate::CameraView;
use crate::surface::block_culling::inward_normals;
use crate::tiling::{Extent, TilingScheme};

/// Blocks along a ring's side: 12 make a ring, 16 the innermost square.
pub const CLIP_BLOCKS_A_SIDE: u32 = 4;

/// Nested square grids round the eye, each of twice the spacing of the one inside it: the mesh of
/// Losasso and Hoppe, "Geometry Clipmaps" (2004), cut into blocks as in Asirvatham and Hoppe, "Terrain
/// Rendering Using GPU-Based Geometry Clipmaps" (2005).
///
/// Vertices stand where texels of the heights meet, on a grid that never moves; what moves is which of
/// it is drawn. A ring's outer border is a line of the next ring's grid, and every second vertex of it
/// moves onto its neighbour there, so that both rings have the very same edges and no crack can open,
/// without the strips of empty triangles of the paper. The rings' sizes are even instead of odd; the
/// square left out of a ring may then be a cell off its middle, and blocks along it are a cell wider or
/// narrower, which takes the place of the paper's trim.
#[derive(Clone, Debug, PartialEq)]
pub struct ClipMesh {
    /// Cells along a ring's side; a multiple of 8.
    pub cells: u32,
    /// Metres of the finest ring's spacing, the unit of the vertices' places.
    pub unit_m: f64,
    /// The grid point nearest to the eye, from the eye, metres east and north.
    pub reference_from_eye_m: DVec2,
    /// Number of rings.
    pub rings: u32,
    /// All blocks, the finest ring first.
    pub blocks: Vec<ClipBlock>,
}

/// What a mesh is made for.
#[derive(Clone, Copy, Debug)]
pub struct ClipMeshView<'a> {
    /// Where the grid lies: its lines meet the root's corner.
    pub scheme: &'a TilingScheme,
    /// The ground to be covered.
    pub data_extent: &'a Extent,
    /// The eye on the map.
    pub eye: DVec2,
    /// Distance from the eye to the ground below, metres.
    pub clearance_m: f64,
    /// Size a triangle is to have as seen from the eye, radians.
    pub triangle_rad: f64,
    /// The least spacing that shows more, metres: half a texel of the finest heights, since bilinear
    /// ground bends at the texels' centres and where they meet.
    pub least_spacing_m: f64,
}

impl ClipMesh {
    /// Fewest and most cells along a ring's side; a block's vertices are numbered with 16 bits.
    const CELLS: [f64; 2] = [32.0, 1000.0];
    /// Finest spacing as a part of the root's side: grid points far from the eye keep within 32 bits.
    const FINEST: f64 = 1.0 / (1 << 27) as f64;
    /// Most rings: a byte would number more.
    const MOST_RINGS: u32 = 32;

    /// The mesh for a view: rings of 4 / `triangle_rad` cells, where a triangle at a ring's inner
    /// border has the wanted size, from the spacing whose double would be too coarse straight below the
    /// eye out to the last of the data.
    pub fn new(view: &ClipMeshView<'_>) -> Self {
        let [fewest, most] = Self::CELLS;
        let cells = ((4.0 / view.triangle_rad).clamp(fewest, most) / 8.0).round() as u32 * 8;
        let unit_m = finest_spacing_m(view);
        let from_corner =
            dvec2(view.eye.x - view.scheme.origin.x, view.scheme.origin.y - view.eye.y);
        let reference = (from_corner / unit_m).round();
        let far =
            (view.data_extent.min - view.eye).abs().max((view.data_extent.max - view.eye).abs());
        let reach_m = far.max_element();
        let mut mesh = Self {
            cells,
            unit_m,
            reference_from_eye_m: (reference * unit_m - from_corner) * dvec2(1.0, -1.0),
            rings: 0,
            blocks: Vec::new(),
        };
        let mut hole: Option<[f64; 2]> = None;
        loop {
            let spacing_m = unit_m * f64::from(mesh.rings).exp2();
            let half = 0.5 * f64::from(cells);
            let is_outermost =
                (half - 1.0) * spacing_m >= reach_m || mesh.rings + 1 == Self::MOST_RINGS;
            // Even, so that its border is a line of the next ring's grid.
            let start = ((from_corner / spacing_m - half) * 0.5).round() * 2.0;
            mesh.add_ring(start, hole, reference, is_outermost);
            hole = Some((start * 0.5).to_array());
            mesh.rings += 1;
            if is_outermost {
                return mesh;
            }
        }
    }

    /// Most cells of a block from one side to the other.
    pub fn block_cells(&self) -> u32 {
        self.cells / CLIP_BLOCKS_A_SIDE + 1
    }

    /// Adds the blocks of a ring whose first grid point is `start` and which leaves out a square of half
    /// its side from `hole` on, both in its own spacing from the root's corner.
    fn add_ring(
        &mut self,
        start: DVec2,
        hole: Option<[f64; 2]>,
        reference: DVec2,
        is_outermost: bool,
    ) {
        let quarter = self.cells / CLIP_BLOCKS_A_SIDE;
        let cuts = [0, 1].map(|axis| {
            let west = hole.map_or(quarter, |hole| (hole[axis] - start[axis]) as u32);
            [0, west, west + quarter, west + 2 * quarter, self.cells]
        });
        let ring = self.rings;
        let last = CLIP_BLOCKS_A_SIDE as usize - 1;
        for row in 0..=last {
            for column in 0..=last {
                let is_inside = |at: usize| at == 1 || at == 2;
                if hole.is_some() && is_inside(row) && is_inside(column) {
                    continue;
                }
                let first = [cuts[0][column], cuts[1][row]];
                let end = [cuts[0][column + 1], cuts[1][row + 1]];
                let place = start + dvec2(f64::from(first[0]), f64::from(first[1]));
                let units = place * f64::from(ring).exp2() - reference;
                let flags = [
                    (column == 0, ClipBlock::WEST),
                    (row == 0, ClipBlock::NORTH),
                    (column == last, ClipBlock::EAST),
                    (row == last, ClipBlock::SOUTH),
                    (first[0] % 2 == 1, ClipBlock::ODD_COLUMN),
                    (first[1] % 2 == 1, ClipBlock::ODD_ROW),
                    (is_outermost, ClipBlock::OUTERMOST),
                ];
                let flags = flags.iter().filter(|flag| flag.0).fold(0, |sum, flag| sum | flag.1);
                self.blocks.push(ClipBlock {
                    corner: [units.x as i32, units.y as i32],
                    cells: (end[0] - first[0]) | (end[1] - first[1]) << 16,
                    ring_and_flags: ring | flags,
                });
            }
        }
    }

    /// The blocks that may be seen: all but those every part of which is outside one of the view's side
    /// planes, behind the eye or beside the data. A large block as a whole may reach inside every plane
    /// at another of its corners with nothing of it in view.
    ///
    /// `height_range_m`: the lowest and highest ground drawn, exaggeration included.
    pub fn visible_blocks(
        &self,
        view: &CameraView,
        height_range_m: [f64; 2],
        data_extent: &Extent,
    ) -> Vec<ClipBlock> {
        let planes = inward_normals(view);
        let eye = view.eye.truncate();
        let data = Extent::new(data_extent.min - eye, data_extent.max - eye);
        let [low_m, high_m] = height_range_m.map(|height_m| height_m - view.eye.z);
        let [low_m, high_m] = [low_m.min(high_m), low_m.max(high_m)];
        let is_visible = |ground: &Extent| {
            let meets_data = (ground.min.cmple(data.max) & ground.max.cmpge(data.min)).all();
            meets_data
                && planes.iter().all(|normal| {
                    let side = |low: f64, high: f64, along: f64| (along * low).max(along * high);
                    side(ground.min.x, ground.max.x, normal.x)
                        + side(ground.min.y, ground.max.y, normal.y)
                        + side(low_m, high_m, normal.z)
                        >= 0.0
                })
        };
        let is_drawn = |block: &&ClipBlock| {
            let ground = self.ground_from_eye_m(block);
            is_visible(&ground) && parts_of(&ground).any(|part| is_visible(&part))
        };
        self.blocks.iter().filter(is_drawn).copied().collect()
    }

    /// The ground a block covers, from the eye; a cell more on every side, since vertices of a border
    /// move by one.
    fn ground_from_eye_m(&self, block: &ClipBlock) -> Extent {
        let cell = f64::from(block.ring()).exp2();
        let [columns, rows] = block.size().map(f64::from);
        let corner = dvec2(f64::from(block.corner[0]), f64::from(block.corner[1])) - cell;
        let end = corner + dvec2(columns + 2.0, rows + 2.0) * cell;
        let place = |x: f64, y: f64| self.reference_from_eye_m + dvec2(x, -y) * self.unit_m;
        Extent::new(place(corner.x, end.y), place(end.x, corner.y))
    }
}

/// A rectangle cut into 4 x 4.
fn parts_of(ground: &Extent) -> impl Iterator<Item = Extent> + use<> {
    let (corner, size) = (ground.min, 0.25 * (ground.max - ground.min));
    (0..16).map(move |part| {
        let min = corner + dvec2(f64::from(part % 4), f64::from(part / 4)) * size;
        Extent::new(min, min + size)
    })
}

/// The spacing of the innermost ring: a power of two of the least one, such that the next coarser would
/// be larger than wanted straight below the eye.
fn finest_spacing_m(view: &ClipMeshView<'_>) -> f64 {
    let least_m = view.least_spacing_m.max(view.scheme.root_size_m * ClipMesh::FINEST);
    let wanted_m = 0.5 * view.triangle_rad * view.clearance_m;
    least_m * (wanted_m / least_m).max(1.0).log2().ceil().exp2()
}
