//! Imagery in the drawn picture: what grows steadily over the ground grows steadily in the picture,
//! across the borders of tiles and of levels. A seam would be a jump, a smear a stretch without change.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{DVec2, DVec3, dvec3};
use terrain_core::{CameraView, RendererSettings};
use terrain_tests::{AnalyticSource, Bench, Surface};

const SIZE_PX: [u32; 2] = [320, 180];
const ROOT_SIZE_M: f64 = 65_536.0;
/// Metres over which the ramp rises by one value of 255, and its value in the middle.
const METRES_A_VALUE: f64 = 60.0;
const MIDDLE: f64 = 128.0;
/// How far the picture is looked at: farther out haze changes the ramp.
const MOST_DISTANCE_M: f64 = 15_000.0;

/// The value of the ramp, sRGB-encoded, within 0..255.
fn ramp(east_m: f64) -> f64 {
    (MIDDLE + east_m / METRES_A_VALUE).clamp(10.0, 245.0)
}

fn level_ground() -> Surface {
    Surface { height_m: |_| 0.0, colour: |p| [ramp(p.x).round() as u8, 90, 90] }
}

/// North over level ground: along every row of the picture the ramp rises to the right.
fn view() -> CameraView {
    CameraView {
        eye: dvec3(2_250.0, -9_000.0, 1_800.0),
        heading_deg: 0.0,
        pitch_deg: -22.0,
        fov_y_deg: 40.0,
        viewport_px: SIZE_PX,
    }
}

/// The red values of the picture row by row, and what the ramp is where each pixel looks; NaN where
/// that is far.
struct Drawn {
    red: Vec<f64>,
    expected: Vec<f64>,
}

fn draw(anisotropy: u32) -> Option<Drawn> {
    let source = Arc::new(AnalyticSource::new(level_ground(), DVec2::ZERO, ROOT_SIZE_M, [4, 7]));
    let settings = RendererSettings { anisotropy, ..Default::default() };
    let mut bench = Bench::new(source, settings).unwrap()?;
    let picture = bench.settled_picture(&view()).unwrap();
    let tiles = &bench.renderer.selection().tiles;
    let levels = tiles.iter().map(|tile| tile.level).collect::<BTreeSet<_>>();
    let tiles = tiles.len();
    println!("{tiles} tiles of levels {levels:?}");
    assert!(levels.len() >= 4 && tiles >= 16, "{tiles} tiles of levels {levels:?}");
    let expected = |point: &DVec3| {
        let is_far = point.distance(view().eye) > MOST_DISTANCE_M;
        if is_far { f64::NAN } else { ramp(point.x) }
    };
    let points = bench.ground_points(&view()).unwrap();
    Some(Drawn {
        red: picture.rgba.chunks_exact(4).map(|pixel| f64::from(pixel[0])).collect(),
        expected: points.iter().map(expected).collect(),
    })
}

/// Changes over `length` neighbouring pixels, as drawn and of the ramp: where it rises, and bright enough
/// that a little haze hardly changes it.
fn stretches(drawn: &Drawn, length: usize) -> Vec<(f64, f64)> {
    let rows = drawn.red.chunks_exact(SIZE_PX[0] as usize);
    let expected_rows = drawn.expected.chunks_exact(SIZE_PX[0] as usize);
    let mut changes = Vec::new();
    for (red, expected) in rows.zip(expected_rows) {
        for start in 0..red.len() - length {
            let (first, last) = (expected[start], expected[start + length]);
            // Not so where either is NaN.
            if first > 90.0 && last < 240.0 {
                changes.push((red[start + length] - red[start], last - first));
            }
        }
    }
    changes
}

#[test]
fn a_ramp_rises_steadily_across_tiles_and_levels() {
    for anisotropy in [1, 8] {
        let Some(drawn) = draw(anisotropy) else { return };
        let steps = stretches(&drawn, 1);
        assert!(steps.len() > 10_000, "only {} pixels show the ramp", steps.len());
        for (change, expected) in &steps {
            // Tiles of each level hold the ramp rounded to whole values, and so does the picture.
            assert!(*change >= -1.0, "{anisotropy} taps: falls by {}", -change);
            assert!(*change <= expected + 1.5, "{anisotropy} taps: jumps by {change}");
        }
        let falls = steps.iter().filter(|(change, _)| *change < 0.0).count();
        println!("{anisotropy} taps: {falls} of {} steps fall, by 1 of 255", steps.len());
        assert!(falls * 200 < steps.len(), "{anisotropy} taps: {falls} falls");
        // Haze lightens even what is near, so that it changes a little less.
        const STRETCH_PX: usize = 24;
        for (change, expected) in stretches(&drawn, STRETCH_PX) {
            let least = 0.65 * expected - 1.0;
            assert!(change >= least, "{anisotropy} taps: {change} instead of {expected}");
        }
    }
}
