//! What models show of their texture.

use glam::dvec2;
use terrain_core::CameraView;
use terrain_core::selection::Strategy;
use terrain_core::surface::models::{Model, ModelImage, ModelInstance, Standing, WrapMode};
use terrain_tests::Picture;

use crate::{bench, is_mostly, plain, scene, standing, textured_wall, view};

/// A wall with an image of so many texels a side: the colour, with dark stripes two texels wide.
pub fn striped(size: u32, colour: [u8; 3]) -> Model {
    let texel = |index: u32| match (index % size / 2).is_multiple_of(2) {
        true => [colour[0], colour[1], colour[2], 255],
        false => [colour[0] / 8, colour[1] / 8, colour[2] / 8, 255],
    };
    textured_wall(image(size, texel), WrapMode::Repeat)
}

fn image(size: u32, texel: impl Fn(u32) -> [u8; 4]) -> ModelImage {
    let rgba = (0..size * size).flat_map(texel).collect();
    ModelImage { size_texels: [size; 2], rgba }
}

fn pixel_at(
    picture: &Picture,
    view: &CameraView,
    instance: &ModelInstance,
    [east, up]: [f64; 2],
) -> [u8; 4] {
    let place = instance.place.extend(110.0) + glam::dvec3(east, 0.0, up);
    let [x, y] = view.pixel_from_world(place).unwrap();
    picture.pixel(x as u32, y as u32)
}

fn on(model: usize, east: f64, north: f64) -> ModelInstance {
    standing(model, dvec2(east, north), Standing::Height(110.0))
}

/// An image of 8 by 8 fields, each of a colour of its own: each field is where its texture coordinates say.
#[test]
fn every_field_of_an_image_is_where_its_texture_coordinates_say() {
    let size = 512;
    let field = |x: u32, y: u32| [30 + 28 * x as u8, 30 + 28 * y as u8, 128];
    let texel = |index: u32| {
        let [red, green, blue] = field(index % size / 64, index / size / 64);
        [red, green, blue, 255]
    };
    let model = textured_wall(image(size, texel), WrapMode::Clamp);
    let instance = on(0, 0.0, -250.0);
    let models = scene(vec![model], vec![instance]);
    for strategy in [Strategy::RttQuadtree, Strategy::PageTable] {
        let Some(mut bench) = bench(plain(strategy), models.clone()) else { return };
        let picture = bench.settled_picture(&view()).unwrap();
        for (x, y) in (0..64).map(|index| (index % 8, index / 8)) {
            let at = [(f64::from(x) + 0.5) * 5.0 - 20.0, 60.0 - (f64::from(y) + 0.5) * 7.5];
            let found = pixel_at(&picture, &view(), &instance, at);
            let off = field(x, y).into_iter().zip(found).map(|(want, found)| want.abs_diff(found));
            // The air is not quite clear.
            assert!(off.max() <= Some(4), "{strategy} {x} {y}: {found:?} for {:?}", field(x, y));
        }
    }
}

/// Near, each of two models shows its own stripes; so far away that an image is two pixels large, each its own mean
/// colour and nothing of the other, which lies beside it in the texture.
#[test]
fn no_model_shows_another_s_texture_however_far_away() {
    let models = vec![striped(64, [230, 10, 10]), striped(64, [10, 10, 230])];
    let near = [on(0, -40.0, -200.0), on(1, 40.0, -200.0)];
    let Some(mut bench) = bench(plain(Strategy::CpuFrustum), scene(models.clone(), near.to_vec()))
    else {
        return;
    };
    let picture = bench.settled_picture(&view()).unwrap();
    for (instance, channel) in near.iter().zip([0, 2]) {
        let across = (0..200).map(|step| {
            pixel_at(&picture, &view(), instance, [f64::from(step) * 0.19 - 19.0, 30.0])[channel]
        });
        let (low, high) =
            across.fold((255, 0), |(low, high), value| (value.min(low), value.max(high)));
        assert!(low < 90 && high > 180, "stripes from {low} to {high}");
    }
    let far = CameraView {
        eye: dvec2(0.0, -40_000.0).extend(300.0),
        pitch_deg: -0.2,
        fov_y_deg: 12.0,
        ..view()
    };
    let apart = near.map(|instance| {
        let place = instance.place * dvec2(3.0, 1.0);
        ModelInstance { scale: 4.0, place, ..instance }
    });
    bench.renderer.set_models(scene(models, apart.to_vec())).unwrap();
    let picture = bench.settled_picture(&far).unwrap();
    let [red, blue] = apart.map(|instance| pixel_at(&picture, &far, &instance, [0.0, 120.0]));
    // Most of what is seen is air, alike before both.
    assert!(red[0] > blue[0] + 20 && blue[2] > red[2] + 20, "{red:?} {blue:?}");
}

/// Where a cut-out has gaps, what is behind it shows, with its own pages.
#[test]
fn through_the_gaps_of_a_cut_out_the_wall_behind_is_seen() {
    let fence = |index: u32| if index % 128 < 64 { [0, 0, 250, 255] } else { [0, 0, 250, 0] };
    let mut model = textured_wall(image(128, fence), WrapMode::Clamp);
    model.materials[0].alpha_cutoff = Some(0.5);
    let behind = striped(64, [250, 0, 0]);
    let instances = [on(0, 0.0, -200.0), on(1, 0.0, -190.0)];
    let Some(mut bench) =
        bench(plain(Strategy::RttQuadtree), scene(vec![model, behind], instances.to_vec()))
    else {
        return;
    };
    let picture = bench.settled_picture(&view()).unwrap();
    let at = |east: f64| pixel_at(&picture, &view(), &instances[0], [east, 30.0]);
    assert!(is_mostly(at(-10.0), 2), "{:?}", at(-10.0));
    let through = (10..180).map(|step| at(f64::from(step) * 0.1)).collect::<Vec<_>>();
    assert!(through.iter().all(|pixel| pixel[2] < 80), "{through:?}");
    assert!(through.iter().any(|pixel| is_mostly(*pixel, 0)), "stripes as sharp as they are");
}
