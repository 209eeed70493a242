//! Points through the whole of preparing and into TINs, against arithmetic by hand.

#![expect(clippy::unwrap_used, reason = "a case fails by panicking")]

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use glam::{DVec2, dvec2};
use terrain_core::dataset::{Dataset, HeightEncoding, TileSource};
use terrain_core::geodesy::{CoordinateSystem, CoordinateTransform};
use terrain_core::prepare::source::read_points;
use terrain_core::prepare::{
    NoProgress, PointOptions, PrepareError, PrepareRequest, TinRequest, make_tin, prepare,
};
use terrain_core::tiling::TileId;
use terrain_tests::RasterFixture;

const CORNER: DVec2 = dvec2(432_000.0, 6_790_000.0);

fn plane(position: DVec2) -> f64 {
    let local = position - CORNER;
    500.0 + 0.2 * local.x - 0.1 * local.y
}

/// Places over 1000 m by 800 m in no order, the corners among them.
fn places() -> Vec<DVec2> {
    let inner = (0..2000_u32).map(|index| {
        let part =
            |factor: u32| f64::from(index.wrapping_mul(factor) >> 8) / f64::from(1_u32 << 24);
        CORNER + dvec2(1000.0 * part(2_654_435_761), 800.0 * part(1_597_334_677))
    });
    let corners = [[0.0, 0.0], [1000.0, 0.0], [0.0, 800.0], [1000.0, 800.0]];
    inner.chain(corners.map(|corner| CORNER + DVec2::from(corner))).collect()
}

fn write_points(path: &Path, points: impl Iterator<Item = (DVec2, f64)>) {
    let lines = points.map(|(place, height_m)| format!("{},{},{height_m}\n", place.x, place.y));
    std::fs::write(path, lines.collect::<String>()).unwrap();
}

fn request(folder: &Path, names: &[&str]) -> PrepareRequest {
    let paths = names.iter().map(|name| folder.join(name)).collect::<Vec<PathBuf>>();
    PrepareRequest {
        epsg: Some(32632),
        height_encoding: HeightEncoding::Float,
        points: PointOptions { spacing_m: Some(10.0), ..PointOptions::default() },
        ..PrepareRequest::new(paths, Vec::new(), folder.join("out"))
    }
}

/// Every sample of the finest level: where it lies, and its height.
fn finest(dataset: &Dataset) -> Vec<(DVec2, f64)> {
    let manifest = dataset.manifest();
    let layout = manifest.heights.layout;
    let level = layout.level_count - 1;
    let (size, gutter) = (layout.tile_size_texels as usize, layout.gutter_texels as usize);
    let texel_m = manifest.scheme.tile_size_m(level) / size as f64;
    let mut samples = Vec::new();
    for row in 0..1_u32 << level {
        for column in 0..1_u32 << level {
            let id = TileId::new(level, row, column);
            if !dataset.heights_present().contains(id) {
                continue;
            }
            let tile = dataset.load_heights(id).unwrap().tile;
            for (y, x) in (0..size).flat_map(|y| (0..size).map(move |x| (y, x))) {
                let index = (y + gutter) * tile.stored_size_texels as usize + x + gutter;
                let Some(height_m) = tile.samples.height_m(index) else { continue };
                let texels = dvec2(
                    (column as usize * size + x) as f64 + 0.5,
                    (row as usize * size + y) as f64 + 0.5,
                );
                let place = manifest.scheme.origin + dvec2(texels.x, -texels.y) * texel_m;
                samples.push((place, f64::from(height_m)));
            }
        }
    }
    samples
}

/// Prepares, and holds every sample against the plane; returns how many hold data.
fn check_plane(request: &PrepareRequest, tolerance_m: f64) -> usize {
    prepare(request, &NoProgress, &AtomicBool::new(false)).unwrap();
    let dataset = Dataset::open(&request.out).unwrap();
    assert_eq!(dataset.manifest().crs.epsg, Some(32632));
    let samples = finest(&dataset);
    for (place, height_m) in &samples {
        let expected_m = plane(*place);
        let error_m = (height_m - expected_m).abs();
        assert!(error_m < tolerance_m, "{height_m} {expected_m} at {place}");
    }
    samples.len()
}

#[test]
fn points_on_a_plane_become_that_plane() {
    let folder = tempfile::tempdir().unwrap();
    let points = places().into_iter().map(|place| (place, plane(place)));
    write_points(&folder.path().join("all.csv"), points);
    assert_eq!(check_plane(&request(folder.path(), &["all.csv"]), 1e-3), 100 * 80);
}

#[test]
fn files_that_adjoin_leave_no_gap_between_them() {
    let folder = tempfile::tempdir().unwrap();
    let split = CORNER.x + 431.0;
    for (name, is_west) in [("west.xyz", true), ("east.xyz", false)] {
        let mine = places().into_iter().filter(|place| (place.x < split) == is_west);
        write_points(&folder.path().join(name), mine.map(|place| (place, plane(place))));
    }
    assert_eq!(check_plane(&request(folder.path(), &["west.xyz", "east.xyz"]), 1e-3), 100 * 80);
}

#[test]
fn points_in_degrees_are_brought_to_metres_before_they_are_joined() {
    let folder = tempfile::tempdir().unwrap();
    let [utm, degrees] = [32632, 4326].map(|epsg| CoordinateSystem::from_epsg(epsg).unwrap());
    let to_degrees = CoordinateTransform::new(&utm, &degrees);
    let points = places().into_iter().map(|place| (to_degrees.apply(place).unwrap(), plane(place)));
    write_points(&folder.path().join("degrees.csv"), points);
    let mut request = request(folder.path(), &["degrees.csv"]);
    request.points.epsg = Some(4326);
    // The way there and back moves points by less than a millimetre, and some off the hull's edge.
    assert!(check_plane(&request, 1e-2) > 99 * 79);
    request.points.epsg = None;
    let error = prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap_err().to_string();
    // Degrees taken for metres lie within a metre of each other.
    assert!(error.contains("degrees.csv") || error.contains("no data"), "{error}");
}

#[test]
fn points_fill_what_a_raster_before_them_leaves_open() {
    let folder = tempfile::tempdir().unwrap();
    let north_west = [CORNER.x, CORNER.y + 800.0];
    let fixture =
        RasterFixture { nodata: Some("-1"), ..RasterFixture::utm([100, 80], north_west, 10.0) };
    // The western half of the raster holds 7 m.
    let heights: Vec<f32> =
        (0..8000).map(|index| if index % 100 < 50 { 7.0 } else { -1.0 }).collect();
    fixture.write_f32(&folder.path().join("dem.tif"), &heights).unwrap();
    write_points(&folder.path().join("all.csv"), places().into_iter().map(|place| (place, 30.0)));
    let request = request(folder.path(), &["dem.tif", "all.csv"]);
    prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap();
    let samples = finest(&Dataset::open(&request.out).unwrap());
    assert_eq!(samples.len(), 8000);
    for (place, height_m) in samples {
        let expected_m = if place.x < CORNER.x + 500.0 { 7.0 } else { 30.0 };
        assert!((height_m - expected_m).abs() < 1e-4, "{height_m} at {place}");
    }
}

#[test]
fn what_makes_no_surface_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let cases = [
        ("line.csv", "1,1,5\n2,2,5\n3,3,5\n", "all 3 points lie on one line"),
        ("one.csv", "1,1,5\n1,1,6\n1,1,5\n", "there are 1"),
        ("none.csv", "x,y,z\n", "holds no points"),
        ("nan.csv", "1,1,5\n2,nan,5\n", "line 2"),
        ("far.csv", "1,1,5\n1e300,2,5\n3,1e250,5\n", "too far away"),
        ("wide.csv", "1,1,5\n9e8,2,5\n3,9e8,5\n", "--point-spacing"),
    ];
    for (name, text, cause) in cases {
        std::fs::write(folder.path().join(name), text).unwrap();
        let request = request(folder.path(), &[name]);
        let error =
            prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(cause), "{error}");
        assert!(!request.out.exists());
    }
    let mut request = request(folder.path(), &["line.csv"]);
    request.epsg = None;
    let error = prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap_err().to_string();
    assert!(error.contains("--point-crs"), "{error}");
}

#[test]
fn a_tin_of_a_raster_keeps_its_place_and_its_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dem.tif");
    let heights: Vec<f32> =
        (0..40 * 30).map(|index| ((index % 40) as f32 * 0.4).sin() * 50.0).collect();
    RasterFixture::utm([40, 30], [432_000.0, 6_850_000.0], 20.0)
        .write_f32(&path, &heights)
        .unwrap();
    let request =
        TinRequest { ground: vec![path.clone()], max_error_m: Some(2.0), ..TinRequest::default() };
    let made = make_tin(&request, &NoProgress, &AtomicBool::new(false)).unwrap();
    let [min, max] = made.tin.bounds();
    // Samples are the cells' centres; texture coordinates span the cells.
    assert_eq!([min[0], max[1]], [432_010.0, 6_849_990.0]);
    assert_eq!(made.place.extent.max, dvec2(432_800.0, 6_850_000.0));
    assert!(made.largest_error_m <= 2.0 && made.largest_error_m > 0.0);
    for vertex in &made.tin.vertices {
        let column = ((vertex[0] - 432_010.0) / 20.0).round();
        assert!((vertex[2] - f64::from((column as f32 * 0.4).sin() * 50.0)).abs() < 1e-4);
    }
    let without = TinRequest { max_error_m: None, ..request.clone() };
    let stop = AtomicBool::new(false);
    assert!(matches!(make_tin(&without, &NoProgress, &stop), Err(PrepareError::Request(_))));
    let cancelled = make_tin(&request, &NoProgress, &AtomicBool::new(true));
    assert!(matches!(cancelled, Err(PrepareError::Cancelled)));
}

/// The lidar's ground as a raster, held against its own points.
#[test]
fn real_lidar_becomes_ground() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../../shared/data/coromandel_nz_lidar_584k.laz");
    if !path.exists() {
        println!("skipped: {} is not there", path.display());
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let request = PrepareRequest::new(vec![path.clone()], Vec::new(), folder.path().join("out"));
    prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap();
    let dataset = Dataset::open(&request.out).unwrap();
    let manifest = dataset.manifest();
    assert_eq!(manifest.crs.epsg, Some(2193));
    assert!(
        manifest.notes.iter().any(|note| note.contains("9904 of 584348")),
        "{:?}",
        manifest.notes
    );
    let range = manifest.heights.range;
    assert!(range.min_m > 765.0 && range.max_m < 850.0, "{range:?}");
    let samples = finest(&dataset);
    assert!(samples.len() > 7000, "{} samples", samples.len());
    let points = read_points(&path, &[2]).unwrap().points;
    // Close to a sample the points are close in height: within 45 degrees of slope and a little.
    for (place, height_m) in samples.iter().step_by(97) {
        let away = |point: &[f64; 3]| place.distance(dvec2(point[0], point[1]));
        let nearest = points.iter().min_by(|a, b| away(a).total_cmp(&away(b))).unwrap();
        let error_m = (nearest[2] - height_m).abs();
        assert!(error_m < 2.0 + 1.5 * away(nearest), "{error_m} m at {place}");
    }
}
