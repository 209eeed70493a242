use std::path::PathBuf;

use glam::{DVec2, dvec2};
use terrain_core::dataset::{
    ColourEncoding, ColourFormat, ColourLayer, ColourTile, Crs, HeightEncoding, HeightLayer,
    HeightRange, HeightRanges, HeightSamples, HeightTile, LoadError, Loaded, Manifest, Shape,
    TileSource,
};
use terrain_core::geodesy::PlateCarree;
use terrain_core::tiling::{Extent, LayerLayout, TileId, TileSet, TilingScheme};

/// A surface given by formulas: the height in metres and the sRGB colour at a point.
pub struct Surface {
    /// Metres above the datum at x east, y north of the *root's centre* (or of the place given to
    /// [`AnalyticSource::with_surface_about`]); NaN where there is no data.
    pub height_m: fn(DVec2) -> f64,
    /// sRGB colour there.
    pub colour: fn(DVec2) -> [u8; 3],
}

/// A source that computes its tiles from a [`Surface`] as they are asked for.
///
/// Tiles of every level sample the formula at their texels' centres, so bilinear interpolation of a
/// tile is known without reading any file.
pub struct AnalyticSource {
    surface: Surface,
    /// Where the surface's own origin lies from the root's centre, metres.
    surface_from_centre_m: DVec2,
    manifest: Manifest,
    heights_present: TileSet,
    colours_present: TileSet,
}

impl AnalyticSource {
    /// A square of `root_size_m` around `centre`, with this many levels of heights and colours.
    pub fn new(
        surface: Surface,
        centre: DVec2,
        root_size_m: f64,
        [height_levels, colour_levels]: [u8; 2],
    ) -> Self {
        let half = DVec2::splat(0.5 * root_size_m);
        let scheme = TilingScheme { origin: centre + dvec2(-half.x, half.y), root_size_m };
        let gutter_texels = LayerLayout::GUTTER_TEXELS;
        let layout = |tile_size_texels, level_count| LayerLayout {
            tile_size_texels,
            gutter_texels,
            level_count,
        };
        let heights = layout(128, height_levels);
        let range = surface.range_over(root_size_m);
        let manifest = Manifest {
            shape: Shape::Plane,
            version: Manifest::VERSION,
            crs: Crs { epsg: None, name: "analytic".to_owned() },
            scheme,
            data_extent: Extent::new(centre - half, centre + half),
            heights: HeightLayer {
                layout: heights,
                encoding: HeightEncoding::Float,
                step_m: 1.0,
                has_voids: surface.has_voids_over(root_size_m),
                range,
                ranges: HeightRanges { levels: vec![vec![Some(range)]] },
            },
            colours: Some(ColourLayer {
                layout: layout(384, colour_levels),
                encoding: ColourEncoding::Rgba8,
                format: ColourFormat::Rgba8,
            }),
            sources: Vec::new(),
            notes: Vec::new(),
        };
        Self {
            surface,
            surface_from_centre_m: DVec2::ZERO,
            manifest,
            heights_present: TileSet::full(height_levels),
            colours_present: TileSet::full(colour_levels),
        }
    }

    /// The same with tiles of so many texels a side, heights and colours; 128 and 384 otherwise.
    pub fn with_tile_sizes(mut self, [heights, colours]: [u32; 2]) -> Self {
        self.manifest.heights.layout.tile_size_texels = heights;
        if let Some(layer) = &mut self.manifest.colours {
            layer.layout.tile_size_texels = colours;
        }
        self
    }

    /// The same with the surface's formulas counting from this place in the world instead of the root's
    /// centre.
    pub fn with_surface_about(mut self, origin: DVec2) -> Self {
        self.surface_from_centre_m = origin - self.centre();
        self
    }

    /// The same with the height ranges of the tiles of this many levels known, by samples of the surface;
    /// otherwise only that of the root is.
    pub fn with_height_ranges(mut self, level_count: u8) -> Self {
        let finest = level_count.max(1) - 1;
        let mut levels = vec![self.ranges_of_level(finest)];
        for level in (0..finest).rev() {
            levels.push(ranges_above(level, &levels[levels.len() - 1]));
        }
        levels.reverse();
        self.manifest.heights.ranges = HeightRanges { levels };
        self
    }

    /// A source of the whole globe, whose surface is told by longitude and latitude as metres on the plate carrée,
    /// with this many levels of heights and colours and tiles of so many texels.
    pub fn globe(surface: Surface, levels: [u8; 2], tile_sizes: [u32; 2]) -> Self {
        let equator_m = PlateCarree::EQUATOR_M;
        let centre = dvec2(0.0, -0.25 * equator_m);
        let mut source = Self::new(surface, centre, equator_m, levels)
            .with_surface_about(DVec2::ZERO)
            .with_tile_sizes(tile_sizes);
        source.manifest.shape = Shape::Globe;
        source.manifest.crs =
            Crs { epsg: Some(PlateCarree::EPSG), name: "WGS 84 / Plate Carree".to_owned() };
        source.manifest.data_extent = PlateCarree::extent();
        // Over the globe; below the root's middle there is nothing.
        let range = source.surface.range_within(PlateCarree::extent().max);
        source.manifest.heights.has_voids = false;
        source.manifest.heights.range = range;
        source.manifest.heights.ranges = HeightRanges { levels: vec![vec![Some(range)]] };
        [source.heights_present, source.colours_present] = levels.map(upper_half);
        source
    }

    /// The true height at a world point.
    pub fn height_m(&self, point: DVec2) -> f64 {
        (self.surface.height_m)(point - self.centre() - self.surface_from_centre_m)
    }

    /// The range of every tile of a level, row by row, from a grid of samples in each.
    fn ranges_of_level(&self, level: u8) -> Vec<Option<HeightRange>> {
        const STEPS: u32 = 6;
        let side = 1_u32 << level;
        let range_of = |tile| {
            let extent = self.manifest.scheme.tile_extent(tile);
            let at = |index: u32| f64::from(index) / f64::from(STEPS);
            let heights = (0..(STEPS + 1) * (STEPS + 1)).map(|index| {
                let place = dvec2(at(index % (STEPS + 1)), at(index / (STEPS + 1)));
                self.height_m(extent.min + place * extent.size_m()) as f32
            });
            heights
                .filter(|&height_m| HeightSamples::is_height(height_m))
                .map(|height_m| HeightRange { min_m: height_m, max_m: height_m })
                .reduce(union)
        };
        (0..side * side)
            .map(|index| range_of(TileId::new(level, index / side, index % side)))
            .collect()
    }

    fn centre(&self) -> DVec2 {
        self.manifest.scheme.root_extent().centre()
    }

    /// Texel centres of a stored tile relative to the surface's origin, row by row.
    fn texel_centres(&self, layout: LayerLayout, tile: TileId) -> impl Iterator<Item = DVec2> {
        let scheme = self.manifest.scheme;
        let texel_m = layout.texel_size_m(&scheme, tile.level);
        let size = layout.stored_size_texels();
        // Computed relative to the surface's origin, so that the same surface far from the origin of the CRS
        // has bit for bit the same samples.
        let half_m = 0.5 * scheme.root_size_m;
        let to_west_m = half_m + self.surface_from_centre_m.x;
        let to_north_m = half_m - self.surface_from_centre_m.y;
        let tile_m = scheme.tile_size_m(tile.level);
        let gutter_m = f64::from(layout.gutter_texels) * texel_m;
        let west = f64::from(tile.column) * tile_m - to_west_m - gutter_m;
        let north = to_north_m - f64::from(tile.row) * tile_m + gutter_m;
        (0..size * size).map(move |index| {
            let (row, column) = (f64::from(index / size), f64::from(index % size));
            dvec2(west + (column + 0.5) * texel_m, north - (row + 0.5) * texel_m)
        })
    }

    fn absent(&self, tile: TileId) -> LoadError {
        LoadError::Absent { path: PathBuf::from("analytic"), tile }
    }
}

impl Surface {
    /// Heights at a fine grid of places within these distances of the origin.
    fn heights_within(&self, half_m: DVec2) -> impl Iterator<Item = f32> {
        let steps = 256;
        let at = move |i: i32| 2.0 * f64::from(i) / f64::from(steps) - 1.0;
        (0..=steps)
            .flat_map(move |row| (0..=steps).map(move |column| dvec2(at(column), at(row))))
            .map(move |place| (self.height_m)(place * half_m) as f32)
    }

    /// Those over the root and a little beyond.
    fn heights_over(&self, size_m: f64) -> impl Iterator<Item = f32> {
        self.heights_within(DVec2::splat(0.55 * size_m))
    }

    /// Range of the heights; 0 to 0 where there are none.
    fn range_over(&self, size_m: f64) -> HeightRange {
        self.range_within(DVec2::splat(0.55 * size_m))
    }

    fn range_within(&self, half_m: DVec2) -> HeightRange {
        let held =
            self.heights_within(half_m).filter(|&height_m| HeightSamples::is_height(height_m));
        let range =
            held.map(|height_m| (height_m, height_m)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        let (min_m, max_m) = range.unwrap_or_default();
        HeightRange { min_m, max_m }
    }

    fn has_voids_over(&self, size_m: f64) -> bool {
        self.heights_over(size_m).any(|height_m| !HeightSamples::is_height(height_m))
    }
}

/// The tiles of so many levels in the upper half of the root, and the root.
fn upper_half(level_count: u8) -> TileSet {
    let mut tiles = TileSet::new();
    for level in 0..level_count {
        for row in 0..(1_u32 << level).div_ceil(2) {
            for column in 0..1 << level {
                tiles.insert(TileId::new(level, row, column));
            }
        }
    }
    tiles
}

/// The ranges of a level's tiles from those of the level below it.
fn ranges_above(level: u8, below: &[Option<HeightRange>]) -> Vec<Option<HeightRange>> {
    let side = 1_u32 << level;
    let range_of = |tile: TileId| {
        let index = |child: TileId| ((child.row << (level + 1)) + child.column) as usize;
        tile.children().into_iter().filter_map(|child| below[index(child)]).reduce(union)
    };
    (0..side * side).map(|index| range_of(TileId::new(level, index / side, index % side))).collect()
}

fn union(a: HeightRange, b: HeightRange) -> HeightRange {
    HeightRange { min_m: a.min_m.min(b.min_m), max_m: a.max_m.max(b.max_m) }
}

/// What a tile is said to have taken to read: nothing is, but that it was asked for is to be seen.
const READ_BYTES: u64 = 1;

impl TileSource for AnalyticSource {
    fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    fn heights_present(&self) -> &TileSet {
        &self.heights_present
    }

    fn colours_present(&self) -> &TileSet {
        &self.colours_present
    }

    fn load_heights(&self, tile: TileId) -> Result<Loaded<HeightTile>, LoadError> {
        if !self.heights_present.contains(tile) {
            return Err(self.absent(tile));
        }
        let layout = self.manifest.heights.layout;
        let heights_m = self
            .texel_centres(layout, tile)
            .map(|point| (self.surface.height_m)(point) as f32)
            .collect::<Vec<_>>();
        Ok(Loaded {
            tile: HeightTile {
                id: tile,
                stored_size_texels: layout.stored_size_texels(),
                range: Some(self.manifest.heights.range),
                samples: HeightSamples::Metres(heights_m),
            },
            disk_bytes: READ_BYTES,
        })
    }

    fn load_colours(&self, tile: TileId) -> Result<Loaded<ColourTile>, LoadError> {
        let layer = self.manifest.colours.as_ref().filter(|_| self.colours_present.contains(tile));
        let layout = layer.ok_or_else(|| self.absent(tile))?.layout;
        let data = self
            .texel_centres(layout, tile)
            .flat_map(|point| {
                let [red, green, blue] = (self.surface.colour)(point);
                [red, green, blue, 255]
            })
            .collect();
        Ok(Loaded {
            tile: ColourTile {
                id: tile,
                stored_size_texels: layout.stored_size_texels(),
                format: ColourFormat::Rgba8,
                data,
            },
            disk_bytes: READ_BYTES,
        })
    }
}
