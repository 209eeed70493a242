//! Strategies side by side: each settles to the same picture where the cache has room for all it wants,
//! one can be switched for another, and none reads back more than it needs.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use terrain_core::measure::FrameRecord;
use terrain_core::selection::{Shortening, Strategy};
use terrain_core::{CameraView, LookupMethod, RendererSettings};
use terrain_tests::{Bench, Picture, Ridges};

/// A tile of the source's imagery, 392 texels a side with its gutter.
const LARGEST_TILE_BYTES: u32 = 392 * 392 * 4;

/// A cache with room for all that a view of this size wants.
fn roomy(strategy: Strategy) -> RendererSettings {
    RendererSettings {
        strategy,
        cache_columns: 12,
        cache_rows: 12,
        max_tiles: 144,
        ..Default::default()
    }
}

fn open(settings: RendererSettings) -> Option<Bench> {
    Bench::new(Ridges::source(), settings).unwrap()
}

fn switch(bench: &mut Bench, strategy: Strategy) {
    bench.change(|settings| settings.strategy = strategy).unwrap();
}

/// The part of the pixels that differ at all, and the greatest difference of a channel.
fn difference(a: &Picture, b: &Picture) -> (f64, u8) {
    let pixels = || a.rgba.chunks_exact(4).zip(b.rgba.chunks_exact(4));
    let differing = pixels().filter(|(a, b)| a != b).count();
    let greatest = a.rgba.iter().zip(&b.rgba).map(|(a, b)| a.abs_diff(*b)).max();
    (differing as f64 / pixels().count() as f64, greatest.unwrap_or(0))
}

#[test]
fn with_room_for_all_they_want_both_settle_to_the_same_picture() {
    let Some(mut scheduled) = open(roomy(Strategy::RttQuadtree)) else { return };
    let Some(mut by_frustum) = open(roomy(Strategy::CpuFrustum)) else { return };
    for view in [
        Ridges::view(20.0, -18.0, 2_500.0),
        Ridges::view(200.0, -5.0, 1_300.0),
        Ridges::view(95.0, -60.0, 6_000.0),
        Ridges::view(0.0, -90.0, 40_000.0),
    ] {
        let (part, greatest) = difference(
            &scheduled.settled_picture(&view).unwrap(),
            &by_frustum.settled_picture(&view).unwrap(),
        );
        let tiles = [&scheduled, &by_frustum].map(|bench| bench.renderer.selection().tiles.len());
        println!(
            "heading {}, height {} m: {} and {} tiles, {:.3} % of the pixels differ, by {greatest} at most",
            view.heading_deg,
            view.eye.z,
            tiles[0],
            tiles[1],
            100.0 * part
        );
        assert!(tiles.iter().all(|&count| count < 144), "no room: {tiles:?}");
        // Where a ridge ends against the sky, triangles have vertices on the ground behind it: the
        // frustum holds it at full detail, the box of what is seen need not.
        assert!(part < 0.006, "{part} of the pixels differ");
    }
}

#[test]
fn without_feedback_nothing_is_read_back() {
    let settings = RendererSettings { strategy: Strategy::CpuFrustum, ..Default::default() };
    let Some(mut bench) = open(settings) else { return };
    let settled = bench.settle(&Ridges::view(20.0, -18.0, 2_500.0)).unwrap();
    assert!(settled.tiles_selected > 20 && settled.tiles_selected <= 36, "{settled:?}");
    assert_eq!((settled.readback_bytes, settled.coordinate_pass_drawn), (0, false));
    assert_eq!((settled.tiles_missing, settled.region_age_frames), (0, None));
}

#[test]
fn a_switch_keeps_the_cache_and_comes_to_the_same_picture() {
    let Some(mut bench) = open(roomy(Strategy::RttQuadtree)) else { return };
    let view = Ridges::view(20.0, -18.0, 2_500.0);
    let first = bench.settled_picture(&view).unwrap();
    switch(&mut bench, Strategy::CpuFrustum);
    assert!(bench.renderer.needs_frame(&view), "the switch shows at once");
    let record = bench.settle(&view).unwrap();
    assert_eq!(record.strategy, "cpu-frustum");
    assert!(record.tiles_new < record.tiles_selected, "only what is not there yet: {record:?}");
    switch(&mut bench, Strategy::RttQuadtree);
    let record = bench.settle(&view).unwrap();
    assert_eq!((record.strategy.as_str(), record.tiles_new), ("rtt-quadtree", 0));
    let again = bench.settled_picture(&view).unwrap();
    // A tile at the border of what is in view may count in with some tiles shown and not with others.
    let differing = again.rgba.iter().zip(&first.rgba).filter(|(a, b)| a != b).count();
    assert!(differing * 1_000 < first.rgba.len(), "{differing} values changed");
    assert!(!bench.renderer.needs_frame(&view));
}

#[test]
fn a_strategy_without_feedback_can_be_switched_to_and_from_in_flight() {
    let Some(mut bench) = open(roomy(Strategy::CpuFrustum)) else { return };
    let mut names = Vec::new();
    for step in 0..12 {
        let strategy = [Strategy::RttQuadtree, Strategy::CpuFrustum][step / 3 % 2];
        switch(&mut bench, strategy);
        let view = Ridges::view(15.0 * step as f64, -20.0, 2_000.0);
        let record = bench.draw(&view).unwrap();
        names.push(record.strategy);
        let asks = record.coordinate_pass_drawn;
        assert!(!asks || strategy == Strategy::RttQuadtree, "frame {step}");
    }
    assert_eq!(names[2..4], ["rtt-quadtree", "cpu-frustum"]);
    let view = Ridges::view(165.0, -20.0, 2_000.0);
    switch(&mut bench, Strategy::CpuFrustum);
    let in_flight = bench.settled_picture(&view).unwrap();
    let fresh = open(roomy(Strategy::CpuFrustum)).unwrap().settled_picture(&view).unwrap();
    // Which slots the tiles got goes by the order in which they came; filtering rounds accordingly.
    let (_, greatest) = difference(&in_flight, &fresh);
    assert!(greatest <= 1, "the picture depends on the way there: {greatest}");
}

/// The paper's selection and cache, on the CPU and on the GPU: the same tiles, so the same picture.
#[test]
fn on_the_gpu_the_same_tiles_are_drawn_as_on_the_cpu() {
    let small = RendererSettings { texel_px: 0.7, ..Default::default() };
    for (what, settings, views) in [
        ("roomy", roomy(Strategy::RttQuadtree), 5),
        ("merging", small, 2),
        ("by error", RendererSettings { shortening: Shortening::LeastError, ..small }, 5),
        ("linear", RendererSettings { lookup: LookupMethod::Linear, ..small }, 1),
    ] {
        let on_gpu = RendererSettings { strategy: Strategy::RttQuadtreeGpu, ..settings };
        let Some(mut on_gpu) = open(on_gpu) else { return };
        let Some(mut on_cpu) = open(settings) else { return };
        for view in [
            Ridges::view(20.0, -18.0, 2_500.0),
            Ridges::view(200.0, -5.0, 1_300.0),
            Ridges::view(95.0, -60.0, 6_000.0),
            Ridges::view(0.0, -90.0, 40_000.0),
            Ridges::view(0.0, 60.0, 3_000.0),
        ]
        .into_iter()
        .take(views)
        {
            let records = [on_gpu.settle(&view).unwrap(), on_cpu.settle(&view).unwrap()];
            let counts = |record: &FrameRecord| {
                (record.tiles_selected, record.tiles_missing, record.finest_level)
            };
            assert_eq!(counts(&records[0]), counts(&records[1]), "{what}: {view:?}");
            let (part, greatest) = difference(
                &on_gpu.settled_picture(&view).unwrap(),
                &on_cpu.settled_picture(&view).unwrap(),
            );
            // The tiles lie in other slots, and filtering rounds accordingly.
            assert!(greatest <= 1 && part < 0.01, "{what}: {part} of the pixels, by {greatest}");
        }
    }
}

#[test]
fn on_the_gpu_little_is_read_back() {
    let settings = RendererSettings { strategy: Strategy::RttQuadtreeGpu, ..Default::default() };
    let Some(mut bench) = open(settings) else { return };
    let (mut heading_deg, mut most_back, mut most_up) = (0.0, 0, 0);
    for _ in 0..40 {
        heading_deg += 1.0;
        let view = Ridges::view(heading_deg, -18.0, 2_500.0);
        let record = bench.draw(&view).unwrap();
        bench.gpu.wait().unwrap();
        if heading_deg > 1.0 {
            assert_eq!(record.region_age_frames, Some(1), "{record:?}");
        }
        assert_eq!(record.upload_table_bytes, 0, "tables are built where they are used");
        // One tile of imagery goes through whatever its size.
        let tiles = record.upload_dem_bytes + record.upload_dom_bytes;
        let one_tile = u64::from(LARGEST_TILE_BYTES);
        assert!(tiles <= settings.upload_budget_bytes + one_tile, "{record:?}");
        most_back = most_back.max(record.readback_bytes);
        most_up = most_up.max(record.upload_uniform_bytes);
    }
    println!("at most {most_back} bytes back and {most_up} bytes of parameters up in a frame");
    // The head and both lists in full; commonly 64 bytes.
    assert!(most_back <= 16 + 2 * 32 * 8, "{most_back}");
    let view = Ridges::view(heading_deg, -18.0, 2_500.0);
    let settled = bench.settle(&view).unwrap();
    assert_eq!((settled.tiles_missing, settled.region_age_frames), (0, Some(0)), "{settled:?}");
    assert!(settled.tiles_selected > 15 && settled.tiles_selected <= 36, "{settled:?}");
    let calm = CameraView { heading_deg: heading_deg + 0.01, ..view };
    assert!(bench.renderer.needs_frame(&calm));
    let calm = bench.draw(&calm).unwrap();
    assert_eq!(calm.readback_bytes, 64, "{calm:?}");
}
