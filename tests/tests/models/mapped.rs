//! The texture map over models: what their pixels ask for, it marks.

use glam::Vec2Swizzles;

use super::*;

/// A box of 40 m with an image on each side, repeated so often; its walls and roof are seen from outside.
fn textured_box(wrap: WrapMode, turns: Vec2) -> Model {
    let image = noise();
    let mut model = Model { vertices: Vec::new(), ..textured_wall(image, wrap) };
    model.indices.clear();
    let sides = [
        (Vec3::NEG_Y, Vec3::X, Vec3::Z),
        (Vec3::X, Vec3::Y, Vec3::Z),
        (Vec3::Y, Vec3::NEG_X, Vec3::Z),
        (Vec3::NEG_X, Vec3::NEG_Y, Vec3::Z),
        (Vec3::Z, Vec3::X, Vec3::Y),
    ];
    for (normal, right, up) in sides {
        let first = model.vertices.len() as u32;
        for (across, along) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            model.vertices.push(ModelVertex {
                position_m: 20.0 * (normal + across * right + along * up) + 20.0 * Vec3::Z,
                normal,
                uv: 0.5 * (vec2(across, along) + 1.0) * turns
                    + vec2(0.25, -0.5) * turns.yx().fract(),
                material: 0,
            });
        }
        model.indices.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
    }
    model.single_sided = model.indices.len() as u32;
    model.bounds_m = [vec3(-20.0, -20.0, 0.0), vec3(20.0, 20.0, 40.0)];
    model
}

fn noise() -> ModelImage {
    let side = 2_400_u32;
    let texel = |i: u32| {
        let value = (i.wrapping_mul(2_654_435_761) >> 24) as u8;
        [value, value / 2, 255 - value, 255]
    };
    ModelImage { size_texels: [side, side], rgba: (0..side * side).flat_map(texel).collect() }
}

#[test]
fn the_map_marks_all_that_pixels_of_models_ask_for() {
    let models = vec![
        textured_box(WrapMode::Clamp, vec2(1.0, 1.0)),
        textured_box(WrapMode::Repeat, vec2(2.5, 1.0)),
        textured_box(WrapMode::Mirror, vec2(1.5, 3.25)),
    ];
    let places = (0..12).map(|i| dvec2(f64::from(i % 4) * 90.0 - 130.0, f64::from(i / 4) * 80.0));
    let instances = places.enumerate().map(|(i, place)| ModelInstance {
        heading_deg: 17.0 * i as f64,
        ..standing(i % 3, place, Standing::OnGround)
    });
    let scene = scene(models, instances.collect());
    for anisotropy in [1, 8] {
        let with =
            |strategy| bench(RendererSettings { anisotropy, ..plain(strategy) }, scene.clone());
        let Some(mut by_pixels) = with(Strategy::PageTable) else { return };
        let mut by_map = with(Strategy::TextureMap).unwrap();
        let (mut asked_for, mut marked) = (0, 0);
        for (east, north, up, heading_deg, pitch_deg) in [
            (0.0, -400.0, 160.0, 0.0, -4.0),
            (-60.0, -45.0, 125.0, 20.0, 3.0),
            (20.0, 60.0, 420.0, 200.0, -80.0),
            (300.0, 250.0, 260.0, 230.0, -20.0),
            (-5_000.0, -4_000.0, 900.0, 50.0, -5.0),
        ] {
            let eye = dvec2(east, north).extend(up);
            let viewport_px = [960, 540];
            let view = CameraView { eye, heading_deg, pitch_deg, viewport_px, ..view() };
            by_pixels.settle(&view).unwrap();
            by_map.settle(&view).unwrap();
            let needed = by_pixels.renderer.model_pages_asked().unwrap();
            let found = by_map.renderer.model_pages_asked().unwrap();
            let is_found =
                |page, steps: &u32| found.get(page).is_some_and(|all| all & steps == *steps);
            let missing: Vec<_> =
                needed.iter().filter(|(page, steps)| !is_found(page, steps)).collect();
            assert!(
                missing.is_empty(),
                "{anisotropy} taps, {view:?}: {missing:?} of {}",
                needed.len()
            );
            asked_for += needed.len();
            marked += found.len();
        }
        println!("{anisotropy} taps: {asked_for} pages asked for, {marked} marked");
        assert!(asked_for > 20 && marked < 3 * asked_for, "{asked_for} {marked}");
    }
}
