//! Clipmaps: what their pictures, bytes and windows promise.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use glam::dvec2;
use terrain_core::selection::Strategy;
use terrain_core::{CameraView, RendererSettings};
use terrain_tests::{Bench, Picture, Ridges};

fn open(settings: RendererSettings) -> Option<Bench> {
    Bench::new(Ridges::source(), settings).unwrap()
}

fn settings() -> RendererSettings {
    RendererSettings {
        strategy: Strategy::Clipmap,
        upload_budget_bytes: 64 << 20,
        ..Default::default()
    }
}

/// Mean and greatest difference of the values of two pictures, of 255.
fn difference(a: &Picture, b: &Picture) -> (f64, u8) {
    let differences = a.rgba.iter().zip(&b.rgba).map(|(a, b)| a.abs_diff(*b));
    let sum = differences.clone().map(f64::from).sum::<f64>();
    (sum / a.rgba.len() as f64, differences.max().unwrap_or(0))
}

#[test]
fn the_picture_is_that_of_the_tiles() {
    // Where filters are to be as sharp as they can be, how levels are chosen matters least.
    let filtered = RendererSettings { anisotropy: 8, ..settings() };
    let Some(mut clipmap) = open(filtered) else { return };
    let roomy = RendererSettings {
        strategy: Strategy::RttQuadtree,
        cache_columns: 12,
        cache_rows: 12,
        max_tiles: 144,
        ..filtered
    };
    let Some(mut tiles) = open(roomy) else { return };
    for view in [
        Ridges::view(20.0, -18.0, 2_500.0),
        Ridges::view(200.0, -5.0, 1_300.0),
        Ridges::view(95.0, -60.0, 6_000.0),
        Ridges::view(0.0, -90.0, 40_000.0),
    ] {
        let (mean, most) = difference(
            &clipmap.settled_picture(&view).unwrap(),
            &tiles.settled_picture(&view).unwrap(),
        );
        println!("heading {}: mean {mean:.3} of 255, at most {most}", view.heading_deg);
        // Filters between levels differ; places do not.
        assert!(mean < 1.5, "{mean} of 255 in the mean");
    }
}

#[test]
fn a_turning_camera_sends_no_texels_and_nothing_is_read_back() {
    let Some(mut bench) = open(settings()) else { return };
    let settled = bench.settle(&Ridges::view(20.0, -18.0, 2_500.0)).unwrap();
    assert_eq!((settled.tiles_missing, settled.readback_bytes), (0, 0));
    for heading in 1..12 {
        let turned = Ridges::view(20.0 + 30.0 * f64::from(heading), -18.0, 2_500.0);
        let record = bench.draw(&turned).unwrap();
        assert_eq!((record.upload_dem_bytes, record.upload_dom_bytes), (0, 0), "{record:?}");
        assert_eq!((record.disk_bytes, record.upload_table_bytes), (0, 0), "{record:?}");
        assert!(record.upload_mesh_bytes < 4_000, "{record:?}");
        assert!(!bench.renderer.needs_frame(&turned));
    }
}

/// Of windows that move, only the texels that are new are sent: by arithmetic over all levels.
#[test]
fn a_moving_camera_sends_the_texels_its_windows_newly_cover() {
    let Some(mut bench) = open(settings()) else { return };
    let level = Ridges::view(0.0, -18.0, 1_500.0);
    bench.settle(&level).unwrap();
    // East by 4 texels of the finest imagery, 5.33 m each, and so on; windows follow in whole steps of 4.
    let texel_m = Ridges::ROOT_M / (384.0 * 32.0);
    let steps = 48;
    let mut sent = [0, 0];
    for step in 1..=steps {
        let east = f64::from(step) * 4.0 * texel_m;
        let moved = CameraView { eye: level.eye + dvec2(east, 0.0).extend(0.0), ..level };
        let record = bench.settle(&moved).unwrap();
        sent[0] += record.upload_dem_bytes;
        sent[1] += record.upload_dom_bytes;
    }
    // 4 / (2 tan(25 degrees) / 180) = 772 texels ask for windows of 768 texels of imagery at 4 bytes and
    // of 256 heights at 4 bytes.
    let windows = |count: f64, side: f64| {
        // Levels 0 and 1 are there as a whole; of the others each covers half the ground of the one before.
        (2..6).map(|level| count / 2.0_f64.powi(5 - level) * side * 4.0).sum::<f64>()
    };
    let texels = f64::from(4 * steps);
    let expected = [windows(texels / 3.0, 256.0), windows(texels, 768.0)];
    println!("{} and {} bytes where {expected:?} were expected", sent[0], sent[1]);
    // Whole steps of each level: coarse levels may be a step behind or ahead. Heights bring their jobs.
    for (sent, expected) in sent.into_iter().zip(expected) {
        let ratio = sent as f64 / expected;
        assert!((0.85..1.2).contains(&ratio), "{sent} bytes where {expected} were expected");
    }
}
