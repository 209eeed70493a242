//! The texture map against what pixels ask for: it finds all of it, whichever stage drops back faces, and the pictures
//! are the same where there is room.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::sync::Arc;

use glam::{DVec2, dvec2};
use terrain_core::residency::page_table::{FaceCulling, PagesAsked};
use terrain_core::selection::Strategy;
use terrain_core::{CameraView, RendererSettings};
use terrain_tests::{AnalyticSource, Bench, Surface};

const SIZE_PX: [u32; 2] = [320, 180];

/// Steep mountains, so that much of the ground turns its back on the eye or is hidden.
fn source() -> Arc<AnalyticSource> {
    let surface = Surface {
        height_m: |p| {
            900.0 * (p.x / 2000.0).sin() * (p.y / 2500.0).cos() + 200.0 * (p.x / 700.0).sin()
        },
        colour: |p| {
            let waves = (p.x / 37.0).sin() * (p.y / 53.0).cos() + (p.x / 610.0).sin();
            [(140.0 + 40.0 * waves) as u8, 130, (90.0 - 30.0 * waves) as u8]
        },
    };
    Arc::new(AnalyticSource::new(surface, DVec2::ZERO, 65_536.0, [6, 9]))
}

fn settings(strategy: Strategy, anisotropy: u32) -> RendererSettings {
    RendererSettings {
        strategy,
        cache_columns: 12,
        cache_rows: 12,
        max_tiles: 144,
        anisotropy,
        ..Default::default()
    }
}

/// Over a ridge, along the ground in a valley, steeply down, straight down from near and far, over the data's edge.
fn views() -> Vec<CameraView> {
    let view = |x: f64, y: f64, height_m, heading_deg, pitch_deg| CameraView {
        eye: dvec2(x, y).extend(height_m),
        heading_deg,
        pitch_deg,
        fov_y_deg: 50.0,
        viewport_px: SIZE_PX,
    };
    vec![
        view(-3_000.0, -9_000.0, 2_500.0, 20.0, -18.0),
        view(-3_000.0, -9_000.0, 1_300.0, 200.0, -5.0),
        view(1_200.0, 3_400.0, 450.0, 300.0, 3.0),
        view(-3_000.0, -9_000.0, 6_000.0, 95.0, -60.0),
        view(-3_000.0, -9_000.0, 1_500.0, 0.0, -90.0),
        view(-3_000.0, -9_000.0, 40_000.0, 0.0, -90.0),
        view(31_000.0, -33_500.0, 3_000.0, 315.0, -20.0),
    ]
}

/// Each page with each step alone.
fn single_steps(asked: &PagesAsked) -> Vec<(terrain_core::residency::page_table::PageId, u32)> {
    let bits = |steps: u32| (0..32).filter(move |bit| steps >> bit & 1 == 1);
    asked.iter().flat_map(|(page, steps)| bits(*steps).map(|bit| (*page, bit))).collect()
}

#[test]
fn the_map_marks_all_that_pixels_ask_for() {
    for anisotropy in [1, 8] {
        let Some(mut by_pixels) =
            Bench::new(source(), settings(Strategy::PageTable, anisotropy)).unwrap()
        else {
            return;
        };
        let mut by_map =
            Bench::new(source(), settings(Strategy::TextureMap, anisotropy)).unwrap().unwrap();
        let (mut asked_for, mut marked) = (0, 0);
        for view in views() {
            by_pixels.settle(&view).unwrap();
            by_map.settle(&view).unwrap();
            let needed = by_pixels.renderer.pages_asked().unwrap();
            let found = by_map.renderer.pages_asked().unwrap();
            let missing = single_steps(&needed)
                .into_iter()
                .filter(|(page, bit)| found.get(page).is_none_or(|steps| steps >> bit & 1 == 0))
                .collect::<Vec<_>>();
            println!(
                "{anisotropy} taps, {:?}: {} pages asked for, {} marked",
                view.eye,
                needed.len(),
                found.len()
            );
            assert!(missing.is_empty(), "{view:?}: {missing:?}");
            asked_for += needed.len();
            marked += found.len();
        }
        let surplus = marked as f64 / asked_for as f64 - 1.0;
        println!("{anisotropy} taps: {:.1} % more pages than asked for", 100.0 * surplus);
        // It finds what is needed, not everything.
        assert!(surplus < 0.6, "{surplus}");
    }
}

#[test]
fn whichever_stage_drops_back_faces_the_same_is_marked() {
    let with = |face_culling| {
        let settings = RendererSettings { face_culling, ..settings(Strategy::TextureMap, 4) };
        Bench::new(source(), settings).unwrap()
    };
    let Some(mut reference) = with(FaceCulling::Fragment) else { return };
    let mut others = [FaceCulling::Compute, FaceCulling::Vertex].map(|way| with(way).unwrap());
    for view in views() {
        reference.settle(&view).unwrap();
        let expected = reference.renderer.pages_asked().unwrap();
        for other in &mut others {
            other.settle(&view).unwrap();
            assert_eq!(other.renderer.pages_asked().unwrap(), expected, "{view:?}");
        }
    }
}

#[test]
fn with_room_for_all_the_picture_is_that_of_the_page_table() {
    let Some(mut by_pixels) = Bench::new(source(), settings(Strategy::PageTable, 1)).unwrap()
    else {
        return;
    };
    let mut by_map = Bench::new(source(), settings(Strategy::TextureMap, 1)).unwrap().unwrap();
    for view in views().iter().take(4) {
        let expected = by_pixels.settled_picture(view).unwrap();
        let picture = by_map.settled_picture(view).unwrap();
        let worst = picture.rgba.iter().zip(&expected.rgba).map(|(a, b)| a.abs_diff(*b)).max();
        // Which slots the pages got goes by the order in which they came; filtering rounds accordingly.
        assert!(worst.unwrap() <= 1, "{view:?}: {worst:?}");
    }
}
