//! The whole globe through preparing and back: what lies across the date line and over the poles.

#![expect(clippy::unwrap_used, reason = "a case fails by panicking")]

use std::f64::consts::TAU;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use terrain_core::dataset::{ColourEncoding, Dataset, HeightEncoding, Shape, TileSource};
use terrain_core::geodesy::PlateCarree;
use terrain_core::prepare::{NoProgress, PrepareRequest, prepare};
use terrain_core::tiling::{LayerLayout, TileId};
use terrain_tests::{RasterFixture, Storage};

/// A smooth function on the sphere: nothing in it knows of the date line or of the poles.
fn height_m(longitude_deg: f64, latitude_deg: f64) -> f64 {
    let (lon, lat) = (longitude_deg.to_radians(), latitude_deg.to_radians());
    let (x, y, z) = (lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin());
    1_000.0 * x * y - 700.0 * y * z + 900.0 * x * x * x + 300.0 * z
}

/// Nodes every 5 degrees from -180 to 175 and from pole to pole, as node-registered rasters of the Earth come.
fn write_nodes(path: &Path) {
    let (columns, rows) = (72, 37);
    let raster = RasterFixture {
        size: [columns, rows],
        tie: [-180.0, 90.0],
        cell: [5.0, 5.0],
        epsg: 4326,
        is_point: true,
        nodata: None,
        storage: Storage::Plain,
    };
    let node = |index: u32| {
        let (column, row) = (f64::from(index % columns), f64::from(index / columns));
        height_m(-180.0 + 5.0 * column, 90.0 - 5.0 * row) as f32
    };
    let heights: Vec<f32> = (0..columns * rows).map(node).collect();
    raster.write_f32(path, &heights).unwrap();
}

/// A picture twice as wide as high, without a georeference.
fn write_picture(path: &Path, width: u32) {
    image::RgbImage::from_fn(width, width / 2, |x, y| {
        let turn = f64::from(x) / f64::from(width) * TAU;
        let part = |wave: f64| (127.5 + 120.0 * (turn * wave).sin()) as u8;
        image::Rgb([part(1.0), part(3.0), (y * 400 / width) as u8])
    })
    .save(path)
    .unwrap();
}

fn request(folder: &Path) -> PrepareRequest {
    PrepareRequest {
        shape: Shape::Globe,
        height_tile_texels: 16,
        colour_tile_texels: 32,
        height_encoding: HeightEncoding::Float,
        colour_encoding: ColourEncoding::Rgba8,
        ..PrepareRequest::new(vec![], vec![], folder.join("earth"))
    }
}

fn open(request: &PrepareRequest) -> Dataset {
    prepare(request, &NoProgress, &AtomicBool::new(false)).unwrap();
    Dataset::open(&request.out).unwrap()
}

/// A level as a whole: its tiles with their gutters, and what of it is data.
struct Level<T> {
    layout: LayerLayout,
    level: u8,
    tiles: Vec<(TileId, Vec<T>)>,
}

impl<T: Copy + PartialEq + std::fmt::Debug> Level<T> {
    fn columns(&self) -> i64 {
        i64::from(self.layout.tile_size_texels) << self.level
    }

    fn rows(&self) -> i64 {
        self.columns() / 2
    }

    /// The texel at a row and column, of the tile in whose middle part it lies.
    fn texel(&self, row: i64, column: i64) -> T {
        let tile = i64::from(self.layout.tile_size_texels);
        let id = TileId::new(self.level, (row / tile) as u32, (column / tile) as u32);
        let (_, texels) = self.tiles.iter().find(|(found, _)| *found == id).unwrap();
        let stored = i64::from(self.layout.stored_size_texels());
        let gutter = i64::from(self.layout.gutter_texels);
        texels[((row % tile + gutter) * stored + column % tile + gutter) as usize]
    }

    /// Compares every texel of every gutter with the one it repeats, round the globe and over its poles; returns how
    /// many of them lay across the date line and over a pole.
    fn check_gutters(&self) -> [u32; 2] {
        let stored = self.layout.stored_size_texels() as usize;
        let (tile, gutter) =
            (i64::from(self.layout.tile_size_texels), i64::from(self.layout.gutter_texels));
        let mut found = [0; 2];
        for (id, texels) in &self.tiles {
            for (index, texel) in texels.iter().enumerate() {
                let row = i64::from(id.row) * tile + (index / stored) as i64 - gutter;
                let column = i64::from(id.column) * tile + (index % stored) as i64 - gutter;
                if row >= self.rows() + gutter {
                    continue;
                }
                let is_over_pole = row < 0 || row >= self.rows();
                let (own_row, half) = match row {
                    row if row < 0 => (-1 - row, self.columns() / 2),
                    row if row >= self.rows() => (2 * self.rows() - 1 - row, self.columns() / 2),
                    row => (row, 0),
                };
                let own = self.texel(own_row, (column + half).rem_euclid(self.columns()));
                assert_eq!(*texel, own, "tile {id}, row {row}, column {column}");
                found[0] += u32::from(column < 0 || column >= self.columns());
                found[1] += u32::from(is_over_pole);
            }
        }
        found
    }
}

fn height_level(dataset: &Dataset, level: u8) -> Level<Option<f32>> {
    let ids = dataset.heights_present().iter().filter(|id| id.level == level);
    let tiles = ids.map(|id| {
        let tile = dataset.load_heights(id).unwrap().tile;
        let count = tile.stored_size_texels as usize * tile.stored_size_texels as usize;
        (id, (0..count).map(|index| tile.samples.height_m(index)).collect())
    });
    Level { layout: dataset.manifest().heights.layout, level, tiles: tiles.collect() }
}

fn colour_level(dataset: &Dataset, level: u8) -> Level<[u8; 4]> {
    let ids = dataset.colours_present().iter().filter(|id| id.level == level);
    let tiles = ids.map(|id| {
        let data = dataset.load_colours(id).unwrap().tile.data;
        (id, data.as_chunks::<4>().0.to_vec())
    });
    let layout = dataset.manifest().colours.as_ref().unwrap().layout;
    Level { layout, level, tiles: tiles.collect() }
}

#[test]
fn gutters_agree_across_the_date_line_and_over_the_poles_at_every_level() {
    let folder = tempfile::tempdir().unwrap();
    let (dem, dom) = (folder.path().join("nodes.tif"), folder.path().join("picture.png"));
    write_nodes(&dem);
    write_picture(&dom, 200);
    for encoding in [HeightEncoding::Float, HeightEncoding::Steps] {
        let dataset = open(&PrepareRequest {
            heights: vec![dem.clone()],
            colours: vec![dom.clone()],
            height_encoding: encoding,
            ..request(folder.path())
        });
        let manifest = dataset.manifest();
        assert_eq!((manifest.shape, manifest.crs.epsg), (Shape::Globe, Some(PlateCarree::EPSG)));
        assert!(!manifest.heights.has_voids);
        // 72 nodes and 200 pixels: 64 texels would be too coarse by 1 %, 128 of either are not.
        assert_eq!(manifest.heights.layout.level_count, 4);
        assert_eq!(manifest.colours.as_ref().unwrap().layout.level_count, 4);
        for level in 0..4 {
            for found in [
                height_level(&dataset, level).check_gutters(),
                colour_level(&dataset, level).check_gutters(),
            ] {
                assert!(found.iter().all(|count| *count > 100), "level {level}: {found:?}");
            }
        }
    }
}

#[test]
fn nodes_are_interpolated_across_the_date_line_and_the_poles() {
    let folder = tempfile::tempdir().unwrap();
    let dem = folder.path().join("nodes.tif");
    write_nodes(&dem);
    let dataset = open(&PrepareRequest { heights: vec![dem], ..request(folder.path()) });
    let level = height_level(&dataset, 3);
    let texel_deg = 360.0 / level.columns() as f64;
    let mut worst_m = [0.0_f64; 2];
    for row in 0..level.rows() {
        for column in 0..level.columns() {
            let longitude_deg = -180.0 + (column as f64 + 0.5) * texel_deg;
            let latitude_deg = 90.0 - (row as f64 + 0.5) * texel_deg;
            let got = f64::from(level.texel(row, column).unwrap());
            let is_edge = column < 3 || column + 3 >= level.columns() || row < 3;
            let worst = &mut worst_m[usize::from(is_edge)];
            *worst = worst.max((got - height_m(longitude_deg, latitude_deg)).abs());
        }
    }
    // What the cubic misses of the function in the middle of the raster it misses there too.
    println!("{:.2} m inside, {:.2} m beside the date line and the pole", worst_m[0], worst_m[1]);
    assert!(worst_m[0] < 3.0 && worst_m[1] < 1.2 * worst_m[0], "{worst_m:?}");
}

#[test]
fn coarser_levels_are_box_averages() {
    let folder = tempfile::tempdir().unwrap();
    let dem = folder.path().join("nodes.tif");
    write_nodes(&dem);
    let dataset = open(&PrepareRequest { heights: vec![dem], ..request(folder.path()) });
    for level in 0..3 {
        let (coarse, fine) = (height_level(&dataset, level), height_level(&dataset, level + 1));
        for row in 0..coarse.rows() {
            for column in 0..coarse.columns() {
                let part = |y, x| f64::from(fine.texel(2 * row + y, 2 * column + x).unwrap());
                let mean = (part(0, 0) + part(0, 1) + part(1, 0) + part(1, 1)) / 4.0;
                let got = f64::from(coarse.texel(row, column).unwrap());
                assert!((got - mean).abs() < 1.0e-3, "level {level} {row} {column}: {got} {mean}");
            }
        }
    }
}

#[test]
fn without_heights_the_ground_is_the_ellipsoid() {
    let folder = tempfile::tempdir().unwrap();
    let dom = folder.path().join("picture.png");
    write_picture(&dom, 64);
    let dataset = open(&PrepareRequest { colours: vec![dom], ..request(folder.path()) });
    let manifest = dataset.manifest();
    assert_eq!(manifest.heights.layout.level_count, 1);
    assert_eq!((manifest.heights.range.min_m, manifest.heights.range.max_m), (0.0, 0.0));
    let level = height_level(&dataset, 0);
    assert_eq!(level.check_gutters()[1], 2 * 4 * 24);
    assert!((0..8).all(|row| (0..16).all(|column| level.texel(row, column) == Some(0.0))));
    let said = |words: &str| manifest.notes.iter().any(|note| note.contains(words));
    assert!(said("the ground is the ellipsoid") && said("taken as the whole Earth"));
    // 64 pixels on 64 texels, pixel for pixel.
    let colours = colour_level(&dataset, 1);
    let picture = image::open(folder.path().join("picture.png")).unwrap().into_rgba8();
    for (x, y, pixel) in picture.enumerate_pixels() {
        let texel = colours.texel(i64::from(y), i64::from(x));
        let worst = texel.iter().zip(pixel.0).map(|(a, b)| a.abs_diff(b)).max().unwrap();
        assert!(worst <= 1, "{x} {y}: {texel:?} {pixel:?}");
    }
}

#[test]
fn what_sources_do_not_cover_is_ground_at_0_without_imagery() {
    let folder = tempfile::tempdir().unwrap();
    let corner = RasterFixture {
        size: [20, 10],
        tie: [170.0, 10.0],
        cell: [1.0, 1.0],
        epsg: 4326,
        is_point: false,
        nodata: None,
        storage: Storage::Plain,
    };
    // Across the date line, from 170 to 190 degrees.
    corner.write_f32(&folder.path().join("dem.tif"), &[500.0; 200]).unwrap();
    corner.write_rgb(&folder.path().join("dom.tif"), &[200; 600]).unwrap();
    let dataset = open(&PrepareRequest {
        heights: vec![folder.path().join("dem.tif")],
        colours: vec![folder.path().join("dom.tif")],
        height_tile_texels: 48,
        colour_tile_texels: 48,
        ..request(folder.path())
    });
    let manifest = dataset.manifest();
    assert_eq!((manifest.heights.range.min_m, manifest.heights.range.max_m), (0.0, 500.0));
    let said = |words: &str| manifest.notes.iter().filter(|note| note.contains(words)).count();
    assert_eq!((said("heights are 0 where"), said("covers a part of the globe only")), (1, 2));
    let heights = height_level(&dataset, 3);
    let colours = colour_level(&dataset, 3);
    heights.check_gutters();
    // 384 texels round: 15 / 16 of a degree each.
    for (longitude_deg, is_covered) in [
        (165.0, false),
        (175.0, true),
        (179.6, true),
        (-179.6, true),
        (-175.0, true),
        (-165.0, false),
    ] {
        let column = ((longitude_deg + 180.0) / 360.0 * 384.0) as i64;
        let row = (85.0 / 180.0 * 192.0) as i64;
        assert_eq!(heights.texel(row, column), Some(if is_covered { 500.0 } else { 0.0 }));
        let is_present = dataset.colours_present().contains(TileId::new(
            3,
            (row / 48) as u32,
            (column / 48) as u32,
        ));
        let coverage = if is_present { colours.texel(row, column)[3] } else { 0 };
        assert_eq!(coverage, if is_covered { 255 } else { 0 }, "{longitude_deg}");
    }
}

#[test]
fn wrong_requests_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let dem = folder.path().join("nodes.tif");
    write_nodes(&dem);
    let refused = |request: PrepareRequest, words: &str| {
        let error =
            prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    let base = || PrepareRequest { heights: vec![dem.clone()], ..request(folder.path()) };
    refused(PrepareRequest { heights: vec![], ..base() }, "--dem or --dom");
    refused(PrepareRequest { epsg: Some(4087), ..base() }, "--crs");
    refused(PrepareRequest { keep_voids: true, ..base() }, "--keep-voids");
    refused(PrepareRequest { heights: vec!["points.xyz".into()], ..base() }, "takes rasters");
}
