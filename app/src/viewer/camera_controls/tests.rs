use glam::dvec3;

use super::*;

const GROUND_M: f64 = 400.0;

fn flat(xy: DVec2) -> Option<f64> {
    bounds().data_extent.contains(xy).then_some(GROUND_M)
}

fn bounds() -> ControlBounds {
    ControlBounds {
        data_extent: Extent::new(dvec2(0.0, 0.0), dvec2(100_000.0, 80_000.0)),
        height_range_m: [0.0, 2_500.0],
        least_clearance_m: 5.0,
        is_globe: false,
    }
}

fn controls(pitch_deg: f64) -> CameraControls {
    let view = CameraView {
        eye: dvec3(50_000.0, 20_000.0, 3_400.0),
        heading_deg: 20.0,
        pitch_deg,
        fov_y_deg: 60.0,
        viewport_px: [800, 600],
    };
    CameraControls::new(view, bounds())
}

fn assert_near(left: [f64; 2], right: [f64; 2], tolerance_px: f64) {
    let apart = (left[0] - right[0]).hypot(left[1] - right[1]);
    assert!(apart <= tolerance_px, "{left:?} is {apart} px from {right:?}");
}

#[test]
fn a_pan_keeps_the_grabbed_ground_under_the_cursor() {
    let mut controls = controls(-40.0);
    let start = [300.0, 350.0];
    controls.begin_drag(DragKind::Pan, start, &flat);
    let held = pick_ground(controls.view(), start, &flat, 1.0, 1.0e6).unwrap();
    for pixel in [[310.0, 340.0], [500.0, 420.0], [200.0, 300.0]] {
        assert!(controls.drag_to(pixel, &flat));
        assert_near(controls.view().pixel_from_world(held).unwrap(), pixel, 0.5);
        assert_eq!(controls.view().eye.z, 3_400.0, "a pan is level");
    }
    controls.end_drag();
    assert!(!controls.drag_to([0.0, 0.0], &flat));
}

#[test]
fn a_pan_that_starts_in_the_sky_does_not_jump() {
    let mut controls = controls(10.0);
    let before = controls.view().eye;
    controls.begin_drag(DragKind::Pan, [400.0, 20.0], &flat);
    controls.drag_to([400.0, 20.0], &flat);
    assert!((controls.view().eye - before).length() < 1e-6);
    controls.drag_to([410.0, 20.0], &flat);
    let moved_m = (controls.view().eye - before).length();
    assert!(moved_m > 1.0 && moved_m < 3_000.0, "{moved_m}");
}

#[test]
fn an_orbit_keeps_its_centre_in_place_and_at_its_distance() {
    let mut controls = controls(-40.0);
    let start = [420.0, 320.0];
    controls.begin_drag(DragKind::Orbit, start, &flat);
    let centre = pick_ground(controls.view(), start, &flat, 1.0, 1.0e6).unwrap();
    let distance_m = (centre - controls.view().eye).length();
    controls.drag_to([520.0, 290.0], &flat);
    let view = controls.view();
    assert!((view.heading_deg - 50.0).abs() < 1e-9, "right drag of 100 of 600 px turns 30 degrees");
    assert!((view.pitch_deg + 31.0).abs() < 1e-9, "up drag of 30 px lifts the view 9 degrees");
    assert!(((centre - view.eye).length() - distance_m).abs() < 0.1);
    assert_near(view.pixel_from_world(centre).unwrap(), start, 0.5);
}

#[test]
fn looking_round_leaves_the_eye_where_it_is() {
    let mut controls = controls(-40.0);
    let eye = controls.view().eye;
    controls.begin_drag(DragKind::Look, [400.0, 300.0], &flat);
    controls.drag_to([100.0, 5_000.0], &flat);
    assert!((controls.view().eye - eye).length() < 1e-6);
    assert_eq!(controls.view().pitch_deg, -90.0, "straight down is the end");
}

#[test]
fn the_wheel_goes_to_the_ground_under_the_cursor() {
    let mut controls = controls(-40.0);
    let pixel = [250.0, 400.0];
    let target = pick_ground(controls.view(), pixel, &flat, 1.0, 1.0e6).unwrap();
    let distance_m = (target - controls.view().eye).length();
    controls.wheel(2.0, pixel, &flat);
    let mut frames = 0;
    while controls.advance(1.0 / 60.0, &flat) {
        frames += 1;
        assert!(frames < 200, "the wheel comes to rest");
        assert_near(controls.view().pixel_from_world(target).unwrap(), pixel, 0.5);
    }
    let left = (target - controls.view().eye).length() / distance_m;
    assert!((left - ZOOM_STEP.powi(2)).abs() < 1e-3, "{left}");
    assert!(frames > 3, "it is soft");
}

#[test]
fn zooming_in_for_ever_stops_above_the_ground() {
    let mut controls = controls(-90.0);
    for _ in 0..100 {
        controls.wheel(3.0, [400.0, 300.0], &flat);
        controls.advance(1.0, &flat);
    }
    assert!(controls.view().eye.z >= GROUND_M + 5.0, "{}", controls.view().eye.z);
    assert!(controls.view().eye.z < GROUND_M + 6.0);
    assert!(controls.view().eye.is_finite());
}

#[test]
fn zooming_out_for_ever_stays_near_the_data() {
    let mut controls = controls(-30.0);
    for _ in 0..200 {
        controls.wheel(-3.0, [10.0, 590.0], &flat);
        controls.advance(1.0, &flat);
    }
    let eye = controls.view().eye;
    let room = bounds().data_extent.grown(FREE_SIZES * 100_000.0);
    assert!(room.contains(eye.truncate()) && eye.z < 1.0e6, "{eye}");
}

#[test]
fn keys_fly_level_at_a_speed_that_goes_with_the_height() {
    let mut controls = controls(-40.0);
    let start = controls.view().eye;
    controls.set_held(HeldDirections { forward: true, ..Default::default() });
    controls.advance(1.0, &flat);
    let one_s = controls.view().eye - start;
    let heading = dvec2(20.0_f64.to_radians().sin(), 20.0_f64.to_radians().cos());
    assert!((one_s.truncate().normalize() - heading).length() < 1e-9);
    assert_eq!(one_s.z, 0.0);
    assert!((one_s.length() / (3_000.0 * CRUISE_PER_S) - 1.0).abs() < 0.01, "{}", one_s.length());
    controls.set_held(HeldDirections { fast: true, ..Default::default() });
    let mut frames = 0;
    while controls.advance(1.0 / 60.0, &flat) {
        frames += 1;
        assert!(frames < 200, "flight comes to rest");
    }
    assert!(!controls.is_moving());
}

#[test]
fn rising_ground_lifts_the_eye() {
    let mut controls = controls(0.0);
    let wall = |xy: DVec2| Some(if xy.y > 21_000.0 { 3_800.0 } else { GROUND_M });
    controls.set_held(HeldDirections { forward: true, ..Default::default() });
    controls.advance(2.0, &wall);
    assert!(controls.view().eye.y > 21_000.0);
    assert!((controls.view().eye.z - 3_805.0).abs() < 1e-9, "{}", controls.view().eye.z);
}

#[test]
fn home_shows_every_corner() {
    for viewport in [[800, 600], [300, 900], [1_900, 400]] {
        let mut controls = controls(-20.0);
        controls.resize(viewport);
        controls.go_home();
        while controls.advance(0.1, &flat) {}
        let extent = bounds().data_extent;
        for x in [extent.min.x, extent.max.x] {
            for y in [extent.min.y, extent.max.y] {
                let [px, py] = controls.view().pixel_from_world(dvec3(x, y, GROUND_M)).unwrap();
                let inside = (0.0..=f64::from(viewport[0])).contains(&px)
                    && (0.0..=f64::from(viewport[1])).contains(&py);
                assert!(inside, "corner {x} {y} at {px} {py} in {viewport:?}");
            }
        }
    }
}

#[test]
fn north_up_keeps_the_middle_of_the_picture() {
    let mut controls = controls(-40.0);
    let middle = [400.0, 300.0];
    let centre = pick_ground(controls.view(), middle, &flat, 1.0, 1.0e6).unwrap();
    controls.go_north_up(&flat);
    while controls.advance(0.05, &flat) {}
    assert_eq!(controls.view().heading_deg, 0.0);
    assert_near(controls.view().pixel_from_world(centre).unwrap(), middle, 0.5);
}

#[test]
fn more_exaggeration_keeps_the_clearance() {
    let mut controls = controls(-40.0);
    controls.scale_heights(3.0, &flat);
    let higher = |xy: DVec2| flat(xy).map(|height_m| 3.0 * height_m);
    assert!((controls.clearance_m(&higher) - 3_000.0).abs() < 1e-9);
}

#[test]
fn a_minimised_window_is_no_fault() {
    let mut controls = controls(-40.0);
    controls.resize([0, 0]);
    controls.wheel(1.0, [0.0, 0.0], &flat);
    controls.advance(0.1, &flat);
    assert!(controls.view().eye.is_finite());
    assert_eq!(controls.view().viewport_px, [1, 1]);
}
