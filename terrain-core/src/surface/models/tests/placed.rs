//! Where models stand.

use glam::{DVec2, Vec3, dvec2, dvec3, vec3};
use proptest::prelude::*;

use crate::dataset::Shape;
use crate::geodesy::PlateCarree;
use crate::surface::models::{Model, ModelInstance, ModelPose, Standing};

fn instance(heading_deg: f64, scale: f64, standing: Standing) -> ModelInstance {
    ModelInstance { model: 0, place: dvec2(463_500.0, 6_820_000.0), standing, heading_deg, scale }
}

fn model() -> Model {
    Model { bounds_m: [vec3(-2.0, -1.0, -0.5), vec3(4.0, 3.0, 9.0)], ..Default::default() }
}

#[test]
fn headings_turn_clockwise_and_scales_enlarge() {
    for (heading_deg, north_goes) in [
        (0.0, dvec3(0.0, 1.0, 0.0)),
        (90.0, dvec3(1.0, 0.0, 0.0)),
        (180.0, dvec3(0.0, -1.0, 0.0)),
        (270.0, dvec3(-1.0, 0.0, 0.0)),
    ] {
        let pose = ModelPose::new(&instance(heading_deg, 3.0, Standing::OnGround), 100.0);
        let found = pose.world_from_local(Vec3::Y) - pose.origin;
        assert!((found - 3.0 * north_goes).length() < 1e-9, "{heading_deg}: {found}");
        let up = pose.world_from_local(Vec3::Z);
        assert_eq!(up.z, 103.0);
    }
}

proptest! {
    #[test]
    fn what_the_gpu_gets_is_the_place_relative_to_the_eye(
        heading in -720.0..720.0_f64, scale in 0.01..100.0_f64, at in prop::array::uniform3(-50.0..50.0_f32),
        eye in prop::array::uniform3(-1_000.0..1_000.0_f64),
    ) {
        let pose = ModelPose::new(&instance(heading, scale, Standing::OnGround), 812.5);
        let eye = pose.origin + dvec3(eye[0], eye[1], eye[2]);
        let local = Vec3::from(at);
        let exact = pose.world_from_local(local) - eye;
        let rows = pose.relative_to(eye, Shape::Plane).rows();
        let drawn = vec3(rows[0].dot(local.extend(1.0)), rows[1].dot(local.extend(1.0)), rows[2].dot(local.extend(1.0)));
        let size = exact.length() + 100.0 * scale;
        prop_assert!((drawn.as_dvec3() - exact).length() < 1e-6 * size, "{} {}", drawn, exact);
    }
}

#[test]
fn on_a_slope_the_lowest_ground_below_carries_the_model() {
    // The ground falls to the east.
    let ground = |point: DVec2| Some(500.0 - 0.25 * (point.x - 463_500.0));
    let model = model();
    let on_ground = instance(0.0, 2.0, Standing::OnGround);
    // Its eastern side is 8 m from the origin, its lowest point 1 m below it.
    assert_eq!(on_ground.origin_height_m(&model, (Shape::Plane, 1.0), ground), 498.0 + 1.0);
    assert_eq!(
        on_ground.origin_height_m(&model, (Shape::Plane, 3.0), ground),
        3.0 * 498.0 + 1.0,
        "the ground is raised, it is not"
    );
    // Turned by half, the western side lies there, 4 m away.
    let turned = instance(180.0, 2.0, Standing::OnGround);
    assert!((turned.origin_height_m(&model, (Shape::Plane, 1.0), ground) - 500.0).abs() < 1e-6);
    let nowhere = on_ground.origin_height_m(&model, (Shape::Plane, 1.0), |_| None);
    assert_eq!(nowhere, 1.0, "on no ground it stands at the datum");
    let fixed = instance(0.0, 2.0, Standing::Height(40.0));
    assert_eq!(fixed.origin_height_m(&model, (Shape::Plane, 2.0), ground), 80.0);
}

#[test]
fn a_sphere_holds_the_whole_model() {
    let model = model();
    let pose = ModelPose::new(&instance(33.0, 2.5, Standing::OnGround), 10.0);
    let eye = pose.origin + dvec3(100.0, -200.0, 50.0);
    let (centre, radius_m) = pose.relative_to(eye, Shape::Plane).bounding_sphere(&model);
    let [low, high] = model.bounds_m;
    for corner in 0..8 {
        let pick = |axis: usize| if (corner >> axis) & 1 == 0 { low[axis] } else { high[axis] };
        let from_eye_m = pose.world_from_local(vec3(pick(0), pick(1), pick(2))) - eye;
        assert!((from_eye_m - centre).length() <= radius_m * (1.0 + 1e-6));
    }
}

/// On the globe a tower stands along the ellipsoid's normal where it is, a metre is a metre at any latitude, and what
/// is far round the earth hangs below the eye's horizon.
#[test]
fn on_the_globe_models_stand_upright_where_they_are() {
    let at = |longitude: f64, latitude: f64| {
        PlateCarree::metres_from_degrees(dvec2(longitude, latitude))
    };
    let tower = ModelInstance { place: at(10.0, 60.0), ..instance(90.0, 1.0, Standing::OnGround) };
    let pose = ModelPose::new(&tower, 0.0);
    let beside = pose.relative_to(tower.place.extend(0.0), Shape::Globe).rows();
    let place = |rows: [glam::Vec4; 3], local: Vec3| rows.map(|row| row.dot(local.extend(1.0)));
    // Its north has turned to the east.
    assert_eq!(place(beside, vec3(0.0, 7.0, 0.0)).map(f32::round), [7.0, 0.0, 0.0]);
    assert_eq!(place(beside, vec3(0.0, 0.0, 9.0)).map(f32::round), [0.0, 0.0, 9.0]);
    let from_south = pose.relative_to(at(10.0, 59.0).extend(0.0), Shape::Globe).rows();
    let [east, north, up] = place(from_south, Vec3::ZERO);
    // A degree of the meridian there, and how far the ground falls off over it.
    assert!(east.abs() < 1.0 && (north - 111_400.0).abs() < 100.0, "{east} {north}");
    assert!((up + 111_400.0 * 0.5_f32.to_radians().sin()).abs() < 20.0, "{up}");
    let top = place(from_south, vec3(0.0, 0.0, 1_000.0));
    let lean_deg = (top[1] - north).atan2(top[2] - up).to_degrees();
    assert!((lean_deg - 1.0).abs() < 0.01, "{lean_deg}");
    let corners = tower.footprint(&model(), Shape::Globe);
    // Six metres along the model's x, which points south; eight along its y are twice as many on the map at 60 degrees.
    let size = corners[8] - corners[0];
    assert!((size.abs() - dvec2(4.0 / 0.5, 6.0)).length() < 1e-3, "{size}");
}
