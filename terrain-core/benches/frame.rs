//! What a frame costs, with a moving and with a still camera: a piece of the demo's own flight at
//! 1280 x 720. Every frame is waited for, so that the figures are whole frames, one after the other.
//!
//! Prints a record as JSON: `cargo bench -p terrain-core --bench frame`, optionally with the number
//! of frames a case (240).

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a measurement that fails may stop")]

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use serde_json::{Value, json};
use terrain_core::dataset::Dataset;
use terrain_core::gpu::{AdapterChoice, GpuContext, OFFSCREEN_FORMAT, OffscreenTarget};
use terrain_core::measure::Flight;
use terrain_core::prepare::{NoProgress, PrepareRequest, prepare};
use terrain_core::{AntiAliasing, RendererSettings, TerrainRenderer};

const SIZE_PX: [u32; 2] = [1280, 720];
const FRAMES: u64 = 240;
/// Where in the flight the measured piece begins, in seconds: low along the Alps.
const START_S: f64 = 10.0;
/// What the demo's mountains are exaggerated by, and the CRS it is prepared in.
const EXAGGERATION: f64 = 15.0;
const EPSG: u32 = 3395;

fn main() {
    let frames = std::env::args().find_map(|text| text.parse().ok()).unwrap_or(FRAMES);
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/demo");
    let folder = tempfile::tempdir().unwrap();
    let dataset = Arc::new(prepare_demo(&demo, &folder.path().join("demo")));
    let flight = Flight::read(&demo.join("flight.json")).unwrap();
    let gpu = Arc::new(GpuContext::headless(&AdapterChoice::default()).unwrap());
    let by_adapter = RendererSettings::default();
    let fine = RendererSettings { triangle_px: 8.0, anisotropy: 8, ..by_adapter };
    let mut cases = Vec::new();
    let smooth = RendererSettings { anti_aliasing: AntiAliasing::FourSamples, ..by_adapter };
    for (settings_name, settings) in [
        ("by adapter", by_adapter),
        ("by adapter, 4 samples", smooth),
        ("8 px triangles, 8 taps", fine),
    ] {
        let settings = RendererSettings { vertical_exaggeration: EXAGGERATION, ..settings };
        let renderer = TerrainRenderer::new(Arc::clone(&gpu), dataset.clone(), settings).unwrap();
        let mut bench = Bench { gpu: &gpu, renderer, flight: &flight };
        for (camera, frames_per_s) in [("still", 0.0), ("moving", flight.fps())] {
            let mut case = bench.run(frames, frames_per_s);
            case["settings"] = json!(settings_name);
            case["camera"] = json!(camera);
            cases.push(case);
        }
    }
    let info = gpu.adapter.get_info();
    let record = json!({
        "bench": "frame",
        "adapter": info.name,
        "driver": format!("{} {}", info.driver, info.driver_info),
        "cores": std::thread::available_parallelism().map_or(0, usize::from),
        "size_px": SIZE_PX,
        "cases": cases,
    });
    println!("{}", serde_json::to_string_pretty(&record).unwrap());
}

fn prepare_demo(sources: &Path, out: &Path) -> Dataset {
    let (heights, colours) = (vec![sources.join("dem.tif")], vec![sources.join("dom.tif")]);
    let request =
        PrepareRequest { epsg: Some(EPSG), ..PrepareRequest::new(heights, colours, out.into()) };
    prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap();
    Dataset::open(out).unwrap()
}

struct Bench<'a> {
    gpu: &'a GpuContext,
    renderer: TerrainRenderer,
    flight: &'a Flight,
}

impl Bench<'_> {
    /// Draws frames along the flight, or at its start where none pass a second.
    fn run(&mut self, frames: u64, frames_per_s: f64) -> Value {
        let step_s = if frames_per_s > 0.0 { 1.0 / frames_per_s } else { 0.0 };
        let target = OffscreenTarget::new(self.gpu, SIZE_PX);
        let start = self.flight.view_at(START_S, SIZE_PX);
        self.renderer.render_settled(&start, target.view(), OFFSCREEN_FORMAT).unwrap();
        self.gpu.wait().unwrap();
        let (mut frame_ms, mut own_ms, mut bytes, mut triangles) = (Vec::new(), 0.0, 0, 0);
        let busy_before_ms = process_cpu_ms();
        for frame in 0..frames {
            let view = self.flight.view_at(START_S + frame as f64 * step_s, SIZE_PX);
            let started = Instant::now();
            let record = self.renderer.render(&view, target.view(), OFFSCREEN_FORMAT).unwrap();
            self.gpu.wait().unwrap();
            frame_ms.push(started.elapsed().as_secs_f64() * 1.0e3);
            own_ms += record.cpu_ms;
            bytes += record.upload_bytes;
            triangles += record.triangles_drawn;
        }
        let busy_ms = process_cpu_ms().zip(busy_before_ms).map(|(now, before)| now - before);
        frame_ms.sort_by(f64::total_cmp);
        let at = |part: f64| rounded(frame_ms[(part * (frame_ms.len() - 1) as f64) as usize]);
        json!({
            "frames": frames,
            "frame_ms": { "fastest": at(0.0), "median": at(0.5), "p95": at(0.95), "slowest": at(1.0) },
            "process_cpu_ms_per_frame": busy_ms.map(|ms| rounded(ms / frames as f64)),
            "own_thread_ms_per_frame": rounded(own_ms / frames as f64),
            "upload_bytes_per_frame": bytes / frames,
            "triangles_per_frame": triangles / frames,
        })
    }
}

fn rounded(ms: f64) -> f64 {
    (ms * 100.0).round() / 100.0
}

/// Processor time of all of the process's threads in milliseconds, a software renderer's counted;
/// `None` where there is no /proc. Unlike the frame's time it hardly depends on other load.
fn process_cpu_ms() -> Option<f64> {
    /// Milliseconds a clock tick of /proc has on Linux.
    const TICK_MS: f64 = 10.0;
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The second field, the program's name in brackets, may hold blanks.
    let fields = stat.rsplit_once(')')?.1.split_whitespace().collect::<Vec<_>>();
    let ticks = |index: usize| fields.get(index)?.parse::<f64>().ok();
    Some((ticks(11)? + ticks(12)?) * TICK_MS)
}
