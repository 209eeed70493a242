//! Cameras and sizes at and beyond the limits of sense: whatever is asked for, a frame ends without a
//! panic, no NaN reaches a pixel, and what is drawn lies where it should.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use terrain_core::gpu::GpuContext;
use terrain_core::selection::Strategy;
use terrain_core::{CameraView, RendererSettings};
use terrain_tests::{AnalyticSource, Bench, Ridges, Surface};

use crate::drawn::{PLACE_CONTRACT_PX, check};

const SIZE_PX: [u32; 2] = [96, 54];

fn hills() -> Surface {
    Surface {
        height_m: |p| 700.0 * (p.x / 4000.0).sin() * (p.y / 5000.0).cos(),
        colour: |_| [120, 130, 90],
    }
}

fn bench(gpu: &Arc<GpuContext>, strategy: Strategy) -> Bench {
    let source = AnalyticSource::new(hills(), DVec2::ZERO, Ridges::ROOT_M, [4, 3]);
    let settings = RendererSettings { strategy, ..Default::default() };
    Bench::on(gpu, Arc::new(source), settings).unwrap()
}

fn view() -> CameraView {
    CameraView { viewport_px: SIZE_PX, ..Ridges::view(20.0, -18.0, 2_500.0) }
}

fn check_places(bench: &mut Bench, what: &str, view: &CameraView) -> bool {
    let drawn = check(bench, what, view);
    let error_px = drawn.place_error_px();
    assert!(error_px < PLACE_CONTRACT_PX, "{error_px} px");
    drawn.ground().next().is_some()
}

pub fn cameras_at_the_limits(gpu: &Arc<GpuContext>, strategy: Strategy) {
    let at = |x: f64, y: f64, z: f64| CameraView { eye: DVec3::new(x, y, z), ..view() };
    let look = |pitch_deg: f64| CameraView { pitch_deg, ..view() };
    let field = |fov_y_deg: f64| CameraView { fov_y_deg, ..view() };
    let sized = |viewport_px: [u32; 2]| CameraView { viewport_px, ..view() };
    let edge = 0.5 * Ridges::ROOT_M;
    let cases = [
        ("inside the ground", at(6_000.0, 0.0, -300.0)),
        ("far below the ground", at(0.0, 0.0, -9_000.0)),
        ("on the ground", at(0.0, 0.0, 0.0)),
        ("straight up", look(90.0)),
        ("straight down", look(-90.0)),
        ("one degree wide", field(1.0)),
        ("170 degrees wide", field(170.0)),
        ("one pixel", sized([1, 1])),
        ("one row", sized([512, 1])),
        ("one column", sized([1, 512])),
        ("very wide", sized([1024, 2])),
        ("the north-east corner", at(edge, edge, 900.0)),
        ("just outside the west edge", at(-edge - 1.0e-3, 0.0, 900.0)),
        ("a thousand km outside", at(-1.0e6, 0.0, 900.0)),
        ("from the moon", CameraView { fov_y_deg: 1.0, pitch_deg: -90.0, ..at(0.0, 0.0, 4.0e8) }),
        ("a denormal away from the origin", at(5.0e-324, -5.0e-324, 1.0e3)),
        ("many turns", CameraView { heading_deg: 3.6e6 + 20.0, ..view() }),
    ];
    let mut bench = bench(gpu, strategy);
    for (what, view) in &cases {
        check_places(&mut bench, what, view);
    }
}

pub fn views_that_are_none_are_refused_and_leave_the_renderer_as_it_was(
    gpu: &Arc<GpuContext>,
    strategy: Strategy,
) {
    let mut bench = bench(gpu, strategy);
    let good = view();
    let nan = f64::NAN;
    let cases = [
        CameraView { eye: DVec3::new(nan, 0.0, 0.0), ..good },
        CameraView { eye: DVec3::new(0.0, f64::INFINITY, 0.0), ..good },
        CameraView { heading_deg: nan, ..good },
        CameraView { pitch_deg: -91.0, ..good },
        CameraView { fov_y_deg: 0.0, ..good },
        CameraView { fov_y_deg: 180.0, ..good },
        CameraView { viewport_px: [0, 0], ..good },
        CameraView { viewport_px: [640, 0], ..good },
    ];
    check(&mut bench, "before", &good);
    for bad in cases {
        let refused = bench.draw(&bad).unwrap_err();
        assert!(refused.to_string().contains("camera"), "{refused}");
        assert!(bench.renderer.ground_coordinates(&bad).is_err(), "{bad:?}");
    }
    assert!(!bench.renderer.needs_frame(&good), "the refused views left something behind");
    check(&mut bench, "after", &good);
}

/// Numbers from 0 to 1, the same on every run (a linear congruential generator; Knuth, "The Art of
/// Computer Programming", volume 2, 1997).
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// From `-10^most` to `10^most`, all magnitudes from 1 mm on equally likely.
    fn any_magnitude(&mut self, most: f64) -> f64 {
        let size = 10.0_f64.powf(self.between(-3.0, most));
        if self.unit() < 0.5 { -size } else { size }
    }
}

/// A camera of any size and field of view, at any distance from a place in the data, looking there.
fn any_view(random: &mut Random) -> CameraView {
    let mut side = || random.between(1.0, 6.5).exp2() as u32;
    let viewport_px = [side(), side()];
    let place = [0.45 * Ridges::ROOT_M; 2].map(|most| random.between(-most, most));
    let place = DVec2::from_array(place).extend(0.0);
    let away = DVec3::from_array([7.5, 7.5, 8.0].map(|most| random.any_magnitude(most)));
    let gaze = -away.normalize();
    CameraView {
        eye: place + away,
        heading_deg: gaze.x.atan2(gaze.y).to_degrees(),
        pitch_deg: gaze.z.asin().to_degrees(),
        fov_y_deg: random.between(1.0, 170.0),
        viewport_px,
    }
}

pub fn any_camera_at_all(gpu: &Arc<GpuContext>, strategy: Strategy) {
    const VIEWS: usize = 50;
    let mut random = Random(0x7e_44a1);
    let mut bench = bench(gpu, strategy);
    let mut with_ground = 0;
    for case in 0..VIEWS {
        if case % 10 == 0 {
            let vertical_exaggeration = 10.0_f64.powf(random.between(-2.0, 3.0));
            let triangle_px = random.between(1.0, 64.0);
            bench
                .change(|settings| {
                    settings.vertical_exaggeration = vertical_exaggeration;
                    settings.triangle_px = triangle_px;
                })
                .unwrap();
        }
        let view = any_view(&mut random);
        with_ground += usize::from(check_places(&mut bench, &format!("case {case}"), &view));
    }
    println!("{with_ground} of {VIEWS} views show ground");
    assert!(4 * with_ground > VIEWS, "{with_ground}");
}
