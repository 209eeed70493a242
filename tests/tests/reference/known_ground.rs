//! The reference against surfaces and footprints known in closed form.

use std::sync::Arc;

use glam::{DVec2, DVec3, dvec2, dvec3};
use terrain_core::CameraView;
use terrain_core::reference::{ReferenceScene, ReferenceSettings};
use terrain_tests::{AnalyticSource, Surface};

use super::{ROOT_M, take};

/// A height texel at the finest level of 5: 16 tiles of 128 texels a side.
const TEXEL_M: f64 = 10.0;

fn scene(surface: Surface, centre: DVec2) -> ReferenceScene {
    ReferenceScene::open(Arc::new(AnalyticSource::new(surface, centre, ROOT_M, [5, 1]))).unwrap()
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
