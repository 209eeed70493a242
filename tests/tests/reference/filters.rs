//! The reference against itself with other filters.

use glam::dvec3;
use terrain_core::CameraView;
use terrain_core::reference::{ReferenceScene, ReferenceSettings};

use super::{demo, differences, himalaya, mean, take};

#[test]
fn coarser_levels_of_imagery_give_the_same_picture_as_the_finest() {
    let (_folder, dataset) = demo();
    let scene = ReferenceScene::open(dataset).unwrap();
    // The same rays for both, so that only the filters differ.
    let settings = ReferenceSettings {
        vertical_exaggeration: 15.0,
        colour_tolerance: 0.0,
        most_rays: 32,
        ..Default::default()
    };
    let finest = ReferenceSettings { finest_imagery: true, ..settings };
    let view = CameraView { eye: dvec3(9.0e6, 1.0e6, 2.2e6), ..himalaya() };
    let [a, b] = [settings, finest].map(|settings| take(&scene, &view, &settings));
    let steps = differences(&a.rgba, &b.rgba);
    let (p99, worst) = (steps[steps.len() * 99 / 100], steps[steps.len() - 1]);
    println!("mean {:.3}, p99 {p99}, worst {worst} steps", mean(&steps));
    assert!(mean(&steps) < 0.15 && p99 <= 1 && worst <= 6);
}

#[test]
fn colours_are_within_their_stated_error_of_a_thousand_rays() {
    let (_folder, dataset) = demo();
    let scene = ReferenceScene::open(dataset).unwrap();
    let settings = ReferenceSettings { vertical_exaggeration: 15.0, ..Default::default() };
    let thousand = ReferenceSettings { colour_tolerance: 0.0, most_rays: 1024, ..settings };
    let high = CameraView { eye: dvec3(9.2e6, 1.0e6, 2.2e6), pitch_deg: -36.0, ..himalaya() };
    for (name, view) in [("low", himalaya()), ("high", high)] {
        let view = CameraView { viewport_px: [64, 36], ..view };
        let [a, b] = [settings, thousand].map(|settings| take(&scene, &view, &settings));
        let steps = differences(&a.rgba, &b.rgba);
        let (p99, worst) = (steps[steps.len() * 99 / 100], steps[steps.len() - 1]);
        println!("{name}: mean {:.3}, p99 {p99}, worst {worst} steps", mean(&steps));
        assert!(mean(&steps) < 1.0 && p99 <= 4, "{name}");
    }
}
