//! Flights: their files, their paths and those recorded.

use glam::dvec3;
use proptest::prelude::*;

use super::*;
use crate::CameraView;
use crate::dataset::Shape;

const VIEWPORT: [u32; 2] = [640, 360];

fn keyframe(t: f64, x: f64, heading: f64) -> Keyframe {
    Keyframe { t, x, y: -x, height: 1_000.0 + x, heading, pitch: -10.0, fov: 50.0 }
}

fn flight(keyframes: Vec<Keyframe>) -> Flight {
    Flight::new("EPSG:32632", 30.0, keyframes).unwrap()
}

#[test]
fn a_flight_file_reads_as_it_is_specified_and_writes_back() {
    let text = r#"{"crs": "EPSG:32632", "fps": 60, "keyframes": [
        {"t": 0.0, "x": 463000.0, "y": 6821000.5, "height": 2400, "heading": 350, "pitch": -20, "fov": 45},
        {"t": 2.5, "x": 464000.0, "y": 6822000.5, "height": 2300, "heading": 10, "pitch": -10, "fov": 60}]}"#;
    let flight = Flight::from_json(text).unwrap();
    assert_eq!((flight.crs(), flight.fps(), flight.duration_s()), ("EPSG:32632", 60.0, 2.5));
    assert_eq!(flight.frame_count(), 151);
    assert_eq!((flight.frame_time_s(0), flight.frame_time_s(150)), (0.0, 2.5));
    let start = flight.view_at(0.0, VIEWPORT);
    assert_eq!(start.eye, dvec3(463_000.0, 6_821_000.5, 2_400.0));
    assert_eq!((start.heading_deg, start.pitch_deg, start.fov_y_deg), (350.0, -20.0, 45.0));
    assert_eq!(flight.view_at(1.25, VIEWPORT).heading_deg, 0.0, "the short way, over north");
    assert_eq!(Flight::from_json(&flight.to_json().unwrap()).unwrap(), flight);

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.json");
    flight.write(&path).unwrap();
    assert_eq!(Flight::read(&path).unwrap(), flight);
}

#[test]
fn what_is_wrong_with_a_flight_is_named() {
    let good = keyframe(0.0, 1.0, 0.0);
    let later = |keyframe: Keyframe| Keyframe { t: 1.0, ..keyframe };
    let error = |keyframes| Flight::new("local", 30.0, keyframes).unwrap_err().to_string();
    assert_eq!(error(vec![]), "no keyframes");
    assert_eq!(error(vec![good, good]), "keyframe 1: t is 0, not later than the one before it");
    let lost = Keyframe { y: f64::NAN, ..later(good) };
    assert_eq!(error(vec![good, lost]), "keyframe 1: y is NaN, not a number");
    let steep = Keyframe { pitch: 90.5, ..good };
    assert_eq!(error(vec![steep]), "keyframe 0: pitch is 90.5, not within -90..90 degrees");
    let blind = Keyframe { fov: 180.0, ..good };
    assert_eq!(error(vec![blind]), "keyframe 0: fov is 180, not between 0 and 180 degrees");
    for fps in [0.0, -1.0, f64::NAN, f64::INFINITY, 1.0e300] {
        let error = Flight::new("local", fps, vec![good, later(good)]).unwrap_err();
        assert!(matches!(error, FlightError::FrameRate(_)), "{fps}: {error}");
    }
}

#[test]
fn a_file_that_is_no_flight_is_named_with_the_cause() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.json");
    // Told as the command tells it: with all causes, each of them once.
    let error = || {
        let error = Flight::read(&path).unwrap_err();
        let whole: &dyn std::error::Error = &error;
        let chain = std::iter::successors(Some(whole), |error| error.source());
        chain.map(ToString::to_string).collect::<Vec<_>>().join(": ")
    };
    let absent = error();
    assert!(absent.contains("flight.json: "), "{absent}");
    assert_eq!(absent.matches("os error").count(), 1, "{absent}");
    for (text, cause) in [
        ("", "EOF"),
        (r#"{"crs": "local", "keyframes": []}"#, "missing field `fps`"),
        (r#"{"crs": "local", "fps": 60, "keyframes": []}"#, "no keyframes"),
        (r#"{"crs": "local", "fps": 60, "keyframes": [{"t": 0}]}"#, "missing field `x`"),
    ] {
        std::fs::write(&path, text).unwrap();
        let error = error();
        assert!(error.contains("flight.json: not a flight: "), "{error}");
        assert_eq!(error.matches(cause).count(), 1, "{error}");
    }
}

#[test]
fn one_keyframe_is_a_flight_of_one_frame() {
    let flight = flight(vec![keyframe(3.0, 5.0, -90.0)]);
    assert_eq!((flight.frame_count(), flight.duration_s()), (1, 0.0));
    for t in [-1.0, 3.0, 9.0, f64::NAN] {
        let view = flight.view_at(t, VIEWPORT);
        assert_eq!((view.eye.x, view.heading_deg), (5.0, 270.0));
    }
}

fn angle_between_deg(a: f64, b: f64) -> f64 {
    (a - b + 180.0).rem_euclid(360.0) - 180.0
}

proptest! {
    #[test]
    fn keyframes_are_hit_and_headings_turn_the_short_way(
        steps in prop::collection::vec(
            (0.01..5.0f64, -1.0e7..1.0e7f64, -720.0..720.0f64), 2..10)
    ) {
        let mut t = -3.0;
        let keyframes: Vec<_> = steps
            .into_iter()
            .map(|(width, x, heading)| {
                t += width;
                keyframe(t, x, heading)
            })
            .collect();
        let flight = flight(keyframes.clone());
        for (index, key) in keyframes.iter().enumerate() {
            let view = flight.view_at(key.t, VIEWPORT);
            prop_assert_eq!(view.eye, dvec3(key.x, key.y, key.height), "keyframe {}", index);
            prop_assert!(angle_between_deg(view.heading_deg, key.heading).abs() < 1e-9);
        }
        for pair in keyframes.windows(2) {
            let turn = angle_between_deg(pair[1].heading, pair[0].heading);
            for step in 0..=16 {
                let t = pair[0].t + (pair[1].t - pair[0].t) * f64::from(step) / 16.0;
                let view = flight.view_at(t, VIEWPORT);
                let turned = angle_between_deg(view.heading_deg, pair[0].heading);
                // Half a turn may go either way.
                let on_the_way = turned * turn.signum() >= -1e-9 && turned.abs() <= turn.abs() + 1e-9;
                prop_assert!(on_the_way || turn.abs() > 179.999, "{turned} of {turn}");
                let (low, high) = (pair[0].x.min(pair[1].x), pair[0].x.max(pair[1].x));
                prop_assert!((low - 1e-6..=high + 1e-6).contains(&view.eye.x), "overshoot");
            }
        }
    }
}

fn view_at_x(x: f64) -> CameraView {
    CameraView {
        eye: dvec3(x, 20.0, 300.0),
        heading_deg: 15.0,
        pitch_deg: -5.0,
        fov_y_deg: 50.0,
        viewport_px: VIEWPORT,
    }
}

#[test]
fn a_recording_keeps_moves_and_rests_with_few_keyframes() {
    // At 60 frames a second: rests for 2 s, moves evenly for 3 s, rests for 2 s.
    let x_at = |t: f64| 100.0 * (t - 2.0).clamp(0.0, 3.0);
    let mut recorder = FlightRecorder::new();
    for frame in 0..=7 * 60 {
        let t = f64::from(frame) / 60.0;
        recorder.record(1_000.0 + t, &view_at_x(x_at(t)));
    }
    recorder.record(1_000.0, &view_at_x(-9.0)); // a clock that went back
    recorder.record(f64::NAN, &view_at_x(-9.0));
    assert!(recorder.len() < 20, "{} keyframes", recorder.len());
    let flight = recorder.finish(("local", Shape::Plane), 60.0).unwrap();
    assert_eq!((flight.time_range_s(), flight.frame_count()), ([0.0, 7.0], 421));
    for frame in 0..flight.frame_count() {
        let t = flight.frame_time_s(frame);
        let error_m = flight.view_at(t, VIEWPORT).eye.x - x_at(t);
        // A cubic from rest to 100 m/s in one interval is at most 4/27 of its way off a sudden start.
        let rounded_off_m = 4.0 / 27.0 * 100.0 * FlightRecorder::INTERVAL_S;
        assert!(error_m.abs() < rounded_off_m + 0.05, "{error_m} at {t}");
    }
    assert!(
        FlightRecorder::new().finish(("local", Shape::Plane), 60.0).is_err(),
        "nothing recorded"
    );
}

#[test]
fn a_cut_holds_the_view_before_it() {
    let [here, there] = [keyframe(0.0, 1.0, 10.0), keyframe(3.0, 9.0e5, 200.0)];
    let hold = |t: f64, keyframe: Keyframe| Keyframe { t, ..keyframe };
    let cut = 3.0 - 0.5 * Flight::CUT_S;
    let flight = flight(vec![here, hold(cut, here), there, hold(4.0, there)]);
    for t in [0.0, 1.5, cut, 3.0 - 0.1 * Flight::CUT_S] {
        assert_eq!(flight.view_at(t, VIEWPORT).eye.x, 1.0, "{t}");
    }
    for t in [3.0, 3.5, 4.0, 5.0] {
        assert_eq!(flight.view_at(t, VIEWPORT).eye.x, 9.0e5, "{t}");
    }
    assert!(flight.is_cut_between(2.9, 3.0) && flight.is_cut_between(2.0, 3.5));
    assert!(!flight.is_cut_between(0.0, 2.9) && !flight.is_cut_between(3.0, 4.0));
    let ends_with_cut = Flight::new("local", 30.0, flight.keyframes()[..3].to_vec()).unwrap();
    assert_eq!(ends_with_cut.view_at(3.0, VIEWPORT).eye.x, 9.0e5);
}

#[test]
fn over_a_globe_a_flight_takes_the_short_way_across_the_date_line() {
    let text = r#"{"crs": "EPSG:4326", "fps": 10, "keyframes": [
        {"t": 0, "x": 170, "y": 10, "height": 1e6, "heading": 90, "pitch": -30, "fov": 50},
        {"t": 2, "x": -170, "y": -10, "height": 1e6, "heading": 90, "pitch": -30, "fov": 50}]}"#;
    let flight = Flight::from_json(text).unwrap();
    let longitude_deg = |t| {
        let eye = flight.view_at(t, [64, 64]).eye.truncate();
        Shape::Globe.user_from_world(eye).x
    };
    for (t, expected_deg) in [(0.0, 170.0), (0.5, 175.0), (1.5, -175.0), (2.0, -170.0)] {
        assert!((longitude_deg(t) - expected_deg).abs() < 1.0e-9, "{t}: {}", longitude_deg(t));
    }
    assert!((longitude_deg(1.0).abs() - 180.0).abs() < 1.0e-9);
    let mut recorder = FlightRecorder::new();
    for frame in 0..20 {
        let t = f64::from(frame) / 10.0;
        recorder.record(t, &flight.view_at(t, [64, 64]));
    }
    let recorded = recorder.finish((flight.crs(), Shape::Globe), 10.0).unwrap();
    let between = recorded.view_at(0.95, [64, 64]).eye - flight.view_at(0.95, [64, 64]).eye;
    assert!(between.length() < 1.0, "{between}");
    let lost = text.replace("-10,", "-91,");
    let error = Flight::from_json(&lost).unwrap_err().to_string();
    assert!(error.contains("keyframe 1: y is -91, not a latitude"), "{error}");
}
