use glam::{DVec2, DVec3, dvec2};

use super::*;
use crate::CameraView;
use crate::dataset::Shape;
use crate::tiling::Extent;

const VIEWPORT: [u32; 2] = [640, 360];

/// A rugged country with one clear summit and one winding valley, on the ground of any size.
struct Country {
    extent: Extent,
    sample_m: f64,
}

impl Country {
    /// Sides of three magnitudes, each finely and coarsely sampled; not square.
    fn all() -> impl Iterator<Item = Self> {
        let sides = [10_000.0, 60_000.0, 2.0e7];
        sides.into_iter().flat_map(|side_m| {
            let corner = dvec2(4.0e5, -3.0e6);
            let extent = Extent::new(corner, corner + dvec2(1.3 * side_m, side_m));
            [300.0, 8192.0].map(|samples| Self { extent, sample_m: side_m / samples })
        })
    }

    fn side_m(&self) -> f64 {
        self.extent.size_m().y
    }

    fn summit(&self) -> DVec2 {
        self.extent.min + 0.35 * self.extent.size_m()
    }

    fn height_m(&self, point: DVec2) -> f64 {
        let side_m = self.side_m();
        let waves = (point * (40.0 / side_m)).map(f64::sin).element_sum();
        let bumps = (point * (900.0 / side_m)).map(f64::sin).element_product();
        let away = (point - self.summit()).length() / side_m;
        0.01 * side_m * waves + 0.001 * side_m * bumps + 0.12 * side_m * (-60.0 * away * away).exp()
    }

    fn flight(&self, planned: PlannedFlight) -> Flight {
        let height_m = |point: DVec2, _: f64| Some(self.height_m(point));
        planned.over(&self.ground(&height_m)).unwrap()
    }

    fn ground<'a>(&self, height_m: &'a dyn Fn(DVec2, f64) -> Option<f64>) -> FlightGround<'a> {
        FlightGround { crs: "local".into(), extent: self.extent, sample_m: self.sample_m, height_m }
    }
}

fn views(flight: &Flight) -> impl Iterator<Item = CameraView> {
    (0..flight.frame_count()).map(|frame| flight.view_at(flight.frame_time_s(frame), VIEWPORT))
}

/// Degrees between where the view looks and where `target` is.
fn aim_error_deg(view: &CameraView, target: DVec3) -> f64 {
    view.forward().angle_between(target - view.eye).to_degrees()
}

fn turn_deg(from: &CameraView, to: &CameraView) -> f64 {
    (to.heading_deg - from.heading_deg + 180.0).rem_euclid(360.0) - 180.0
}

#[test]
fn a_name_is_a_flight_and_any_other_is_refused_with_the_names() {
    for flight in PlannedFlight::ALL {
        assert_eq!(flight.name().parse(), Ok(flight));
        let json = serde_json::to_string(&flight).unwrap();
        assert_eq!(json, format!("\"{flight}\""));
    }
    let error = "loop".parse::<PlannedFlight>().unwrap_err().to_string();
    assert!(error.contains("no flight \"loop\"") && error.contains("valley, teleport"), "{error}");
    assert_eq!(PlannedFlight::measuring().count(), 8);
}

#[test]
fn no_flight_meets_the_ground() {
    for country in Country::all() {
        let clearance_m = country.ground(&|_, _| None).low_clearance_m();
        for planned in PlannedFlight::ALL {
            let flight = country.flight(planned);
            let [start, end] = flight.time_range_s();
            // Four times as often as it has frames.
            let samples = 4 * flight.frame_count();
            for sample in 0..=samples {
                let t = start + (end - start) * sample as f64 / samples as f64;
                let view = flight.view_at(t, VIEWPORT);
                let above_m = view.eye.z - country.height_m(view.eye.truncate());
                assert_eq!(view.check(), Ok(()), "{planned} at {t} s");
                assert!(above_m > 0.9 * clearance_m, "{planned} at {t} s: {above_m} m");
                let inside = country.extent.contains(view.eye.truncate());
                assert!(inside || planned == PlannedFlight::Tour, "{planned} at {t} s");
            }
        }
    }
}

#[test]
fn flights_are_smooth_and_the_same_again() {
    for country in Country::all() {
        for planned in PlannedFlight::ALL {
            let flight = country.flight(planned);
            assert_eq!(flight, country.flight(planned), "{planned}");
            if planned == PlannedFlight::Teleport {
                continue;
            }
            let views = views(&flight).collect::<Vec<_>>();
            for pair in views.windows(2) {
                assert!(turn_deg(&pair[0], &pair[1]).abs() < 3.0, "{planned}: {pair:?}");
                let above_m = pair[0].eye.z - country.height_m(pair[0].eye.truncate());
                let step_m = pair[0].eye.distance(pair[1].eye);
                assert!(step_m < 0.25 * above_m, "{planned}: {step_m} m, {above_m} m above");
            }
        }
    }
}

#[test]
fn forward_flights_keep_their_speed_and_direction() {
    for country in Country::all() {
        for planned in [PlannedFlight::ForwardLow, PlannedFlight::ForwardHigh] {
            let views = views(&country.flight(planned)).collect::<Vec<_>>();
            let step = (views[1].eye - views[0].eye).truncate();
            assert!(step.x > 0.0 && step.y.abs() < 1e-6 * step.x, "along the longer side");
            for pair in views.windows(2) {
                let other = (pair[1].eye - pair[0].eye).truncate();
                assert!((other - step).length() < 1e-4 * step.length(), "{planned}");
                assert_eq!(pair[1].heading_deg, 90.0);
            }
        }
        let high = views(&country.flight(PlannedFlight::ForwardHigh)).collect::<Vec<_>>();
        assert!(high.iter().all(|view| view.eye.z == high[0].eye.z));
    }
}

#[test]
fn a_low_flight_keeps_low() {
    let country = Country { sample_m: 60_000.0 / 8192.0, ..Country::all().nth(2).unwrap() };
    let clearance_m = country.ground(&|_, _| None).low_clearance_m();
    for planned in [PlannedFlight::ForwardLow, PlannedFlight::Valley] {
        let flight = country.flight(planned);
        let frames = flight.frame_count() as f64;
        let above = views(&flight).map(|view| view.eye.z - country.height_m(view.eye.truncate()));
        let mean_m = above.sum::<f64>() / frames;
        assert!(mean_m < 3.0 * clearance_m, "{planned}: {mean_m} m of {clearance_m} m");
    }
}

#[test]
fn hovering_is_still_and_spinning_turns_once_on_the_spot() {
    for country in Country::all() {
        let hover = views(&country.flight(PlannedFlight::Hover)).collect::<Vec<_>>();
        assert!(hover.len() > 200 && hover.iter().all(|view| *view == hover[0]));
        let spin = views(&country.flight(PlannedFlight::Spin)).collect::<Vec<_>>();
        assert!(spin.iter().all(|view| view.eye == spin[0].eye));
        let turned = spin.windows(2).map(|pair| turn_deg(&pair[0], &pair[1])).sum::<f64>();
        assert!((turned - 360.0).abs() < 1e-6, "{turned}");
    }
}

#[test]
fn an_orbit_looks_at_the_summit_from_all_sides() {
    for country in Country::all() {
        let orbit = views(&country.flight(PlannedFlight::Orbit)).collect::<Vec<_>>();
        let middle = orbit.iter().map(|view| view.eye).sum::<DVec3>() / orbit.len() as f64;
        assert!(middle.truncate().distance(country.summit()) < 0.05 * country.side_m());
        let turned = orbit.windows(2).map(|pair| turn_deg(&pair[0], &pair[1])).sum::<f64>();
        assert!((turned - 360.0).abs() < 1.0, "clockwise: {turned}");
        assert!(orbit.iter().all(|view| view.eye.z == orbit[0].eye.z && view.pitch_deg < 10.0));
    }
}

#[test]
fn a_climb_goes_from_the_ground_to_a_view_of_the_whole() {
    for country in Country::all() {
        let climb = views(&country.flight(PlannedFlight::ClimbAndDescend)).collect::<Vec<_>>();
        let top = climb.iter().max_by(|a, b| a.eye.z.total_cmp(&b.eye.z)).unwrap();
        assert!(top.eye.z > 0.85 * country.side_m());
        assert!(climb[0].eye.distance(climb[climb.len() - 1].eye) < 1e-6);
        assert!(climb.iter().all(|view| view.eye.truncate() == climb[0].eye.truncate()));
    }
}

#[test]
fn a_teleport_is_held_and_then_far_away() {
    for country in Country::all() {
        let views = views(&country.flight(PlannedFlight::Teleport)).collect::<Vec<_>>();
        let (mut jumps, mut held) = (0, 0);
        for pair in views.windows(2) {
            if pair[0] == pair[1] {
                held += 1;
                continue;
            }
            let way_m = pair[0].eye.distance(pair[1].eye);
            assert!(way_m > 0.25 * country.side_m(), "{way_m} m");
            assert!(held >= 60, "held for {held} frames");
            (jumps, held) = (jumps + 1, 0);
        }
        assert_eq!(jumps, 7);
    }
}

#[test]
fn a_valley_is_followed_along_its_floor() {
    // A winding valley, 0.02 of the side deep, in a plain that slopes a little.
    let side_m = 50_000.0;
    let floor_y = |x: f64| 25_000.0 + 2_000.0 * (x / 2_500.0).sin();
    let height_m = |point: DVec2, _: f64| {
        let off = (point.y - floor_y(point.x)) / 600.0;
        Some(2_000.0 - 1_000.0 * (-off * off).exp() + 0.002 * point.x)
    };
    let ground = FlightGround {
        crs: "local".into(),
        extent: Extent::new(DVec2::ZERO, DVec2::splat(side_m)),
        sample_m: 30.0,
        height_m: &height_m,
    };
    let flight = PlannedFlight::Valley.over(&ground).unwrap();
    let mut below_rim = 0.0;
    for view in views(&flight) {
        let off_m = (view.eye.y - floor_y(view.eye.x)).abs();
        assert!(off_m < 900.0, "{off_m} m off the floor at {}", view.eye);
        below_rim += f64::from(u8::from(view.eye.z < 2_000.0 + 0.002 * view.eye.x));
    }
    assert!(below_rim > 0.9 * flight.frame_count() as f64, "{below_rim} frames between the sides");
    let way_m = views(&flight).collect::<Vec<_>>();
    let way_m = way_m.windows(2).map(|pair| pair[0].eye.distance(pair[1].eye)).sum::<f64>();
    assert!(way_m > 0.45 * 75.0 * ground.low_clearance_m(), "{way_m} m");
}

#[test]
fn a_tour_shows_the_whole_then_the_summit() {
    for country in Country::all() {
        let side_m = country.side_m();
        let extent = country.extent;
        let grid = (0..250_000).map(|i| dvec2(f64::from(i % 500), f64::from(i / 500)) / 499.0);
        let peak = grid
            .map(|part| extent.min + part * extent.size_m())
            .map(|point| point.extend(country.height_m(point)))
            .max_by(|a, b| a.z.total_cmp(&b.z))
            .unwrap();
        let tour = views(&country.flight(PlannedFlight::Tour)).collect::<Vec<_>>();
        let aimed = tour.iter().filter(|view| aim_error_deg(view, peak) < 5.0).count();
        assert!(2 * aimed > tour.len(), "{side_m}: {aimed} of {}", tour.len());
        for corner in [extent.min, extent.max, dvec2(extent.min.x, extent.max.y)] {
            let way = 0.5 * (corner + extent.centre());
            let [x, y] = tour[0].pixel_from_world(way.extend(0.0)).unwrap();
            assert!((0.0..640.0).contains(&x) && (0.0..360.0).contains(&y), "{x} {y}");
        }
    }
}

#[test]
fn nowhere_is_an_error_and_unknown_or_flat_ground_is_not() {
    let unknown = |_: DVec2, _: f64| None;
    let odd = |_: DVec2, _: f64| Some(f64::NAN);
    let flat = |_: DVec2, _: f64| Some(7.0);
    let ground =
        |extent, height_m| FlightGround { crs: "local".into(), extent, sample_m: 1.0, height_m };
    let somewhere = Extent::new(DVec2::ZERO, DVec2::splat(1.0e4));
    let point = Extent::new(DVec2::ZERO, DVec2::ZERO);
    let lost = Extent::new(DVec2::NAN, DVec2::NAN);
    for planned in PlannedFlight::ALL {
        for nowhere in [point, lost] {
            let error = planned.over(&ground(nowhere, &unknown)).unwrap_err();
            assert!(matches!(error, FlightError::NoArea), "{planned}: {error}");
        }
        for height_m in [&unknown as &dyn Fn(DVec2, f64) -> Option<f64>, &odd, &flat] {
            assert!(planned.over(&ground(somewhere, height_m)).is_ok(), "{planned}");
        }
    }
}

/// A mountain on an ocean globe, beside the date line.
#[test]
fn flights_over_a_globe_stay_above_its_ground_and_near_its_highest() {
    let summit_deg = dvec2(176.0, -40.0);
    let east_deg =
        |place_deg: DVec2| (place_deg.x - summit_deg.x + 180.0).rem_euclid(360.0) - 180.0;
    let height_m = |point: DVec2, _: f64| {
        let place_deg = Shape::Globe.user_from_world(point);
        let away_deg = dvec2(east_deg(place_deg) * 0.77, place_deg.y - summit_deg.y).length();
        Some(8_000.0 * (-0.02 * away_deg * away_deg).exp() - 3_000.0)
    };
    for planned in PlannedFlight::ALL {
        let flight = planned.over_globe(10_000.0, &height_m).unwrap();
        assert_eq!(flight.crs(), "EPSG:4326");
        for frame in (0..flight.frame_count()).step_by(30) {
            let eye = flight.view_at(flight.frame_time_s(frame), [64, 64]).eye;
            let place_deg = Shape::Globe.user_from_world(eye.truncate());
            assert!((place_deg.y - summit_deg.y).abs() < 20.0, "{planned}: {place_deg}");
            assert!(east_deg(place_deg).abs() < 25.0, "{planned}: {place_deg}");
            let ground_m = height_m(eye.truncate(), 0.0).unwrap();
            assert!(eye.z > ground_m + 1_000.0, "{planned}: {} over {ground_m}", eye.z);
        }
    }
    let flat = PlannedFlight::Hover.over_globe(10_000.0, &|_, _| Some(0.0)).unwrap();
    assert!((flat.keyframes()[0].x - 10.0).abs() < 15.0);
}
