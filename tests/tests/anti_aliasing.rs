//! Smooth edges: the ground's edge against the sky covers each pixel as far as it should, and the rest
//! of the picture is what it is without.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::sync::Arc;

use glam::{DVec2, DVec3, dvec2, dvec3};
use terrain_core::{AntiAliasing, CameraView, DebugView, RendererSettings};
use terrain_tests::{AnalyticSource, Bench, Picture, Surface};

const SIZE_PX: [u32; 2] = [320, 180];
const ROOT_SIZE_M: f64 = 65_536.0;

/// A slope up to the north, dark, whose upper edge stands against the sky as a straight ridge.
fn ridge() -> Surface {
    Surface { height_m: |p| 0.25 * p.y + 0.02 * p.x, colour: |_| [50, 60, 40] }
}

fn view() -> CameraView {
    CameraView {
        eye: dvec3(-4_000.0, 12_000.0, 4_000.0),
        heading_deg: 12.0,
        pitch_deg: 6.0,
        fov_y_deg: 40.0,
        viewport_px: SIZE_PX,
    }
}

fn drawn(settings: RendererSettings) -> Option<Picture> {
    let source = Arc::new(AnalyticSource::new(ridge(), DVec2::ZERO, ROOT_SIZE_M, [5, 3]));
    let mut bench = Bench::new(source, settings).unwrap()?;
    Some(bench.settled_picture(&view()).unwrap())
}

fn with(anti_aliasing: AntiAliasing) -> RendererSettings {
    RendererSettings { anti_aliasing, ..Default::default() }
}

/// Row of the picture, in pixels and parts of one from its upper border, at which the ridge crosses
/// the vertical line `x` pixels from the left border.
fn ridge_row(x: f64) -> f64 {
    let end = |east_m: f64| -> DVec2 {
        let place = dvec2(east_m, 0.5 * ROOT_SIZE_M);
        let height_m = (ridge().height_m)(place);
        view().pixel_from_world(DVec3::new(place.x, place.y, height_m)).unwrap().into()
    };
    let (west, east) = (end(-8_000.0), end(16_000.0));
    west.y + (x - west.x) / (east.x - west.x) * (east.y - west.y)
}

/// Part of a pixel below the ridge: in f64, by thin vertical strips.
fn coverage(x: u32, y: u32) -> f64 {
    const STRIPS: u32 = 64;
    let below = |strip: u32| {
        let row = ridge_row(f64::from(x) + (f64::from(strip) + 0.5) / f64::from(STRIPS));
        (f64::from(y) + 1.0 - row).clamp(0.0, 1.0)
    };
    (0..STRIPS).map(below).sum::<f64>() / f64::from(STRIPS)
}

fn linear(encoded: u8) -> f64 {
    let value = f64::from(encoded) / 255.0;
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// For every pixel on the ridge: the part of it that is ground, by its red light between the sky's
/// above and the ground's below; and the part that should be.
fn edge(picture: &Picture) -> Vec<(f64, f64)> {
    let red = |x, y| linear(picture.pixel(x, y)[0]);
    let mut pairs = Vec::new();
    for x in 0..SIZE_PX[0] {
        let row = ridge_row(f64::from(x) + 0.5) as u32;
        let (sky, ground) = (red(x, row - 3), red(x, row + 3));
        for y in row - 1..=row + 1 {
            let expected = coverage(x, y);
            if expected > 0.0 && expected < 1.0 {
                pairs.push(((red(x, y) - sky) / (ground - sky), expected));
            }
        }
    }
    pairs
}

fn mean_error(pairs: &[(f64, f64)]) -> f64 {
    pairs.iter().map(|(found, expected)| (found - expected).abs()).sum::<f64>() / pairs.len() as f64
}

#[test]
fn a_ridge_covers_each_pixel_as_far_as_it_should_in_linear_light() {
    let Some(smooth) = drawn(with(AntiAliasing::FourSamples)) else { return };
    let Some(hard) = drawn(with(AntiAliasing::Off)) else { return };
    let (smooth, hard) = (edge(&smooth), edge(&hard));
    assert!(smooth.len() > 300, "the ridge crosses {} pixels", smooth.len());
    let partly =
        |pairs: &[(f64, f64)]| pairs.iter().filter(|(found, _)| (0.1..0.9).contains(found)).count();
    assert_eq!(partly(&hard), 0, "without smoothing each pixel is ground or sky");
    assert!(partly(&smooth) > smooth.len() / 2, "{} of {}", partly(&smooth), smooth.len());
    // Four samples tell coverage in steps of a quarter.
    for (found, expected) in &smooth {
        assert!((found - expected).abs() < 0.3, "{found} of a pixel instead of {expected}");
    }
    let (smooth_error, hard_error) = (mean_error(&smooth), mean_error(&hard));
    println!(
        "mean error of coverage: {smooth_error:.3} with four samples, {hard_error:.3} with one"
    );
    assert!(smooth_error < 0.09 && hard_error > 0.2);
}

/// Within a triangle nothing changes. A pixel across triangles is drawn from each for its part, where
/// one sample takes all from one: the colours of neighbours on one surface differ by next to nothing.
#[test]
fn away_from_edges_the_picture_is_what_it_is_without() {
    let Some(smooth) = drawn(with(AntiAliasing::FourSamples)) else { return };
    let Some(hard) = drawn(with(AntiAliasing::Off)) else { return };
    let (mut compared, mut differing) = (0, 0);
    for (x, y) in (0..SIZE_PX[1]).flat_map(|y| (0..SIZE_PX[0]).map(move |x| (x, y))) {
        if (f64::from(y) + 0.5 - ridge_row(f64::from(x) + 0.5)).abs() < 2.0 {
            continue;
        }
        let (a, b) = (smooth.pixel(x, y), hard.pixel(x, y));
        let most = (0..4).map(|channel| a[channel].abs_diff(b[channel])).max().unwrap();
        assert!(most <= 1, "{a:?} instead of {b:?} at {x}, {y}");
        compared += 1;
        differing += u32::from(most > 0);
    }
    println!("{differing} of {compared} pixels differ by 1 of 255");
    assert!(differing * 50 < compared, "{differing} of {compared}");
}

#[test]
fn every_view_of_the_ground_can_be_smoothed_and_is_as_bright_as_without() {
    let views = [
        RendererSettings { debug_view: DebugView::TileBorders, ..Default::default() },
        RendererSettings { debug_view: DebugView::Levels, ..Default::default() },
        RendererSettings { debug_view: DebugView::Shading, ..Default::default() },
        RendererSettings { wireframe: true, ..Default::default() },
    ];
    for settings in views {
        let with = |anti_aliasing| drawn(RendererSettings { anti_aliasing, ..settings });
        let Some(smooth) = with(AntiAliasing::FourSamples) else { return };
        let Some(hard) = with(AntiAliasing::Off) else { return };
        let brightness = |picture: &Picture| {
            let sum = picture.rgba.iter().map(|&value| u64::from(value)).sum::<u64>();
            sum as f64 / picture.rgba.len() as f64
        };
        let (smooth_mean, hard_mean) = (brightness(&smooth), brightness(&hard));
        println!("{settings:?}: mean {smooth_mean:.1} of 255, {hard_mean:.1} without");
        assert!(smooth != hard, "{settings:?}");
        assert!((smooth_mean - hard_mean).abs() < 6.0, "{settings:?}");
    }
}
