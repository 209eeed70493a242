//! Limit-triangulated surfaces of datasets: prepared, stored, cast on CPU and GPU, deformed.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec2, DVec3, Vec3, dvec2};
use terrain_core::CameraView;
use terrain_core::dataset::{Dataset, TileSource};
use terrain_core::gpu::{LimitGpuColour, LimitSurfacePass};
use terrain_core::prepare::{NoProgress, PrepareRequest, Progress, prepare};
use terrain_core::reference::limit_surface::{
    CastSettings, KnotRule, LIMIT_FILE, LimitPrepareSummary, LimitRequest, LimitSurface,
    LimitSurfaceError, RayColour, RayPattern, cast_picture, prepare_limit_surface, read_limit_file,
    texture_window,
};
use terrain_core::tiling::Extent;
use terrain_tests::{AnalyticSource, Surface, gpu};

const CENTRE: DVec2 = dvec2(500_000.0, 6_800_000.0);

/// Hills under a patchwork of stripes and plain fields.
fn hills() -> AnalyticSource {
    let surface = Surface {
        height_m: |p| 300.0 + 60.0 * (p.x / 150.0).sin() * (p.y / 210.0).cos(),
        colour: |p| {
            if p.x < -200.0 {
                return [90, 140, 60];
            }
            let wave = |v: f64| (127.5 + 120.0 * v.sin()) as u8;
            [wave(p.x / 9.0), wave(p.y / 23.0), wave((p.x + p.y) / 61.0)]
        },
    };
    AnalyticSource::new(surface, CENTRE, 1_536.0, [3, 2])
}

fn request() -> LimitRequest {
    let half = DVec2::splat(50.0);
    LimitRequest {
        area: Some(Extent::new(CENTRE - half, CENTRE + half)),
        admissible_angle_rad: 2.0e-3,
        reach: 8.0,
        rule: KnotRule::ColourError(2.0),
        ..LimitRequest::default()
    }
}

fn made(
    source: &dyn TileSource,
    request: &LimitRequest,
) -> Result<(LimitPrepareSummary, LimitSurface), LimitSurfaceError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(LIMIT_FILE);
    let cancel = AtomicBool::new(false);
    let summary = prepare_limit_surface(source, request, &path, &NoProgress, &cancel)?;
    let (header, surface) = read_limit_file(&path)?;
    assert_eq!(header, summary.header);
    assert_eq!(std::fs::metadata(&path).unwrap().len(), summary.file_bytes);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing else is left");
    Ok((summary, surface))
}

fn linear(code: u8) -> f64 {
    let encoded = f64::from(code) / 255.0;
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

fn code(linear: f64) -> f64 {
    255.0
        * if linear <= 0.003_130_8 {
            12.92 * linear
        } else {
            1.055 * linear.powf(1.0 / 2.4) - 0.055
        }
}

/// The mean linear colour of the formula over the ground that the cone cuts out around a triangle, by
/// counting points of a lattice over it.
fn mean_over_footprint(surface: &LimitSurface, triangle: usize, distance_m: f64) -> [f64; 3] {
    let colour = |p: DVec2| {
        let wave = |v: f64| (127.5 + 120.0 * v.sin()) as u8;
        let striped = [wave(p.x / 9.0), wave(p.y / 23.0), wave((p.x + p.y) / 61.0)];
        if p.x < -200.0 { [90, 140, 60] } else { striped }
    };
    let [a, b, c] = surface.relief().corners(triangle).unwrap();
    let (centre, normal) = ((a + b + c) / 3.0, (b - a).cross(c - a).normalize());
    let normal = normal * normal.z.signum();
    let apex = centre + normal * distance_m;
    let least_cosine = (0.5 * surface.admissible_angle_rad()).cos();
    let radius_m = 1.5 * distance_m * (0.5 * surface.admissible_angle_rad()).tan();
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for (x, y) in (0..60).flat_map(|x| (0..60).map(move |y| (x, y))) {
        let at = |i: i32| (f64::from(i) + 0.5) / 30.0 - 1.0;
        let place = centre.truncate() + dvec2(at(x), at(y)) * radius_m;
        let point = place.extend(surface.relief().height_m(place));
        if (apex - point).normalize().dot(normal) >= least_cosine {
            let parts = colour(place - CENTRE).map(linear);
            (0..3).for_each(|channel| sum[channel] += parts[channel]);
            count += 1.0;
        }
    }
    sum.map(|part| part / count)
}

#[test]
fn colours_hold_their_limit_against_an_independent_integration() {
    let (summary, surface) = made(&hills(), &request()).unwrap();
    assert_eq!(surface.memory(), summary.memory);
    let distances_m = surface.colours().distances().as_slice().to_vec();
    let mut errors: Vec<f64> = Vec::new();
    for triangle in (0..surface.colours().triangle_count()).step_by(97) {
        for &distance_m in &distances_m {
            let found = surface.colours().colour(triangle, distance_m).unwrap().linear;
            let exact = mean_over_footprint(&surface, triangle, distance_m);
            for channel in 0..3 {
                let shown = code(f64::from(found[channel]));
                errors.push((shown - code(exact[channel])).abs());
            }
        }
    }
    errors.sort_by(f64::total_cmp);
    let at = |part: f64| errors[((errors.len() - 1) as f64 * part) as usize];
    println!("steps off: median {:.2}, p99 {:.2}, worst {:.2}", at(0.5), at(0.99), at(1.0));
    println!("{:.2} bytes a triangle", summary.memory.colour_bytes_per_triangle());
    // The limit of two steps, half a step of rounding, and what texels of 2 m lose of stripes that
    // are 57 m from crest to crest, which grows where they are dark.
    assert!(at(0.5) < 1.5 && at(0.99) < 4.0, "{} {}", at(0.5), at(0.99));
}

#[test]
fn a_memory_limit_is_kept_and_the_error_shrinks_with_the_memory() {
    let source = hills();
    let half = DVec2::splat(24.0);
    let area = Some(Extent::new(CENTRE - half, CENTRE + half));
    let with = |rule: KnotRule| made(&source, &LimitRequest { rule, area, ..request() });
    let triangles = with(KnotRule::ColourError(255.0)).unwrap().0.memory.triangles;
    let mut last_steps = f32::INFINITY;
    for bytes_each in [5, 8, 16] {
        let most_bytes = bytes_each * triangles;
        let (summary, _) = with(KnotRule::Memory(most_bytes)).unwrap();
        println!("{bytes_each} bytes a triangle: {} steps", summary.header.limit_steps);
        assert!(summary.memory.colour_bytes <= most_bytes);
        assert!(summary.header.limit_steps < last_steps);
        last_steps = summary.header.limit_steps;
    }
    let error = with(KnotRule::Memory(4 * triangles - 1)).unwrap_err();
    assert!(error.to_string().contains(&(4 * triangles).to_string()), "{error}");
}

#[test]
fn one_colour_takes_one_word_a_triangle() {
    let plain =
        Surface { height_m: |p| 0.1 * p.x + 5.0 * (p.y / 80.0).sin(), colour: |_| [10, 200, 90] };
    let source = AnalyticSource::new(plain, CENTRE, 1_536.0, [3, 2]);
    let rule = KnotRule::ColourError(0.0);
    let (summary, surface) = made(&source, &LimitRequest { rule, ..request() }).unwrap();
    assert_eq!(summary.memory.knots, summary.memory.triangles);
    assert_eq!(summary.memory.colour_bytes, 4 * summary.memory.triangles);
    let found = surface.colours().knots(471);
    assert_eq!(found.iter().map(|knot| knot.srgb).collect::<Vec<_>>(), [[10, 200, 90]]);
}

/// Sets the flag as soon as anything is done.
struct StopAtOnce<'a>(&'a AtomicBool);

impl Progress for StopAtOnce<'_> {
    fn advanced(&self, _phase: &str, _done: u64, _total: u64) {
        self.0.store(true, Ordering::Relaxed);
    }
}

#[test]
fn what_cannot_be_made_or_is_stopped_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(LIMIT_FILE);
    let source = hills();
    let cancel = AtomicBool::new(false);
    let make = |request: &LimitRequest| {
        prepare_limit_surface(&source, request, &path, &StopAtOnce(&cancel), &cancel)
    };
    // Two bands: the first one done stops the second.
    let half = dvec2(10.0, 80.0);
    let tall = Some(Extent::new(CENTRE - half, CENTRE + half));
    let stopped = make(&LimitRequest { area: tall, ..request() }).unwrap_err();
    assert!(matches!(stopped, LimitSurfaceError::Cancelled), "{stopped}");
    let beside = Extent::new(DVec2::ZERO, DVec2::ONE);
    let wrong = [
        LimitRequest { area: Some(beside), ..request() },
        LimitRequest { admissible_angle_rad: f64::NAN, ..request() },
        LimitRequest { triangle_share: 0.0, ..request() },
        LimitRequest { least_distance_m: Some(-1.0), ..request() },
        LimitRequest { least_distance_m: Some(1.0e9), ..request() },
        LimitRequest { reach: 0.5, ..request() },
    ];
    for wrong in wrong {
        let error = make(&wrong).unwrap_err();
        assert!(matches!(error, LimitSurfaceError::Setting(_)), "{error}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

fn view(from_centre: DVec3, heading_deg: f64, pitch_deg: f64) -> CameraView {
    let eye = CENTRE.extend(0.0) + from_centre;
    CameraView { eye, heading_deg, pitch_deg, fov_y_deg: 0.6, viewport_px: [96, 64] }
}

#[test]
fn a_surface_that_changes_shape_keeps_its_colours() {
    let (_, surface) = made(&hills(), &request()).unwrap();
    let bent = surface
        .deformed(|place, height_m| height_m + (20.0 * ((place.x - CENTRE.x) / 40.0).sin()) as f32)
        .unwrap();
    let mut compared = 0;
    for triangle in (0..surface.colours().triangle_count()).step_by(11) {
        let before = surface.relief().corners(triangle).unwrap();
        let after = bent.relief().corners(triangle).unwrap();
        assert_ne!(before, after, "it has moved");
        for distance_m in [700.0, 1_500.0, 4_000.0] {
            // Straight down on the triangle in both shapes: rays that meet it tell its colour.
            let colour = |surface: &LimitSurface, corners: [DVec3; 3]| {
                let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
                let eye = middle + DVec3::Z * distance_m;
                let hit = surface.relief().first_hit(eye, DVec3::NEG_Z).unwrap();
                assert_eq!(hit.triangle as usize, triangle);
                assert!((hit.distance_m - distance_m).abs() < 1e-6);
                surface.colours().colour(triangle, distance_m).unwrap().linear
            };
            assert_eq!(colour(&surface, before), colour(&bent, after));
            compared += 1;
        }
    }
    assert!(compared > 1_000, "{compared}");
}

/// Part of the pixels whose first rays meet the same triangle, and the largest difference of colours.
fn gpu_against_cpu(
    surface: &LimitSurface,
    source: &dyn TileSource,
    view: CameraView,
) -> Option<()> {
    let gpu = gpu()?;
    let texture = texture_window(source, &surface.relief().grid().extent()).unwrap().unwrap();
    let pass = LimitSurfacePass::new(&gpu, surface, &texture).unwrap();
    let rays = RayPattern::of(16);
    let (ray_angle_rad, background) = (surface.admissible_angle_rad(), Vec3::new(0.2, 0.3, 0.9));
    let methods = [
        (LimitGpuColour::Limit, RayColour::Limit(surface.colours()), 0.004, 0.02),
        (LimitGpuColour::Trilinear, RayColour::Trilinear(&texture), 0.01, 0.05),
    ];
    for (on_gpu, on_cpu, mean_bound, p99_bound) in methods {
        let found = pass.cast(&gpu, &view, rays, on_gpu, ray_angle_rad, background).unwrap();
        let settings = CastSettings { view, rays, colour: on_cpu, ray_angle_rad, background };
        let expected = cast_picture(surface.relief(), &settings);
        let place = rays.places().next().unwrap();
        let (mut same, mut hits) = (0, 0);
        for (index, hit) in found.first_hits.iter().enumerate() {
            let [x, y] = [index as u32 % 96, index as u32 / 96].map(f64::from);
            let direction = view.ray_direction(x + place.x, y + place.y);
            let exact = surface.relief().first_hit(view.eye, direction);
            same += usize::from(hit.map(|h| h.0) == exact.map(|h| h.triangle));
            hits += usize::from(exact.is_some());
        }
        let mut apart: Vec<f32> = found
            .picture
            .linear
            .iter()
            .zip(&expected.linear)
            .map(|(a, b)| (*a - *b).abs().max_element())
            .collect();
        apart.sort_by(f32::total_cmp);
        let mean = apart.iter().sum::<f32>() / apart.len() as f32;
        let p99 = apart[apart.len() * 99 / 100];
        println!(
            "{on_gpu:?}: {same} of {} same, colours {mean:.5} / {p99:.5}, {:?} ms, {:.2} words a hit",
            apart.len(),
            found.gpu_ms,
            found.picture.accesses.words_per_hit()
        );
        assert!(hits > 1_000, "{hits} rays meet the surface");
        // Rays within rounding of an edge may meet the triangle beside it.
        assert!(same as f64 > 0.99 * apart.len() as f64, "{same} of {}", apart.len());
        assert!(mean < mean_bound && p99 < p99_bound, "{mean} {p99}");
        let (words, expected_words) =
            (found.picture.accesses.words_per_hit(), expected.accesses.words_per_hit());
        assert!((words - expected_words).abs() < 0.01 * expected_words, "{words} {expected_words}");
    }
    Some(())
}

#[test]
fn the_gpu_meets_the_same_triangles_and_gives_the_same_colours() {
    let source = hills();
    let (_, surface) = made(&source, &request()).unwrap();
    for view in [
        view(DVec3::new(10.0, 3.0, 5_000.0), 30.0, -90.0),
        view(DVec3::new(-2_700.0, -2_100.0, 1_800.0), 52.1, -23.7),
        view(DVec3::new(900.0, -4_500.0, 1_500.0), -11.3, -14.6),
    ] {
        if gpu_against_cpu(&surface, &source, view).is_none() {
            return;
        }
    }
}

/// Jotunheimen's imagery over its mountains, its ideal filter being 1024 unfiltered rays a pixel.
#[test]
fn on_real_terrain_and_imagery_the_error_is_below_a_tenth_in_all_but_a_hundredth_of_the_pixels() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    let [dem, dom] = ["jotunheimen_dem_512.tif", "jotunheimen_map_4096.jpg"].map(|f| data.join(f));
    if !dem.exists() {
        println!("SKIPPED: {} is not there", dem.display());
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("dataset");
    let request = PrepareRequest::new(vec![dem], vec![dom], out.clone());
    prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap();
    let source = Dataset::open(&out).unwrap();
    let middle = dvec2(463_000.0, 6_822_000.0);
    let area = Extent::new(middle - 500.0, middle + 500.0);
    let request = LimitRequest { area: Some(area), reach: 2.0, ..LimitRequest::default() };
    let (summary, surface) = made(&source, &request).unwrap();
    let least_m = surface.colours().distances().least_m();
    println!(
        "D_min {least_m:.0} m, {:.2} bytes a triangle",
        summary.memory.colour_bytes_per_triangle()
    );
    let texture = texture_window(&source, &area).unwrap().unwrap();
    let eye = middle.extend(1.5 * least_m + 1_500.0);
    let (pitch_deg, viewport_px) = (-90.0, [18, 18]);
    let pixel_rad = 2.0 * surface.admissible_angle_rad();
    let fov_y_deg = 2.0 * (9.0 * pixel_rad).atan().to_degrees();
    let view = CameraView { eye, heading_deg: 17.0, pitch_deg, fov_y_deg, viewport_px };
    let cast = |rays: u32, colour: RayColour<'_>| {
        let rays = RayPattern::of(rays);
        let ray_angle_rad = surface.admissible_angle_rad();
        let settings = CastSettings { view, rays, colour, ray_angle_rad, background: Vec3::ZERO };
        cast_picture(surface.relief(), &settings).linear
    };
    let ideal = cast(1024, RayColour::Unfiltered(&&texture));
    let errors = |colour: RayColour<'_>| {
        let found = cast(16, colour);
        let apart = |(a, b): (&Vec3, &Vec3)| (*a - *b).abs().max_element();
        let mut errors: Vec<f32> = found.iter().zip(&ideal).map(apart).collect();
        errors.sort_by(f32::total_cmp);
        let mean = errors.iter().sum::<f32>() / errors.len() as f32;
        [mean, errors[errors.len() * 99 / 100], errors[errors.len() - 1]]
    };
    let limit = errors(RayColour::Limit(surface.colours()));
    let trilinear = errors(RayColour::Trilinear(&texture));
    println!("limit: mean, p99, worst {limit:.4?}; trilinear {trilinear:.4?}");
    assert!(limit[1] < 0.1, "{limit:?}");
    assert!(limit[0] <= trilinear[0] && limit[1] <= trilinear[1], "{limit:?} {trilinear:?}");
}
