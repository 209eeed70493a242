use glam::{DVec2, IVec2, dvec2};

use super::patch_errors::{Lattice, PatchErrors};
use crate::dataset::HeightTile;
use crate::tiling::{Extent, FIXED_UNITS_PER_ROOT, LayerLayout, TileId, TilingScheme};

/// Where height tiles lie and how they are cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchFrame {
    /// Where the root lies.
    pub scheme: TilingScheme,
    /// The ground that holds data.
    pub data_extent: Extent,
    /// How height tiles are cut into texels.
    pub layout: LayerLayout,
}

/// A height tile made ready for a [`ViewMesh`](super::ViewMesh): its heights, and how far the ground
/// lies from every triangle it may be drawn with.
///
/// Building one takes some milliseconds, which a loading thread has.
pub struct HeightPatch {
    tile: HeightTile,
    frame: PatchFrame,
    errors: PatchErrors,
    /// Ground beyond the outermost texel centres that hold data has their height.
    within: Extent,
    /// Whether there are no finer tiles below: the ground between texels is then as exact as it gets.
    is_finest: bool,
}

/// The ground at a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundSample {
    /// Metres above the datum.
    pub height_m: f32,
    /// Metres gained per metre east and north.
    pub slope: [f32; 2],
    /// Part of the four nearest samples, by their weights, that hold data.
    pub coverage: f32,
}

impl HeightPatch {
    /// Texels on either side that slopes are taken across.
    const SLOPE_REACH_TEXELS: f64 = 1.0;

    /// The patch of a tile that has `frame`'s layout.
    pub fn new(tile: HeightTile, frame: PatchFrame, is_finest: bool) -> Self {
        let texel_m = frame.layout.texel_size_m(&frame.scheme, tile.id.level);
        let shrunk = dvec2(0.5 * texel_m, 0.5 * texel_m).min(0.5 * frame.data_extent.size_m());
        let within = Extent::new(frame.data_extent.min + shrunk, frame.data_extent.max - shrunk);
        let lattice = lattice_of(&tile, &frame, &within);
        let errors = PatchErrors::of(&lattice, (tile.id.row, tile.id.column));
        Self { tile, frame, errors, within, is_finest }
    }

    /// The tile.
    pub fn tile(&self) -> TileId {
        self.tile.id
    }

    /// Height in metres at a world point, as [`HeightTile::height_at_m`] has it.
    pub fn height_at_m(&self, point: DVec2) -> Option<f64> {
        self.tile.height_at_m(&self.frame.scheme, &self.frame.layout, point)
    }

    /// The ground at a point in fixed-point units of the root, in the tile or on its border. Beyond the
    /// data it goes on level; where there is no data the height is the tile's lowest.
    pub fn sample(&self, point: IVec2) -> GroundSample {
        let place = self.place(point);
        let (height_m, coverage) = self.held(place);
        let reach_m = Self::SLOPE_REACH_TEXELS * self.texel_size_m();
        let along = |step: DVec2| {
            let ends =
                [place - step, place + step].map(|end| end.clamp(self.within.min, self.within.max));
            let [low_m, high_m] = ends.map(|end| {
                let (end_m, weight) = self.held(end);
                if weight > 0.0 { end_m } else { height_m }
            });
            let run_m = (ends[1] - ends[0]).length();
            if run_m > 0.0 { ((high_m - low_m) / run_m) as f32 } else { 0.0 }
        };
        GroundSample {
            height_m: height_m as f32,
            slope: [along(dvec2(reach_m, 0.0)), along(dvec2(0.0, reach_m))],
            coverage: coverage as f32,
        }
    }

    /// How far in metres the ground lies from a triangle that `depth` cuts make of the tile's half; see
    /// [`PatchErrors::error_m`]. `ends_m` and `middle` are the heights at the ends of its longest edge,
    /// and the edge's middle, by which triangles smaller than the tile's cells are judged.
    pub(super) fn error_m(
        &self,
        (half, depth, path): (u32, u8, u64),
        ends_m: [f32; 2],
        middle: IVec2,
    ) -> f32 {
        if let Some(error_m) = self.errors.error_m(half, depth, path) {
            return error_m;
        }
        if !self.is_finest && depth > self.errors.depth() + 1 {
            return 0.0;
        }
        let (middle_m, coverage) = self.held(self.place(middle));
        let is_held = coverage > 0.0;
        // Between the texels the ground is bilinear: each cut leaves a quarter of the error, and 4/3
        // of the first bounds their sum.
        if is_held {
            (4.0 / 3.0) * (middle_m as f32 - 0.5 * (ends_m[0] + ends_m[1])).abs()
        } else {
            0.0
        }
    }

    fn texel_size_m(&self) -> f64 {
        self.frame.layout.texel_size_m(&self.frame.scheme, self.tile.id.level)
    }

    /// The world point, taken onto the outermost samples where it lies beyond them.
    fn place(&self, point: IVec2) -> DVec2 {
        world_from_fixed(&self.frame.scheme, point).clamp(self.within.min, self.within.max)
    }

    fn held(&self, place: DVec2) -> (f64, f64) {
        let PatchFrame { scheme, layout, .. } = &self.frame;
        self.tile
            .held_height_at_m(scheme, layout, place)
            .unwrap_or_else(|| (lowest_m(&self.tile), 0.0))
    }
}

/// The world point of a point in fixed-point units of the root, x to the east and y to the south.
pub(super) fn world_from_fixed(scheme: &TilingScheme, point: IVec2) -> DVec2 {
    let unit_m = scheme.root_size_m / f64::from(FIXED_UNITS_PER_ROOT);
    scheme.origin + dvec2(f64::from(point.x), -f64::from(point.y)) * unit_m
}

fn lowest_m(tile: &HeightTile) -> f64 {
    tile.range.map_or(0.0, |range| f64::from(range.min_m))
}

/// The tile's heights at the corners and middles of cells as small as its texels or a little smaller.
fn lattice_of(tile: &HeightTile, frame: &PatchFrame, within: &Extent) -> Lattice {
    let cells = frame.layout.tile_size_texels.next_power_of_two();
    let side = 2 * cells;
    let corner = frame.scheme.tile_origin(tile.id);
    let half_cell_m = frame.scheme.tile_size_m(tile.id.level) / f64::from(side);
    let mut heights_m = vec![f32::NAN; ((side + 1) * (side + 1)) as usize];
    for y in 0..=side {
        for x in ((y & 1)..=side).step_by(2) {
            let place = corner + dvec2(f64::from(x), -f64::from(y)) * half_cell_m;
            let place = place.clamp(within.min, within.max);
            let height_m = tile.height_at_m(&frame.scheme, &frame.layout, place);
            heights_m[(y * (side + 1) + x) as usize] = height_m.map_or(f32::NAN, |h| h as f32);
        }
    }
    Lattice { cells, cell_m: 2.0 * half_cell_m, heights_m }
}
