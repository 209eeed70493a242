//! Models on the ground, as drawn: where they are, what hides them, which colours they show, that a still camera comes
//! to rest. Whatever the strategy.

#![allow(clippy::unwrap_used, reason = "a step that fails fails the test")]

mod drawn;
mod globe;
mod mapped;
mod textured;

use std::sync::Arc;

use glam::{DVec2, Vec2, Vec3, dvec2, vec2, vec3};
use terrain_core::selection::Strategy;
use terrain_core::surface::models::{
    Model, ModelImage, ModelInstance, ModelMaterial, ModelScene, ModelTexture, ModelVertex,
    Standing, WrapMode,
};
use terrain_core::{AntiAliasing, CameraView, RendererSettings};
use terrain_tests::{AnalyticSource, Bench, Picture, Surface};

const SIZE_PX: [u32; 2] = [320, 180];
const RED: [f32; 4] = [1.0, 0.0, 0.0, 1.0];
const BLUE: [f32; 4] = [0.0, 0.0, 1.0, 1.0];

/// Green ground that rises to the east, with a ridge 200 m high 2 km north of the root's centre.
fn source() -> Arc<AnalyticSource> {
    let surface = Surface {
        height_m: |p| 100.0 + 0.1 * p.x + 200.0 * (-((p.y - 2_000.0) / 150.0).powi(2)).exp(),
        colour: |_| [40, 160, 60],
    };
    Arc::new(AnalyticSource::new(surface, DVec2::ZERO, 16_384.0, [6, 3]))
}

/// Light that is the same on all sides.
fn plain(strategy: Strategy) -> RendererSettings {
    RendererSettings {
        strategy,
        shading_strength: 0.0,
        anti_aliasing: AntiAliasing::Off,
        ..Default::default()
    }
}

/// A wall of the model's plane at `north` metres, seen from the south: `low` to `high`, east and up.
fn wall(model: &mut Model, material: u32, north: f32, [low, high]: [Vec2; 2]) {
    let first = model.vertices.len() as u32;
    let corner = |east: f32, up: f32, uv: Vec2| ModelVertex {
        position_m: vec3(east, north, up),
        normal: Vec3::NEG_Y,
        uv,
        material,
    };
    model.vertices.extend([
        corner(low.x, low.y, vec2(0.0, 1.0)),
        corner(high.x, low.y, vec2(1.0, 1.0)),
        corner(high.x, high.y, vec2(1.0, 0.0)),
        corner(low.x, high.y, vec2(0.0, 0.0)),
    ]);
    model.indices.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
    model.single_sided = model.indices.len() as u32;
    let positions = || model.vertices.iter().map(|vertex| vertex.position_m);
    model.bounds_m = [
        positions().fold(Vec3::INFINITY, Vec3::min),
        positions().fold(Vec3::NEG_INFINITY, Vec3::max),
    ];
}

/// A wall of one colour, 40 m wide and 60 m high, that stands on its origin.
fn plain_wall(colour: [f32; 4]) -> Model {
    let mut model = Model {
        materials: vec![ModelMaterial { colour, ..Default::default() }],
        ..Default::default()
    };
    wall(&mut model, 0, 0.0, [vec2(-20.0, 0.0), vec2(20.0, 60.0)]);
    model
}

/// The same with an image on it.
fn textured_wall(image: ModelImage, wrap: WrapMode) -> Model {
    let texture = Some(ModelTexture { image: 0, wrap: [wrap; 2] });
    let material = ModelMaterial { texture, ..Default::default() };
    Model { materials: vec![material], images: vec![image], ..plain_wall([1.0; 4]) }
}

fn standing(model: usize, place: DVec2, standing: Standing) -> ModelInstance {
    ModelInstance { model, place, standing, heading_deg: 0.0, scale: 1.0 }
}

fn scene(models: Vec<Model>, instances: Vec<ModelInstance>) -> Option<Arc<ModelScene>> {
    Some(Arc::new(ModelScene { models, instances, ..Default::default() }))
}

/// From 400 m south of the root's centre, looking north.
fn view() -> CameraView {
    CameraView {
        eye: dvec2(0.0, -400.0).extend(160.0),
        heading_deg: 0.0,
        pitch_deg: -4.0,
        fov_y_deg: 40.0,
        viewport_px: SIZE_PX,
    }
}

fn bench(settings: RendererSettings, models: Option<Arc<ModelScene>>) -> Option<Bench> {
    let mut bench = Bench::new(source(), settings).unwrap()?;
    bench.renderer.set_models(models).unwrap();
    Some(bench)
}

/// Whether the pixel is more of this channel than of any other, by far.
fn is_mostly(pixel: [u8; 4], channel: usize) -> bool {
    let others = (0..3).filter(|other| *other != channel).map(|other| pixel[other]);
    u32::from(pixel[channel]) > 100 + others.map(u32::from).max().unwrap()
}

/// First and last column and row of the pixels that are mostly of this channel.
fn extent_px(picture: &Picture, channel: usize) -> Option<[[u32; 2]; 2]> {
    let [width, height] = picture.size_px;
    let all = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    let found = all.filter(|&[x, y]| is_mostly(picture.pixel(x, y), channel));
    found.fold(None, |extent, at| {
        let [first, last] = extent.unwrap_or([at, at]);
        Some([[first[0].min(at[0]), first[1].min(at[1])], [last[0].max(at[0]), last[1].max(at[1])]])
    })
}
