//! What a texture map costs with back faces dropped before rasterisation, in a compute pass or in the vertex stage,
//! and without: scenes in the shape of the paper's, a landscape with more and more buildings, and one of each
//! degenerate kind. A fixed flight round each scene; the stages take turns at every view, so that whatever else the
//! machine does slows all of them.
//!
//! Prints a record as JSON: `cargo bench -p terrain-tests --bench texture_map`, optionally with the number of views a
//! scene (24). The buildings are looked for in `../shared/data/models` beside the repository; without them boxes of
//! as many triangles stand in.

#![allow(clippy::unwrap_used, reason = "a measurement that fails may stop")]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a table is what this is for")]

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DVec2, Vec2, Vec3, dvec2, vec2, vec3};
use serde_json::{Value, json};
use terrain_core::residency::page_table::FaceCulling;
use terrain_core::selection::Strategy;
use terrain_core::surface::models::{
    Model, ModelImage, ModelInstance, ModelMaterial, ModelScene, ModelTexture, ModelVertex,
    Standing, WrapMode,
};
use terrain_core::{CameraView, RendererSettings};
use terrain_tests::{AnalyticSource, Bench, Surface};

const SIZE_PX: [u32; 2] = [1280, 720];
const VIEWS: u32 = 24;
/// Times that each stage is measured at a view; the least counts.
const REPEATS: usize = 5;
/// Quads along the landscape's side, and its length.
const QUADS: u32 = 45;
const LANDSCAPE_M: f32 = 600.0;
/// Texels along the side of each model's image.
const IMAGE_TEXELS: u32 = 2_048;

fn main() {
    let views = std::env::args().find_map(|text| text.parse().ok()).unwrap_or(VIEWS);
    let source = Arc::new(AnalyticSource::new(
        Surface { height_m: |_| -500.0, colour: |_| [90, 120, 80] },
        DVec2::ZERO,
        8_192.0,
        [2, 2],
    ));
    let settings = RendererSettings { strategy: Strategy::TextureMap, ..Default::default() };
    let mut bench = Bench::new(source, settings).unwrap().unwrap();
    let cases = scenes().into_iter().map(|case| case.measure(&mut bench, views));
    let cases = cases.collect::<Vec<_>>();
    let info = bench.gpu.adapter.get_info();
    let record = json!({
        "bench": "texture_map",
        "size_px": SIZE_PX,
        "views": views,
        "cases": cases,
        "adapter": info.name,
        "driver": format!("{} {}", info.driver, info.driver_info),
        "cores": std::thread::available_parallelism().map_or(0, usize::from),
    });
    println!("{}", serde_json::to_string_pretty(&record).unwrap());
}

/// A scene and the flight round it.
struct Case {
    name: &'static str,
    scene: ModelScene,
    /// The eye's height, and how far down it looks.
    height_m: f64,
    pitch_deg: f64,
}

impl Case {
    fn triangles(&self) -> usize {
        let instances = self.scene.instances.iter();
        instances.map(|instance| self.scene.models[instance.model].triangle_count()).sum()
    }

    fn view(&self, part: f64) -> CameraView {
        let heading_deg = 360.0 * part;
        let (sin, cos) = heading_deg.to_radians().sin_cos();
        CameraView {
            eye: (dvec2(sin, cos) * -330.0).extend(self.height_m),
            heading_deg,
            pitch_deg: self.pitch_deg,
            fov_y_deg: 50.0,
            viewport_px: SIZE_PX,
        }
    }

    fn measure(self, bench: &mut Bench, views: u32) -> Value {
        let (name, triangles) = (self.name, self.triangles());
        bench.renderer.set_models(Some(Arc::new(self.scene.clone()))).unwrap();
        let mut sums_ms = FaceCulling::ALL.map(|_| 0.0);
        for index in 0..views {
            let view = self.view(f64::from(index) / f64::from(views));
            for (sum_ms, face_culling) in sums_ms.iter_mut().zip(FaceCulling::ALL) {
                bench.change(|settings| settings.face_culling = face_culling).unwrap();
                let times_ms = bench.renderer.time_models_map(&view, REPEATS).unwrap().unwrap();
                *sum_ms += times_ms.into_iter().fold(f64::INFINITY, f64::min);
            }
        }
        let means_ms = sums_ms.map(|sum_ms| sum_ms / f64::from(views));
        let without_ms = means_ms[2];
        let of = |index: usize| {
            json!({
                "mean_ms": rounded(means_ms[index]),
                "frames_per_s": rounded(1_000.0 / means_ms[index]),
                "times_as_fast": rounded(without_ms / means_ms[index]),
            })
        };
        eprintln!("{name}: {triangles} triangles, {means_ms:.3?} ms");
        json!({
            "scene": name,
            "triangles": triangles,
            "compute": of(0),
            "vertex": of(1),
            "without": { "mean_ms": rounded(without_ms), "frames_per_s": rounded(1_000.0 / without_ms) },
        })
    }
}

fn rounded(value: f64) -> f64 {
    (value * 1_000.0).round() / 1_000.0
}

/// The paper's four scenes by their numbers of triangles, then seen so that nothing and that everything is dropped.
fn scenes() -> Vec<Case> {
    let case = |name, scene| Case { name, scene, height_m: 150.0, pitch_deg: -22.0 };
    let small = || building("kenney/building-small-a.glb", 452, 14.0);
    let tall = || building("building_H_1k9.glb", 1_885, 8.0);
    let block = || building("block_8bldg_10k.glb", 9_622, 8.0);
    let district = || building("district_40bldg_52k.glb", 51_945, 8.0);
    let open =
        |height_m, pitch_deg, name| Case { name, scene: scene(Vec::new()), height_m, pitch_deg };
    vec![
        case("a landscape and a house", scene(vec![(small(), 1)])),
        case("with four buildings", scene(vec![(tall(), 4)])),
        case("with eleven buildings", scene(vec![(tall(), 3), (block(), 1)])),
        case("with fifty buildings", scene(vec![(tall(), 2), (block(), 1), (district(), 1)])),
        open(150.0, -22.0, "the landscape alone, from above"),
        open(-150.0, 22.0, "the landscape alone, from below"),
    ]
}

/// The landscape with so many of each building, in a spiral round its middle.
fn scene(buildings: Vec<((Model, f64), u32)>) -> ModelScene {
    let place = |model, place, standing, scale| ModelInstance {
        model,
        place,
        standing,
        heading_deg: 20.0,
        scale,
    };
    let mut scene = ModelScene { models: vec![landscape()], ..Default::default() };
    scene.instances.push(place(0, DVec2::ZERO, Standing::Height(0.0), 1.0));
    let mut turn = 0.0_f64;
    for ((model, scale), count) in buildings {
        for _ in 0..count {
            let (sin, cos) = (2.4 * turn).sin_cos();
            let at = dvec2(cos, sin) * 60.0 * turn.sqrt();
            let height_m = f64::from(hill_m(at.as_vec2())) - 2.0;
            let model = scene.models.len();
            scene.instances.push(place(model, at, Standing::Height(height_m), scale));
            turn += 1.0;
        }
        scene.models.push(model);
    }
    scene
}

fn hill_m(at: Vec2) -> f32 {
    18.0 * (at.x / 70.0).sin() * (at.y / 90.0).cos()
}

/// Open ground, seen from above alone.
fn landscape() -> Model {
    let corner = |i: u32| vec2((i % (QUADS + 1)) as f32, (i / (QUADS + 1)) as f32) / QUADS as f32;
    let vertex = |i: u32| {
        let at = (corner(i) - 0.5) * LANDSCAPE_M;
        ModelVertex {
            position_m: at.extend(hill_m(at)),
            normal: Vec3::Z,
            uv: vec2(corner(i).x, 1.0 - corner(i).y),
            material: 0,
        }
    };
    let quads = (0..QUADS * QUADS).map(|i| i / QUADS * (QUADS + 1) + i % QUADS);
    let across = QUADS + 1;
    let indices = quads.flat_map(|a| [a, a + 1, a + across + 1, a, a + across + 1, a + across]);
    model((0..(QUADS + 1).pow(2)).map(vertex).collect(), indices.collect())
}

/// A building with an image of its own laid over it, and metres a unit of it. The files' own texture coordinates
/// point into a palette of a few texels, where the paper's world has texels of its own everywhere.
fn building(file: &str, triangles: u32, scale: f64) -> (Model, f64) {
    let path =
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/models").join(file);
    if !path.exists() {
        eprintln!("{file} is not there: boxes stand in");
        return (boxes(triangles / 12), scale);
    }
    let found = Model::load(&path).unwrap();
    let [low, high] = found.bounds_m;
    let laid = |vertex: &ModelVertex| {
        let part = (vertex.position_m - low) / (high - low);
        let normal = vertex.normal.abs();
        let uv = match normal.max_element() {
            most if most == normal.z => part.truncate() * vec2(0.5, 0.5),
            most if most == normal.x => vec2(0.5 + 0.5 * part.y, 0.5 * part.z),
            _ => vec2(0.5 * part.x, 0.5 + 0.5 * part.z),
        };
        ModelVertex { uv: uv.clamp(Vec2::ZERO, Vec2::ONE), material: 0, ..*vertex }
    };
    (model(found.vertices.iter().map(laid).collect(), found.indices), scale)
}

fn boxes(count: u32) -> Model {
    let (mut vertices, mut indices) = (Vec::new(), Vec::new());
    for i in 0..count {
        let middle = vec3((i % 8) as f32, (i / 8 % 8) as f32, (i / 64) as f32) * 1.5;
        for (normal, right) in [
            (Vec3::X, Vec3::Y),
            (Vec3::Y, Vec3::Z),
            (Vec3::Z, Vec3::X),
            (Vec3::NEG_X, Vec3::Z),
            (Vec3::NEG_Y, Vec3::X),
            (Vec3::NEG_Z, Vec3::Y),
        ] {
            let up = normal.cross(right);
            let first = vertices.len() as u32;
            for (across, along) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)] {
                let position_m = middle + 0.5 * normal + across * right + along * up;
                let uv = vec2(across, along) + 0.5;
                vertices.push(ModelVertex { position_m, normal, uv, material: 0 });
            }
            indices.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
        }
    }
    model(vertices, indices)
}

/// A model whose back faces are not drawn, with an image.
fn model(vertices: Vec<ModelVertex>, indices: Vec<u32>) -> Model {
    let texel = |i: u32| {
        let value = (i.wrapping_mul(2_654_435_761) >> 25) as u8 + 64;
        [value, value, value, 255]
    };
    let side = IMAGE_TEXELS;
    let image =
        ModelImage { size_texels: [side, side], rgba: (0..side * side).flat_map(texel).collect() };
    let texture = Some(ModelTexture { image: 0, wrap: [WrapMode::Clamp; 2] });
    let positions = || vertices.iter().map(|vertex: &ModelVertex| vertex.position_m);
    Model {
        bounds_m: [
            positions().fold(Vec3::INFINITY, Vec3::min),
            positions().fold(Vec3::NEG_INFINITY, Vec3::max),
        ],
        single_sided: indices.len() as u32,
        materials: vec![ModelMaterial { texture, ..Default::default() }],
        images: vec![image],
        vertices,
        indices,
        ..Default::default()
    }
}
