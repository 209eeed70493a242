//! Models on a globe.

use std::sync::Arc;

use glam::{DVec3, dvec2, dvec3};
use terrain_core::CameraView;
use terrain_core::geodesy::PlateCarree;
use terrain_core::selection::Strategy;
use terrain_core::surface::models::Standing;
use terrain_tests::{AnalyticSource, Bench, Surface};

use crate::drawn::{assert_is_seen_at, expected_px};
use crate::{RED, extent_px, plain, plain_wall, scene, standing, view};

/// Earth-centred place of longitude and latitude in degrees and metres above WGS 84: the textbook's formula.
fn ecef([longitude, latitude]: [f64; 2], height_m: f64) -> DVec3 {
    let [(sin_lon, cos_lon), (sin_lat, cos_lat)] =
        [longitude, latitude].map(|degrees: f64| degrees.to_radians().sin_cos());
    let flattening = 1.0 / 298.257_223_563;
    let e2 = flattening * (2.0 - flattening);
    let radius_m = 6_378_137.0 / (1.0 - e2 * sin_lat * sin_lat).sqrt();
    let across_m = (radius_m + height_m) * cos_lat;
    dvec3(across_m * cos_lon, across_m * sin_lon, (radius_m * (1.0 - e2) + height_m) * sin_lat)
}

/// A wall some kilometres away stands where longitude and latitude say, leans away with the curve of the earth, and is
/// set on the ground; over the date line and near a pole too.
#[test]
fn models_on_the_globe_are_seen_where_longitude_and_latitude_say() {
    let surface = Surface { height_m: |_| 50.0, colour: |_| [40, 160, 60] };
    let source = Arc::new(AnalyticSource::globe(surface, [3, 3], [128, 256]));
    for [longitude, latitude] in [[10.0, 47.0], [-179.999, -35.0], [60.0, 89.0]] {
        let south = [longitude - 0.002, latitude - 0.05];
        let place =
            |degrees: [f64; 2]| PlateCarree::metres_from_degrees(dvec2(degrees[0], degrees[1]));
        let mut wall = standing(0, place([longitude, latitude]), Standing::OnGround);
        wall.scale = 10.0;
        let Some(mut bench) = Bench::new(source.clone(), plain(Strategy::PageTable)).unwrap()
        else {
            return;
        };
        bench.renderer.set_models(scene(vec![plain_wall(RED)], vec![wall])).unwrap();
        let view = CameraView {
            eye: place(south).extend(400.0),
            pitch_deg: 0.0,
            fov_y_deg: 20.0,
            ..view()
        };
        let picture = bench.settled_picture(&view).unwrap();

        // The eye's axes from the places of points beside it.
        let eye = ecef(south, 400.0);
        let up = (ecef(south, 401.0) - eye).normalize();
        let east = DVec3::Z.cross(up).normalize();
        let axes = [east, up.cross(east), up];
        let (sin, cos) = longitude.to_radians().sin_cos();
        let wall_east = dvec3(-sin, cos, 0.0);
        let [foot, top] = [50.0, 650.0].map(|height_m| ecef([longitude, latitude], height_m));
        let corners =
            [foot, top].into_iter().flat_map(|at| [at - 200.0 * wall_east, at + 200.0 * wall_east]);
        let seen = corners.map(|at| view.eye + DVec3::from(axes.map(|axis| axis.dot(at - eye))));
        assert_is_seen_at(
            extent_px(&picture, 0),
            expected_px(&view, seen),
            &format!("at {longitude}, {latitude}"),
        );
    }
}
