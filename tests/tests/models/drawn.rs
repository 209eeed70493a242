//! Where models are seen, and when.

use std::sync::Arc;

use glam::{DVec3, dvec2, dvec3, vec3};
use terrain_core::selection::Strategy;
use terrain_core::surface::models::{ModelInstance, ModelPose, Standing};
use terrain_core::{AntiAliasing, CameraView};

use crate::{BLUE, RED, bench, extent_px, plain, plain_wall, scene, standing, view};

/// The pixels between which the box round world points is seen.
pub fn expected_px(view: &CameraView, points: impl Iterator<Item = DVec3>) -> [[f64; 2]; 2] {
    points.map(|point| view.pixel_from_world(point).unwrap()).fold(
        [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]],
        |[low, high], at| {
            [[low[0].min(at[0]), low[1].min(at[1])], [high[0].max(at[0]), high[1].max(at[1])]]
        },
    )
}

/// Asserts that the extent is that of what covers these pixels.
pub fn assert_is_seen_at(found: Option<[[u32; 2]; 2]>, expected: [[f64; 2]; 2], what: &str) {
    let Some([first, last]) = found else { panic!("{what}: nothing of it is seen") };
    for axis in 0..2 {
        // A pixel is covered where its centre is.
        assert!(
            (f64::from(first[axis]) + 0.5 - expected[0][axis] - 0.5).abs() <= 0.51,
            "{what}: {first:?} {expected:?}"
        );
        assert!(
            (f64::from(last[axis]) + 0.5 - expected[1][axis] + 0.5).abs() <= 0.51,
            "{what}: {last:?} {expected:?}"
        );
    }
}

/// A corner projected in f64 is where the picture shows it, in the view's middle and near its edge, turned and
/// enlarged, whatever draws the ground.
#[test]
fn models_are_seen_where_they_stand_beside_every_strategy() {
    let height = Standing::Height(150.0);
    let instances = vec![
        standing(0, dvec2(-60.0, 300.0), height),
        ModelInstance { heading_deg: -35.0, scale: 1.5, ..standing(1, dvec2(75.0, 250.0), height) },
    ];
    let models = scene(vec![plain_wall(RED), plain_wall(BLUE)], instances.clone());
    for strategy in Strategy::ALL {
        let Some(mut bench) = bench(plain(strategy), models.clone()) else { return };
        let picture = bench.settled_picture(&view()).unwrap();
        for (instance, channel) in instances.iter().zip([0, 2]) {
            let pose = ModelPose::new(instance, 150.0);
            let corners = [-20.0, 20.0]
                .into_iter()
                .flat_map(|east| [0.0, 60.0].map(|up| vec3(east, 0.0, up)));
            let expected =
                expected_px(&view(), corners.map(|corner| pose.world_from_local(corner)));
            assert_is_seen_at(extent_px(&picture, channel), expected, strategy.name());
        }
    }
}

#[test]
fn ten_thousand_kilometres_from_the_origin_nothing_moves() {
    let far = dvec3(9_876_543.25, -4_321_098.75, 0.0);
    let instance = standing(0, far.truncate() + dvec2(-60.0, 300.0), Standing::Height(1_650.0));
    let Some(mut bench) =
        bench(plain(Strategy::CpuFrustum), scene(vec![plain_wall(RED)], vec![instance]))
    else {
        return;
    };
    let view = CameraView { eye: view().eye + far + dvec3(0.0, 0.0, 1_500.0), ..view() };
    let picture = bench.settled_picture(&view).unwrap();
    let pose = ModelPose::new(&instance, 1_650.0);
    let corners = [vec3(-20.0, 0.0, 0.0), vec3(20.0, 0.0, 60.0)];
    let expected = expected_px(&view, corners.iter().map(|corner| pose.world_from_local(*corner)));
    assert_is_seen_at(extent_px(&picture, 0), expected, "far from the origin");
}

/// On a slope the lower side stands on the ground and the higher one in it: of the wall's foot only that of its
/// lower side is seen, where the ground is, exaggerated or not.
#[test]
fn a_model_set_on_the_ground_stands_on_it_whatever_the_exaggeration() {
    let models =
        scene(vec![plain_wall(RED)], vec![standing(0, dvec2(0.0, 0.0), Standing::OnGround)]);
    for strategy in
        [Strategy::RttQuadtree, Strategy::RttQuadtreeGpu, Strategy::Clipmap, Strategy::CpuMesh]
    {
        for exaggeration in [1.0, 2.0] {
            let mut settings = plain(strategy);
            settings.vertical_exaggeration = exaggeration;
            let Some(mut bench) = bench(settings, models.clone()) else { return };
            let view =
                CameraView { eye: dvec3(0.0, -400.0, 60.0 + 100.0 * exaggeration), ..view() };
            let picture = bench.settled_picture(&view).unwrap();
            // Ground of 98 m below its western end, which carries it.
            let foot_m = 98.0 * exaggeration;
            let corners = [dvec3(-20.0, 0.0, foot_m), dvec3(20.0, 0.0, foot_m + 60.0)];
            let found = extent_px(&picture, 0);
            assert_is_seen_at(
                found,
                expected_px(&view, corners.into_iter()),
                &format!("{strategy} x {exaggeration}"),
            );
        }
    }
}

#[test]
fn ground_hides_models_and_models_hide_ground_and_one_another() {
    // Behind the ridge; before it, the blue one behind the red one.
    let height = Standing::Height(110.0);
    let hidden = [standing(0, dvec2(0.0, 2_400.0), height)];
    let before = [standing(0, dvec2(0.0, 300.0), height), standing(1, dvec2(0.0, 320.0), height)];
    let models = |instances: &[ModelInstance]| {
        scene(vec![plain_wall(RED), plain_wall(BLUE)], instances.to_vec())
    };
    let Some(mut bench) = bench(plain(Strategy::RttQuadtree), models(&hidden)) else { return };
    let picture = bench.settled_picture(&view()).unwrap();
    assert_eq!(extent_px(&picture, 0), None, "the ridge hides it");
    bench.renderer.set_models(models(&before)).unwrap();
    let picture = bench.settled_picture(&view()).unwrap();
    assert!(extent_px(&picture, 0).is_some());
    let blue = extent_px(&picture, 2);
    assert_eq!(blue, None, "the one before it is as large and nearer");
    // From behind a wall whose back is not drawn is not seen.
    let from_behind = CameraView { eye: dvec3(0.0, 900.0, 160.0), heading_deg: 180.0, ..view() };
    let picture = bench.settled_picture(&from_behind).unwrap();
    assert_eq!((extent_px(&picture, 0), extent_px(&picture, 2)), (None, None));
    let mut open = plain_wall(RED);
    open.single_sided = 0;
    bench.renderer.set_models(scene(vec![open], vec![before[0]])).unwrap();
    let picture = bench.settled_picture(&from_behind).unwrap();
    assert!(extent_px(&picture, 0).is_some(), "of both sides either is");
}

#[test]
fn a_still_camera_moves_no_byte_and_drawing_beside_the_frames_leaves_no_trace() {
    let instances = vec![standing(0, dvec2(-60.0, 300.0), Standing::OnGround)];
    let models = scene(vec![crate::textured::striped(64, [200, 40, 40])], instances);
    for strategy in Strategy::ALL {
        let Some(mut bench) = bench(plain(strategy), models.clone()) else { return };
        for view in [view(), CameraView { heading_deg: 180.0, ..view() }] {
            let settled = bench.settle(&view).unwrap();
            assert_eq!(settled.tiles_missing, 0, "{strategy}");
            let before = bench.picture().unwrap();
            assert!(!bench.renderer.needs_frame(&view), "{strategy}: goes on for ever");
            let elsewhere = CameraView { heading_deg: view.heading_deg + 40.0, ..view };
            bench.redraw(&elsewhere).unwrap();
            assert!(!bench.renderer.needs_frame(&view), "{strategy}");
            let still = bench.draw(&view).unwrap();
            assert_eq!(
                (still.upload_bytes, still.disk_bytes, still.readback_bytes),
                (0, 0, 0),
                "{strategy}"
            );
            assert!(bench.picture().unwrap() == before, "{strategy}");
        }
    }
}

#[test]
fn models_stay_when_the_strategy_changes_and_go_when_they_are_taken_away() {
    let instances = vec![standing(0, dvec2(0.0, 300.0), Standing::OnGround)];
    let models = scene(vec![plain_wall(RED)], instances);
    let Some(mut bench) = bench(plain(Strategy::RttQuadtree), models.clone()) else { return };
    bench.settle(&view()).unwrap();
    bench.change(|settings| settings.strategy = Strategy::PageTable).unwrap();
    let record = bench.settle(&view()).unwrap();
    assert!(extent_px(&bench.picture().unwrap(), 0).is_some());
    assert!(record.triangles_drawn > 2);
    bench.change(|settings| settings.anti_aliasing = AntiAliasing::FourSamples).unwrap();
    assert!(extent_px(&bench.settled_picture(&view()).unwrap(), 0).is_some());
    assert!(Arc::ptr_eq(bench.renderer.models().unwrap(), &models.unwrap()));
    bench.renderer.set_models(None).unwrap();
    assert!(bench.renderer.needs_frame(&view()));
    assert_eq!(extent_px(&bench.settled_picture(&view()).unwrap(), 0), None);
}
