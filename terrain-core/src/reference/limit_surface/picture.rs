use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;
use serde::Serialize;

use super::grid::middle_and_normal;
use super::{LimitHit, LimitRelief, MipTexture, RayPattern, SurfaceTexture, TriangleColours};
use crate::CameraView;

/// How a ray that meets the surface gets its colour.
#[derive(Clone, Copy)]
pub enum RayColour<'a> {
    /// From the triangle, formula (4).
    Limit(&'a TriangleColours),
    /// Trilinear filtering of a texture.
    Trilinear(&'a MipTexture),
    /// Anisotropic filtering of a texture with at most so many taps.
    Anisotropic(&'a MipTexture, u32),
    /// The texture itself at the point, not filtered: with many rays a pixel the ideal filter.
    Unfiltered(&'a dyn SurfaceTexture),
}

/// How a picture of a limit-triangulated surface is cast.
#[derive(Clone, Copy)]
pub struct CastSettings<'a> {
    /// The camera.
    pub view: CameraView,
    /// Rays a pixel.
    pub rays: RayPattern,
    /// How they are coloured.
    pub colour: RayColour<'a>,
    /// Angle that a ray stands for, radians: what texture filters take for its footprint.
    pub ray_angle_rad: f64,
    /// Linear light where no triangle is met.
    pub background: Vec3,
}

/// What colouring the rays read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct AccessCounts {
    /// Rays cast.
    pub rays: u64,
    /// Rays that met a triangle.
    pub hits: u64,
    /// 32-bit words (texels or knots) read for colours.
    pub words: u64,
    /// Separate places in memory they were read from.
    pub places: u64,
}

/// A picture and what it took.
#[derive(Clone, Debug, PartialEq)]
pub struct CastPicture {
    /// Width and height in pixels.
    pub size_px: [u32; 2],
    /// Linear light, row by row from the top left.
    pub linear: Vec<Vec3>,
    /// What was read for it.
    pub accesses: AccessCounts,
}

/// Casts a picture of the surface; rows in parallel.
pub fn cast_picture(relief: &LimitRelief, settings: &CastSettings<'_>) -> CastPicture {
    let size_px = settings.view.viewport_px;
    let rows: Vec<(Vec<Vec3>, AccessCounts)> =
        (0..size_px[1]).into_par_iter().map(|row| cast_row(relief, settings, row)).collect();
    let mut accesses = AccessCounts::default();
    let mut linear = Vec::with_capacity(size_px[0] as usize * rows.len());
    for (pixels, counts) in rows {
        linear.extend(pixels);
        accesses.add(counts);
    }
    CastPicture { size_px, linear, accesses }
}

fn cast_row(
    relief: &LimitRelief,
    settings: &CastSettings<'_>,
    row: u32,
) -> (Vec<Vec3>, AccessCounts) {
    let mut counts = AccessCounts::default();
    let pixel = |column: u32| {
        let mut sum = Vec3::ZERO;
        for place in settings.rays.places() {
            let at = DVec2::new(f64::from(column), f64::from(row)) + place;
            let direction = settings.view.ray_direction(at.x, at.y);
            sum += ray_colour(relief, settings, direction, &mut counts);
        }
        sum / settings.rays.rays() as f32
    };
    let pixels = (0..settings.view.viewport_px[0]).map(pixel).collect();
    (pixels, counts)
}

fn ray_colour(
    relief: &LimitRelief,
    settings: &CastSettings<'_>,
    direction: DVec3,
    counts: &mut AccessCounts,
) -> Vec3 {
    counts.rays += 1;
    let Some(hit) = relief.first_hit(settings.view.eye, direction) else {
        return settings.background;
    };
    counts.hits += 1;
    let (linear, words, places) = match settings.colour {
        RayColour::Limit(colours) => match colours.colour(hit.triangle as usize, hit.distance_m) {
            Some(read) => (read.linear, read.words, read.places),
            None => (settings.background, 1, 1),
        },
        RayColour::Trilinear(texture) => {
            let [a, b] = footprint_sides(relief, &hit, direction, settings.ray_angle_rad);
            let found = texture.trilinear(hit.point.truncate(), a.length().max(b.length()));
            (found.over(settings.background), found.texels, found.places)
        }
        RayColour::Anisotropic(texture, most_taps) => {
            let sides = footprint_sides(relief, &hit, direction, settings.ray_angle_rad);
            let found = texture.anisotropic(hit.point.truncate(), sides, most_taps);
            (found.over(settings.background), found.texels, found.places)
        }
        RayColour::Unfiltered(texture) => {
            let found = texture.colour(hit.point, 0.0);
            (found.truncate() / found.w.max(f32::MIN_POSITIVE), 1, 1)
        }
    };
    counts.words += u64::from(words);
    counts.places += u64::from(places);
    linear
}

/// The two sides, seen from above in metres, of the parallelogram that the ray's square beam cuts out
/// of the triangle's plane: one across the view, one along it, longer by the cosine.
fn footprint_sides(
    relief: &LimitRelief,
    hit: &LimitHit,
    direction: DVec3,
    ray_angle_rad: f64,
) -> [DVec2; 2] {
    /// At most so much longer than wide: a ray along the plane has no footprint.
    const LONGEST: f64 = 1.0e3;
    let width_m = hit.distance_m * ray_angle_rad;
    let normal = relief
        .corners(hit.triangle as usize)
        .map_or(DVec3::Z, |corners| middle_and_normal(corners).1);
    let across = direction.cross(normal).try_normalize().unwrap_or(DVec3::X);
    let along = across.cross(normal);
    let stretch = (1.0 / direction.dot(normal).abs()).min(LONGEST);
    [(across * width_m).truncate(), (along * (width_m * stretch)).truncate()]
}

impl AccessCounts {
    fn add(&mut self, other: Self) {
        self.rays += other.rays;
        self.hits += other.hits;
        self.words += other.words;
        self.places += other.places;
    }

    /// Words read a ray that met a triangle.
    pub fn words_per_hit(&self) -> f64 {
        self.words as f64 / self.hits.max(1) as f64
    }

    /// Separate places in memory a ray that met a triangle.
    pub fn places_per_hit(&self) -> f64 {
        self.places as f64 / self.hits.max(1) as f64
    }
}

impl CastPicture {
    /// sRGB with alpha 255, as the renderer's pictures are.
    pub fn to_rgba(&self) -> Vec<u8> {
        let pixel = |&linear: &Vec3| {
            let [red, green, blue] = super::colour_codes::srgb_from_linear(linear);
            [red, green, blue, 255]
        };
        self.linear.iter().flat_map(pixel).collect()
    }
}
