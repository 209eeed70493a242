//! Single rays: where they meet the surface, and that none slips through.

use std::sync::Arc;

use glam::{DVec2, DVec3, dvec2, dvec3};
use proptest::prelude::*;

use super::raster_source::RasterSource;
use super::{Case, ORIGIN, TEXEL_M, bumpy_m, down};
use crate::reference::{ReferenceError, ReferenceScene};
use crate::tiling::{TileId, TileSet};

/// The first descent of the ray through the surface by small steps and bisection, heights straight
/// from the raster; `None` where there is none within `reach_m`.
fn marched_m(case: &Case, origin: DVec3, direction: DVec3, reach_m: f64) -> Option<f64> {
    const STEPS: usize = 8_000;
    let above = |t: f64| {
        let point = origin + t * direction;
        case.height_m(point.truncate()).map(|height_m| point.z - height_m)
    };
    let at = |step: usize| reach_m * step as f64 / STEPS as f64;
    let step = (0..STEPS).find(|&step| {
        let (Some(now), Some(next)) = (above(at(step)), above(at(step + 1))) else { return false };
        now >= 0.0 && next < 0.0
    })?;
    let (mut from, mut to) = (at(step), at(step + 1));
    for _ in 0..60 {
        let middle = 0.5 * (from + to);
        if above(middle).is_some_and(|above| above >= 0.0) { from = middle } else { to = middle }
    }
    Some(to)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn a_ray_meets_the_surface_where_small_steps_do(
        seed in any::<u32>(), voids in any::<bool>(),
        from in (0.0..37.0_f64, 0.0..29.0_f64), to in (0.0..37.0_f64, 0.0..29.0_f64),
        heights in (0.0..90.0_f64, -20.0..60.0_f64),
    ) {
        let case = Case::bumpy(37, 29, seed, 60.0, voids);
        let start = case.world(DVec2::from(from)).extend(heights.0);
        let end = case.world(DVec2::from(to)).extend(heights.1);
        prop_assume!(start.distance(end) > 1.0);
        let direction = (end - start).normalize();
        let marched = marched_m(&case, start, direction, start.distance(end));
        let hit = case.scene.first_hit(start, direction, 1.0);
        if let Some(distance_m) = marched {
            let hit = hit.expect("small steps find a hit");
            // Steps may jump over a bump that the ray just touches: then the hit is nearer.
            prop_assert!(hit.distance_m <= distance_m + 1e-6, "{} {distance_m}", hit.distance_m);
        }
        if let Some(hit) = hit {
            let on_map = hit.point.truncate();
            let height_m = case.height_m(on_map).or_else(|| {
                // On the very border of a void rounding may tell either way.
                let inwards = (case.world(DVec2::from(from)) - on_map).normalize_or_zero();
                case.height_m(on_map + 1e-6 * inwards)
            });
            let height_m = height_m.expect("a hit lies where there is ground");
            prop_assert!((hit.point.z - height_m).abs() < 1e-4, "{} {height_m}", hit.point.z);
            prop_assert!((hit.point - (start + hit.distance_m * direction)).length() < 1e-8);
            // And it was above just before.
            let before = start + (hit.distance_m - 1e-5) * direction;
            if let Some(height_m) = case.height_m(before.truncate()) {
                prop_assert!(before.z >= height_m - 1e-7);
            }
        }
    }

    #[test]
    fn heights_are_those_of_the_raster(
        seed in any::<u32>(), voids in any::<bool>(),
        place in (-3.0..40.0_f64, -3.0..32.0_f64),
    ) {
        let case = Case::bumpy(37, 29, seed, 60.0, voids);
        let point = case.world(DVec2::from(place));
        let is_inside = (0.0..=37.0).contains(&place.0) && (0.0..=29.0).contains(&place.1);
        let expected = case.height_m(point).filter(|_| is_inside);
        let found = case.scene.height_m(point);
        prop_assert_eq!(found.is_some(), expected.is_some());
        let difference = found.zip(expected).map_or(0.0, |(a, b)| (a - b).abs());
        prop_assert!(difference < 1e-7, "{:?} {:?}", found, expected);
    }
}

/// Places that are exactly on nodes, lines between cells, and borders of tiles.
fn special_places(width: usize, height: usize) -> impl Iterator<Item = DVec2> {
    (0..=4 * height).flat_map(move |row| {
        (0..=4 * width).map(move |column| dvec2(column as f64, row as f64) * 0.25)
    })
}

#[test]
fn no_vertical_ray_slips_through_nodes_lines_or_borders() {
    let case = Case::bumpy(37, 29, 5, 60.0, false);
    for place in special_places(37, 29) {
        let point = case.world(place);
        let hit = case.scene.first_hit(point.extend(500.0), down(), 1.0);
        let hit = hit.unwrap_or_else(|| panic!("slipped through at {place}"));
        let height_m = case.height_m(point).unwrap();
        assert!((hit.point.z - height_m).abs() < 1e-7, "{place}: {} {height_m}", hit.point.z);
        // From below it is not seen.
        assert_eq!(case.scene.first_hit(point.extend(-100.0), DVec3::Z, 1.0), None);
    }
}

#[test]
fn no_slanted_ray_slips_through_nodes_lines_or_borders() {
    let case = Case::bumpy(37, 29, 6, 30.0, false);
    let slants = [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [-1.0, 1.0], [0.5, -1.0], [-1.0, 0.0]];
    let inside = |place: &DVec2| place.min_element() > 0.0 && place.x < 37.0 && place.y < 29.0;
    for place in special_places(37, 29).filter(inside).step_by(7) {
        for slant in slants {
            // Steeper than any ground: the only hit is where the ray is aimed, if it stays within.
            let direction = dvec3(slant[0], slant[1], -8.0);
            let target = case.world(place).extend(case.height_m(case.world(place)).unwrap());
            let origin = target - direction * 12.0;
            let within = |point: DVec3| case.scene.height_m(point.truncate()).is_some();
            if !within(origin) {
                continue;
            }
            let hit = case.scene.first_hit(origin, direction, 1.0);
            let hit = hit.unwrap_or_else(|| panic!("slipped through at {place} going {slant:?}"));
            assert!((hit.point - target).length() < 1e-6, "{place} {slant:?}: {}", hit.point);
        }
    }
}

#[test]
fn rays_along_lines_of_the_grid_meet_the_line_between_samples() {
    let case = Case::bumpy(37, 29, 7, 60.0, false);
    // Along a row of samples, a line between texels, a border of tiles, and the data's own edge.
    for row in [3.5, 5.0, 8.0, 16.0, 0.0, 29.0] {
        for height_m in [15.0, 30.0, 45.0] {
            let origin = case.world(dvec2(0.25, row)).extend(height_m + 30.0);
            let direction = dvec3(1.0, 0.0, -0.2).normalize();
            let hit = case.scene.first_hit(origin, direction, 1.0).unwrap();
            let expected = marched_m(&case, origin, direction, 400.0).unwrap();
            assert!((hit.distance_m - expected).abs() < 1e-6, "row {row}");
        }
    }
}

#[test]
fn a_ray_level_with_the_top_touches_only_what_is_higher() {
    let case = Case::new(32, 32, |row, column| if (row, column) == (9, 20) { 10.0 } else { 0.0 });
    let towards_peak = |z: f64| {
        let origin = case.world(dvec2(2.0, 9.5)).extend(z);
        case.scene.first_hit(origin, DVec3::X, 1.0)
    };
    // The peak is a tent of one texel each way.
    let hit = towards_peak(5.0).unwrap();
    assert!((hit.point.x - case.world(dvec2(20.0, 0.0)).x).abs() < 1e-9);
    // North and south of its ridge it falls by half as much, half way up.
    assert!((hit.slope.abs() - dvec2(1.0, 0.5)).length() < 1e-12, "{}", hit.slope);
    assert_eq!(towards_peak(10.0), None, "a ray that only touches the top goes on");
    assert!(towards_peak(9.999_999).is_some());
    // Grazing the plain from the side, a hair above it and a hair below.
    assert_eq!(
        case.scene.first_hit(case.world(dvec2(-5.0, 2.5)).extend(1e-9), DVec3::X, 1.0),
        None
    );
    assert_eq!(
        case.scene.first_hit(case.world(dvec2(-5.0, 2.5)).extend(-1e-9), DVec3::X, 1.0),
        None
    );
    let sinking = dvec3(1.0, 0.0, -1e-9);
    let hit = case.scene.first_hit(case.world(dvec2(1.0, 2.5)).extend(1e-7), sinking, 1.0).unwrap();
    assert!((hit.distance_m - 100.0).abs() < 1e-3, "{}", hit.distance_m);
}

#[test]
fn a_camera_on_or_under_the_surface_sees_what_is_in_front_of_it() {
    let case = Case::bumpy(37, 29, 8, 60.0, false);
    let point = case.world(dvec2(17.5, 13.5));
    let on_ground = point.extend(case.scene.height_m(point).unwrap());
    assert_eq!(case.scene.first_hit(on_ground, DVec3::Z, 1.0), None);
    let hit = case.scene.first_hit(on_ground, down(), 1.0).unwrap();
    assert_eq!((hit.distance_m, hit.point), (0.0, on_ground));
    let under = on_ground - DVec3::Z;
    assert_eq!(case.scene.first_hit(under, down(), 1.0), None);
    assert_eq!(case.scene.first_hit(under, DVec3::Z, 1.0), None, "the ground has no underside");
}

#[test]
fn exaggeration_scales_heights_and_not_slopes() {
    let case = Case::bumpy(37, 29, 9, 60.0, false);
    let point = case.world(dvec2(11.3, 20.7));
    let height_m = case.height_m(point).unwrap();
    let hit_at =
        |exaggeration: f64| case.scene.first_hit(point.extend(1e6), down(), exaggeration).unwrap();
    for exaggeration in [0.0, 0.01, 1.0, 15.0, 1000.0] {
        let hit = hit_at(exaggeration);
        assert!((hit.point.z - exaggeration * height_m).abs() < 1e-6, "{exaggeration}");
        assert_eq!(hit.slope, hit_at(1.0).slope);
    }
    // The gradient by differences.
    let at = |dx: f64, dy: f64| case.height_m(point + dvec2(dx, dy)).unwrap();
    let expected = dvec2(at(1e-3, 0.0) - at(-1e-3, 0.0), at(0.0, 1e-3) - at(0.0, -1e-3)) / 2e-3;
    assert!((hit_at(1.0).slope - expected).length() < 1e-6);
}

#[test]
fn the_lit_slope_is_the_central_difference_at_samples_and_bilinear_between() {
    let case = Case::bumpy(37, 29, 10, 60.0, false);
    let sample = |column: usize, row: usize| case.heights_m[row * 37 + column];
    let at_sample = |column: usize, row: usize| {
        let east = (sample(column + 1, row) - sample(column - 1, row)) / (2.0 * TEXEL_M);
        let north = (sample(column, row - 1) - sample(column, row + 1)) / (2.0 * TEXEL_M);
        dvec2(east, north)
    };
    // Across a border of tiles, too: they are 8 texels wide.
    for column in 4..12 {
        let place = dvec2(column as f64 + 0.75, 7.5);
        let expected = at_sample(column, 7) * 0.75 + at_sample(column + 1, 7) * 0.25;
        let found = case.scene.lit_slope(case.world(place));
        assert!((found - expected).length() < 1e-9, "{place}: {found} {expected}");
    }
}

#[test]
fn rays_pass_where_there_is_no_data() {
    // A hole of 3 x 3 samples in a plain, across the border of two tiles.
    let hole = |row: usize, column: usize| (6..9).contains(&row) && (6..9).contains(&column);
    let case = Case::new(24, 24, |row, column| if hole(row, column) { f64::NAN } else { 4.0 });
    for place in special_places(24, 24) {
        let hit = case.scene.first_hit(case.world(place).extend(50.0), down(), 1.0);
        let (_, share) = case.sum_and_share(case.world(place));
        if (share - 0.5).abs() > 1e-6 {
            assert_eq!(hit.is_some(), share > 0.5, "{place}: {share}");
        }
        assert!(hit.is_none_or(|hit| (hit.point.z - 4.0).abs() < 1e-9));
    }
    // Through the hole from above, then under the plain, seeing nothing.
    let through =
        case.scene.first_hit(case.world(dvec2(7.5, 7.5)).extend(5.0), dvec3(1.0, 0.0, -1.0), 1.0);
    assert_eq!(through, None);
}

#[test]
fn steps_between_regions_of_different_depth_are_closed() {
    let rough = |row: usize, column: usize| bumpy_m(11, 60.0, false, row, column);
    let case = Case::of_source(32, 32, rough, |source| {
        source.keep_finest(|tile| (tile.row + tile.column) % 3 == 0);
    });
    let slants = [[0.0, 0.0], [3.0, 1.0], [-2.0, 0.5], [1.0, -4.0], [0.0, 2.0]];
    for place in special_places(32, 32) {
        for slant in slants {
            let direction = dvec3(slant[0], slant[1], -2.0);
            let origin = case.world(place).extend(70.0);
            // Where the ray is below all ground it must have met it, if it is still over the data.
            let end = origin + direction * 40.0;
            if case.scene.height_m(end.truncate()).is_none() {
                continue;
            }
            let hit = case.scene.first_hit(origin, direction, 1.0);
            assert!(hit.is_some(), "slipped through from {place} going {slant:?}");
        }
    }
}

#[test]
fn where_the_finest_level_ends_the_nearest_ancestor_is_the_ground() {
    let rough = |row: usize, column: usize| bumpy_m(12, 60.0, false, row, column);
    let case = Case::of_source(32, 32, rough, |source| {
        source.keep_finest(|tile| tile.column < 2);
    });
    let coarse = |row: usize, column: usize| {
        let at = |y: usize, x: usize| f64::from(rough(2 * row + y, 2 * column + x) as f32);
        f64::from((0.25 * (at(0, 0) + at(0, 1) + at(1, 0) + at(1, 1))) as f32)
    };
    // Samples of the next level lie in the middle of 2 x 2 texels.
    for (row, column) in [(3, 9), (7, 12), (12, 14)] {
        let point = case.world(dvec2(2.0 * column as f64 + 1.0, 2.0 * row as f64 + 1.0));
        let found = case.scene.height_m(point).unwrap();
        assert!((found - coarse(row, column)).abs() < 1e-5, "{found}");
    }
    let fine = case.world(dvec2(9.5, 20.5));
    assert!((case.scene.height_m(fine).unwrap() - case.height_m(fine).unwrap()).abs() < 1e-7);
}

#[test]
fn a_tile_that_cannot_be_read_is_told_and_is_no_ground() {
    let mut source = RasterSource::new(32, vec![1.0; 32 * 32], ORIGIN, TEXEL_M);
    source.broken = TileSet::from_iter([TileId::new(2, 1, 1)]);
    let scene = ReferenceScene::open(Arc::new(source)).unwrap();
    let shoot = |x: f64, y: f64| {
        let point = ORIGIN + dvec2(x, -y) * TEXEL_M;
        scene.first_hit(point.extend(9.0), down(), 1.0)
    };
    assert!(shoot(4.0, 4.0).is_some());
    assert!(scene.check().is_ok(), "only what is touched is read");
    let before = scene.loaded_bytes();
    assert_eq!(shoot(12.0, 12.0), None);
    let error = scene.check().unwrap_err();
    assert!(matches!(error, ReferenceError::Load(_)) && error.to_string().contains("2/1/1"));
    assert_eq!(scene.loaded_bytes(), before);
}

#[test]
fn what_is_no_ray_meets_nothing() {
    let case = Case::bumpy(16, 16, 13, 60.0, false);
    let origin = case.world(dvec2(8.0, 8.0)).extend(100.0);
    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    for number in bad {
        assert_eq!(case.scene.first_hit(origin.with_x(number), down(), 1.0), None);
        assert_eq!(case.scene.first_hit(origin, down().with_z(number), 1.0), None);
        assert_eq!(case.scene.first_hit(origin, down(), number), None);
        assert_eq!(case.scene.height_m(DVec2::new(number, origin.y)), None);
    }
    assert_eq!(case.scene.first_hit(origin, DVec3::ZERO, 1.0), None);
    assert_eq!(case.scene.first_hit(origin, down(), -1.0), None);
    assert!(case.scene.first_hit(origin, down() * 1e-30, 1.0).is_some(), "any length will do");
}
