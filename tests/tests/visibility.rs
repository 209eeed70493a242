//! What pixels saw, tile for tile, against all of the box round it: the picture is the same, with fewer
//! tiles, and next to none that a finer look would show.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::collections::HashSet;

use glam::dvec2;
use terrain_core::measure::FrameRecord;
use terrain_core::selection::{
    CoordinateImage, SeenGround, Selection, SelectionConfig, Strategy, Visibility, select,
    visible_region,
};
use terrain_core::{CameraView, RendererSettings};
use terrain_tests::{Bench, Picture, Ridges};

fn settings(strategy: Strategy) -> RendererSettings {
    RendererSettings {
        strategy,
        cache_columns: 14,
        cache_rows: 14,
        max_tiles: 196,
        ..Default::default()
    }
}

/// Down in the valleys, along and across them, and high above.
fn views() -> Vec<CameraView> {
    [(20.0, -4.0, 700.0), (95.0, -2.0, 500.0), (200.0, -6.0, 1_000.0), (310.0, -25.0, 6_000.0)]
        .into_iter()
        .map(|(heading_deg, pitch_deg, eye_m)| CameraView {
            viewport_px: [480, 270],
            ..Ridges::view(heading_deg, pitch_deg, eye_m)
        })
        .collect()
}

fn open(strategy: Strategy) -> Option<Bench> {
    Bench::new(Ridges::source(), settings(strategy)).unwrap()
}

/// The picture of a view at rest, and what it took.
fn settled(bench: &mut Bench, view: &CameraView, visibility: Visibility) -> (FrameRecord, Picture) {
    bench.change(|settings| settings.visibility = visibility).unwrap();
    let record = bench.settle(view).unwrap();
    assert!(!bench.renderer.needs_frame(view), "it comes to rest");
    (record, bench.picture().unwrap())
}

fn greatest_difference(a: &Picture, b: &Picture) -> u8 {
    a.rgba.iter().zip(&b.rgba).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
}

#[test]
fn exact_visibility_draws_the_same_picture_with_fewer_tiles() {
    for strategy in [Strategy::RttQuadtree, Strategy::RttQuadtreeGpu] {
        let Some(mut bench) = open(strategy) else { return };
        let mut hidden = 0;
        for view in views() {
            let (boxed, expected) = settled(&mut bench, &view, Visibility::Box);
            let (exact, picture) = settled(&mut bench, &view, Visibility::Exact);
            println!(
                "{strategy}: {} tiles by the box, {} by what pixels saw, {} hidden",
                boxed.tiles_selected, exact.tiles_selected, exact.tiles_hidden
            );
            assert_eq!((boxed.tiles_hidden, boxed.tiles_missing, exact.tiles_missing), (0, 0, 0));
            assert!(exact.tiles_selected <= boxed.tiles_selected);
            hidden += exact.tiles_hidden;
            // Which slots the tiles got goes by the order in which they came; filtering rounds so.
            assert!(greatest_difference(&picture, &expected) <= 1, "{view:?}");
        }
        assert!(hidden > 30, "{hidden}");
    }
}

/// The image that a coordinate pass of this size gives of the view.
fn image(bench: &mut Bench, view: &CameraView, [width, height]: [u32; 2]) -> CoordinateImage {
    let seen_by = CameraView { viewport_px: [width, height], ..*view };
    let points = bench.renderer.drawn_coordinates(&seen_by).unwrap();
    let origin = view.eye.truncate();
    let offset = |[x, y, _]: &[f64; 3]| (dvec2(*x, *y) - origin).as_vec2().to_array();
    let offsets = points.iter().map(offset).collect();
    CoordinateImage { width, height, origin, offsets, frame: 0, view: *view }
}

#[test]
fn next_to_no_tile_is_lost_between_the_pixels_of_a_small_image() {
    let Some(mut bench) = open(Strategy::RttQuadtree) else { return };
    let (mut tiles, mut lost) = (0, 0);
    for view in views() {
        settled(&mut bench, &view, Visibility::Box);
        let view = CameraView { viewport_px: [1280, 720], ..view };
        let tree = bench.renderer.tree().clone();
        let config = SelectionConfig { max_tiles: 10_000, ..Default::default() };
        let select_by = |image: &CoordinateImage| -> Selection {
            let region = visible_region(image);
            let seen = region.as_ref().map(|region| SeenGround { region, image: Some(image) });
            select(&tree, seen, &view, &config)
        };
        let full = select_by(&image(&mut bench, &view, [1280, 720]));
        let small = select_by(&image(&mut bench, &view, [160, 90]));
        let small_tiles: HashSet<_> = small.tiles.iter().copied().collect();
        let lost_here = full.tiles.iter().filter(|tile| !small_tiles.contains(tile)).count();
        println!(
            "{} tiles at 1280 x 720, {} hidden; at 160 x 90 {} tiles, {lost_here} of those lost",
            full.tiles.len(),
            full.statistics.hidden,
            small.tiles.len()
        );
        tiles += full.tiles.len();
        lost += lost_here;
    }
    // Slivers of ground that no pixel of the small image meets.
    assert!(20 * lost <= tiles, "{lost} of {tiles}");
}
