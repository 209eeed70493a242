//! The reference against closed forms, against itself with other filters, and against the GPU.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{DVec2, DVec3, dvec2, dvec3};
use terrain_core::dataset::{Dataset, TileSource};
use terrain_core::gpu::{OFFSCREEN_FORMAT, OffscreenTarget};
use terrain_core::prepare::{NoProgress, PrepareRequest, prepare};
use terrain_core::reference::{
    ReferencePicture, ReferenceScene, ReferenceSettings, render_reference,
};
use terrain_core::{CameraView, RendererSettings, TerrainRenderer};
use terrain_tests::{AnalyticSource, Picture, RasterFixture, Surface, gpu};

/// Side of the root, and of a height texel at its finest level of 5: 16 tiles of 128 texels a side.
const ROOT_M: f64 = 20_480.0;
const TEXEL_M: f64 = 10.0;

fn scene(surface: Surface, centre: DVec2) -> ReferenceScene {
    ReferenceScene::open(Arc::new(AnalyticSource::new(surface, centre, ROOT_M, [5, 1]))).unwrap()
}

fn take(
    scene: &ReferenceScene,
    view: &CameraView,
    settings: &ReferenceSettings,
) -> ReferencePicture {
    render_reference(scene, view, settings, &NoProgress, &AtomicBool::new(false)).unwrap()
}

fn grey(_: DVec2) -> [u8; 3] {
    [128, 128, 128]
}

/// A surface with everything known about it. Points are relative to the root's centre.
struct KnownSurface {
    name: &'static str,
    height_m: fn(DVec2) -> f64,
    /// The distance at which a ray first goes below it.
    meets: fn(DVec3, DVec3) -> Option<f64>,
    /// How far bilinear interpolation between samples `TEXEL_M` apart may be from it:
    /// TEXEL_M^2 / 8 (|h_xx| + |h_yy|), or the height across a cell where it has a kink.
    bound_m: fn(DVec2) -> f64,
}

const SLOPE: DVec2 = DVec2::new(0.05, -0.02);
const RADIUS_M: f64 = 9_000.0;
const STEEPNESS: f64 = 0.3;

fn plane_m(p: DVec2) -> f64 {
    300.0 + SLOPE.dot(p)
}

fn meets_plane(o: DVec3, d: DVec3) -> Option<f64> {
    let rate = d.z - SLOPE.dot(d.truncate());
    Some((plane_m(o.truncate()) - o.z) / rate).filter(|t| rate < 0.0 && *t >= 0.0)
}

/// A sphere's cap: its centre lies 8 km below the datum.
fn cap_m(p: DVec2) -> f64 {
    (RADIUS_M * RADIUS_M - p.length_squared()).max(0.0).sqrt() - 8_000.0
}

fn meets_cap(o: DVec3, d: DVec3) -> Option<f64> {
    let from = o + 8_000.0 * DVec3::Z;
    let (b, c) = (from.dot(d), from.length_squared() - RADIUS_M * RADIUS_M);
    let root = (b * b - c).sqrt();
    Some(-b - root).filter(|t| *t >= 0.0)
}

fn cone_m(p: DVec2) -> f64 {
    2_000.0 - STEEPNESS * p.length()
}

fn meets_cone(o: DVec3, d: DVec3) -> Option<f64> {
    // (2000 - z)^2 = k^2 (x^2 + y^2) along the ray, on the lower nappe.
    let k = STEEPNESS * STEEPNESS;
    let below = 2_000.0 - o.z;
    let a = d.z * d.z - k * d.truncate().length_squared();
    let b = -below * d.z - k * o.truncate().dot(d.truncate());
    let c = below * below - k * o.truncate().length_squared();
    let root = (b * b - a * c).sqrt();
    let roots = [(-b - root) / a, (-b + root) / a];
    let is_entry = |t: &f64| {
        let p = o + *t * d;
        let outward = -STEEPNESS * p.truncate().normalize();
        *t >= 0.0 && p.z <= 2_000.0 && d.z - outward.dot(d.truncate()) < 0.0
    };
    roots.into_iter().filter(is_entry).reduce(f64::min)
}

/// 0 in the west and 100 m in the east: between the samples beside the middle a ramp, exactly.
fn step_m(p: DVec2) -> f64 {
    100.0 * ((p.x + 0.5 * TEXEL_M) / TEXEL_M).clamp(0.0, 1.0)
}

fn meets_step(o: DVec3, d: DVec3) -> Option<f64> {
    let half = 0.5 * TEXEL_M;
    let level = |z: f64| (z - o.z) / d.z;
    let ramp = (10.0 * (o.x + half) - o.z) / (d.z - 10.0 * d.x);
    let at = |t: f64| o + t * d;
    let faces = [
        (level(0.0), d.z < 0.0 && at(level(0.0)).x <= -half),
        (level(100.0), d.z < 0.0 && at(level(100.0)).x >= half),
        (ramp, d.z - 10.0 * d.x < 0.0 && at(ramp).x.abs() <= half),
    ];
    let met = faces.into_iter().filter(|(t, is_met)| *is_met && *t >= 0.0);
    met.map(|(t, _)| t).reduce(f64::min)
}

const SURFACES: [KnownSurface; 4] = [
    KnownSurface { name: "plane", height_m: plane_m, meets: meets_plane, bound_m: |_| 0.0 },
    KnownSurface {
        name: "sphere cap",
        height_m: cap_m,
        meets: meets_cap,
        // h_xx + h_yy of a sphere is at most 2 R^2 / h^3, its height being taken from its centre.
        bound_m: |p| {
            let up = cap_m(p) + 8_000.0 - TEXEL_M;
            TEXEL_M * TEXEL_M / 8.0 * 2.0 * RADIUS_M * RADIUS_M / up.powi(3)
        },
    },
    KnownSurface {
        name: "cone",
        height_m: cone_m,
        meets: meets_cone,
        bound_m: |p| {
            let nearest = p.length() - 2.0 * TEXEL_M;
            let smooth = TEXEL_M * TEXEL_M / 8.0 * STEEPNESS / nearest.max(1e-9);
            smooth.min(STEEPNESS * TEXEL_M)
        },
    },
    KnownSurface { name: "step", height_m: step_m, meets: meets_step, bound_m: |_| 0.0 },
];

/// Numbers in -1..1, the same in every run.
fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

#[test]
fn known_surfaces_are_met_within_the_error_of_interpolation() {
    for centre in [DVec2::ZERO, dvec2(500_000.0, 6_800_000.0), dvec2(1e7, -1e7)] {
        for surface in &SURFACES {
            check_surface(surface, centre);
        }
    }
}

fn check_surface(surface: &KnownSurface, centre: DVec2) {
    let scene = scene(Surface { height_m: surface.height_m, colour: grey }, centre);
    let mut next = numbers(7);
    let (mut met, mut worst_m) = (0, 0.0_f64);
    for _ in 0..3_000 {
        // From up to 3 km above the ground around a middle part, to another place of it.
        let from = dvec2(next(), next()) * 3_000.0;
        let origin = from.extend((surface.height_m)(from) + 1_500.0 * (next() + 1.0));
        let to = dvec2(next(), next()) * 3_000.0;
        let aim = to.extend((surface.height_m)(to) + 100.0 * next());
        let direction = (aim - origin).normalize();
        let Some(distance_m) = (surface.meets)(origin, direction) else { continue };
        let true_point = origin + distance_m * direction;
        if true_point.truncate().abs().max_element() > 6_000.0 {
            continue;
        }
        let found = scene.first_hit(origin + centre.extend(0.0), direction, 1.0);
        let found = found.unwrap_or_else(|| panic!("{}: {origin} {direction}", surface.name));
        let point = found.point - centre.extend(0.0);
        // Samples are stored as f32; places of 1e7 m have steps of 2e-9 m in f64.
        let rounding_m = 3e-4 + 1e-8 * (surface.height_m)(DVec2::ZERO).abs();
        let bound_m = (surface.bound_m)(point.truncate()) + rounding_m;
        let error_m = (point.z - (surface.height_m)(point.truncate())).abs();
        assert!(error_m <= bound_m, "{}: {error_m} m at {point}", surface.name);
        // Along the ray the error is that height over the rate at which the ray sinks.
        let gradient = slope_of(surface, true_point.truncate());
        let sinks = gradient.dot(direction.truncate()) - direction.z;
        if sinks > 0.05 {
            let along_m = (found.distance_m - distance_m).abs();
            let bound_m = 2.0 * ((surface.bound_m)(true_point.truncate()) + rounding_m) / sinks;
            assert!(along_m <= bound_m, "{}: {along_m} m of {bound_m}", surface.name);
        }
        worst_m = worst_m.max(error_m);
        met += 1;
    }
    println!("{} at {centre}: {met} rays, worst {worst_m:.2e} m", surface.name);
    assert!(met > 1_000, "{}: {met}", surface.name);
}

fn slope_of(surface: &KnownSurface, p: DVec2) -> DVec2 {
    let at = |dx: f64, dy: f64| (surface.height_m)(p + dvec2(dx, dy));
    dvec2(at(1e-3, 0.0) - at(-1e-3, 0.0), at(0.0, 1e-3) - at(0.0, -1e-3)) / 2e-3
}

/// Linear light of an sRGB code (IEC 61966-2-1).
fn linear(code: u8) -> f64 {
    let encoded = f64::from(code) / 255.0;
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Black west of a line and white east of it, by texels of the finest level: on a plane at 0 m.
fn halves(p: DVec2) -> [u8; 3] {
    if p.x < 0.0 { [0; 3] } else { [255; 3] }
}

#[test]
fn a_pixel_is_the_mean_of_the_imagery_over_its_true_footprint() {
    // Texels of 53 m at the one level there is; the border is a ramp between two of them.
    let flat = Surface { height_m: |_| 0.0, colour: halves };
    let scene = scene(flat, DVec2::ZERO);
    let texel_m = ROOT_M / 384.0;
    let ramp = |x: f64| (x / texel_m + 0.5).clamp(0.0, 1.0);
    for heading_deg in [6.0, 45.0, 84.0] {
        let view = CameraView {
            eye: dvec3(-700.0, -900.0, 900.0),
            heading_deg,
            pitch_deg: -20.0,
            fov_y_deg: 50.0,
            viewport_px: [48, 32],
        };
        let settings = ReferenceSettings { shading_strength: 0.0, ..Default::default() };
        let seen = take(&scene, &view, &settings);
        let (mut checked, mut worst) = (0, 0.0_f64);
        for index in 0..48 * 32 {
            let corner = dvec2(f64::from(index % 48), f64::from(index / 48));
            let Some(white) = white_share(&view, corner, ramp) else { continue };
            let distance_m = seen.distance_m[index as usize];
            // The air in front of black and of white ground at this distance.
            let [black, full] = [0.0, 1.0].map(|bare| through_air(bare, distance_m, 900.0));
            let found = (linear(seen.rgba[index as usize][0]) - black) / (full - black);
            worst = worst.max((found - white).abs());
            checked += 1;
        }
        println!(
            "border at {heading_deg} degrees: {checked} pixels, worst share off by {worst:.4}"
        );
        assert!(checked > 500 && worst < 0.02, "{worst}");
    }
}

/// The white share of a pixel's footprint on the plane at 0 m: the mean over 96 x 96 rays. `None`
/// where some see no ground within 8 km.
fn white_share(view: &CameraView, corner: DVec2, ramp: impl Fn(f64) -> f64) -> Option<f64> {
    const SIDE: u32 = 96;
    let mut sum = 0.0;
    for index in 0..SIDE * SIDE {
        let part = dvec2(f64::from(index % SIDE) + 0.5, f64::from(index / SIDE) + 0.5);
        let position = corner + part / f64::from(SIDE);
        let direction = view.ray_direction(position.x, position.y);
        let way = -view.eye.z / direction.z;
        if direction.z >= 0.0 || way > 8_000.0 {
            return None;
        }
        sum += ramp(view.eye.x + way * direction.x);
    }
    Some(sum / f64::from(SIDE * SIDE))
}

/// The red light of level ground seen through the air, as the renderer documents it: over an area
/// this small haze of 60 km at the ground, thinning out by e every 8 km.
fn through_air(bare: f64, distance_m: f64, eye_m: f64) -> f64 {
    let up = eye_m / 8_000.0;
    let mean = (1.0 - (-up).exp()) / up;
    let clear = (-distance_m / 60_000.0 * mean).exp();
    0.66 * (1.0 - clear) + bare * clear
}

/// Prepares rasters into a folder that lives as long as the answer.
fn prepared(dem: PathBuf, dom: PathBuf, epsg: Option<u32>) -> (tempfile::TempDir, Arc<Dataset>) {
    let folder = tempfile::tempdir().unwrap();
    let mut request = PrepareRequest::new(vec![dem], vec![dom], folder.path().join("dataset"));
    request.epsg = epsg;
    prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap();
    let dataset = Arc::new(Dataset::open(&request.out).unwrap());
    (folder, dataset)
}

fn demo() -> (tempfile::TempDir, Arc<Dataset>) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/demo");
    prepared(folder.join("dem.tif"), folder.join("dom.tif"), Some(3395))
}

fn jotunheimen() -> Option<(tempfile::TempDir, Arc<Dataset>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    let dem = folder.join("jotunheimen_dem_512.tif");
    if !dem.exists() {
        println!("SKIPPED: {} is not there", dem.display());
        return None;
    }
    Some(prepared(dem, folder.join("jotunheimen_map_4096.jpg"), None))
}

fn himalaya() -> CameraView {
    CameraView {
        eye: dvec3(9.0e6, 2.75e6, 390_000.0),
        heading_deg: 20.0,
        pitch_deg: -16.0,
        fov_y_deg: 50.0,
        viewport_px: [160, 90],
    }
}

/// Differences of two pictures' colours in 8-bit steps, sorted.
fn differences(a: &[[u8; 4]], b: &[[u8; 4]]) -> Vec<u8> {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    let mut steps: Vec<u8> = pairs.map(|(a, b)| a.abs_diff(*b)).collect();
    steps.sort_unstable();
    steps
}

fn mean(steps: &[u8]) -> f64 {
    // Of three channels: alpha is the same everywhere.
    let sum: f64 = steps.iter().copied().map(f64::from).sum();
    sum / steps.len() as f64 * 4.0 / 3.0
}

#[test]
fn coarser_levels_of_imagery_give_the_same_picture_as_the_finest() {
    let (_folder, dataset) = demo();
    let scene = ReferenceScene::open(dataset).unwrap();
    // The same rays for both, so that only the filters differ.
    let settings = ReferenceSettings {
        vertical_exaggeration: 15.0,
        colour_tolerance: 0.0,
        most_rays: 32,
        ..Default::default()
    };
    let finest = ReferenceSettings { finest_imagery: true, ..settings };
    let view = CameraView { eye: dvec3(9.0e6, 1.0e6, 2.2e6), ..himalaya() };
    let [a, b] = [settings, finest].map(|settings| take(&scene, &view, &settings));
    let steps = differences(&a.rgba, &b.rgba);
    let (p99, worst) = (steps[steps.len() * 99 / 100], steps[steps.len() - 1]);
    println!("mean {:.3}, p99 {p99}, worst {worst} steps", mean(&steps));
    assert!(mean(&steps) < 0.15 && p99 <= 1 && worst <= 6);
}

#[test]
fn colours_are_within_their_stated_error_of_a_thousand_rays() {
    let (_folder, dataset) = demo();
    let scene = ReferenceScene::open(dataset).unwrap();
    let settings = ReferenceSettings { vertical_exaggeration: 15.0, ..Default::default() };
    let thousand = ReferenceSettings { colour_tolerance: 0.0, most_rays: 1024, ..settings };
    let high = CameraView { eye: dvec3(9.2e6, 1.0e6, 2.2e6), pitch_deg: -36.0, ..himalaya() };
    for (name, view) in [("low", himalaya()), ("high", high)] {
        let view = CameraView { viewport_px: [64, 36], ..view };
        let [a, b] = [settings, thousand].map(|settings| take(&scene, &view, &settings));
        let steps = differences(&a.rgba, &b.rgba);
        let (p99, worst) = (steps[steps.len() * 99 / 100], steps[steps.len() - 1]);
        println!("{name}: mean {:.3}, p99 {p99}, worst {worst} steps", mean(&steps));
        assert!(mean(&steps) < 1.0 && p99 <= 4, "{name}");
    }
}

/// The GPU's picture and ground coordinates, settled, of fine triangles.
fn drawn(
    source: Arc<dyn TileSource>,
    view: &CameraView,
    exaggeration: f64,
) -> Option<(Vec<[u8; 4]>, Vec<DVec3>)> {
    let gpu = gpu()?;
    let settings = RendererSettings {
        triangle_px: 2.0,
        anisotropy: 16,
        vertical_exaggeration: exaggeration,
        cache_columns: 12,
        cache_rows: 12,
        max_tiles: 144,
        ..Default::default()
    };
    let mut renderer = TerrainRenderer::new(Arc::clone(&gpu), source, settings).unwrap();
    let target = OffscreenTarget::new(&gpu, view.viewport_px);
    renderer.render_settled(view, target.view(), OFFSCREEN_FORMAT).unwrap();
    gpu.wait().unwrap();
    let picture = Picture::read(&gpu, &target).unwrap();
    let (pixels, _) = picture.rgba.as_chunks::<4>();
    let points = renderer.ground_coordinates(view).unwrap();
    Some((pixels.to_vec(), points.into_iter().map(DVec3::from_array).collect()))
}

/// Bounds on how the GPU's answers differ from the reference's: the mean of the colours' steps, the
/// part of pixels of which one has ground and the other sky, and for 99 % of the pixels away from
/// silhouettes the distance, in pixels, between where both see the ground.
struct Agreement {
    mean_steps: f64,
    sky_part: f64,
    p99_px: f64,
}

fn check_agreement(
    name: &str,
    dataset: Arc<dyn TileSource>,
    view: &CameraView,
    exaggeration: f64,
    bounds: &Agreement,
) {
    let Some((pixels, points)) = drawn(Arc::clone(&dataset), view, exaggeration) else { return };
    let scene = ReferenceScene::open(dataset).unwrap();
    let settings = ReferenceSettings { vertical_exaggeration: exaggeration, ..Default::default() };
    let seen = take(&scene, view, &settings);
    let mean_steps = mean(&differences(&pixels, &seen.rgba));
    let pairs = || points.iter().zip(&seen.coordinates).zip(&seen.silhouette);
    let unlike = pairs().filter(|((a, b), _)| a.is_nan() != b.is_nan()).count();
    let sky_part = unlike as f64 / points.len() as f64;
    // Seen from the eye both lie behind one pixel; the difference is the height at the same place.
    let mut offsets_px: Vec<f64> = pairs()
        .filter(|((a, b), is_edge)| !a.is_nan() && !b.is_nan() && !**is_edge)
        .filter_map(|((drawn, _), _)| {
            let true_m = scene.height_m(drawn.truncate())? * exaggeration;
            let shifted = view.pixel_from_world(drawn.truncate().extend(true_m))?;
            let place = view.pixel_from_world(*drawn)?;
            Some((shifted[0] - place[0]).hypot(shifted[1] - place[1]))
        })
        .collect();
    offsets_px.sort_by(f64::total_cmp);
    let p99_px = offsets_px[offsets_px.len() * 99 / 100];
    println!("{name}: colours {mean_steps:.3} steps, sky {sky_part:.5}, p99 {p99_px:.3} px");
    assert!(mean_steps < bounds.mean_steps, "{name}: {mean_steps} steps");
    assert!(sky_part < bounds.sky_part, "{name}: sky {sky_part}");
    assert!(p99_px < bounds.p99_px, "{name}: {p99_px} px");
}

#[test]
fn smooth_ground_is_drawn_as_the_reference_has_it() {
    let hills = Surface {
        height_m: |p| 200.0 * (p.x / 1_500.0).sin() * (p.y / 2_100.0).cos(),
        colour: |p| {
            let wave = 0.5 + 0.5 * (p.x / 3_000.0).sin() * (p.y / 2_500.0).sin();
            [(60.0 + 150.0 * wave) as u8, 120, (200.0 - 150.0 * wave) as u8]
        },
    };
    let source = Arc::new(AnalyticSource::new(hills, DVec2::ZERO, ROOT_M, [5, 4]));
    let eye = dvec3(-500.0, -6_000.0, 900.0);
    let view = CameraView { eye, pitch_deg: -12.0, viewport_px: [320, 180], ..himalaya() };
    let bounds = Agreement { mean_steps: 0.5, sky_part: 0.003, p99_px: 0.1 };
    check_agreement("hills", source, &view, 1.0, &bounds);
}

#[test]
fn the_demo_is_drawn_as_the_reference_has_it() {
    let (_folder, dataset) = demo();
    let view = CameraView { viewport_px: [320, 180], ..himalaya() };
    let bounds = Agreement { mean_steps: 4.0, sky_part: 0.003, p99_px: 1.0 };
    check_agreement("demo", dataset, &view, 15.0, &bounds);
}

#[test]
fn real_mountains_are_drawn_as_the_reference_has_them() {
    let Some((_folder, dataset)) = jotunheimen() else { return };
    let eye = dvec3(463_500.0, 6_820_000.0, 2_500.0);
    let view = CameraView {
        eye,
        heading_deg: 215.0,
        pitch_deg: -12.0,
        viewport_px: [320, 180],
        ..himalaya()
    };
    let bounds = Agreement { mean_steps: 1.5, sky_part: 0.01, p99_px: 0.5 };
    check_agreement("Jotunheimen", dataset, &view, 1.0, &bounds);
}

#[test]
fn ground_without_imagery_and_ground_without_data_are_drawn_as_the_reference_has_them() {
    let folder = tempfile::tempdir().unwrap();
    let [dem, out] = ["dem.tif", "dataset"].map(|name| folder.path().join(name));
    // Hills of 300 m with a hole of 40 x 30 cells, in which there is nothing to see.
    let height_m = |row: u32, column: u32| {
        let is_hole = (100..130).contains(&row) && (80..120).contains(&column);
        let (x, y) = (f64::from(column) / 30.0, f64::from(row) / 40.0);
        if is_hole { f32::NAN } else { (150.0 * x.sin() * y.cos() + 150.0) as f32 }
    };
    let places = (0..200).flat_map(|row| (0..240).map(move |column| (row, column)));
    let heights_m: Vec<f32> = places.map(|(row, column)| height_m(row, column)).collect();
    let raster = RasterFixture::utm([240, 200], [500_000.0, 6_800_000.0], 50.0);
    raster.write_f32(&dem, &heights_m).unwrap();
    let request =
        PrepareRequest { keep_voids: true, ..PrepareRequest::new(vec![dem], vec![], out) };
    prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap();
    let dataset = Arc::new(Dataset::open(&request.out).unwrap());
    let eye = dvec3(505_000.0, 6_791_000.0, 1_800.0);
    let view = CameraView {
        eye,
        pitch_deg: -25.0,
        viewport_px: [320, 180],
        heading_deg: 0.0,
        ..himalaya()
    };
    let hole = view.pixel_from_world(dvec3(505_000.0, 6_794_250.0, 0.0)).unwrap();
    let scene = ReferenceScene::open(dataset.clone()).unwrap();
    assert!(scene.first_hit(eye, view.ray_direction(hole[0], hole[1]), 1.0).is_none());
    let bounds = Agreement { mean_steps: 0.8, sky_part: 0.005, p99_px: 0.2 };
    check_agreement("hills with a hole", dataset, &view, 1.0, &bounds);
}
