//! TINs of rasters, held against every sample by arithmetic of their own.

use glam::{DVec2, dvec2};
use proptest::prelude::*;

use super::super::{Breakline, BreaklinePoint, SampleGrid, Tin, TinError, tin_of_grid};
use super::{doubled_area, height_in_m, noise};

/// Where the grids of these tests lie: far from 0, with cells that are not square.
const FIRST: DVec2 = dvec2(1_839_000.25, 5_912_000.5);
const STEP: DVec2 = dvec2(2.0, 3.0);

fn grid(columns: usize, heights_m: &[f32]) -> SampleGrid<'_> {
    let rows = heights_m.len() / columns;
    SampleGrid { columns, rows, heights_m, first: FIRST, step: STEP }
}

fn tin(grid: &SampleGrid<'_>, max_error_m: f64, breaklines: &[Breakline]) -> Tin {
    tin_of_grid(grid, max_error_m, breaklines, &mut |_, _| true).unwrap()
}

fn hills(columns: usize, rows: usize, is_void: impl Fn(usize, usize) -> bool) -> Vec<f32> {
    (0..columns * rows)
        .map(|index| {
            let (column, row) = (index % columns, index / columns);
            let (x, y) = (column as f64, row as f64);
            let wave = 80.0 * (0.21 * x).sin() * (0.17 * y + 0.02 * x).cos();
            let height_m = 900.0 + wave + 8.0 * noise(index as u64);
            if is_void(column, row) { f32::NAN } else { height_m as f32 }
        })
        .collect()
}

/// Looks at every sample and every cell: those of cells that hold data are covered once, within the
/// error; nothing else is covered.
fn check(grid: &SampleGrid<'_>, tin: &Tin, max_error_m: f64) {
    let held = |column: usize, row: usize| !grid.heights_m[row * grid.columns + column].is_nan();
    let mut wanted = vec![false; grid.heights_m.len()];
    let mut cells = 0;
    for row in 0..grid.rows - 1 {
        for column in 0..grid.columns - 1 {
            let corners = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| [column + x, row + y]);
            if corners.iter().all(|corner| held(corner[0], corner[1])) {
                cells += 1;
                corners.iter().for_each(|[x, y]| wanted[y * grid.columns + x] = true);
            }
        }
    }
    let mut met = vec![false; wanted.len()];
    let mut area = 0.0;
    for triangle in &tin.triangles {
        let corners = triangle.map(|index| tin.vertices[index as usize]);
        // In samples from the first one, rows southwards.
        let corners = corners.map(|[x, y, z]| [(x - FIRST.x) / STEP.x, (y - FIRST.y) / STEP.y, z]);
        let own = doubled_area(corners);
        assert!(own > 0.0, "{corners:?} does not turn left");
        area += 0.5 * own;
        let axis = |axis: usize| corners.map(|corner| corner[axis]);
        let low = |values: [f64; 3]| values.into_iter().fold(f64::INFINITY, f64::min).floor();
        let high = |values: [f64; 3]| values.into_iter().fold(f64::NEG_INFINITY, f64::max).ceil();
        for row in -high(axis(1)) as usize..=-low(axis(1)) as usize {
            for column in low(axis(0)) as usize..=high(axis(0)) as usize {
                let Some(height_m) = height_in_m(corners, column as f64, -(row as f64)) else {
                    continue;
                };
                let sample = row * grid.columns + column;
                let error_m = (height_m - f64::from(grid.heights_m[sample])).abs();
                assert!(error_m <= max_error_m + 1e-6, "{error_m} m at {column}, {row}");
                met[sample] = true;
            }
        }
    }
    assert!((area - f64::from(cells)).abs() < 1e-6 * f64::from(cells), "{area} of {cells} cells");
    assert_eq!(met, wanted);
}

fn line(points: &[[f64; 2]], height_m: Option<f64>) -> Breakline {
    let point = |place: &[f64; 2]| {
        let position = FIRST + dvec2(place[0], -place[1]) * STEP;
        BreaklinePoint { position, height_m }
    };
    Breakline { points: points.iter().map(point).collect() }
}

#[test]
fn every_sample_is_within_the_error_and_a_larger_error_takes_fewer_triangles() {
    let heights_m = hills(61, 47, |_, _| false);
    let grid = grid(61, &heights_m);
    let mut last = usize::MAX;
    for max_error_m in [0.0, 1.0, 5.0, 20.0] {
        let tin = tin(&grid, max_error_m, &[]);
        check(&grid, &tin, max_error_m);
        assert!(tin.triangles.len() < last, "{max_error_m} m");
        last = tin.triangles.len();
    }
    // A regular grid with this error has every sample: noise is 8 m.
    assert!(last < 60 * 46 * 2 / 10, "{last} triangles");
}

#[test]
fn a_plane_is_two_triangles() {
    let heights_m: Vec<f32> =
        (0..40 * 30).map(|index| (2 * (index % 40) + 3 * (index / 40)) as f32).collect();
    let grid = grid(40, &heights_m);
    let tin = tin(&grid, 1e-9, &[]);
    assert_eq!((tin.vertices.len(), tin.triangles.len()), (4, 2));
    check(&grid, &tin, 1e-9);
    assert_eq!(tin.bounds()[0], [FIRST.x, FIRST.y - 29.0 * STEP.y, 0.0]);
}

#[test]
fn nothing_covers_voids() {
    let holes = |x: usize, y: usize| {
        let pond = (x as f64 - 20.0).hypot(y as f64 - 15.0) < 6.5;
        // Voids that touch at corners, at the border, and one that leaves a sample alone.
        pond || x < 3 && y > 30 || (x + y).is_multiple_of(2) && x > 40 && y < 9 || x == 50
    };
    let heights_m = hills(55, 40, holes);
    let grid = grid(55, &heights_m);
    for max_error_m in [0.5, 15.0] {
        check(&grid, &tin(&grid, max_error_m, &[]), max_error_m);
    }
}

#[test]
fn breaklines_become_edges() {
    let heights_m = hills(50, 40, |x, y| (30..36).contains(&x) && (10..20).contains(&y));
    let grid = grid(50, &heights_m);
    // Two that cross, one of them over a void and off the raster, and one with a height of its own.
    let lines = [
        line(&[[5.3, 7.1], [44.7, 31.9]], None),
        line(&[[20.5, 44.0], [33.0, 12.0], [60.0, 12.0]], None),
        line(&[[3.5, 30.5], [11.5, 36.5]], Some(1500.0)),
    ];
    let tin = tin(&grid, 10.0, &lines);
    check(&grid, &tin, 10.0);
    let places: Vec<DVec2> = tin
        .vertices
        .iter()
        .map(|vertex| (dvec2(vertex[0], vertex[1]) - FIRST) / STEP * dvec2(1.0, -1.0))
        .collect();
    // No triangle reaches across the first line.
    let (from, way) = (dvec2(5.3, 7.1), dvec2(39.4, 24.8));
    let side = |place: DVec2| way.perp_dot(place - from) / way.length();
    for triangle in &tin.triangles {
        let corners = triangle.map(|index| places[index as usize]);
        let across = corners.map(side);
        let parts = corners.map(|place| way.dot(place - from) / way.length_squared());
        let beside = parts.iter().all(|part| (0.0..1.0).contains(part));
        let crosses =
            across.iter().any(|side| *side > 1e-6) && across.iter().any(|side| *side < -1e-6);
        assert!(!(beside && crosses), "{corners:?}");
    }
    assert!(tin.vertices.iter().any(|vertex| vertex[2] == 1500.0));
    let elsewhere = [line(&[[-9.0, 0.0], [-3.0, 5.0]], None)];
    let refused = tin_of_grid(&grid, 10.0, &elsewhere, &mut |_, _| true);
    assert_eq!(refused, Err(TinError::BreaklinesElsewhere));
}

#[test]
fn what_has_no_surface_is_refused() {
    let refused = |columns: usize, heights_m: &[f32], max_error_m: f64| {
        tin_of_grid(&grid(columns, heights_m), max_error_m, &[], &mut |_, _| true).unwrap_err()
    };
    assert!(matches!(refused(5, &[1.0; 5], 1.0), TinError::TooFewSamples { rows: 1, .. }));
    assert!(matches!(refused(1, &[1.0; 5], 1.0), TinError::TooFewSamples { columns: 1, .. }));
    assert_eq!(refused(3, &[f32::NAN; 9], 1.0), TinError::NoData);
    for max_error_m in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(refused(2, &[1.0; 4], max_error_m), TinError::MaxError(_)));
    }
    let heights_m = hills(120, 120, |_, _| false);
    let stopped = tin_of_grid(&grid(120, &heights_m), 0.1, &[], &mut |_, _| false);
    assert_eq!(stopped, Err(TinError::Cancelled));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// Any small raster, with gaps and lines anywhere: the error is kept and only cells with data are
    /// covered.
    #[test]
    fn any_grid_keeps_its_error(
        columns in 2_usize..12,
        rows in 2_usize..12,
        seed in 0_u64..1 << 40,
        voids in 0.0_f64..0.4,
        max_error_m in 0.0_f64..60.0,
        lines in prop::collection::vec(
            prop::collection::vec((-20_i32..260, -20_i32..260), 2..5), 0..4),
    ) {
        let heights_m: Vec<f32> = (0..(columns * rows) as u64)
            .map(|index| match noise(seed ^ index.rotate_left(48)) < voids {
                true => f32::NAN,
                false => (100.0 * noise(seed.wrapping_add(index))) as f32,
            })
            .collect();
        let grid = grid(columns, &heights_m);
        // Steps of a twentieth: crossings, overlaps and places on samples all come up.
        let place = |&(x, y): &(i32, i32)| [f64::from(x) / 20.0, f64::from(y) / 20.0];
        let lines: Vec<Breakline> = lines
            .iter()
            .map(|points| line(&points.iter().map(place).collect::<Vec<_>>(), None))
            .collect();
        match tin_of_grid(&grid, max_error_m, &lines, &mut |_, _| true) {
            Ok(tin) => check(&grid, &tin, max_error_m),
            Err(error) => prop_assert!(
                matches!(error, TinError::NoData | TinError::BreaklinesElsewhere), "{error}"),
        }
    }
}
