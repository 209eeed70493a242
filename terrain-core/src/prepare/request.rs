use std::path::PathBuf;

use crate::dataset::{ColourEncoding, ColourFormat, HeightEncoding, Shape};
use crate::tiling::LayerLayout;

/// How files of points are read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointOptions {
    /// LAS classes to take; empty takes ground alone if any point is said to be ground, else all.
    pub classes: Vec<u8>,
    /// Side in metres of the cells that points are interpolated to; `None` follows their density.
    pub spacing_m: Option<f64>,
    /// EPSG code of points that do not say theirs; `None` takes the dataset's.
    pub epsg: Option<u32>,
}

/// What to prepare, and how.
#[derive(Clone, Debug)]
pub struct PrepareRequest {
    /// Height rasters and files of points, at least one; where they overlap the first one counts. All
    /// points together make one surface. Those of a globe are rasters, and may be none: it is the ellipsoid then.
    pub heights: Vec<PathBuf>,
    /// Pictures; may be none, but for a globe without heights.
    pub colours: Vec<PathBuf>,
    /// What the ground lies on. A globe has a CRS of its own ([`Shape::Globe`]) and heights everywhere, 0 where no
    /// source has any; pictures without a georeference that are twice as wide as high are the whole Earth.
    pub shape: Shape,
    /// Folder the dataset is written to. A dataset that is there already is replaced; anything else
    /// is not.
    pub out: PathBuf,
    /// EPSG code of the dataset's CRS, also taken for that of height rasters that do not say theirs.
    pub epsg: Option<u32>,
    /// How files of points are read.
    pub points: PointOptions,
    /// Where pictures without a georeference lie: west, south, east, north, in the units of
    /// `colour_epsg`.
    pub colour_bounds: Option<[f64; 4]>,
    /// EPSG code of pictures that do not say theirs; `None` takes the heights'.
    pub colour_epsg: Option<u32>,
    /// Texels along a height tile; a multiple of 8.
    pub height_tile_texels: u32,
    /// Texels along a colour tile; a multiple of 8.
    pub colour_tile_texels: u32,
    /// Most levels of either layer; `None` keeps all.
    pub level_limit: Option<u8>,
    /// How heights are stored.
    pub height_encoding: HeightEncoding,
    /// How colours are stored.
    pub colour_encoding: ColourEncoding,
    /// What JPEG tiles are transcoded to when loaded.
    pub jpeg_format: ColourFormat,
    /// Leaves gaps in the heights as they are; else those that data encloses are filled, if at most
    /// [`MAX_VOID_CELLS`](super::MAX_VOID_CELLS) wide and high.
    pub keep_voids: bool,
    /// Fills larger gaps too, and all by the natural neighbours on their rims: those of at most so many
    /// square kilometres that data encloses, at most [`MAX_LARGE_VOID_CELLS`](super::MAX_LARGE_VOID_CELLS)
    /// wide and high.
    pub fill_voids_km2: Option<f64>,
    /// Goes on with the layers that an interrupted preparation of the same request has finished, and
    /// on an interruption or an error leaves those finished by then in a hidden folder beside `out`.
    /// Finished layers of changed settings or files are made anew.
    pub is_resumable: bool,
}

impl PrepareRequest {
    /// A request with the usual settings.
    pub fn new(heights: Vec<PathBuf>, colours: Vec<PathBuf>, out: PathBuf) -> Self {
        Self {
            heights,
            colours,
            shape: Shape::Plane,
            out,
            epsg: None,
            points: PointOptions::default(),
            colour_bounds: None,
            colour_epsg: None,
            height_tile_texels: 128,
            colour_tile_texels: 384,
            level_limit: None,
            height_encoding: HeightEncoding::Steps,
            colour_encoding: ColourEncoding::Bc7,
            jpeg_format: ColourFormat::Bc7,
            keep_voids: false,
            fill_voids_km2: None,
            is_resumable: false,
        }
    }

    /// The format colour tiles decode to.
    pub fn colour_format(&self) -> ColourFormat {
        match self.colour_encoding {
            ColourEncoding::Bc1 => ColourFormat::Bc1,
            ColourEncoding::Bc7 => ColourFormat::Bc7,
            ColourEncoding::Rgba8 => ColourFormat::Rgba8,
            ColourEncoding::Jpeg => self.jpeg_format,
        }
    }

    pub(super) fn layout(&self, tile_size_texels: u32, level_count: u8) -> LayerLayout {
        LayerLayout { tile_size_texels, gutter_texels: LayerLayout::GUTTER_TEXELS, level_count }
    }
}
