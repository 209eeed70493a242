use glam::{DVec2, dvec2};

/// EPSG code of the rasters: WGS 84 / UTM zone 48 N, which holds the west of Sichuan.
pub const EPSG: u16 = 32648;
/// Cells of the heights and of the picture along a side.
pub const HEIGHT_CELL_M: f64 = 30.0;
/// See [`HEIGHT_CELL_M`].
pub const COLOUR_CELL_M: f64 = 10.0;
/// Colour cells along a height cell.
pub const COLOURS_PER_HEIGHT: usize = 3;

/// Easting and northing of the ground's north-west corner in metres.
const GROUND_CORNER_M: DVec2 = dvec2(166_020.0, 3_583_980.0);

/// A named square of the synthetic ground.
///
/// All presets show the same ground: what a smaller one holds is, cell for cell, a part of the larger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    /// Its name on the command line.
    pub name: &'static str,
    /// Height cells along a side.
    pub heights_side: usize,
    /// Height cells from the ground's north-west corner, east and south.
    first_cell: [usize; 2],
}

impl Preset {
    /// All presets, the largest first.
    pub const ALL: [Self; 4] = [
        Self { name: "sichuan", heights_side: 8000, first_cell: [800, 800] },
        Self { name: "sichuan-half", heights_side: 4000, first_cell: [4000, 4000] },
        Self { name: "sichuan-small", heights_side: 1000, first_cell: [4040, 6340] },
        Self { name: "sichuan-tiny", heights_side: 250, first_cell: [4230, 6680] },
    ];

    /// The preset of a name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|preset| preset.name == name)
    }

    /// Colour cells along a side.
    pub fn colours_side(&self) -> usize {
        COLOURS_PER_HEIGHT * self.heights_side
    }

    /// Easting and northing of the north-west corner in metres.
    pub fn corner_m(&self) -> [f64; 2] {
        let [column, row] = self.first_cell.map(|cell| cell as f64 * HEIGHT_CELL_M);
        [GROUND_CORNER_M.x + column, GROUND_CORNER_M.y - row]
    }

    /// Centre of a height cell, in metres east and south of the ground's corner. Cells just outside
    /// have negative rows and columns.
    pub(super) fn height_centre_m(&self, row: isize, column: isize) -> DVec2 {
        let cell = |first: usize, index: isize| first as f64 + index as f64 + 0.5;
        HEIGHT_CELL_M * dvec2(cell(self.first_cell[0], column), cell(self.first_cell[1], row))
    }

    /// Centre of a colour cell, likewise.
    pub(super) fn colour_centre_m(&self, row: usize, column: usize) -> DVec2 {
        let cell = |first: usize, index: usize| (first * COLOURS_PER_HEIGHT + index) as f64 + 0.5;
        COLOUR_CELL_M * dvec2(cell(self.first_cell[0], column), cell(self.first_cell[1], row))
    }
}
