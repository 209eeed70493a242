use super::TileId;

/// Fixed-point units along one side of the root tile: 2^30, so that an `i32` reaches two root sides
/// either way and offsets between any two points of interest cannot overflow.
///
/// A unit is 56 micrometres on a 60 km root and 4 cm on one that holds the Earth, which is several
/// texels of level 24. The fixed-point position only decides *which tile* holds a point, and borders of
/// tiles are whole units; the place *within* the tile comes from a tile-relative float.
pub const FIXED_UNITS_PER_ROOT: i32 = 1 << 30;

/// A point in fixed-point units from the root's north-west corner: x to the east, y to the south.
///
/// The integer form makes the tile of a point the same on the CPU and on the GPU, bit for bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FixedPosition {
    /// Units to the east.
    pub x: i32,
    /// Units to the south.
    pub y: i32,
}

impl FixedPosition {
    /// From fractions of the root's side; saturates at the range of `i32`.
    pub fn from_root_fraction(east: f64, south: f64) -> Self {
        let units = f64::from(FIXED_UNITS_PER_ROOT);
        // A float to integer `as` cast saturates and takes NaN to 0.
        Self { x: (east * units).round() as i32, y: (south * units).round() as i32 }
    }

    /// The unit that holds the point `offset_m` metres (east, north) away from an anchor in the root,
    /// taken to the root's border where it lies outside. Rounded down, so that a point just short of a
    /// tile's border stays in its tile however coarse the units are. `units_per_m` is [`FIXED_UNITS_PER_ROOT`] over the root's side.
    ///
    /// The twin of `fixed_from_offset` in `common/tile_lookup.wgsl`: the same operations in the same
    /// order and precision, so that CPU and GPU agree bit for bit.
    pub fn from_offset(anchor: Self, offset_m: [f32; 2], units_per_m: f32) -> Self {
        const REACH: f32 = FIXED_UNITS_PER_ROOT as f32;
        let units = |metres: f32| (metres * units_per_m).clamp(-REACH, REACH).floor() as i32;
        let in_root = |position: i32| position.clamp(0, FIXED_UNITS_PER_ROOT - 1);
        Self {
            x: in_root(anchor.x + units(offset_m[0])),
            y: in_root(anchor.y + units(-offset_m[1])),
        }
    }

    /// Whether the point lies in the root.
    pub fn is_in_root(self) -> bool {
        let range = 0..FIXED_UNITS_PER_ROOT;
        range.contains(&self.x) && range.contains(&self.y)
    }

    /// The tile of the level that holds the point, or `None` outside the root.
    pub fn tile_at(self, level: u8) -> Option<TileId> {
        self.is_in_root().then(|| {
            let shift = 30 - u32::from(level);
            TileId::new(level, (self.y >> shift) as u32, (self.x >> shift) as u32)
        })
    }
}
