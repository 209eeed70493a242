//! What a ray on a limit-triangulated surface costs: coloured from the triangles, and by the usual
//! filters in the same ray caster, on the CPU and on the GPU. A hilly surface under noise, seen from
//! above and at a slant.
//!
//! Prints a record as JSON: `cargo bench -p terrain-core --bench limit_surface`, optionally with the
//! side of the pictures in pixels (48).

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a measurement that fails may stop")]

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use glam::{DVec2, DVec3, Vec3, dvec2};
use serde_json::{Value, json};
use terrain_core::CameraView;
use terrain_core::gpu::{AdapterChoice, GpuContext, LimitGpuColour, LimitSurfacePass};
use terrain_core::reference::limit_surface::{
    AccessCounts, CastSettings, ColourBuild, ConvergedQuadrature, DistanceSet, KnotRule, LimitGrid,
    LimitRelief, LimitSurface, MipTexture, RayColour, RayPattern, cast_picture,
};
use terrain_core::tiling::Extent;

const SIDE_PX: u32 = 48;
/// Cells a side of the surface, and texels of its texture.
const CELLS: usize = 384;
const PIXEL_RAD: f64 = 1.295e-3;
const LEAST_M: f64 = 1_000.0;
/// Each case is cast so often; the fastest counts.
const REPEATS: usize = 3;

fn main() {
    let side_px = std::env::args().find_map(|text| text.parse().ok()).unwrap_or(SIDE_PX);
    let (surface, texture, build_s) = scene();
    let gpu = GpuContext::headless(&AdapterChoice::default()).ok();
    let pass = gpu.as_ref().map(|gpu| LimitSurfacePass::new(gpu, &surface, &texture).unwrap());
    let mut cases = Vec::new();
    for (name, view) in views(&surface, side_px) {
        for rays in [1, 16, 64] {
            for case in cpu_cases(&surface, &texture, view, rays) {
                cases.push(with_view(case, name));
            }
            if let Some((gpu, pass)) = gpu.as_ref().zip(pass.as_ref()) {
                for case in gpu_cases(gpu, pass, &surface, view, rays) {
                    cases.push(with_view(case, name));
                }
            }
        }
    }
    let memory = surface.memory();
    let record = json!({
        "bench": "limit_surface",
        "adapter": gpu.map(|gpu| gpu.adapter.get_info().name),
        "cores": std::thread::available_parallelism().map_or(0, usize::from),
        "side_px": side_px,
        "build_triangles_per_s": (memory.triangles as f64 / build_s).round(),
        "memory": memory,
        "colour_bytes_per_triangle": rounded(memory.colour_bytes_per_triangle()),
        "texture_bytes": texture.byte_len(),
        "cases": cases,
    });
    println!("{}", serde_json::to_string_pretty(&record).unwrap());
}

/// Hills of 60 m under three octaves of noise, and the seconds their colours took.
fn scene() -> (LimitSurface, MipTexture, f64) {
    let angle_rad = 0.5 * PIXEL_RAD;
    let cell_m = LimitGrid::cell_m_for(LEAST_M, 0.5 * angle_rad);
    let extent = Extent::new(DVec2::ZERO, DVec2::splat(CELLS as f64 * cell_m));
    let grid = LimitGrid::over(&extent, cell_m).unwrap();
    let height_m = |index: usize| {
        let (row, column) = (index / (CELLS + 1), index % (CELLS + 1));
        30.0 * ((row as f32 / 40.0).sin() + (column as f32 / 55.0).cos())
    };
    let heights_m = (0..grid.node_count()).map(height_m).collect();
    let relief = LimitRelief::new(grid, heights_m).unwrap();
    let texture =
        MipTexture::new(grid.origin, cell_m, [CELLS; 2], (0..CELLS * CELLS).map(noise).collect());
    let distances = DistanceSet::geometric(LEAST_M, 4.0 * LEAST_M, 2).unwrap();
    let integral = ConvergedQuadrature {
        texture: &texture,
        relief: &relief,
        tolerance: 0.002,
        bare_colour: Vec3::ZERO,
    };
    let build = ColourBuild {
        relief: &relief,
        distances: &distances,
        admissible_angle_rad: angle_rad,
        integral: &integral,
        cancel: &AtomicBool::new(false),
    };
    let started = Instant::now();
    let surface = build.surface(KnotRule::ColourError(4.0)).unwrap();
    (surface, texture, started.elapsed().as_secs_f64())
}

fn noise(index: usize) -> [u8; 4] {
    let (row, column) = (index / CELLS, index % CELLS);
    let octave = |scale: usize, salt: u32| {
        let cell = (row / scale * CELLS + column / scale) as u32 ^ salt;
        cell.wrapping_mul(2_654_435_761) >> 24
    };
    let mixed = |salt: u32| ((octave(1, salt) + 2 * octave(8, salt) + octave(64, salt)) / 4) as u8;
    [mixed(1), mixed(77), mixed(991), 255]
}

fn views(surface: &LimitSurface, side_px: u32) -> [(&'static str, CameraView); 2] {
    let middle = surface.relief().grid().extent().centre();
    let half_height = 0.5 * f64::from(side_px) * PIXEL_RAD;
    let fov_y_deg = 2.0 * half_height.atan().to_degrees();
    let viewport_px = [side_px; 2];
    let look = |eye: DVec3, pitch_deg: f64| CameraView {
        eye,
        heading_deg: 0.0,
        pitch_deg,
        fov_y_deg,
        viewport_px,
    };
    let down = look(middle.extend(1_200.0), -90.0);
    let slant = look((middle + dvec2(0.0, -1_000.0)).extend(700.0), -35.0);
    [("from above", down), ("at a slant", slant)]
}

fn cpu_cases(
    surface: &LimitSurface,
    texture: &MipTexture,
    view: CameraView,
    rays: u32,
) -> Vec<Value> {
    let ways = [
        ("limit-triangulated", RayColour::Limit(surface.colours())),
        ("trilinear", RayColour::Trilinear(texture)),
        ("anisotropic", RayColour::Anisotropic(texture, 16)),
    ];
    let case = |(name, colour): (&str, RayColour<'_>)| {
        let settings = CastSettings {
            view,
            rays: RayPattern::of(rays),
            colour,
            ray_angle_rad: surface.admissible_angle_rad(),
            background: Vec3::ZERO,
        };
        let mut fastest_ms = f64::INFINITY;
        let mut accesses = AccessCounts::default();
        for _ in 0..REPEATS {
            let started = Instant::now();
            accesses = cast_picture(surface.relief(), &settings).accesses;
            fastest_ms = fastest_ms.min(started.elapsed().as_secs_f64() * 1.0e3);
        }
        case_of("CPU", name, rays, fastest_ms, &accesses)
    };
    ways.into_iter().map(case).collect()
}

fn gpu_cases(
    gpu: &GpuContext,
    pass: &LimitSurfacePass,
    surface: &LimitSurface,
    view: CameraView,
    rays: u32,
) -> Vec<Value> {
    let ways = [
        ("limit-triangulated", LimitGpuColour::Limit),
        ("trilinear", LimitGpuColour::Trilinear),
        ("anisotropic", LimitGpuColour::Anisotropic),
    ];
    let case = |(name, colour): (&str, LimitGpuColour)| {
        let angle_rad = surface.admissible_angle_rad();
        let pattern = RayPattern::of(rays);
        let cast = || pass.cast(gpu, &view, pattern, colour, angle_rad, Vec3::ZERO).unwrap();
        let found: Vec<_> = (0..REPEATS).map(|_| cast()).collect();
        let fastest_ms = found.iter().filter_map(|cast| cast.gpu_ms).fold(f64::INFINITY, f64::min);
        case_of("GPU", name, rays, fastest_ms, &found[0].picture.accesses)
    };
    ways.into_iter().map(case).collect()
}

fn case_of(device: &str, name: &str, rays: u32, ms: f64, accesses: &AccessCounts) -> Value {
    json!({
        "device": device,
        "colouring": name,
        "rays_per_pixel": rays,
        "ms": rounded(ms),
        "ns_per_ray": rounded(ms * 1.0e6 / accesses.rays as f64),
        "words_per_hit": rounded(accesses.words_per_hit()),
        "places_per_hit": rounded(accesses.places_per_hit()),
        "hits_per_ray": rounded(accesses.hits as f64 / accesses.rays as f64),
    })
}

fn with_view(mut case: Value, view: &str) -> Value {
    case["view"] = json!(view);
    case
}

fn rounded(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}
