//! How the camera moves over a globe: by turning the globe, in earth-centred coordinates. What a drag or the wheel
//! holds is a point of these coordinates. Headings and pitches are those at the eye's own place, which a turn of the
//! globe about its centre keeps upright.

use glam::{DMat3, DQuat, DVec3, dvec3};
use terrain_core::CameraView;
use terrain_core::geodesy::{Geodetic, PlateCarree, Wgs84};

use crate::viewer::ground_pick::{GroundHeight, pick_ground_at};

/// Where the eye of the whole globe's picture stands, degrees.
const HOME_DEG: [f64; 2] = [10.0, 20.0];
/// Share of the picture's height that the globe then fills.
const HOME_SHARE: f64 = 0.85;
/// How high the eye may go, metres.
pub const CEILING_M: f64 = 1.0e8;

/// A camera in earth-centred coordinates.
#[derive(Clone, Copy)]
struct Pose {
    eye: DVec3,
    /// The directions right, up and back as columns.
    axes: DMat3,
}

impl Pose {
    fn of(view: &CameraView) -> Self {
        let place = Geodetic::from_plate_carree(view.eye);
        Self {
            eye: Wgs84::ecef_from_geodetic(&place),
            axes: place.ecef_from_local() * view.view_from_world().transpose(),
        }
    }

    /// The camera upright at the pose's place, looking where it does.
    fn view(&self, like: &CameraView) -> CameraView {
        let place = Wgs84::geodetic_from_ecef(self.eye);
        let in_local = place.ecef_from_local().transpose() * self.axes;
        let forward = -in_local.z_axis;
        // Where the view is steep, the picture's upper side tells better where it is turned to.
        let ahead =
            if forward.z.abs() < 0.7 { forward } else { in_local.y_axis * -forward.z.signum() };
        CameraView {
            eye: place.plate_carree().extend(place.height_m),
            heading_deg: ahead.x.atan2(ahead.y).to_degrees().rem_euclid(360.0),
            pitch_deg: forward.z.clamp(-1.0, 1.0).asin().to_degrees(),
            ..*like
        }
    }

    fn turned(&self, turn: DQuat) -> Self {
        Self { eye: turn * self.eye, axes: DMat3::from_quat(turn) * self.axes }
    }
}

/// The point of the globe under a pixel: of its ground, or of the sphere through `level_m` above the ellipsoid below
/// the eye; where the ray passes by, the point nearest to it.
pub fn point_under(
    view: &CameraView,
    pixel: [f64; 2],
    ground: GroundHeight<'_>,
    clearance_m: f64,
) -> DVec3 {
    let in_place = |point: DVec3| {
        let place = Geodetic::of_seen(view.eye, point);
        place.plate_carree().extend(place.height_m)
    };
    let far_m = 4.0 * Wgs84::EQUATOR_RADIUS_M + 2.0 * clearance_m;
    let picked = pick_ground_at(view, pixel, ground, (0.1 * clearance_m, far_m), in_place);
    match picked {
        Some(point) => {
            let place = Geodetic::of_seen(view.eye, point);
            Wgs84::ecef_from_geodetic(&place)
        }
        None => on_sphere(view, pixel, Pose::of(view).eye.length() - clearance_m),
    }
}

/// Where the ray through a pixel meets a sphere round the earth's centre, or comes nearest to it.
fn on_sphere(view: &CameraView, pixel: [f64; 2], radius_m: f64) -> DVec3 {
    let pose = Pose::of(view);
    let in_view = view.view_from_world() * view.ray_direction(pixel[0], pixel[1]);
    let direction = pose.axes * in_view;
    let nearest_m = -pose.eye.dot(direction);
    let passes_squared = pose.eye.length_squared() - nearest_m * nearest_m;
    let half_chord = (radius_m * radius_m - passes_squared).max(0.0).sqrt();
    let point = pose.eye + direction * (nearest_m - half_chord).max(0.0);
    point.normalize_or(DVec3::Z) * radius_m
}

/// Turns the globe so that the point that was held lies under a pixel again.
pub fn pan(view: &CameraView, held: DVec3, pixel: [f64; 2]) -> CameraView {
    let under = on_sphere(view, pixel, held.length());
    let turn = DQuat::from_rotation_arc(under.normalize(), held.normalize());
    let moved = Pose::of(view).turned(turn).view(view);
    keep_height(view, moved)
}

/// Turns eye and view about a point by so many degrees: about its vertical, and up.
pub fn turn_about(view: &CameraView, centre: DVec3, turn_deg: f64, pitch_deg: f64) -> CameraView {
    let pose = Pose::of(view);
    let vertical = Wgs84::geodetic_from_ecef(centre).normal();
    // Headings run clockwise.
    let about_vertical = DQuat::from_axis_angle(vertical, -turn_deg.to_radians());
    let up = DQuat::from_axis_angle(pose.axes.x_axis, (pitch_deg - view.pitch_deg).to_radians());
    let turn = about_vertical * up;
    let turned = Pose { eye: centre + turn * (pose.eye - centre), ..pose.turned(turn) };
    turned.view(view)
}

/// Brings the eye to so large a part of its way from a point; the point keeps its place in the picture.
pub fn zoom(view: &CameraView, target: DVec3, part: f64) -> CameraView {
    let pose = Pose::of(view);
    let nearer = Pose { eye: target + (pose.eye - target) * part, ..pose };
    let place = Wgs84::geodetic_from_ecef(nearer.eye);
    let moved = CameraView { eye: place.plate_carree().extend(place.height_m), ..*view };
    // Upright over its new place; then the globe is turned until the target is where it was.
    match pixel_of(view, target) {
        Some(pixel) => pan(&moved, target, pixel),
        None => moved,
    }
}

/// Moves the eye level: metres right, ahead and up. It goes straight on, across poles and the date line too.
pub fn fly(view: &CameraView, metres: DVec3) -> CameraView {
    let pose = Pose::of(view);
    let (sin, cos) = view.heading_deg.to_radians().sin_cos();
    let local = dvec3(cos, -sin, 0.0) * metres.x + dvec3(sin, cos, 0.0) * metres.y;
    let along = Geodetic::from_plate_carree(view.eye).ecef_from_local() * local;
    let moved = if along == DVec3::ZERO {
        *view
    } else {
        let to = (pose.eye + along).normalize();
        pose.turned(DQuat::from_rotation_arc(pose.eye.normalize(), to)).view(view)
    };
    let level = keep_height(view, moved);
    CameraView { eye: level.eye.with_z(level.eye.z + metres.z), ..level }
}

/// All of the globe, north up.
pub fn home(view: &CameraView) -> CameraView {
    let place = PlateCarree::metres_from_degrees(HOME_DEG.into());
    let half_width = view.aspect().min(1.0) * (0.5 * view.fov_y_deg.to_radians()).tan();
    let half_angle = (HOME_SHARE * half_width).atan();
    let height_m = Wgs84::EQUATOR_RADIUS_M * (1.0 / half_angle.sin() - 1.0);
    let eye = place.extend(height_m.min(CEILING_M));
    CameraView { eye, heading_deg: 0.0, pitch_deg: -90.0, ..*view }
}

/// The pixel that a point in earth-centred coordinates is seen at.
pub fn pixel_of(view: &CameraView, point: DVec3) -> Option<[f64; 2]> {
    let place = Geodetic::from_plate_carree(view.eye);
    let from_eye = point - Wgs84::ecef_from_geodetic(&place);
    view.pixel_from_world(view.eye + place.ecef_from_local().transpose() * from_eye)
}

/// A turn about the earth's centre changes heights by what the ellipsoid is flat.
fn keep_height(before: &CameraView, moved: CameraView) -> CameraView {
    CameraView { eye: moved.eye.with_z(before.eye.z), pitch_deg: before.pitch_deg, ..moved }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    fn view(longitude: f64, latitude: f64, height_m: f64, heading_deg: f64) -> CameraView {
        let place = PlateCarree::metres_from_degrees(DVec2::new(longitude, latitude));
        CameraView {
            eye: place.extend(height_m),
            heading_deg,
            pitch_deg: -55.0,
            fov_y_deg: 50.0,
            viewport_px: [1_200, 800],
        }
    }

    fn sea(_: DVec2) -> Option<f64> {
        Some(0.0)
    }

    /// Over Europe, Fiji with the date line in view, and close to a pole.
    fn views() -> [CameraView; 4] {
        [
            view(8.0, 46.0, 900_000.0, 30.0),
            view(179.8, -17.0, 300_000.0, 100.0),
            view(-40.0, 88.5, 500_000.0, 250.0),
            CameraView { pitch_deg: -82.0, ..view(20.0, 5.0, 9_000_000.0, 0.0) },
        ]
    }

    #[test]
    fn the_held_point_follows_the_cursor() {
        for view in views() {
            let held = point_under(&view, [640.0, 430.0], &sea, view.eye.z);
            let moved = pan(&view, held, [500.0, 520.0]);
            let pixel = pixel_of(&moved, held).unwrap();
            assert!((pixel[0] - 500.0).abs() < 4.0 && (pixel[1] - 520.0).abs() < 4.0, "{pixel:?}");
            assert_eq!((moved.eye.z, moved.pitch_deg), (view.eye.z, view.pitch_deg));
        }
    }

    #[test]
    fn the_wheel_goes_to_the_point_under_the_cursor() {
        for view in views() {
            let target = point_under(&view, [700.0, 380.0], &sea, view.eye.z);
            let mut near = view;
            for _ in 0..10 {
                near = zoom(&near, target, 0.8);
            }
            let pixel = pixel_of(&near, target).unwrap();
            assert!(
                (pixel[0] - 700.0).abs() < 40.0 && (pixel[1] - 380.0).abs() < 40.0,
                "{pixel:?}"
            );
            let left = near.eye.z / view.eye.z;
            assert!((0.05..0.2).contains(&left), "{left}");
        }
    }

    #[test]
    fn turning_about_a_point_keeps_it_and_the_distance() {
        for view in views() {
            let centre = point_under(&view, [600.0, 400.0], &sea, view.eye.z);
            let distance_m = |view: &CameraView| (Pose::of(view).eye - centre).length();
            let turned = turn_about(&view, centre, 40.0, -45.0);
            let pixel = pixel_of(&turned, centre).unwrap();
            assert!((pixel[0] - 600.0).abs() < 1.0 && (pixel[1] - 400.0).abs() < 1.0, "{pixel:?}");
            assert!((distance_m(&turned) / distance_m(&view) - 1.0).abs() < 1.0e-9);
        }
    }

    #[test]
    fn flying_straight_on_goes_round_the_globe_over_the_pole() {
        let mut view = view(10.0, 80.0, 10_000.0, 0.0);
        for _ in 0..400 {
            view = fly(&view, dvec3(0.0, 100_000.0, 0.0));
        }
        // 40,000 km on, nearly all the way round: north over one pole and the other.
        let degrees = PlateCarree::degrees_from_metres(view.eye.truncate());
        assert!((degrees.x - 10.0).abs() < 1.0 && (degrees.y - 80.0).abs() < 2.0, "{degrees}");
        assert!(view.heading_deg.min(360.0 - view.heading_deg) < 1.0, "{}", view.heading_deg);
        assert_eq!(view.eye.z, 10_000.0);
    }

    #[test]
    fn home_shows_all_of_the_globe() {
        for viewport_px in [[1_200, 800], [500, 900]] {
            let home = home(&CameraView { viewport_px, ..views()[0] });
            let rim = Wgs84::EQUATOR_RADIUS_M / (home.eye.z + Wgs84::EQUATOR_RADIUS_M);
            let half_height = (0.5 * home.fov_y_deg.to_radians()).tan();
            let part = rim.asin().tan() / (half_height * home.aspect().min(1.0));
            assert!((0.8..0.9).contains(&part), "{part}");
        }
    }
}
