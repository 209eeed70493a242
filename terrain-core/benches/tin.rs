//! What TINs cost: time and triangles against the largest error, beside the coarsest regular grid that
//! keeps the same error; and points to a raster of their natural neighbours.
//!
//! Prints a JSON object a line before criterion measures. Real rasters and points are looked for in
//! `../shared/data` beside the repository; what is absent is left out, saying so.

#![allow(clippy::unwrap_used, reason = "a measurement that fails may stop")]
#![allow(clippy::print_stdout, reason = "a table is what this is for")]

use std::path::PathBuf;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec2, dvec2};
use terrain_core::prepare::source::{PointRaster, RasterSource, Window, open_raster, read_points};
use terrain_core::surface::tin::{SampleGrid, Tin, tin_of_grid};

struct Heights {
    name: &'static str,
    columns: usize,
    rows: usize,
    heights_m: Vec<f32>,
}

impl Heights {
    fn grid(&self) -> SampleGrid<'_> {
        SampleGrid {
            columns: self.columns,
            rows: self.rows,
            heights_m: &self.heights_m,
            first: DVec2::ZERO,
            step: DVec2::ONE,
        }
    }

    fn tin(&self, max_error_m: f64) -> Tin {
        tin_of_grid(&self.grid(), max_error_m, &[], &mut |_, _| true).unwrap()
    }
}

fn data(file: &str) -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data").join(file);
    let found = path.exists();
    if !found {
        println!("{file} is not there and left out");
    }
    found.then_some(path)
}

fn raster(name: &'static str, file: &str) -> Option<Heights> {
    let source = open_raster(&data(file)?).unwrap();
    let [width, height] = source.info().size;
    let window = Window { column: 0, row: 0, width, height };
    let heights_m = source.read_heights(window).unwrap();
    Some(Heights { name, columns: width as usize, rows: height as usize, heights_m })
}

/// The same ground with `side` samples a side, bilinear, with 2 m of noise so that it is no smoother.
fn finer(name: &'static str, from: &Heights, side: usize) -> Heights {
    let step = dvec2((from.columns - 1) as f64, (from.rows - 1) as f64) / (side - 1) as f64;
    let heights = (0..side * side).map(|index| {
        let place = dvec2((index % side) as f64, (index / side) as f64) * step;
        let corner = place.floor().min(dvec2((from.columns - 2) as f64, (from.rows - 2) as f64));
        let part = place - corner;
        let first = corner.y as usize * from.columns + corner.x as usize;
        let at = |offset: usize| f64::from(from.heights_m[first + offset]);
        let mix = |a: f64, b: f64, part: f64| a + (b - a) * part;
        let north = mix(at(0), at(1), part.x);
        let south = mix(at(from.columns), at(from.columns + 1), part.x);
        let noise = f64::from((index as u32).wrapping_mul(2_654_435_761) >> 16) / 65_536.0;
        (mix(north, south, part.y) + 2.0 * noise) as f32
    });
    Heights { name, columns: side, rows: side, heights_m: heights.collect() }
}

/// Triangles of the coarsest regular grid of samples whose error is no larger.
fn regular_triangles(heights: &Heights, max_error_m: f64) -> usize {
    (1..=64)
        .rev()
        .map(|every| regular(heights, every))
        .find(|tin| heights.grid().largest_error_m(tin) <= max_error_m)
        .map_or(0, |tin| tin.triangles.len())
}

/// Every so manieth sample and the last ones, two triangles a cell; none over gaps.
fn regular(heights: &Heights, every: usize) -> Tin {
    let lines =
        |count: usize| -> Vec<usize> { (0..count - 1).step_by(every).chain([count - 1]).collect() };
    let (columns, rows) = (lines(heights.columns), lines(heights.rows));
    let mut tin = Tin::default();
    for &row in &rows {
        for &column in &columns {
            let height_m = f64::from(heights.heights_m[row * heights.columns + column]);
            tin.vertices.push([column as f64, -(row as f64), height_m]);
        }
    }
    for row in 0..rows.len() - 1 {
        for column in 0..columns.len() - 1 {
            let north = (row * columns.len() + column) as u32;
            let south = north + columns.len() as u32;
            tin.triangles.push([north, south, south + 1]);
            tin.triangles.push([north, south + 1, north + 1]);
        }
    }
    tin
}

fn triangulate(criterion: &mut Criterion) {
    let mut rasters: Vec<Heights> = [
        ("rmnp 152 x 187, 231 m", "rmnp-dem.tif"),
        ("jotunheimen 512 x 512, 117 m", "jotunheimen_dem_512.tif"),
    ]
    .into_iter()
    .filter_map(|(name, file)| raster(name, file))
    .collect();
    if let Some(jotunheimen) = rasters.get(1) {
        rasters.push(finer("jotunheimen made 2048 x 2048", jotunheimen, 2048));
    }
    let mut group = criterion.benchmark_group("tin");
    group.sample_size(10).warm_up_time(Duration::from_millis(500));
    group.measurement_time(Duration::from_secs(3));
    for heights in &rasters {
        for max_error_m in [50.0, 20.0, 10.0, 5.0] {
            let (name, tin) = (heights.name, heights.tin(max_error_m));
            let largest_m = heights.grid().largest_error_m(&tin);
            let triangles = tin.triangles.len();
            let regular = regular_triangles(heights, max_error_m);
            let ratio = regular as f64 / triangles as f64;
            println!(
                "{{\"ground\": \"{name}\", \"max_error_m\": {max_error_m}, \"largest_error_m\": \
                 {largest_m:.3}, \"triangles\": {triangles}, \"regular_grid_triangles\": {regular}, \
                 \"ratio\": {ratio:.2}}}"
            );
            group.throughput(Throughput::Elements(heights.heights_m.len() as u64));
            group.bench_function(format!("{name}, {max_error_m} m"), |bencher| {
                bencher.iter(|| heights.tin(max_error_m));
            });
        }
    }
    group.finish();
}

fn points(criterion: &mut Criterion) {
    let Some(path) = data("coromandel_nz_lidar_584k.laz") else { return };
    let mut group = criterion.benchmark_group("points");
    group.sample_size(10).measurement_time(Duration::from_secs(5));
    let classes = [2, 3, 4, 5];
    group.bench_function("584k of LAZ, read", |bencher| {
        bencher.iter(|| read_points(&path, &classes).unwrap());
    });
    let cloud = read_points(&path, &classes).unwrap();
    group.throughput(Throughput::Elements(cloud.points.len() as u64));
    group.bench_function("584k triangulated and as many cells of natural neighbours", |bencher| {
        bencher.iter(|| {
            let raster = PointRaster::new(vec![cloud.clone()], 2193, None).unwrap();
            let [width, height] = raster.info().size;
            raster.read_heights(Window { column: 0, row: 0, width, height }).unwrap()
        });
    });
    group.finish();
}

criterion_group!(benches, triangulate, points);
criterion_main!(benches);
