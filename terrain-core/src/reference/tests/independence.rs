//! The bounds that let rays pass blocks and tiles change nothing, bit for bit.

use glam::{DVec2, DVec3, dvec2, dvec3};
use proptest::prelude::*;

use super::{Case, bumpy_m, unit};
use crate::reference::SurfaceHit;

fn bits(hit: Option<SurfaceHit>) -> Option<[u64; 6]> {
    let hit = hit?;
    let numbers = [hit.point.x, hit.point.y, hit.point.z, hit.distance_m, hit.slope.x, hit.slope.y];
    Some(numbers.map(f64::to_bits))
}

/// Directions of all kinds: any, level or nearly, straight down, along the axes and diagonals.
fn directions() -> impl Strategy<Value = DVec3> {
    let any = (-1.0..1.0_f64, -1.0..1.0_f64, -1.0..0.3_f64);
    let axis = prop_oneof![Just(-1.0), Just(0.0), Just(1.0)];
    prop_oneof![
        any.prop_map(DVec3::from),
        (-1.0..1.0_f64, -1.0..1.0_f64, -1e-3..1e-3_f64).prop_map(DVec3::from),
        (axis.clone(), axis, prop_oneof![Just(0.0), Just(-1.0), Just(-0.1), -0.5..0.0_f64])
            .prop_map(DVec3::from),
    ]
}

/// Places in texels: any, on nodes, on lines and on borders of tiles, and some outside.
fn places() -> impl Strategy<Value = DVec2> {
    let exact = (-4..90_i32).prop_map(|halves| 0.5 * f64::from(halves));
    let any = -5.0..45.0_f64;
    let one = prop_oneof![exact, any];
    (one.clone(), one).prop_map(DVec2::from)
}

fn hits_agree(
    case: &Case,
    place: DVec2,
    height_m: f64,
    direction: DVec3,
    exaggeration: f64,
) -> bool {
    let origin = case.world(place).extend(height_m * exaggeration);
    let bounded = case.scene.first_hit(origin, direction, exaggeration);
    let exhaustive = case.scene.first_hit_exhaustive(origin, direction, exaggeration);
    bits(bounded) == bits(exhaustive)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn hits_are_the_same_with_and_without_bounds(
        seed in any::<u32>(), voids in any::<bool>(), smooth in any::<bool>(),
        rays in prop::collection::vec((places(), -20.0..120.0_f64, directions()), 40),
        exaggeration in prop_oneof![Just(1.0), Just(0.0), Just(15.0), 0.1..3.0_f64],
    ) {
        let relief_m = if smooth { 5.0 } else { 100.0 };
        let case = Case::bumpy(41, 38, seed, relief_m, voids);
        for (place, height_m, direction) in rays {
            prop_assert!(
                hits_agree(&case, place, height_m, direction, exaggeration),
                "{place} {height_m} {direction}"
            );
        }
    }

    #[test]
    fn and_where_the_depth_changes(
        seed in any::<u32>(),
        rays in prop::collection::vec((places(), -20.0..120.0_f64, directions()), 40),
    ) {
        let rough = |row: usize, column: usize| bumpy_m(seed, 80.0, false, row, column);
        let case = Case::of_source(41, 38, rough, |source| {
            source.keep_finest(|tile| unit(seed ^ (64 * tile.row + tile.column)) < 0.6);
        });
        for (place, height_m, direction) in rays {
            prop_assert!(
                hits_agree(&case, place, height_m, direction, 1.0),
                "{place} {height_m} {direction}"
            );
        }
    }
}

#[test]
fn rays_that_touch_flat_ground_agree_as_well() {
    // Terraces: long stretches at exactly the height of the ray.
    let case = Case::new(40, 40, |row, column| ((row / 6 + column / 6) * 10) as f64);
    for row in 0..80 {
        for height_m in [0.0, 10.0, 20.0, 50.0, 20.000_000_001] {
            for direction in [DVec3::X, -DVec3::X, dvec3(1.0, 1.0, 0.0), dvec3(1.0, 0.0, -1e-12)] {
                let place = dvec2(20.0, 0.5 * f64::from(row));
                assert!(hits_agree(&case, place, height_m, direction, 1.0), "{place} {direction}");
            }
        }
    }
}
