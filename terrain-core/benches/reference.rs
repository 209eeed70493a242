//! What the reference costs on one core: rays against the surface, and whole pictures, over the
//! demo's Himalaya seen from low above, from high above, and towards the horizon. Times are what the
//! processor spent on it, whatever else the machine was doing.

#![allow(clippy::unwrap_used, reason = "a measurement that fails may stop")]

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec2, DVec3, dvec3};
use terrain_core::CameraView;
use terrain_core::dataset::Dataset;
use terrain_core::prepare::{NoProgress, PrepareRequest, prepare};
use terrain_core::reference::{ReferenceScene, ReferenceSettings, render_reference};

/// What the demo's mountains are exaggerated by, and the CRS it is prepared in.
const EXAGGERATION: f64 = 15.0;
const EPSG: u32 = 3395;
const SIZE_PX: [u32; 2] = [320, 180];

fn scene(folder: &Path) -> ReferenceScene {
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/demo");
    let (dem, dom) = (demo.join("dem.tif"), demo.join("dom.tif"));
    let mut request = PrepareRequest::new(vec![dem], vec![dom], folder.join("demo"));
    request.epsg = Some(EPSG);
    prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap();
    ReferenceScene::open(Arc::new(Dataset::open(&request.out).unwrap())).unwrap()
}

/// The time that a processor has spent on this thread; on systems that do not tell, the time since
/// `started`.
fn thread_time(started: Instant) -> Duration {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = told.and_then(|text| text.split(' ').next()?.parse().ok());
    nanoseconds.map_or_else(|| started.elapsed(), Duration::from_nanos)
}

/// Time a thread takes for so many rounds of some work.
fn rounds<T>(count: u64, mut work: impl FnMut() -> T) -> Duration {
    let started = Instant::now();
    let before = thread_time(started);
    for _ in 0..count {
        black_box(work());
    }
    thread_time(started).saturating_sub(before)
}

/// Views by name.
fn views() -> [(&'static str, CameraView); 3] {
    let view = |eye: DVec3, heading_deg: f64, pitch_deg: f64| CameraView {
        eye,
        heading_deg,
        pitch_deg,
        fov_y_deg: 50.0,
        viewport_px: SIZE_PX,
    };
    [
        ("low", view(dvec3(9.0e6, 2.75e6, 390_000.0), 20.0, -16.0)),
        ("high", view(dvec3(9.2e6, 1.0e6, 2_200_000.0), -5.0, -36.0)),
        ("horizon", view(dvec3(9.4e6, 3.3e6, 100_000.0), 300.0, -2.0)),
    ]
}

/// The directions through the centres of a view's pixels.
fn directions(view: &CameraView) -> Vec<DVec3> {
    let [width, height] = view.viewport_px;
    let pixels = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
    pixels.map(|(x, y)| view.ray_direction(f64::from(x) + 0.5, f64::from(y) + 0.5)).collect()
}

fn reference(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path());
    rays(criterion, &scene);
    pictures(criterion, &scene);
}

fn rays(criterion: &mut Criterion, scene: &ReferenceScene) {
    let mut group = criterion.benchmark_group("rays");
    for (name, view) in views() {
        let directions = directions(&view);
        group.throughput(Throughput::Elements(directions.len() as u64));
        group.bench_function(name, |bencher| {
            let hit =
                |direction: &&DVec3| scene.first_hit(view.eye, **direction, EXAGGERATION).is_some();
            bencher.iter_custom(|count| rounds(count, || directions.iter().filter(hit).count()));
        });
    }
    let (_, low) = views()[0];
    let few: Vec<DVec3> = directions(&low).into_iter().step_by(64).collect();
    group.throughput(Throughput::Elements(few.len() as u64));
    group.bench_function("low, without bounds", |bencher| {
        let hit = |direction: &&DVec3| {
            scene.first_hit_exhaustive(low.eye, **direction, EXAGGERATION).is_some()
        };
        bencher.iter_custom(|count| rounds(count, || few.iter().filter(hit).count()));
    });
    group.finish();
    criterion.bench_function("height at a point", |bencher| {
        bencher.iter(|| scene.height_m(black_box(DVec2::new(9.4e6, 3.3e6))));
    });
}

fn pictures(criterion: &mut Criterion, scene: &ReferenceScene) {
    let one_core = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let settings =
        ReferenceSettings { vertical_exaggeration: EXAGGERATION, ..ReferenceSettings::default() };
    let mut group = criterion.benchmark_group("pictures");
    group.sample_size(10);
    for (name, view) in views() {
        let [width, height] = view.viewport_px.map(u64::from);
        group.throughput(Throughput::Elements(width * height));
        group.bench_function(name, |bencher| {
            let take = || {
                let going_on = AtomicBool::new(false);
                render_reference(scene, &view, &settings, &NoProgress, &going_on).unwrap()
            };
            bencher.iter_custom(|count| one_core.install(|| rounds(count, take)));
        });
    }
    group.finish();
}

criterion_group!(benches, reference);
criterion_main!(benches);
