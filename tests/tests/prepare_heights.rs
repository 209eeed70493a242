//! Heights through the whole of preparing and back, against arithmetic by hand.

#![expect(clippy::unwrap_used, reason = "a case fails by panicking")]

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use glam::dvec2;
use terrain_core::dataset::{Dataset, HeightEncoding, HeightSamples, TileSource};
use terrain_core::prepare::{NoProgress, PrepareRequest, PrepareSummary, prepare};
use terrain_core::tiling::TileId;
use terrain_tests::{RasterFixture, Storage};

const ORIGIN: [f64; 2] = [432_000.0, 6_850_000.0];
const NODATA: i16 = -32768;

fn run(request: &PrepareRequest) -> (Dataset, PrepareSummary) {
    let summary = prepare(request, &NoProgress, &AtomicBool::new(false)).unwrap();
    (Dataset::open(&request.out).unwrap(), summary)
}

fn request(folder: &Path, heights: &[&str]) -> PrepareRequest {
    let paths = heights.iter().map(|name| folder.join(name)).collect::<Vec<PathBuf>>();
    PrepareRequest {
        height_tile_texels: 32,
        keep_voids: true,
        ..PrepareRequest::new(paths, Vec::new(), folder.join("out"))
    }
}

/// Rough whole metres with some cells missing.
fn terrain(width: u32, height: u32, missing: bool) -> Vec<i16> {
    (0..width * height)
        .map(|index| {
            let (row, column) = (f64::from(index / width), f64::from(index % width));
            let noise = f64::from(index.wrapping_mul(2_654_435_761) >> 24) / 16.0;
            let lost = missing && index % 41 == 0 || missing && row > 60.0 && column < 20.0;
            let wave = 900.0 * (0.05 * row).sin() * (0.031 * column).cos();
            if lost { NODATA } else { (wave + noise) as i16 }
        })
        .collect()
}

fn as_metres(heights: &[i16]) -> Vec<f64> {
    let metres = |&height: &i16| if height == NODATA { f64::NAN } else { f64::from(height) };
    heights.iter().map(metres).collect()
}

/// Checks every sample of a level, gutters too, against a raster; NaN is no data and absent tiles
/// must hold none.
fn check_level(dataset: &Dataset, level: u8, raster: &[f64], width: usize, tolerance_m: f64) {
    let layout = dataset.manifest().heights.layout;
    let (tile_size, gutter) = (layout.tile_size_texels as i64, i64::from(layout.gutter_texels));
    let height = raster.len() / width;
    let expected = |x: i64, y: i64| {
        let inside = x >= 0 && y >= 0 && x < width as i64 && y < height as i64;
        if inside { raster[y as usize * width + x as usize] } else { f64::NAN }
    };
    for row in 0..1_u32 << level {
        for column in 0..1_u32 << level {
            let id = TileId::new(level, row, column);
            let (left, top) = (i64::from(column) * tile_size, i64::from(row) * tile_size);
            if !dataset.heights_present().contains(id) {
                let any = (0..tile_size * tile_size).any(|index| {
                    !expected(left + index % tile_size, top + index / tile_size).is_nan()
                });
                assert!(!any, "{id} holds data and is absent");
                continue;
            }
            let tile = dataset.load_heights(id).unwrap().tile;
            let stored = i64::from(tile.stored_size_texels);
            for index in 0..stored * stored {
                let (x, y) = (left + index % stored - gutter, top + index / stored - gutter);
                let got = tile.samples.height_m(index as usize).map_or(f64::NAN, f64::from);
                let want = expected(x, y);
                assert_eq!(got.is_nan(), want.is_nan(), "{id} at {x} {y}: {got} {want}");
                assert!(got.is_nan() || (got - want).abs() <= tolerance_m, "{id} {got} {want}");
            }
        }
    }
}

/// The straightforward average of each two by two cells that hold data.
fn box_filter(finest: &[f64], width: usize) -> (Vec<f64>, usize) {
    let height = finest.len() / width;
    let half = width.div_ceil(2);
    let mut out = vec![f64::NAN; half * height.div_ceil(2)];
    for (index, target) in out.iter_mut().enumerate() {
        let corner = (2 * (index % half), 2 * (index / half));
        let cells = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| (corner.0 + dx, corner.1 + dy));
        let inside = cells.into_iter().filter(|&(x, y)| x < width && y < height);
        let held: Vec<f64> =
            inside.map(|(x, y)| finest[y * width + x]).filter(|cell| !cell.is_nan()).collect();
        *target = held.iter().sum::<f64>() / held.len() as f64;
    }
    (out, half)
}

#[test]
fn a_projected_raster_keeps_its_samples_and_its_grid_in_every_form_of_tiff() {
    for storage in Storage::ALL {
        let folder = tempfile::tempdir().unwrap();
        let (width, height) = (101, 77);
        let heights = terrain(width, height, true);
        let fixture = RasterFixture {
            nodata: Some("-32768"),
            storage,
            ..RasterFixture::utm([width, height], ORIGIN, 30.0)
        };
        fixture.write_i16(&folder.path().join("dem.tif"), &heights).unwrap();
        let (dataset, _) = run(&request(folder.path(), &["dem.tif"]));
        let manifest = dataset.manifest();
        assert_eq!(manifest.crs.epsg, Some(32632));
        assert_eq!(manifest.scheme.origin, dvec2(ORIGIN[0], ORIGIN[1]));
        assert_eq!(manifest.scheme.root_size_m, 30.0 * 128.0, "{storage:?}");
        let extent = manifest.data_extent;
        assert_eq!(extent.size_m(), dvec2(101.0 * 30.0, 77.0 * 30.0));
        let finest = manifest.heights.layout.finest_level();
        assert_eq!(finest, 2);
        // Bit for bit: no tolerance at all.
        check_level(&dataset, finest, &as_metres(&heights), width as usize, 0.0);
    }
}

#[test]
fn heights_without_a_sign_keep_their_upper_half() {
    for storage in [Storage::Deflate, Storage::DeflatedTiles] {
        let folder = tempfile::tempdir().unwrap();
        let (width, height) = (101_u32, 77);
        // Up to 65 534 m: what would be below zero with a sign.
        let heights: Vec<u16> = (0..width * height)
            .map(|index| if index % 53 == 0 { 65_535 } else { (index * 8 % 65_535) as u16 })
            .collect();
        let fixture = RasterFixture {
            nodata: Some("65535"),
            storage,
            ..RasterFixture::utm([width, height], ORIGIN, 30.0)
        };
        fixture.write_u16(&folder.path().join("dem.tif"), &heights).unwrap();
        let (dataset, _) = run(&request(folder.path(), &["dem.tif"]));
        let metres = |&height: &u16| if height == 65_535 { f64::NAN } else { f64::from(height) };
        let raster = heights.iter().map(metres).collect::<Vec<_>>();
        check_level(&dataset, 2, &raster, width as usize, 0.0);
    }
}

#[test]
fn floats_by_the_predictor_for_floats_are_kept_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let (width, height) = (101_u16, 77);
    let heights: Vec<f32> =
        (0..width * height).map(|i| 1500.0 - 1700.0 * (f32::from(i) * 0.0171).sin()).collect();
    let fixture = RasterFixture {
        storage: Storage::DeflatedTiles,
        ..RasterFixture::utm([u32::from(width), u32::from(height)], ORIGIN, 10.0)
    };
    fixture.write_f32(&folder.path().join("dem.tif"), &heights).unwrap();
    let mut request = request(folder.path(), &["dem.tif"]);
    request.height_encoding = HeightEncoding::Float;
    let (dataset, _) = run(&request);
    let raster: Vec<f64> = heights.iter().copied().map(f64::from).collect();
    check_level(&dataset, 2, &raster, usize::from(width), 0.0);
}

#[test]
fn coarser_levels_are_box_averages_to_within_half_a_step() {
    let folder = tempfile::tempdir().unwrap();
    let (width, height) = (150, 131);
    let heights = terrain(width, height, true);
    let fixture = RasterFixture {
        nodata: Some("-32768"),
        ..RasterFixture::utm([width, height], ORIGIN, 30.0)
    };
    fixture.write_i16(&folder.path().join("dem.tif"), &heights).unwrap();
    let (dataset, _) = run(&request(folder.path(), &["dem.tif"]));
    let step_m = f64::from(dataset.manifest().heights.step_m);
    let (mut raster, mut width) = (as_metres(&heights), width as usize);
    for level in (0..dataset.manifest().heights.layout.level_count).rev() {
        check_level(&dataset, level, &raster, width, 0.5 * step_m + 1e-3);
        (raster, width) = box_filter(&raster, width);
    }
}

#[test]
fn fewer_levels_keep_the_coarse_ones_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let heights = terrain(100, 90, false);
    let fixture = RasterFixture::utm([100, 90], ORIGIN, 30.0);
    fixture.write_i16(&folder.path().join("dem.tif"), &heights).unwrap();
    let mut request = request(folder.path(), &["dem.tif"]);
    let (whole, _) = run(&request);
    let root = whole.load_heights(TileId::ROOT).unwrap();
    assert_eq!(whole.heights_present().len(), 1 + 4 + 12);
    request.level_limit = Some(2);
    let (limited, _) = run(&request);
    assert_eq!(limited.heights_present().len(), 1 + 4);
    assert_eq!(limited.load_heights(TileId::ROOT).unwrap(), root);
}

#[test]
fn floats_lose_at_most_a_centimetre_or_nothing_where_asked() {
    let folder = tempfile::tempdir().unwrap();
    let heights: Vec<f32> =
        (0..90_u16 * 90).map(|i| 1500.0 + 700.0 * (f32::from(i) * 0.0171).sin()).collect();
    let fixture = RasterFixture::utm([90, 90], ORIGIN, 10.0);
    fixture.write_f32(&folder.path().join("dem.tif"), &heights).unwrap();
    let raster: Vec<f64> = heights.iter().copied().map(f64::from).collect();
    let mut request = request(folder.path(), &["dem.tif"]);
    let (dataset, _) = run(&request);
    check_level(&dataset, 2, &raster, 90, 0.01);
    request.height_encoding = HeightEncoding::Float;
    let (dataset, _) = run(&request);
    check_level(&dataset, 2, &raster, 90, 0.0);
    let root = dataset.load_heights(TileId::ROOT).unwrap().tile;
    assert!(matches!(root.samples, HeightSamples::Metres(_)));
}

#[test]
fn the_same_ground_cut_into_files_makes_the_same_dataset() {
    let folder = tempfile::tempdir().unwrap();
    let (width, height) = (100_u32, 80_u32);
    let heights = terrain(width, height, false);
    let whole = RasterFixture::utm([width, height], ORIGIN, 30.0);
    whole.write_i16(&folder.path().join("whole.tif"), &heights).unwrap();
    // Four parts that share a row and a column, given in any order.
    let parts =
        [("d", 60, 30, 40, 50), ("a", 0, 0, 61, 31), ("c", 0, 30, 61, 50), ("b", 60, 0, 40, 31)];
    for (name, left, top, w, h) in parts {
        let cells: Vec<i16> = (0..w * h)
            .map(|index| heights[((top + index / w) * width + left + index % w) as usize])
            .collect();
        let tie = [ORIGIN[0] + 30.0 * f64::from(left), ORIGIN[1] - 30.0 * f64::from(top)];
        let part = RasterFixture::utm([w, h], tie, 30.0);
        part.write_i16(&folder.path().join(format!("{name}.tif")), &cells).unwrap();
    }
    let read = |names: &[&str]| {
        let request = request(folder.path(), names);
        let (dataset, _) = run(&request);
        let scheme = dataset.manifest().scheme;
        (scheme, std::fs::read(request.out.join("heights.pmtiles")).unwrap())
    };
    assert_eq!(read(&["whole.tif"]), read(&["d.tif", "a.tif", "c.tif", "b.tif"]));
}

#[test]
fn point_registration_moves_the_ground_by_half_a_cell() {
    let folder = tempfile::tempdir().unwrap();
    let heights = terrain(40, 40, false);
    for (name, is_point) in [("area.tif", false), ("point.tif", true)] {
        let fixture = RasterFixture { is_point, ..RasterFixture::utm([40, 40], ORIGIN, 30.0) };
        fixture.write_i16(&folder.path().join(name), &heights).unwrap();
    }
    let (area, _) = run(&request(folder.path(), &["area.tif"]));
    let (area, area_extent) = (area.manifest().scheme.origin, area.manifest().data_extent);
    let (point, _) = run(&request(folder.path(), &["point.tif"]));
    assert_eq!(point.manifest().scheme.origin - area, dvec2(-15.0, 15.0));
    assert_eq!(point.manifest().data_extent.min - area_extent.min, dvec2(-15.0, 15.0));
}

#[test]
fn enclosed_gaps_are_filled_and_counted_and_outer_ones_stay() {
    let folder = tempfile::tempdir().unwrap();
    let (width, height) = (96_u32, 96_u32);
    let slope = |x: u32, y: u32| (10 * x + 3 * y) as i16;
    let heights: Vec<i16> = (0..width * height)
        .map(|index| {
            let (x, y) = (index % width, index / width);
            let inner = (40..52).contains(&x) && (50..58).contains(&y);
            let outer = x < 9 && y > 70;
            if inner || outer { NODATA } else { slope(x, y) }
        })
        .collect();
    let fixture = RasterFixture {
        nodata: Some("-32768"),
        ..RasterFixture::utm([width, height], ORIGIN, 30.0)
    };
    fixture.write_i16(&folder.path().join("dem.tif"), &heights).unwrap();
    let mut request = request(folder.path(), &["dem.tif"]);
    request.keep_voids = false;
    let (dataset, summary) = run(&request);
    assert_eq!((summary.voids.voids_filled, summary.voids.cells_filled), (1, 96));
    assert!(dataset.manifest().notes.iter().any(|note| note.contains("96 cells")));
    let filled: Vec<f64> = (0..width * height)
        .map(|index| {
            let (x, y) = (index % width, index / width);
            if x < 9 && y > 70 { f64::NAN } else { f64::from(slope(x, y)) }
        })
        .collect();
    // The fill meets a plane to within a few metres of its 120 m rise across the gap.
    check_level(&dataset, 2, &filled, width as usize, 6.0);
}

#[test]
fn degrees_are_brought_to_the_utm_zone_and_a_plane_stays_a_plane() {
    let folder = tempfile::tempdir().unwrap();
    // Heights that rise 10 m a hundredth of a degree north, around 8.5 E, 61.5 N.
    let (width, height, cell) = (120_u32, 110_u32, 0.002);
    let heights: Vec<f32> = (0..width * height)
        .map(|index| {
            let latitude = 61.6 - (f64::from(index / width) + 0.5) * cell;
            (1000.0 * (latitude - 61.0)) as f32
        })
        .collect();
    let fixture = RasterFixture {
        size: [width, height],
        tie: [8.4, 61.6],
        cell: [cell, cell],
        epsg: 4326,
        ..RasterFixture::utm([0, 0], ORIGIN, 1.0)
    };
    fixture.write_f32(&folder.path().join("dem.tif"), &heights).unwrap();
    let (dataset, _) = run(&request(folder.path(), &["dem.tif"]));
    let manifest = dataset.manifest();
    assert_eq!(manifest.crs.epsg, Some(32632));
    assert!(manifest.notes.iter().any(|note| note.contains("resampled")));

    // 8.5 E, 61.5 N, computed with PROJ 9.
    let place = dvec2(473_383.376, 6_818_583.756);
    let finest = manifest.heights.layout.finest_level();
    let id = manifest.scheme.tile_at(finest, place).unwrap();
    let tile = dataset.load_heights(id).unwrap().tile;
    let corner = manifest.heights.layout.stored_extent(&manifest.scheme, id);
    let texel_m = manifest.heights.layout.texel_size_m(&manifest.scheme, finest);
    let column = ((place.x - corner.min.x) / texel_m) as usize;
    let row = ((corner.max.y - place.y) / texel_m) as usize;
    let index = row * tile.stored_size_texels as usize + column;
    let height_m = f64::from(tile.samples.height_m(index).unwrap());
    // A texel is some 160 m, 1.4 m of height.
    assert!((height_m - 500.0).abs() < 1.0, "{height_m}");
}

#[test]
fn a_clear_value_of_a_grey_png_is_no_data() {
    let folder = tempfile::tempdir().unwrap();
    let texel =
        |x: u32, y: u32| image::LumaA([(1000 + x) as u16, if x == y { 0 } else { u16::MAX }]);
    let heights = image::ImageBuffer::<_, Vec<u16>>::from_fn(30, 30, texel);
    heights.save(folder.path().join("dem.png")).unwrap();
    std::fs::write(folder.path().join("dem.pgw"), "10\n0\n0\n-10\n432005\n6849995\n").unwrap();
    let request = PrepareRequest { epsg: Some(32632), ..request(folder.path(), &["dem.png"]) };
    let (dataset, _) = run(&request);
    let tile = dataset.load_heights(TileId::ROOT).unwrap().tile;
    let stored = tile.stored_size_texels as usize;
    for (row, column) in (0..30).flat_map(|row| (0..30).map(move |column| (row, column))) {
        let height_m = tile.samples.height_m((row + 4) * stored + column + 4);
        assert_eq!(height_m, (row != column).then_some(1000.0 + column as f32));
    }
}
