//! Imagery through a page table: every way to learn what pixels need comes to the same picture, which is that of
//! tile scheduling; a still camera comes to rest however small the cache. What every strategy promises is tested with
//! all of them.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::sync::Arc;

use glam::{DVec2, dvec2};
use terrain_core::dataset::TileSource;
use terrain_core::residency::page_table::PageFeedback;
use terrain_core::selection::Strategy;
use terrain_core::{AntiAliasing, CameraView, RendererSettings};
use terrain_tests::{AnalyticSource, Bench, Picture, Reluctant, Surface};

const SIZE_PX: [u32; 2] = [320, 180];

/// Mountains with waves on them that are finer than the coarse levels can show.
fn source() -> Arc<AnalyticSource> {
    let surface = Surface {
        height_m: |p| {
            900.0 * (p.x / 4000.0).sin() * (p.y / 5000.0).cos() + 200.0 * (p.x / 900.0).sin()
        },
        colour: |p| {
            let waves = (p.x / 37.0).sin() * (p.y / 53.0).cos() + (p.x / 610.0).sin();
            [(140.0 + 40.0 * waves) as u8, 130, (90.0 - 30.0 * waves) as u8]
        },
    };
    Arc::new(AnalyticSource::new(surface, DVec2::ZERO, 65_536.0, [6, 6]))
}

fn roomy() -> RendererSettings {
    RendererSettings {
        strategy: Strategy::PageTable,
        cache_columns: 12,
        cache_rows: 12,
        max_tiles: 144,
        ..Default::default()
    }
}

fn view(heading_deg: f64, pitch_deg: f64, height_m: f64) -> CameraView {
    CameraView {
        eye: dvec2(-3_000.0, -9_000.0).extend(height_m),
        heading_deg,
        pitch_deg,
        fov_y_deg: 50.0,
        viewport_px: SIZE_PX,
    }
}

/// From far above, over a ridge, steeply down, and straight down from near and far.
fn views() -> [CameraView; 5] {
    [
        view(20.0, -18.0, 2_500.0),
        view(200.0, -5.0, 1_300.0),
        view(95.0, -60.0, 6_000.0),
        view(0.0, -90.0, 1_500.0),
        view(0.0, -90.0, 40_000.0),
    ]
}

fn bench(settings: RendererSettings) -> Option<Bench> {
    Bench::new(source(), settings).unwrap()
}

/// The mean difference of all channels, and the part of the pixels of which one differs by more than 24.
fn difference(a: &Picture, b: &Picture) -> (f64, f64) {
    let channels = || a.rgba.iter().zip(&b.rgba).map(|(a, b)| f64::from(a.abs_diff(*b)));
    let pixels = a.rgba.chunks_exact(4).zip(b.rgba.chunks_exact(4));
    let differs = |(a, b): &(&[u8], &[u8])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 24);
    let differing = pixels.filter(differs).count() as f64;
    let count = a.rgba.len() as f64;
    (channels().sum::<f64>() / count, 4.0 * differing / count)
}

#[test]
fn every_way_to_learn_what_pixels_need_comes_to_the_same_picture() {
    let with = |page_feedback| bench(RendererSettings { page_feedback, ..roomy() });
    let Some(mut list) = with(PageFeedback::List) else { return };
    let mut others = [PageFeedback::Full, PageFeedback::Jittered].map(|way| with(way).unwrap());
    for view in views().iter().take(3) {
        let record = list.settle(view).unwrap();
        assert_eq!((record.tiles_missing, record.region_age_frames), (0, Some(0)), "{record:?}");
        let picture = list.settled_picture(view).unwrap();
        for other in &mut others {
            let theirs = other.settle(view).unwrap();
            let pages = |record: &terrain_core::measure::FrameRecord| {
                (record.tiles_selected, record.tiles_resident, record.finest_level)
            };
            assert_eq!(pages(&theirs), pages(&record), "{:?}", other.renderer.settings());
            // Which slots the pages got goes by the order in which they came; filtering rounds accordingly.
            let theirs = other.settled_picture(view).unwrap();
            let worst = picture.rgba.iter().zip(&theirs.rgba).map(|(a, b)| a.abs_diff(*b)).max();
            assert!(worst.unwrap() <= 1, "{worst:?}");
        }
    }
}

#[test]
fn with_room_for_all_the_picture_is_that_of_tile_scheduling() {
    for (anisotropy, anti_aliasing) in [(1, AntiAliasing::Off), (8, AntiAliasing::FourSamples)] {
        let settings = RendererSettings { anisotropy, anti_aliasing, ..roomy() };
        let Some(mut paged) = bench(settings) else { return };
        let strategy = Strategy::CpuFrustum;
        let mut tiled = bench(RendererSettings { strategy, ..settings }).unwrap();
        for view in views() {
            let tiles = tiled.settle(&view).unwrap().tiles_selected;
            let pages = paged.settle(&view).unwrap().tiles_selected;
            let pictures =
                [&mut tiled, &mut paged].map(|bench| bench.settled_picture(&view).unwrap());
            let (mean, differing) = difference(&pictures[0], &pictures[1]);
            println!(
                "{anisotropy} taps: {tiles} tiles, {pages} pages; {mean:.3} of 255 in the mean, {:.2} % of the pixels by more than 24",
                100.0 * differing
            );
            // From straight above, footprints that are not quite square take two taps of a level finer than tiles
            // are chosen by.
            assert!(mean < 2.0, "{view:?}: {mean}");
            assert!(differing < 0.006, "{view:?}: {differing}");
        }
    }
}

#[test]
fn a_still_camera_comes_to_rest_and_moves_no_byte() {
    for (what, settings) in [
        ("roomy", roomy()),
        ("small", RendererSettings { texel_px: 0.5, ..RendererSettings::default() }),
        ("tiny", RendererSettings { cache_columns: 2, cache_rows: 2, max_tiles: 4, ..roomy() }),
        ("one slot", RendererSettings { cache_columns: 1, cache_rows: 1, max_tiles: 1, ..roomy() }),
    ] {
        let settings = RendererSettings { strategy: Strategy::PageTable, ..settings };
        let Some(mut bench) = bench(settings) else { return };
        for view in &views()[..3] {
            let settled = bench.settle(view).unwrap();
            assert_eq!(settled.strategy, "page-table");
            assert!(settled.tiles_selected <= settings.max_tiles as u64, "{what}: {settled:?}");
            assert!(!bench.renderer.needs_frame(view), "{what}: goes on for ever");
            let still = bench.draw(view).unwrap();
            let moved = (still.upload_bytes, still.disk_bytes, still.readback_bytes);
            assert_eq!((moved, still.tiles_new), ((0, 0, 0), 0), "{what}");
            let turned = CameraView { heading_deg: view.heading_deg + 0.1, ..*view };
            assert!(bench.renderer.needs_frame(&turned));
        }
    }
}

/// With a cache far too small all pages are drawn coarser, by as much as the view asks, whatever the camera saw
/// before.
#[test]
fn the_way_to_a_view_does_not_show() {
    for settings in
        [roomy(), RendererSettings { cache_columns: 3, cache_rows: 3, max_tiles: 8, ..roomy() }]
    {
        let Some(mut flown) = bench(settings) else { return };
        for step in 0..15 {
            flown.draw(&view(25.0 * f64::from(step), -20.0, 2_000.0)).unwrap();
        }
        let here = view(20.0, -18.0, 2_500.0);
        let in_flight = flown.settled_picture(&here).unwrap();
        let fresh = bench(settings).unwrap().settled_picture(&here).unwrap();
        // Which slots the pages got goes by the order in which they came; filtering rounds accordingly.
        let worst = in_flight.rgba.iter().zip(&fresh.rgba).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(worst.unwrap() <= 1, "the picture depends on the way there: {worst:?}");
    }
}

#[test]
fn in_flight_little_comes_back_and_the_budget_holds() {
    let settings = RendererSettings { strategy: Strategy::PageTable, ..Default::default() };
    let Some(mut bench) = bench(settings) else { return };
    let (mut most_back, mut back, mut most_table) = (0, 0, 0);
    for step in 0..40 {
        let view = view(f64::from(step), -18.0, 2_500.0);
        let record = bench.draw(&view).unwrap();
        bench.gpu.wait().unwrap();
        if step > 0 {
            assert_eq!(record.region_age_frames, Some(1), "{record:?}");
        }
        // A tile of 392 texels a side goes through whatever its size.
        let tiles = record.upload_dem_bytes + record.upload_dom_bytes;
        assert!(tiles <= settings.upload_budget_bytes + 392 * 392 * 4, "{record:?}");
        most_back = most_back.max(record.readback_bytes);
        back += record.readback_bytes;
        most_table = most_table.max(record.upload_table_bytes);
    }
    println!("{} bytes back a frame, at most {most_back}; tables at most {most_table}", back / 40);
    // The first list is copied in full length.
    assert!(most_back <= 8 + 256 * 8, "{most_back}");
}

#[test]
fn pages_fade_in_and_the_coarsest_shows_until_they_come() {
    let reluctant = Reluctant::new(source(), false);
    let shared: Arc<dyn TileSource> = Arc::clone(&reluctant) as Arc<dyn TileSource>;
    let Some(mut bench) = Bench::new(shared, roomy()).unwrap() else { return };
    let view = view(0.0, -90.0, 4_000.0);
    for _ in 0..4 {
        bench.draw(&view).unwrap();
        bench.gpu.wait().unwrap();
    }
    let coarsest = Picture::read(&bench.gpu, &bench.target).unwrap();
    let blue = |picture: &Picture| picture.pixel(SIZE_PX[0] / 2, SIZE_PX[1] / 2)[2];
    assert!(blue(&coarsest) > 20, "there is ground from the first frame on");
    reluctant.release();
    let settled = bench.settled_picture(&view).unwrap();
    let (mean, _) = difference(&coarsest, &settled);
    assert!(mean > 1.0, "the pages show something else: {mean}");
    assert!(!bench.renderer.needs_frame(&view));
}
