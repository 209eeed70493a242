use glam::Vec3;
use serde::Serialize;

use super::{
    AccessCounts, CastPicture, CastSettings, LimitSurface, MipTexture, RayColour, RayPattern,
    cast_picture,
};
use crate::CameraView;
use crate::measure::error::Spread;

/// One way of colouring on a dataset's ground, against the ideal filter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GroundComparison {
    /// The way of colouring.
    pub name: String,
    /// Rays a pixel.
    pub rays: u32,
    /// Mean over the pixels of the largest channel's error, linear light.
    pub mean: f64,
    /// The error that 99 of 100 pixels stay below.
    pub p99: f64,
    /// The largest error.
    pub largest: f64,
    /// What was read.
    pub accesses: AccessCounts,
}

/// Linear light where nothing is met: a pale sky.
const SKY: Vec3 = Vec3::new(0.66, 0.76, 0.86);
/// Rays a pixel of the ideal filter.
const IDEAL_RAYS: u32 = 1024;
/// Most taps of anisotropic filtering.
const MOST_TAPS: u32 = 16;

impl GroundComparison {
    /// Names of [`Self::row`].
    pub const HEADER: [&str; 8] = [
        "colouring",
        "rays a pixel",
        "mean error %",
        "p99 error %",
        "largest error %",
        "words a hit",
        "places a hit",
        "hits a pixel",
    ];

    /// The numbers as text.
    pub fn row(&self) -> [String; 8] {
        let percent = |part: f64| format!("{:.3}", 100.0 * part);
        let pixels = self.accesses.rays as f64 / f64::from(self.rays);
        [
            self.name.clone(),
            self.rays.to_string(),
            percent(self.mean),
            percent(self.p99),
            percent(self.largest),
            format!("{:.2}", self.accesses.words_per_hit()),
            format!("{:.2}", self.accesses.places_per_hit()),
            format!("{:.2}", self.accesses.hits as f64 / pixels.max(1.0)),
        ]
    }

    fn of(name: &str, rays: u32, found: &CastPicture, ideal: &CastPicture) -> Self {
        let apart = |(a, b): (&Vec3, &Vec3)| f64::from((*a - *b).abs().max_element());
        let errors = Spread::of(found.linear.iter().zip(&ideal.linear).map(apart));
        Self {
            name: name.to_owned(),
            rays,
            mean: errors.map_or(0.0, |errors| errors.mean),
            p99: errors.map_or(0.0, |errors| errors.p99),
            largest: errors.map_or(0.0, |errors| errors.max),
            accesses: found.accesses,
        }
    }
}

/// A way of colouring with the picture it gives.
pub struct ComparedPicture {
    /// What it is.
    pub name: String,
    /// The picture.
    pub picture: CastPicture,
}

/// Casts a view of a surface in every way of colouring with 1, 16 and 64 rays a pixel, and with the
/// ideal filter: 1024 rays that read the texture unfiltered. Answers the numbers of each, and the
/// pictures of 16 rays with the ideal one first.
pub fn compare_on_ground(
    surface: &LimitSurface,
    texture: &MipTexture,
    view: CameraView,
) -> (Vec<GroundComparison>, Vec<ComparedPicture>) {
    let cast = |rays: u32, colour: RayColour<'_>| {
        let rays = RayPattern::of(rays);
        let ray_angle_rad = surface.admissible_angle_rad();
        let settings = CastSettings { view, rays, colour, ray_angle_rad, background: SKY };
        cast_picture(surface.relief(), &settings)
    };
    let ideal = cast(IDEAL_RAYS, RayColour::Unfiltered(&texture));
    let ways = [
        ("limit-triangulated", RayColour::Limit(surface.colours())),
        ("trilinear", RayColour::Trilinear(texture)),
        ("anisotropic", RayColour::Anisotropic(texture, MOST_TAPS)),
    ];
    let mut rows = Vec::new();
    let mut pictures = Vec::new();
    for (name, colour) in ways {
        for rays in [1, 16, 64] {
            let picture = cast(rays, colour);
            rows.push(GroundComparison::of(name, rays, &picture, &ideal));
            if rays == 16 {
                pictures.push(ComparedPicture { name: name.to_owned(), picture });
            }
        }
    }
    pictures.insert(0, ComparedPicture { name: "ideal".to_owned(), picture: ideal });
    (rows, pictures)
}
