//! How the ground is cut into tiles: ids, extents, pyramids, texel rectangles. Pure.
//!
//! **Conventions, stated once.** Level 0 is the coarsest: one square tile over the whole area (the
//! *root*). A tile of level `l` is the root cut into `2^l` by `2^l` squares. Row 0 is the
//! northernmost row, column 0 the westernmost column, so a tile's texels are stored in the order of
//! an image: first row north, first column west. World coordinates are f64 metres in the dataset's
//! projected CRS, x to the east, y to the north.

mod extent;
mod fixed_point;
mod layer_layout;
mod tile_id;
mod tile_set;
mod tiling_scheme;

pub use extent::Extent;
pub use fixed_point::{FIXED_UNITS_PER_ROOT, FixedPosition};
pub use layer_layout::LayerLayout;
pub use tile_id::{MAX_LEVEL, TileId};
pub use tile_set::TileSet;
pub use tiling_scheme::TilingScheme;
