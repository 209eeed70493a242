//! What a frame costs over data of 2^13 texels a side and over 2^18 of which the first is a tile: the
//! same flights over the same ground, frame by frame in turn, so that whatever else the machine does slows both.
//!
//! Prints a record as JSON: `cargo bench -p terrain-tests --bench data_size`, optionally with the number
//! of frames a case (60). `-- select EXTRA_LEVELS TIMES` only selects tiles, for counting its instructions.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a measurement that fails may stop")]

use std::hint::black_box;
use std::time::Instant;

use glam::dvec2;
use serde_json::{Value, json};
use terrain_core::dataset::{HeightRange, HeightRanges};
use terrain_core::measure::FrameRecord;
use terrain_core::selection::{
    SeenGround, SelectionConfig, Strategy, TileTree, VisibleRegion, select, select_by_frustum,
};
use terrain_core::tiling::Extent;
use terrain_core::{CameraView, RendererSettings};
use terrain_tests::{Bench, NestedSources};

const SIZE_PX: [u32; 2] = [1280, 720];
const FRAMES: u32 = 60;
const EXTRA_LEVELS: u8 = 5;
/// Moving frames that are timed after each frame of the flight.
const TIMED: u32 = 3;

/// A flight looking this far down, and what is in view.
const FLIGHTS: [(&str, f64); 2] =
    [("down, the same ground in view", -55.0), ("to the horizon", -10.0)];

const SOURCES: NestedSources = NestedSources { tile_sizes_texels: [128, 384] };

fn view(frame: f64, pitch_deg: f64) -> CameraView {
    CameraView {
        eye: dvec2(-13_000.0, 6_000.0 + 30.0 * frame).extend(2_500.0),
        heading_deg: 5.0,
        pitch_deg,
        fov_y_deg: 50.0,
        viewport_px: SIZE_PX,
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    if let [mode, extra_levels, times] = &arguments[..]
        && mode == "select"
    {
        return select_often(extra_levels.parse().unwrap(), times.parse().unwrap());
    }
    let frames = arguments.first().map_or(FRAMES, |text| text.parse().unwrap());
    let sources = [0, EXTRA_LEVELS].map(|extra| SOURCES.source(extra));
    let mut cases = Vec::new();
    for strategy in Strategy::ALL {
        for slots in [6, 8] {
            for (what, pitch_deg) in FLIGHTS {
                let settings = RendererSettings {
                    strategy,
                    cache_columns: slots,
                    cache_rows: slots,
                    max_tiles: (slots * slots) as usize,
                    ..Default::default()
                };
                let benches = sources
                    .each_ref()
                    .map(|source| Bench::new(source.clone(), settings).unwrap().unwrap());
                let mut case = fly(benches, frames, pitch_deg);
                case["strategy"] = json!(strategy.name());
                case["cache"] = json!(format!("{slots}x{slots}"));
                case["flight"] = json!(what);
                cases.push(case);
            }
        }
    }
    let record = json!({
        "bench": "data_size",
        "texels_a_side": [1 << 13, 1 << 18],
        "size_px": SIZE_PX,
        "frames": frames,
        "cores": std::thread::available_parallelism().map_or(0, usize::from),
        "cases": cases,
    });
    println!("{}", serde_json::to_string_pretty(&record).unwrap());
}

/// What the frames of one renderer were.
#[derive(Default)]
struct Frames {
    /// Those of the flight, each drawn until nothing was missing; the first, which fills the cache, left out.
    settled: Vec<FrameRecord>,
    /// Moving ones without new tiles, waited for: `frame_ms` is all of a frame.
    timed: Vec<FrameRecord>,
}

/// Both renderers along the flight, frame by frame in turn.
fn fly(mut benches: [Bench; 2], frames: u32, pitch_deg: f64) -> Value {
    let mut flown = [Frames::default(), Frames::default()];
    for frame in 0..frames {
        for (bench, flown) in benches.iter_mut().zip(&mut flown) {
            let record = bench.settle(&view(f64::from(frame), pitch_deg)).unwrap();
            bench.gpu.wait().unwrap();
            if frame > 0 {
                flown.settled.push(record);
            }
        }
        for step in 1..=TIMED {
            // A hand's breadth: everything is computed anew, and no tile is new.
            let moved = view(f64::from(frame) + 1.0e-3 * f64::from(step), pitch_deg);
            for (bench, flown) in benches.iter_mut().zip(&mut flown) {
                let started = Instant::now();
                let mut record = bench.draw(&moved).unwrap();
                bench.gpu.wait().unwrap();
                record.frame_ms = started.elapsed().as_secs_f64() * 1.0e3;
                flown.timed.push(record);
            }
        }
    }
    summary(&flown)
}

/// Means and medians of both, the smaller source's first, and the ratio of the second to the first.
fn summary(flown: &[Frames; 2]) -> Value {
    let mean = |of: fn(&FrameRecord) -> u64| {
        with_ratio(flown.each_ref().map(|frames| {
            let sum: u64 = frames.settled.iter().map(of).sum();
            sum as f64 / frames.settled.len().max(1) as f64
        }))
    };
    let median = |of: fn(&FrameRecord) -> f64| {
        with_ratio(flown.each_ref().map(|frames| {
            let mut values: Vec<f64> = frames.timed.iter().map(of).collect();
            values.sort_by(f64::total_cmp);
            values[values.len() / 2]
        }))
    };
    json!({
        "mean_a_frame": {
            "bytes": mean(|r| r.upload_bytes + r.readback_bytes),
            "bytes of heights": mean(|r| r.upload_dem_bytes),
            "bytes of colours": mean(|r| r.upload_dom_bytes),
            "bytes of tables": mean(|r| r.upload_table_bytes),
            "bytes of meshes and uniforms": mean(|r| r.upload_mesh_bytes + r.upload_uniform_bytes),
            "bytes read back": mean(|r| r.readback_bytes),
            "tiles selected": mean(|r| r.tiles_selected),
            "tiles new": mean(|r| r.tiles_new),
            "triangles": mean(|r| r.triangles_drawn),
        },
        "median_ms": {
            "frame": median(|r| r.frame_ms),
            "GPU": median(|r| r.gpu_ms.unwrap_or(f64::NAN)),
            "CPU": median(|r| r.cpu_ms),
            "selection": median(|r| r.select_ms),
        },
    })
}

fn with_ratio([small, large]: [f64; 2]) -> Value {
    let rounded = |value: f64| (value * 1.0e4).round() / 1.0e4;
    json!([rounded(small), rounded(large), rounded(large / small)])
}

/// Selects the same tiles again and again, by the paper's way and by the frustum: a program to count the
/// instructions of. Prints how many tiles there were.
fn select_often(extra_levels: u8, times: u32) {
    let mut tree = TileTree::of_source(&SOURCES.source_without_ranges(extra_levels));
    // Equally much is known of every tile but the finest, without a look at the ground.
    let range = Some(HeightRange { min_m: -500.0, max_m: 500.0 });
    let known = 0..tree.finest_level();
    let levels = known.map(|level| vec![range; 1 << (2 * level)]).collect();
    tree.height_ranges = HeightRanges { levels };
    let view = view(0.0, FLIGHTS[0].1);
    let ahead = view.eye.truncate() + dvec2(200.0, 2_300.0);
    let extent = Extent::new(ahead - 2_500.0, ahead + 2_500.0);
    let region = VisibleRegion::of_extent(&extent);
    let seen = SeenGround::of_box(&region);
    let config = SelectionConfig { max_tiles: 256, ..Default::default() };
    let mut tiles = 0;
    for _ in 0..times {
        tiles += select(&tree, Some(seen), black_box(&view), &config).tiles.len();
        tiles += select_by_frustum(&tree, black_box(&view), &config).tiles.len();
    }
    println!("{extra_levels} levels more, {times} times: {tiles} tiles");
}
