//! How exact the globe is: where shaders place its vertices, and where in the texture its points are, against f64.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3, dvec2, dvec3};
use wgpu::util::DeviceExt;

use super::gpu;
use super::page_table::read_buffer;
use super::random_field::Random;
use crate::CameraView;
use crate::dataset::{ColourFormat, Shape};
use crate::frame_setup::NEAR_PLANE_M;
use crate::geodesy::{Geodetic, PlateCarree, Wgs84};
use crate::gpu::displace_pass::bind_buffers;
use crate::gpu::shader_library::GLOBE_PROBE;
use crate::gpu::{
    FrameGroup, FrameUniforms, GlobeGroup, GlobeUniforms, GpuContext, PageAtlas, PageBindings,
    PageTableUniforms,
};
use crate::residency::page_table::PageLayout;
use crate::surface::globe::{GlobeAir, GlobeGround, SplitPlace};
use crate::tiling::TilingScheme;

/// The globe's texture: 2^18 texels round.
const TEXELS: f64 = 262_144.0;
const EQUATOR_M: f64 = PlateCarree::EQUATOR_M;

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct GlobeProbePoint {
    pub coarse: [i32; 3],
    pub height_m: f32,
    pub fine: [i32; 3],
    pub padding: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct GlobeProbeAnswer {
    pub clip: [f32; 4],
    pub relative_m: [f32; 3],
    pub cos_latitude: f32,
    pub texel: [i32; 2],
    pub part: [f32; 2],
    pub east: [f32; 3],
    pub texels_per_m_east: f32,
    pub north: [f32; 3],
    pub texels_per_m_south: f32,
    pub clear: [f32; 3],
    pub padding: u32,
    pub sky: [f32; 3],
    pub padding_too: u32,
}

/// The probe's pipeline, and what it reads.
struct Stage {
    gpu: GpuContext,
    frame: FrameGroup,
    globe: GlobeGroup,
    pages: PageBindings,
    layout: PageLayout,
    scheme: TilingScheme,
    own: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

impl Stage {
    fn new(gpu: GpuContext) -> Self {
        let device = &gpu.device;
        let scheme = PlateCarree::scheme();
        let ground = (&PlateCarree::extent(), Shape::Globe);
        let layout = PageLayout::of_ground(&scheme, ground, 9, (512, 4));
        let (frame, globe) = (FrameGroup::new(device), GlobeGroup::new(device));
        let atlas = PageAtlas::new(&gpu, (1, 1), 520, ColourFormat::Rgba8).unwrap();
        let mut pages = PageBindings::new(device, &layout, &atlas);
        let table = PageTableUniforms::new(&layout, atlas.grid(), [0.0, 0.0]);
        pages.set_uniforms(&gpu.queue, &table);
        let entries =
            [(0, true), (1, false)].map(|(binding, read_only)| wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage { read_only },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            });
        let own = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: None,
            entries: &entries,
        });
        let groups = [&frame.layout, &globe.layout, &pages.layout, &own].map(Some);
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: Some(&pipeline_layout),
            module: &GLOBE_PROBE.module(device),
            entry_point: Some("globe_probe"),
            compilation_options: Default::default(),
            cache: None,
        });
        Self { frame, globe, pages, layout, scheme, own, pipeline, gpu }
    }

    /// Answers for earth-centred places and their heights, as seen by a view.
    fn probe(&mut self, view: &CameraView, places: &[(DVec3, f64)]) -> Vec<GlobeProbeAnswer> {
        let point = |&(place, height_m): &(DVec3, f64)| {
            let SplitPlace { coarse, fine } = SplitPlace::nearest(place);
            let (coarse, fine) = (coarse.to_array(), fine.to_array());
            GlobeProbePoint { coarse, height_m: height_m as f32, fine, padding: 0 }
        };
        let points = places.iter().map(point).collect::<Vec<_>>();
        let device = &self.gpu.device;
        let haze_colour = crate::frame_setup::HAZE_COLOUR;
        let clip_from_relative = view.clip_from_relative(NEAR_PLANE_M);
        let uniforms = FrameUniforms { clip_from_relative, haze_colour, ..Default::default() };
        self.frame.set_uniforms(&self.gpu.queue, &uniforms);
        let globe = GlobeUniforms::new(&self.layout, &self.scheme, view.eye, 1.0);
        self.globe.set(&self.gpu.queue, &globe);
        let input = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents: bytemuck::cast_slice(&points),
            usage: wgpu::BufferUsages::STORAGE,
        });
        let output = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: (points.len() * size_of::<GlobeProbeAnswer>()) as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let own = bind_buffers(device, &self.own, &[&input, &output]);
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        let groups = [&self.frame.group, &self.globe.group, &self.pages.group, &own];
        for (index, group) in (0..).zip(groups) {
            pass.set_bind_group(index, group, &[]);
        }
        pass.dispatch_workgroups((points.len() as u32).div_ceil(64), 1, 1);
        drop(pass);
        self.gpu.queue.submit([encoder.finish()]);
        bytemuck::pod_collect_to_vec(&read_buffer(&self.gpu, &output, output.size()))
    }
}

fn view(longitude_deg: f64, latitude_deg: f64, height_m: f64) -> CameraView {
    CameraView {
        eye: PlateCarree::metres_from_degrees(dvec2(longitude_deg, latitude_deg)).extend(height_m),
        heading_deg: 0.0,
        pitch_deg: 0.0,
        fov_y_deg: 50.0,
        viewport_px: [1920, 1080],
    }
}

/// Eyes at special places and at random ones, from 1 m to 10^7 m.
fn eyes() -> Vec<CameraView> {
    let mut random = Random(11);
    let mut eyes = Vec::new();
    for exponent in 0..=14 {
        let height_m = 10.0_f64.powf(0.5 * f64::from(exponent));
        for (longitude, latitude) in
            [(0.0, 0.0), (180.0, 20.0), (-179.999_999, -66.0), (30.0, 90.0), (12.0, -89.999_99)]
        {
            eyes.push(view(longitude, latitude, height_m));
        }
        for _ in 0..10 {
            let place = dvec2(random.unit(), random.unit()) - 0.5;
            eyes.push(view(360.0 * place.x, 180.0 * place.y, height_m));
        }
    }
    eyes
}

/// Points of the ground about the eye, from below it to the horizon and beyond, with heights.
fn ground_points(view: &CameraView, random: &mut Random) -> Vec<Geodetic> {
    let eye = Geodetic::from_plate_carree(view.eye);
    let frame = eye.ecef_from_local();
    let below = Wgs84::ecef_from_geodetic(&Geodetic { height_m: 0.0, ..eye });
    let farthest_m = 2.0 * (view.eye.z * (2.0 * 6.4e6 + view.eye.z)).sqrt();
    (0..64)
        .map(|index| {
            let part = random.unit();
            let away_m = view.eye.z * 0.1 * (farthest_m / (view.eye.z * 0.1)).powf(part);
            let turn = 2.0 * PI * random.unit();
            let step = frame * dvec3(turn.cos() * away_m, turn.sin() * away_m, 0.0);
            let at = Wgs84::geodetic_from_ecef(below + step);
            let height_m = if index % 2 == 0 { 0.0 } else { 9_000.0 * random.unit() - 1_000.0 };
            // Below the eye, or it would be inside of the ground.
            Geodetic { height_m: height_m.min(0.2 * view.eye.z), ..at }
        })
        .collect()
}

/// The direction of a point from the eye in the eye's axes, exactly, and its distance.
fn relative(view: &CameraView, place: DVec3) -> DVec3 {
    let eye = Geodetic::from_plate_carree(view.eye);
    eye.ecef_from_local().transpose() * (place - Wgs84::ecef_from_geodetic(&eye))
}

/// The angle between two directions in pixels of the view's middle; of small angles too.
fn apart_px(view: &CameraView, a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b)) / view.pixel_angle_rad()
}

#[test]
fn points_keep_their_place_in_the_picture_to_a_sixteenth_of_a_pixel() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::new(gpu);
    let mut random = Random(5);
    let (mut worst_px, mut worst_clip_px) = (0.0_f64, 0.0_f64);
    for view in eyes() {
        let points = ground_points(&view, &mut random);
        let places: Vec<_> =
            points.iter().map(|p| (Wgs84::ecef_from_geodetic(p), p.height_m)).collect();
        for ((place, _), answer) in places.iter().zip(stage.probe(&view, &places)) {
            let exact = relative(&view, *place);
            let drawn = DVec3::from_array(answer.relative_m.map(f64::from));
            worst_px = worst_px.max(apart_px(&view, exact, drawn));
            let clip = answer.clip.map(f64::from);
            let Some([x, y]) = view.pixel_from_world(view.eye + exact) else { continue };
            let on_picture = (0.0..=1920.0).contains(&x) && (0.0..=1080.0).contains(&y);
            if on_picture {
                let [drawn_x, drawn_y] =
                    [0.5 + 0.5 * clip[0] / clip[3], 0.5 - 0.5 * clip[1] / clip[3]];
                let missed = dvec2(drawn_x * 1920.0 - x, drawn_y * 1080.0 - y);
                worst_clip_px = worst_clip_px.max(missed.length());
            }
        }
    }
    println!("points are seen {worst_px:.5} px off at the most, on the picture {worst_clip_px:.5}");
    assert!(worst_px < 1.0 / 16.0 && worst_clip_px < 1.0 / 16.0);
}

#[test]
fn places_in_the_texture_are_right_to_a_sixteenth_of_a_pixel_and_of_a_texel_nearby() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::new(gpu);
    let mut random = Random(6);
    let texel_m = EQUATOR_M / TEXELS;
    let (mut worst_px, mut worst_texels, mut worst_part) = (0.0_f64, 0.0_f64, 0.0_f64);
    for view in eyes() {
        let points = ground_points(&view, &mut random);
        let places: Vec<_> =
            points.iter().map(|p| (Wgs84::ecef_from_geodetic(p), p.height_m)).collect();
        let anchor = Geodetic { height_m: 0.0, ..Geodetic::from_plate_carree(view.eye) };
        let anchor = Wgs84::ecef_from_geodetic(&anchor);
        for (index, answer) in stage.probe(&view, &places).iter().enumerate() {
            let at = points[index];
            let found = dvec2(
                f64::from(answer.texel[0]) + f64::from(answer.part[0]),
                f64::from(answer.texel[1]) + f64::from(answer.part[1]),
            );
            let exact = dvec2(
                (at.longitude_rad / (2.0 * PI) + 0.5) * TEXELS,
                (FRAC_PI_2 - at.latitude_rad) / (2.0 * PI) * TEXELS,
            );
            // Once round is the same place; a row is as long as its part of the globe.
            let mut missed: DVec2 = found - exact;
            missed.x -= (missed.x / TEXELS).round() * TEXELS;
            missed.x *= at.latitude_rad.cos();
            let missed_texels = missed.length();
            let distance_m = relative(&view, places[index].0).length();
            let away_m = places[index].0.distance(anchor).max(distance_m);
            let missed_px = missed_texels * texel_m / distance_m / view.pixel_angle_rad();
            worst_px = worst_px.max(missed_px);
            // The part of a texel is a float: its last bit is 2^-24.
            let beyond = (missed_texels - 2.0_f64.powi(-22)).max(0.0);
            worst_part = worst_part.max(beyond * texel_m / away_m);
            if away_m < 1.0e5 {
                worst_texels = worst_texels.max(missed_texels);
            }
        }
    }
    println!(
        "places are {worst_px:.5} px off at the most, {worst_part:.2e} of the distance, {worst_texels:.5} texels within 100 km"
    );
    assert!(worst_px < 1.0 / 16.0 && worst_texels < 1.0 / 64.0 && worst_part < 1.0e-6);
}

#[test]
fn a_moving_eye_shakes_nothing() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::new(gpu);
    let mut random = Random(7);
    let mut worst_px = 0.0_f64;
    for start in eyes().into_iter().step_by(3) {
        let points = ground_points(&start, &mut random);
        let places: Vec<_> =
            points.iter().map(|p| (Wgs84::ecef_from_geodetic(p), p.height_m)).collect();
        let mut before: Option<Vec<DVec3>> = None;
        for step in 0..8 {
            // A fiftieth of a pixel of the nearest ground each.
            let moved_m = 0.02 * start.pixel_angle_rad() * start.eye.z * f64::from(step);
            let eye = start.eye + moved_m * dvec3(0.6, 0.7, -0.3);
            let view = CameraView { eye, ..start };
            let missed: Vec<DVec3> = places
                .iter()
                .zip(stage.probe(&view, &places))
                .map(|((place, _), answer)| {
                    let exact = relative(&view, *place);
                    let drawn = DVec3::from_array(answer.relative_m.map(f64::from));
                    (drawn - exact) / exact.length() / view.pixel_angle_rad()
                })
                .collect();
            if let Some(before) = &before {
                for (before, now) in before.iter().zip(&missed) {
                    worst_px = worst_px.max((*now - *before).length());
                }
            }
            before = Some(missed);
        }
    }
    println!("from step to step points shake by {worst_px:.5} px at the most");
    assert!(worst_px < 1.0 / 64.0, "{worst_px}");
}

#[test]
fn directions_on_the_ground_and_the_air_are_those_of_f64() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::new(gpu);
    let mut random = Random(8);
    let mut worst_air = 0.0_f64;
    for view in eyes().into_iter().step_by(2) {
        let within = GlobeGround::within(view.eye.truncate()).extend(view.eye.z);
        let eye = Geodetic::from_plate_carree(within);
        let air = GlobeAir::new(&eye, 1.0);
        let points = ground_points(&view, &mut random);
        let places: Vec<_> =
            points.iter().map(|p| (Wgs84::ecef_from_geodetic(p), p.height_m)).collect();
        // The axes of the probe's directions: east, away from the axis, along it, at the eye's longitude.
        let (sin_lon, cos_lon) = eye.longitude_rad.sin_cos();
        for (point, answer) in points.iter().zip(stage.probe(&view, &places)) {
            let ecef = |v: [f32; 3]| {
                let v = v.map(f64::from);
                let outward = dvec3(cos_lon, sin_lon, 0.0);
                dvec3(-sin_lon, cos_lon, 0.0) * v[0] + outward * v[1] + DVec3::Z * v[2]
            };
            let frame = point.ecef_from_local();
            let sin_lat = point.latitude_rad.sin();
            if point.latitude_rad.cos() > 1.0e-5 {
                assert!((ecef(answer.east) - frame.x_axis).length() < 1.0e-3, "{view:?} {point:?}");
                assert!(
                    (ecef(answer.north) - frame.y_axis).length() < 1.0e-3,
                    "{view:?} {point:?}"
                );
            }
            let per_radian = TEXELS / (2.0 * PI);
            let east = per_radian / (Wgs84::normal_radius_m(sin_lat) + point.height_m);
            let south = per_radian / (Wgs84::meridian_radius_m(sin_lat) + point.height_m);
            assert!((f64::from(answer.texels_per_m_east) / east - 1.0).abs() < 1.0e-5);
            assert!((f64::from(answer.texels_per_m_south) / south - 1.0).abs() < 1.0e-5);
            let at = DVec3::from_array(answer.relative_m.map(f64::from));
            let missed = air.clear(at) - DVec3::from_array(answer.clear.map(f64::from));
            let sky = air.sky(at.normalize()) - DVec3::from_array(answer.sky.map(f64::from));
            worst_air = worst_air.max(missed.abs().max_element()).max(sky.abs().max_element());
        }
    }
    println!("light through the air is {worst_air:.4} off at the most");
    assert!(worst_air < 0.02, "{worst_air}");
}
