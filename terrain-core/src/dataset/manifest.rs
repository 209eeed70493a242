use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::{ColourFormat, HeightRange};
use crate::geodesy::{CoordinateSystem, PlateCarree};
use crate::tiling::{Extent, LayerLayout, TileId, TilingScheme};

/// What `manifest.json` says of a dataset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of this format; readers refuse any other than [`Manifest::VERSION`].
    pub version: u32,
    /// The projected coordinate reference system of all coordinates.
    pub crs: Crs,
    /// What the ground lies on.
    #[serde(default)]
    pub shape: Shape,
    /// Where the tiles lie.
    pub scheme: TilingScheme,
    /// The ground that holds heights: the sources' extent in the CRS, within the root.
    pub data_extent: Extent,
    /// The height layer.
    pub heights: HeightLayer,
    /// The colour layer, where there is imagery.
    pub colours: Option<ColourLayer>,
    /// What was read, by file name (never a path).
    pub sources: Vec<String>,
    /// What a reader should know: resampling done, voids filled, data assumed.
    pub notes: Vec<String>,
}

impl Manifest {
    /// The version this program writes and reads.
    pub const VERSION: u32 = 1;

    /// The CRS in which people give and read places, as flight files name it: such as `EPSG:32632`, and
    /// longitude and latitude for a globe.
    pub fn user_crs(&self) -> String {
        match (self.shape, self.crs.epsg) {
            (Shape::Globe, _) => format!("EPSG:{}", CoordinateSystem::WGS84),
            (Shape::Plane, Some(code)) => format!("EPSG:{code}"),
            (Shape::Plane, None) => self.crs.name.clone(),
        }
    }
}

/// What the ground of a dataset lies on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// The plane of the CRS.
    #[default]
    Plane,
    /// The ellipsoid of WGS 84, all of it. The CRS is [`PlateCarree`](crate::geodesy::PlateCarree), and the root a
    /// square of the equator's length a side, whose upper half is the data: what leaves a level's tiles in the
    /// east comes back in the west.
    Globe,
}

impl Shape {
    /// The place, in metres of the dataset's CRS, of one as people give and read it: in the same metres on a plane,
    /// longitude and latitude in degrees on a globe. Longitudes may be any number of turns; the metres are of the one
    /// from the date line on.
    pub fn world_from_user(self, position: DVec2) -> DVec2 {
        match self {
            Self::Plane => position,
            Self::Globe => {
                let longitude_deg = (position.x + 180.0).rem_euclid(360.0) - 180.0;
                PlateCarree::metres_from_degrees(DVec2::new(longitude_deg, position.y))
            }
        }
    }

    /// The reverse of [`Self::world_from_user`].
    pub fn user_from_world(self, position: DVec2) -> DVec2 {
        match self {
            Self::Plane => position,
            Self::Globe => PlateCarree::degrees_from_metres(position),
        }
    }
}

/// A projected coordinate reference system in metres.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Crs {
    /// EPSG code; `None` for a local grid in metres with no known place on Earth.
    pub epsg: Option<u32>,
    /// A name for people, such as "WGS 84 / UTM zone 32N".
    pub name: String,
}

/// How heights are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum HeightEncoding {
    /// 16-bit steps wherever a tile's range fits, float32 (on the same steps) elsewhere.
    Steps,
    /// float32 for every tile, samples unchanged.
    Float,
}

/// The height layer of a dataset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeightLayer {
    /// Tile and pyramid sizes.
    pub layout: LayerLayout,
    /// How samples are stored.
    pub encoding: HeightEncoding,
    /// Metres a step of [`HeightEncoding::Steps`]; a power of two.
    pub step_m: f32,
    /// Whether any ground within the data's extent holds no data.
    #[serde(default = "yes")]
    pub has_voids: bool,
    /// Range of all heights.
    pub range: HeightRange,
    /// Ranges of the coarse levels' tiles.
    pub ranges: HeightRanges,
}

/// What an older manifest is taken to say: drawing is then right, if slower.
fn yes() -> bool {
    true
}

/// The lowest and highest height of every tile of the coarsest levels.
///
/// Selection needs a tile's height range to know its distance from the eye before the tile is
/// loaded; keeping it for the first few levels only makes the answer small, and the same whatever
/// happens to be in memory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeightRanges {
    /// `levels[l][row * 2^l + column]`; `None` where the tile holds no data.
    pub levels: Vec<Vec<Option<HeightRange>>>,
}

impl HeightRanges {
    /// Number of levels written at the most.
    pub const MAX_LEVELS: u8 = 6;

    /// The range of the tile, or of its finest ancestor known; `None` where there is no data.
    pub fn range(&self, tile: TileId) -> Option<HeightRange> {
        let finest = self.levels.len().checked_sub(1)? as u8;
        let known = tile.ancestor_at(finest.min(tile.level));
        let index = ((known.row as usize) << known.level) + known.column as usize;
        *self.levels.get(usize::from(known.level))?.get(index)?
    }
}

/// How colours are stored on disk.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ColourEncoding {
    /// BC1 blocks, losslessly compressed.
    Bc1,
    /// BC7 blocks, losslessly compressed.
    Bc7,
    /// Plain RGBA8, losslessly compressed.
    Rgba8,
    /// JPEG for slow links; transcoded to BC blocks when loaded.
    Jpeg,
}

/// The colour layer of a dataset.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ColourLayer {
    /// Tile and pyramid sizes.
    pub layout: LayerLayout,
    /// How tiles are stored on disk.
    pub encoding: ColourEncoding,
    /// The format tiles decode to.
    pub format: ColourFormat,
}
