use std::path::PathBuf;

use glam::{DVec2, dvec2};

use crate::dataset::{
    ColourTile, Crs, HeightEncoding, HeightLayer, HeightRange, HeightRanges, HeightSamples,
    HeightTile, LoadError, Loaded, Manifest, Shape, TileSource,
};
use crate::tiling::{Extent, LayerLayout, TileId, TileSet, TilingScheme};

/// Texels a side of a tile: small, so that rays cross many.
const TILE: u32 = 8;

/// A source over a raster of heights: what preparing would make of it, without files.
pub struct RasterSource {
    manifest: Manifest,
    present: TileSet,
    /// Of each level, coarsest first: width, height and samples.
    levels: Vec<(usize, usize, Vec<f64>)>,
    /// Tiles that are present and yet cannot be read.
    pub broken: TileSet,
}

impl RasterSource {
    /// Of heights in metres, row by row from the north-west; NaN where there is no data.
    pub fn new(width: usize, heights_m: Vec<f64>, origin: DVec2, texel_m: f64) -> Self {
        let height = heights_m.len() / width;
        let size_m = dvec2(width as f64, height as f64) * texel_m;
        let mut levels = vec![(width, height, heights_m)];
        while levels[0].0.max(levels[0].1) > TILE as usize {
            let coarser = halved(&levels[0]);
            levels.insert(0, coarser);
        }
        let level_count = levels.len() as u8;
        let finest = &levels[levels.len() - 1].2;
        let known = || finest.iter().filter(|height| !height.is_nan()).map(|height| *height as f32);
        let range = HeightRange {
            min_m: known().fold(f32::INFINITY, f32::min),
            max_m: known().fold(f32::NEG_INFINITY, f32::max),
        };
        let root_size_m = f64::from(TILE << (level_count - 1)) * texel_m;
        let corner = origin - dvec2(0.0, size_m.y);
        let manifest = Manifest {
            shape: Shape::Plane,
            version: Manifest::VERSION,
            crs: Crs { epsg: None, name: "raster".to_owned() },
            scheme: TilingScheme { origin, root_size_m },
            data_extent: Extent::new(corner, corner + size_m),
            heights: HeightLayer {
                layout: LayerLayout { tile_size_texels: TILE, gutter_texels: 4, level_count },
                encoding: HeightEncoding::Float,
                step_m: 1.0,
                has_voids: finest.iter().any(|height| height.is_nan()),
                range,
                ranges: HeightRanges { levels: Vec::new() },
            },
            colours: None,
            sources: Vec::new(),
            notes: Vec::new(),
        };
        let mut source = Self { manifest, present: TileSet::new(), levels, broken: TileSet::new() };
        source.present = source.find_present();
        source.manifest.heights.ranges = source.find_ranges();
        source
    }

    /// Leaves out the tiles of the finest level for which `is_kept` says no: their ground is shown
    /// by coarser ones.
    pub fn keep_finest(&mut self, is_kept: impl Fn(TileId) -> bool) {
        let finest = self.manifest.heights.layout.finest_level();
        self.present = self.present.iter().filter(|&t| t.level < finest || is_kept(t)).collect();
    }

    fn sample(&self, level: u8, row: i64, column: i64) -> f64 {
        let (width, height, samples) = &self.levels[usize::from(level)];
        let is_inside = (0..*height as i64).contains(&row) && (0..*width as i64).contains(&column);
        if is_inside { samples[row as usize * width + column as usize] } else { f64::NAN }
    }

    fn texels(&self, tile: TileId, margin: i64) -> impl Iterator<Item = f64> + '_ {
        let size = i64::from(TILE);
        let start = move |index: u32| i64::from(index) * size;
        (-margin..size + margin).flat_map(move |row| {
            (-margin..size + margin).map(move |column| {
                self.sample(tile.level, start(tile.row) + row, start(tile.column) + column)
            })
        })
    }

    fn find_present(&self) -> TileSet {
        all_tiles(self.levels.len() as u8)
            .filter(|&tile| self.texels(tile, 0).any(|height| !height.is_nan()))
            .collect()
    }

    /// Ranges of the two coarsest levels: finer tiles go by their ancestors'.
    fn find_ranges(&self) -> HeightRanges {
        let finest = self.levels.len() as u8 - 1;
        let known = finest.min(1);
        let mut levels: Vec<Vec<Option<HeightRange>>> =
            (0..=known).map(|level| vec![None; 1 << (2 * level)]).collect();
        for tile in self.present.iter() {
            for level in 0..=known.min(tile.level) {
                let ancestor = tile.ancestor_at(level);
                let index = ((ancestor.row as usize) << level) + ancestor.column as usize;
                for height in self.texels(tile, 4).filter(|height| !height.is_nan()) {
                    let height = height as f32;
                    let range = levels[usize::from(level)][index]
                        .get_or_insert(HeightRange { min_m: height, max_m: height });
                    range.min_m = range.min_m.min(height);
                    range.max_m = range.max_m.max(height);
                }
            }
        }
        HeightRanges { levels }
    }
}

fn all_tiles(levels: u8) -> impl Iterator<Item = TileId> {
    (0..levels).flat_map(|level| {
        let side = 1_u32 << level;
        (0..side * side).map(move |index| TileId::new(level, index / side, index % side))
    })
}

fn halved((width, height, samples): &(usize, usize, Vec<f64>)) -> (usize, usize, Vec<f64>) {
    let (w, h) = (width.div_ceil(2), height.div_ceil(2));
    let mean = |index: usize| {
        let (row, column) = (2 * (index / w), 2 * (index % w));
        let places = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(y, x)| (row + y, column + x));
        let held = places.iter().filter(|(y, x)| y < height && x < width);
        let held = held.map(|(y, x)| samples[y * width + x]).filter(|height| !height.is_nan());
        let (sum, count) = held.fold((0.0, 0.0), |(sum, n), height| (sum + height, n + 1.0));
        sum / count
    };
    (w, h, (0..w * h).map(mean).collect())
}

impl TileSource for RasterSource {
    fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    fn heights_present(&self) -> &TileSet {
        &self.present
    }

    fn colours_present(&self) -> &TileSet {
        static NONE: std::sync::LazyLock<TileSet> = std::sync::LazyLock::new(TileSet::new);
        &NONE
    }

    fn load_heights(&self, tile: TileId) -> Result<Loaded<HeightTile>, LoadError> {
        if !self.present.contains(tile) || self.broken.contains(tile) {
            return Err(LoadError::Absent { path: PathBuf::from("raster"), tile });
        }
        let samples = self.texels(tile, 4).map(|height| height as f32).collect();
        let stored_size_texels = TILE + 8;
        let samples = HeightSamples::Metres(samples);
        let tile = HeightTile { id: tile, stored_size_texels, samples, range: None };
        Ok(Loaded { tile, disk_bytes: 0 })
    }

    fn load_colours(&self, tile: TileId) -> Result<Loaded<ColourTile>, LoadError> {
        Err(LoadError::Absent { path: PathBuf::from("raster"), tile })
    }
}
