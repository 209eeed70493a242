//! Cameras, sizes, settings and heights at and beyond the limits of sense: whatever is asked for, a
//! frame ends without a panic, no NaN reaches a table or a pixel, and what is drawn lies where it
//! should.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]
#![allow(clippy::print_stdout, reason = "measured values are to be seen")]

use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{DVec2, DVec3, dvec2};
use terrain_core::dataset::{Dataset, TileSource};
use terrain_core::gpu::{GpuContext, OFFSCREEN_FORMAT, OffscreenTarget};
use terrain_core::prepare::{NoProgress, PrepareRequest, prepare};
use terrain_core::residency::{OffsetTable, TileCache};
use terrain_core::selection::Strategy;
use terrain_core::tiling::TileId;
use terrain_core::{CameraView, RendererSettings, TerrainRenderer};
use terrain_tests::{AnalyticSource, Picture, RasterFixture, Surface, gpu};

/// One strategy of each way to bring ground to the GPU and to draw it.
const STRATEGIES: [Strategy; 4] =
    [Strategy::RttQuadtree, Strategy::RttQuadtreeGpu, Strategy::Clipmap, Strategy::PageTable];

fn settings_of(strategy: Strategy) -> RendererSettings {
    RendererSettings { strategy, ..Default::default() }
}

const ROOT_M: f64 = 65_536.0;
const SIZE_PX: [u32; 2] = [96, 54];

fn hills() -> Surface {
    Surface {
        height_m: |p| 700.0 * (p.x / 4000.0).sin() * (p.y / 5000.0).cos(),
        colour: |_| [120, 130, 90],
    }
}

fn source_of(surface: Surface) -> Arc<AnalyticSource> {
    Arc::new(AnalyticSource::new(surface, DVec2::ZERO, ROOT_M, [4, 3]))
}

fn view() -> CameraView {
    CameraView {
        eye: DVec3::new(-2_000.0, -9_000.0, 2_500.0),
        heading_deg: 20.0,
        pitch_deg: -18.0,
        fov_y_deg: 50.0,
        viewport_px: SIZE_PX,
    }
}

struct Bench {
    gpu: Arc<GpuContext>,
    renderer: TerrainRenderer,
}

impl Bench {
    fn new(gpu: &Arc<GpuContext>, source: Arc<dyn TileSource>, settings: RendererSettings) -> Self {
        let renderer = TerrainRenderer::new(Arc::clone(gpu), source, settings).unwrap();
        Self { gpu: Arc::clone(gpu), renderer }
    }

    /// Draws the view until nothing is missing and looks at everything that comes out.
    fn check(&mut self, what: &str, view: &CameraView) -> Drawn {
        let target = OffscreenTarget::new(&self.gpu, view.viewport_px);
        let record = self.renderer.render_settled(view, target.view(), OFFSCREEN_FORMAT).unwrap();
        assert_eq!(record.tiles_missing, 0, "{what}: {record:?}");
        let picture = Picture::read(&self.gpu, &target).unwrap();
        // Neither ground nor sky is black anywhere; NaN and infinity are.
        let black = picture.rgba.chunks_exact(4).filter(|pixel| pixel[..3] == [0; 3]).count();
        assert_eq!(black, 0, "{what}: black pixels");
        assert!(picture.rgba.chunks_exact(4).all(|pixel| pixel[3] == 255), "{what}: see-through");
        for tile in &self.renderer.selection().tiles {
            assert!(self.renderer.tree().heights.present.contains(*tile), "{what}: {tile}");
        }
        let points = self.renderer.ground_coordinates(view).unwrap();
        let points = points.into_iter().map(DVec3::from_array).collect::<Vec<_>>();
        let whole =
            |point: &DVec3| point.is_finite() || point.to_array().iter().all(|c| c.is_nan());
        assert!(points.iter().all(whole), "{what}: a point is neither ground nor sky");
        Drawn { view: *view, points }
    }
}

/// The points of the ground that a view shows.
struct Drawn {
    view: CameraView,
    points: Vec<DVec3>,
}

impl Drawn {
    fn ground(&self) -> impl Iterator<Item = (usize, DVec3)> {
        self.points.iter().copied().enumerate().filter(|(_, point)| point.is_finite())
    }

    /// Largest distance in pixels between where a point lies in the picture and its pixel's centre.
    fn place_error_px(&self) -> f64 {
        let width = self.view.viewport_px[0] as usize;
        let errors = self.ground().map(|(index, point)| {
            let centre = dvec2((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
            let place = self.view.pixel_from_world(point).map_or(DVec2::NAN, DVec2::from);
            // `max` would drop a NaN.
            let error = place.distance(centre);
            if error.is_nan() { f64::INFINITY } else { error }
        });
        errors.fold(0.0, f64::max)
    }
}

/// Part of a pixel within which a point must lie in its pixel: the contract of the positions.
const PLACE_CONTRACT_PX: f64 = 1.0 / 16.0;

#[test]
fn cameras_at_the_limits() {
    let Some(gpu) = gpu() else { return };
    let at = |x: f64, y: f64, z: f64| CameraView { eye: DVec3::new(x, y, z), ..view() };
    let look = |pitch_deg: f64| CameraView { pitch_deg, ..view() };
    let field = |fov_y_deg: f64| CameraView { fov_y_deg, ..view() };
    let sized = |viewport_px: [u32; 2]| CameraView { viewport_px, ..view() };
    let edge = 0.5 * ROOT_M;
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
    for strategy in STRATEGIES {
        let mut bench = Bench::new(&gpu, source_of(hills()), settings_of(strategy));
        for (what, view) in &cases {
            let drawn = bench.check(what, view);
            let error_px = drawn.place_error_px();
            assert!(error_px < PLACE_CONTRACT_PX, "{strategy}, {what}: {error_px} px");
        }
    }
}

#[test]
fn views_that_are_none_are_refused_and_leave_the_renderer_as_it_was() {
    let Some(gpu) = gpu() else { return };
    let mut bench = Bench::new(&gpu, source_of(hills()), RendererSettings::default());
    let target = OffscreenTarget::new(&gpu, SIZE_PX);
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
    bench.check("before", &good);
    for bad in cases {
        let refused = bench.renderer.render(&bad, target.view(), OFFSCREEN_FORMAT).unwrap_err();
        assert!(refused.to_string().contains("camera"), "{refused}");
        assert!(bench.renderer.ground_coordinates(&bad).is_err(), "{bad:?}");
    }
    assert!(!bench.renderer.needs_frame(&good), "the refused views left something behind");
    bench.check("after", &good);
}

#[test]
fn exaggeration_up_to_a_thousandfold_and_what_is_none() {
    // What is no factor, or beyond the range from 0.01 to 1000, is brought into it.
    let Some(gpu) = gpu() else { return };
    let factors = [0.0, 1.0e-3, 1.0, 1000.0, f64::INFINITY, f64::NAN, -3.0];
    let strategies = [Strategy::RttQuadtree, Strategy::Clipmap].into_iter();
    for (strategy, vertical_exaggeration) in
        strategies.flat_map(|strategy| factors.map(|factor| (strategy, factor)))
    {
        let settings = RendererSettings { vertical_exaggeration, ..settings_of(strategy) };
        let mut bench = Bench::new(&gpu, source_of(hills()), settings);
        let what = format!("{strategy}, exaggeration {vertical_exaggeration}");
        for (eye_m, pitch_deg) in [(2_500.0, -18.0), (900_000.0, -90.0)] {
            let eye = view().eye.truncate().extend(eye_m);
            let drawn = bench.check(&what, &CameraView { eye, pitch_deg, ..view() });
            let error_px = drawn.place_error_px();
            assert!(error_px < PLACE_CONTRACT_PX, "{what}: {error_px} px");
        }
    }
}

#[test]
fn heights_at_the_limits_of_their_types() {
    let Some(gpu) = gpu() else { return };
    fn half(p: DVec2, west_m: f64, east_m: f64) -> f64 {
        if p.x < 0.0 { west_m } else { east_m }
    }
    type Height = fn(DVec2) -> f64;
    let surfaces: [(&str, Height); 8] = [
        ("the range of 16-bit integers", |p| half(p, -32_768.0, 32_767.0)),
        ("the largest floats", |p| half(p, f64::from(f32::MIN), f64::from(f32::MAX))),
        ("infinity", |p| half(p, f64::INFINITY, 10.0)),
        ("minus infinity", |p| half(p, f64::NEG_INFINITY, 10.0)),
        ("no data in one half", |p| half(p, f64::NAN, 10.0)),
        ("no data at all", |_| f64::NAN),
        ("denormals", |p| half(p, 1.0e-40, -1.0e-40)),
        ("the usual mark of a void", |p| half(p, -3.402_823_466e38, 10.0)),
    ];
    for (what, height_m) in surfaces {
        for strategy in [Strategy::RttQuadtree, Strategy::Clipmap] {
            let surface = Surface { height_m, colour: |_| [120, 130, 90] };
            let mut bench = Bench::new(&gpu, source_of(surface), settings_of(strategy));
            let what = format!("{strategy}, {what}");
            for (x, heading_deg, pitch_deg) in
                [(4_000.0, -60.0, -18.0), (-4_000.0, 60.0, -18.0), (500.0, 0.0, -90.0)]
            {
                let eye = DVec3::new(x, 0.0, 2_500.0);
                bench.check(&what, &CameraView { eye, heading_deg, pitch_deg, ..view() });
            }
        }
    }
}

#[test]
fn a_dem_full_of_numbers_that_are_no_heights() {
    let Some(gpu) = gpu() else { return };
    let oddities = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, 1.0e-40, -0.0];
    let fixture = RasterFixture::utm([200, 160], [500_000.0, 6_800_000.0], 30.0);
    let heights = (0..200 * 160)
        .map(
            |i: usize| {
                if i.is_multiple_of(3) { oddities[i / 3 % 7] } else { 500.0 + (i % 200) as f32 }
            },
        )
        .collect::<Vec<_>>();
    let folder = tempfile::tempdir().unwrap();
    let (dem, out) = (folder.path().join("dem.tif"), folder.path().join("dataset"));
    fixture.write_f32(&dem, &heights).unwrap();
    let request = PrepareRequest::new(vec![dem], Vec::new(), out.clone());
    prepare(&request, &NoProgress, &AtomicBool::new(false)).unwrap();
    let dataset = Dataset::open(&out).unwrap();
    let range = dataset.manifest().heights.range;
    assert!(range.min_m.abs() < 1.0 && (range.max_m - 699.0).abs() < 1.0, "{range:?}");
    assert!(dataset.manifest().heights.has_voids);
    let eye = dvec2(503_000.0, 6_797_600.0).extend(2_000.0);
    let mut bench = Bench::new(&gpu, Arc::new(dataset), RendererSettings::default());
    for pitch_deg in [-5.0, -90.0] {
        bench.check("from a file", &CameraView { eye, pitch_deg, ..view() });
    }
}

#[test]
fn jumps_across_the_earth_leave_nothing_behind() {
    let Some(gpu) = gpu() else { return };
    for strategy in STRATEGIES {
        let mut bench = Bench::new(&gpu, source_of(hills()), settings_of(strategy));
        let home = bench.check("home", &view()).points;
        for shift in [dvec2(1.0e7, 0.0), dvec2(-1.0e7, 1.0e7), dvec2(0.0, -4.0e7)] {
            let away = CameraView { eye: view().eye + shift.extend(0.0), ..view() };
            // One frame only: the next jump comes before anything has been answered.
            let target = OffscreenTarget::new(&gpu, SIZE_PX);
            bench.renderer.render(&away, target.view(), OFFSCREEN_FORMAT).unwrap();
            let back = bench.check("back", &view()).points;
            let equal = |(a, b): (&DVec3, &DVec3)| a == b || (a.is_nan() && b.is_nan());
            assert!(home.iter().zip(&back).all(equal), "{strategy}: after a jump by {shift}");
        }
    }
}

#[test]
fn a_cache_drifted_over_for_a_million_frames_keeps_its_promises() {
    let mut cache = TileCache::new(6, 6);
    let level = 20;
    for frame in 0..1_000_000_u64 {
        // A window of 5 x 5 tiles that moves on by a tile every 16 frames.
        let start = (frame / 16) as u32;
        let window = (0..25).map(|i| TileId::new(level, start + i / 5, 3 * start + i % 5));
        let wanted = std::iter::once(TileId::ROOT).chain(window).collect::<Vec<_>>();
        let plan = cache.plan(&wanted, &|_| Some(36_992), 1 << 18, frame);
        assert!(plan.uploads.len() <= 7 && plan.turned_away == 0, "frame {frame}: {plan:?}");
        assert!(cache.slot_of(TileId::ROOT).is_some() && cache.len() <= 36, "frame {frame}");
        if frame % 16 == 15 {
            assert_eq!(plan.missing, 0, "frame {frame}: {plan:?}");
        }
        if frame % 10_000 == 0 {
            let table = OffsetTable::build(cache.residents());
            let slots = table.entries.iter().map(|entry| entry.slot).collect::<HashSet<_>>();
            assert_eq!((table.entries.len(), slots.len()), (cache.len(), cache.len()));
        }
    }
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
    let place = [0.45 * ROOT_M; 2].map(|most| random.between(-most, most));
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

#[test]
fn any_camera_at_all() {
    let Some(gpu) = gpu() else { return };
    let mut random = Random(0x7e_44a1);
    let mut bench = Bench::new(&gpu, source_of(hills()), RendererSettings::default());
    let mut with_ground = 0;
    for case in 0..200 {
        if case % 25 == 0 {
            let settings = RendererSettings {
                strategy: STRATEGIES[case / 25 % STRATEGIES.len()],
                vertical_exaggeration: 10.0_f64.powf(random.between(-2.0, 3.0)),
                triangle_px: random.between(1.0, 64.0),
                ..Default::default()
            };
            bench.renderer.set_settings(settings).unwrap();
        }
        let view = any_view(&mut random);
        let what = format!("case {case}, {view:?}");
        let drawn = bench.check(&what, &view);
        with_ground += usize::from(drawn.ground().next().is_some());
        let error_px = drawn.place_error_px();
        assert!(error_px < PLACE_CONTRACT_PX, "{what}: {error_px} px");
    }
    println!("{with_ground} of 200 views show ground");
    assert!(with_ground > 50, "{with_ground}");
}
