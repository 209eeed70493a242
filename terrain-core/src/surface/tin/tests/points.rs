//! TINs of points and heights between them.

use glam::dvec2;
use proptest::prelude::*;

use super::super::{
    Breakline, BreaklinePoint, DistinctPoints, NaturalNeighbours, TinError, tin_of_points,
    tin_of_points_within,
};
use super::{doubled_area, height_in_m, noise};

fn scattered(count: u64, height_m: impl Fn(f64, f64) -> f64) -> Vec<[f64; 3]> {
    (0..count)
        .map(|index| {
            let (x, y) =
                (1_839_000.0 + 90.0 * noise(index), 5_912_000.0 + 60.0 * noise(index + 7777));
            [x, y, height_m(x - 1_839_000.0, y - 5_912_000.0)]
        })
        .collect()
}

fn distinct(points: &[[f64; 3]]) -> DistinctPoints {
    DistinctPoints::new(points.to_vec()).unwrap()
}

#[test]
fn the_triangles_are_delaunays_and_cover_the_hull() {
    let points = distinct(&scattered(150, |x, y| x + y));
    let tin = tin_of_points(&points, &[]).unwrap();
    assert_eq!(tin.vertices.len(), 150);
    let mut area = 0.0;
    for triangle in &tin.triangles {
        let corners = triangle.map(|index| tin.vertices[index as usize]);
        area += 0.5 * doubled_area(corners);
        let origin = corners[0];
        let local = |point: [f64; 3]| [point[0] - origin[0], point[1] - origin[1]];
        let [b, c] = [local(corners[1]), local(corners[2])];
        // The circle through three points: centre by its equations, then everyone's distance.
        let (bb, cc) = (b[0] * b[0] + b[1] * b[1], c[0] * c[0] + c[1] * c[1]);
        let d = 2.0 * (b[0] * c[1] - b[1] * c[0]);
        let centre = [(c[1] * bb - b[1] * cc) / d, (b[0] * cc - c[0] * bb) / d];
        let radius = centre[0].hypot(centre[1]);
        for point in points.points() {
            let point = local(*point);
            let away = (point[0] - centre[0]).hypot(point[1] - centre[1]);
            assert!(away >= radius * (1.0 - 1e-6), "{away} in a circle of {radius}");
        }
    }
    let ground = NaturalNeighbours::new(&points).unwrap();
    assert!((area - ground.hull_area()).abs() < 1e-3, "{area}");
}

#[test]
fn of_points_at_one_place_the_median_stays_in_any_order() {
    let mut points =
        vec![[0.0, 0.0, 5.0], [4.0, 0.0, 1.0], [0.0, 0.0, 9.0], [0.0, 3.0, 2.0], [-0.0, 0.0, 7.0]];
    points.extend([[4.0, 0.0, 8.0]; 3]);
    let expected = [[0.0, 0.0, 7.0], [0.0, 3.0, 2.0], [4.0, 0.0, 8.0]];
    for _ in 0..points.len() {
        points.rotate_left(1);
        let found = distinct(&points);
        assert_eq!((found.points(), found.merged), (&expected[..], 5));
    }
}

#[test]
fn points_without_a_surface_are_refused() {
    let refused = |points: &[[f64; 3]]| {
        let points = distinct(points);
        let error = tin_of_points(&points, &[]).unwrap_err();
        assert_eq!(NaturalNeighbours::new(&points).err(), Some(error.clone()));
        error
    };
    assert_eq!(refused(&[]), TinError::TooFewPoints { count: 0 });
    assert_eq!(refused(&[[1.0, 2.0, 3.0]; 4]), TinError::TooFewPoints { count: 1 });
    let line: Vec<[f64; 3]> =
        (0..9).map(|index| [f64::from(index), 2.0 * f64::from(index), 1.0]).collect();
    assert_eq!(refused(&line), TinError::Collinear { count: 9 });
    for bad in
        [[f64::NAN, 0.0, 0.0], [0.0, f64::INFINITY, 0.0], [0.0, 0.0, f64::NAN], [1e300, 0.0, 0.0]]
    {
        let error = DistinctPoints::new(vec![[0.0; 3], bad]).unwrap_err();
        assert!(matches!(error, TinError::BadPoint { .. }), "{error}");
    }
}

#[test]
fn natural_neighbours_reproduce_planes_and_meet_points() {
    let plane = |x: f64, y: f64| 700.0 + 0.7 * x - 1.9 * y;
    let on_plane = distinct(&scattered(400, plane));
    let ground = NaturalNeighbours::new(&on_plane).unwrap();
    let mut sampler = ground.sampler();
    let mut inside = 0;
    for index in 0..3000 {
        let (x, y) = (-5.0 + 100.0 * noise(index + 50_000), -5.0 + 70.0 * noise(index + 90_000));
        let Some(height_m) = sampler.height_m(1_839_000.0 + x, 5_912_000.0 + y) else { continue };
        assert!((height_m - plane(x, y)).abs() < 1e-5, "{height_m} at {x}, {y}");
        inside += 1;
    }
    assert!((1500..2900).contains(&inside), "{inside} places inside");
    for &[x, y, height_m] in on_plane.points() {
        assert_eq!(sampler.height_m(x, y), Some(height_m));
    }
    assert_eq!(sampler.height_m(f64::NAN, 0.0), None);
    assert_eq!(sampler.height_m(1e300, 0.0), None);
}

/// Sibson's shares by counting: which of many small squares a new point's cell takes from whom.
#[test]
fn shares_are_those_of_stolen_ground() {
    let points = distinct(&scattered(30, |x, y| (0.1 * x).sin() * 100.0 + y * y * 0.05));
    let ground = NaturalNeighbours::new(&points).unwrap();
    for [x, y] in [[1_839_045.0, 5_912_030.0], [1_839_030.0, 5_912_040.0]] {
        let squared = |point: &[f64; 3], place: [f64; 2]| {
            (point[0] - place[0]).powi(2) + (point[1] - place[1]).powi(2)
        };
        let (mut taken, mut sum) = (0.0, 0.0);
        for index in 0..1_000_000_u32 {
            let place = [
                x - 40.0 + 0.08 * f64::from(index % 1000),
                y - 40.0 + 0.08 * f64::from(index / 1000),
            ];
            let owner = points
                .points()
                .iter()
                .min_by(|a, b| squared(a, place).total_cmp(&squared(b, place)))
                .unwrap();
            if squared(&[x, y, 0.0], place) < squared(owner, place) {
                taken += 1.0;
                sum += owner[2];
            }
        }
        let height_m = ground.sampler().height_m(x, y).unwrap();
        assert!((height_m - sum / taken).abs() < 0.3, "{height_m} {}", sum / taken);
    }
}

#[test]
fn breaklines_among_points() {
    let points = distinct(&scattered(200, |x, _| x));
    let point = |x: f64, y: f64, height_m| {
        let position = dvec2(1_839_000.0 + x, 5_912_000.0 + y);
        BreaklinePoint { position, height_m }
    };
    let lines = [
        Breakline { points: vec![point(20.0, 10.0, None), point(70.0, 50.0, None)] },
        Breakline { points: vec![point(20.0, 50.0, Some(500.0)), point(70.0, 10.0, Some(500.0))] },
    ];
    let tin = tin_of_points(&points, &lines).unwrap();
    // Four ends, and the crossing with the height of the later line.
    assert_eq!(tin.vertices.len(), 205);
    assert_eq!(tin.vertices.iter().filter(|vertex| (vertex[2] - 500.0).abs() < 1e-9).count(), 3);
    let off = [Breakline { points: vec![point(20.0, 10.0, None), point(900.0, 50.0, None)] }];
    let refused = tin_of_points(&points, &off);
    assert!(matches!(refused, Err(TinError::BreaklineWithoutHeight { .. })), "{refused:?}");
}

#[test]
fn thinned_points_keep_within_the_error() {
    let hills = |x: f64, y: f64| 300.0 + 20.0 * (0.1 * x).sin() * (0.13 * y).cos();
    let points = distinct(&scattered(1500, hills));
    let position = |x: f64, y: f64| dvec2(1_839_000.0 + x, 5_912_000.0 + y);
    let ridge = [[20.0, 10.0], [70.0, 50.0]]
        .map(|[x, y]| BreaklinePoint { position: position(x, y), height_m: None });
    let ridge = [Breakline { points: ridge.to_vec() }];
    let mut last = 1501;
    for (max_error_m, lines) in [(0.0, &[][..]), (0.5, &[]), (4.0, &[]), (4.0, &ridge)] {
        let (tin, largest_m) =
            tin_of_points_within(&points, max_error_m, lines, &mut |_, _| true).unwrap();
        assert!(largest_m <= max_error_m);
        let mut largest_seen_m = 0.0_f64;
        for &[x, y, height_m] in points.points() {
            let corners = |triangle: &[u32; 3]| triangle.map(|index| tin.vertices[index as usize]);
            let heights =
                tin.triangles.iter().filter_map(|triangle| height_in_m(corners(triangle), x, y));
            let nearest_m = heights.map(|over_m| (over_m - height_m).abs()).reduce(f64::min);
            largest_seen_m = largest_seen_m.max(nearest_m.expect("every point is covered"));
        }
        assert!((largest_seen_m - largest_m).abs() < 1e-6, "{largest_seen_m} {largest_m}");
        let count = tin.vertices.len();
        assert!(count < last || !lines.is_empty(), "{count} vertices for {max_error_m} m");
        last = count;
    }
    assert!(last < 300, "{last} of 1500 points for a fifth of the relief");
    let stopped = tin_of_points_within(
        &distinct(&scattered(9000, |x, y| noise((x * y) as u64))),
        0.0,
        &[],
        &mut |_, _| false,
    );
    assert_eq!(stopped, Err(TinError::Cancelled));
}

/// A coordinate of the awkward kinds.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => (0_i32..6).prop_map(f64::from),
        2 => -1.0e7..1.0e7,
        1 => prop::sample::select(vec![
            f64::NAN, f64::INFINITY, 1e300, -1e59, 1e59, 1e-300, -0.0, 1e-40, 0.1 + 0.2, 0.3,
        ]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    /// Duplicates, lines, not a number, much too far: an error or sound triangles, never a panic.
    #[test]
    fn any_points_make_triangles_or_a_clear_error(
        points in prop::collection::vec([coordinate(), coordinate(), coordinate()], 0..14),
        place in [coordinate(), coordinate()],
    ) {
        let finite = points.iter().flatten().all(|value| value.is_finite() && value.abs() < 1e60);
        let distinct = DistinctPoints::new(points);
        prop_assert_eq!(distinct.is_ok(), finite);
        let Ok(points) = distinct else { return Ok(()) };
        match tin_of_points(&points, &[]) {
            Ok(tin) => {
                prop_assert_eq!(tin.vertices.len(), points.points().len());
                let hull = 2 * tin.vertices.len() - 2 - tin.triangles.len();
                prop_assert!(hull >= 3, "by Euler's formula so many points lie on the hull");
                let ground = NaturalNeighbours::new(&points).unwrap();
                let height_m = ground.sampler().height_m(place[0], place[1]);
                let thinned = tin_of_points_within(&points, 2.0, &[], &mut |_, _| true);
                prop_assert!(thinned.unwrap().0.triangles.len() <= tin.triangles.len());
                prop_assert!(height_m.is_none_or(f64::is_finite));
            }
            Err(error) => prop_assert!(
                matches!(error, TinError::TooFewPoints { .. } | TinError::Collinear { .. }),
                "{error}"
            ),
        }
    }
}
