use std::sync::atomic::AtomicBool;

use glam::{DVec2, DVec3, Vec3, dvec2};
use serde::Serialize;

use super::colour_codes::srgb_from_linear;
use super::half_plane::HalfPlane;
use super::{
    CastSettings, ColourBuild, DistanceSet, KnotRule, LimitGrid, LimitMemory, LimitRelief,
    LimitSurface, LimitSurfaceError, MipTexture, RayColour, RayPattern, cast_picture,
};
use crate::CameraView;
use crate::tiling::Extent;

/// The published experiment: a plane half black, half white, seen straight on, its border tilted
/// against the pixels' columns.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StudySettings {
    /// Angle of a pixel, radians.
    pub pixel_angle_rad: f64,
    /// Columns and rows of the picture.
    pub size_px: u32,
    /// The admissible angle, the cone's at its apex, as a part of a pixel's.
    pub angle_share: f64,
    /// The part of the admissible angle that a triangle spans from the least distance.
    pub triangle_share: f64,
    /// The least distance, metres.
    pub least_distance_m: f64,
    /// Distances in a doubling.
    pub per_doubling: u32,
    /// Largest error of a triangle's reduced colours, in steps of 1/255 of sRGB.
    pub limit_steps: f32,
    /// Rays a pixel of the method and of trilinear filtering.
    pub rays: u32,
    /// Most taps a ray of anisotropic filtering.
    pub most_taps: u32,
}

impl Default for StudySettings {
    fn default() -> Self {
        Self {
            pixel_angle_rad: 1.0e-3,
            size_px: 24,
            angle_share: 0.5,
            triangle_share: 0.5,
            least_distance_m: 1_000.0,
            per_doubling: 2,
            limit_steps: 1.0,
            rays: 16,
            most_taps: 16,
        }
    }
}

/// Where in the experiment a case lies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StudyPlace {
    /// Tilt of the border against the pixels' columns, degrees.
    pub border_deg: f64,
    /// Number i of the interval [d_i, d_(i+1)] of distances.
    pub interval: usize,
    /// Where in the interval the camera stands: 0..1.
    pub part: f64,
}

impl StudySettings {
    /// As published: a cone as wide as a pixel, and triangles of a pixel at the least distance.
    pub fn published() -> Self {
        Self { angle_share: 1.0, triangle_share: 1.0, ..Self::default() }
    }
}

impl StudyPlace {
    /// The published tilts, and the published parts of three intervals: from the least distance, from
    /// twice and from four times as far with two distances in a doubling.
    pub fn published() -> Vec<Self> {
        let parts = [(0, 0.1), (2, 0.5), (4, 0.9)];
        [6.0, 23.0, 45.0]
            .into_iter()
            .flat_map(|border_deg| {
                parts.map(|(interval, part)| Self { border_deg, interval, part })
            })
            .collect()
    }
}

/// White parts of pixels by every filter, 0..=1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FilteredPixel {
    /// The ideal filter: the white part of the pixel's square, exactly.
    pub ideal: f64,
    /// Anisotropic filtering with 16 rays a pixel.
    pub anisotropic_16: f64,
    /// Anisotropic filtering with 64 rays a pixel.
    pub anisotropic_64: f64,
    /// Trilinear filtering.
    pub trilinear: f64,
    /// The limit-triangulated surface.
    pub limit: f64,
}

/// Largest and mean difference over the pixels that the border touches by any filter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FilterError {
    /// The largest, as a part of the range from black to white.
    pub largest: f64,
    /// The mean.
    pub mean: f64,
}

/// The outcome of a case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StudyCase {
    /// Where it lies.
    pub place: StudyPlace,
    /// Distance of the camera from the plane, metres.
    pub distance_m: f64,
    /// All pixels, row by row.
    #[serde(skip)]
    pub pixels: Vec<FilteredPixel>,
    /// The pixels of the middle row: the profile across the border.
    pub profile: Vec<FilteredPixel>,
    /// The method against the ideal filter.
    pub limit_error: FilterError,
    /// Trilinear filtering against the ideal filter.
    pub trilinear_error: FilterError,
    /// Anisotropic filtering with 16 rays against the ideal filter.
    pub anisotropic_16_error: FilterError,
    /// Anisotropic filtering with 64 rays against the ideal filter.
    pub anisotropic_64_error: FilterError,
    /// The method against anisotropic filtering with as many rays, the published comparison.
    pub limit_to_anisotropic: FilterError,
    /// Trilinear filtering against the same.
    pub trilinear_to_anisotropic: FilterError,
    /// What the surface takes in memory.
    pub memory: LimitMemory,
}

/// Runs a case.
///
/// # Errors
/// [`LimitSurfaceError::Setting`] where the settings make no surface.
pub fn run_study_case(
    settings: &StudySettings,
    place: StudyPlace,
) -> Result<StudyCase, LimitSurfaceError> {
    let scene = Scene::new(settings, place)?;
    let cast = |rays: u32, colour: RayColour<'_>| scene.cast(settings, rays, colour);
    let colours = scene.surface.colours();
    let limit = cast(settings.rays, RayColour::Limit(colours));
    let trilinear = cast(settings.rays, RayColour::Trilinear(&scene.texture));
    let anisotropic = RayColour::Anisotropic(&scene.texture, settings.most_taps);
    let [few, many] = [16, 64].map(|rays| cast(rays, anisotropic));
    let size = settings.size_px;
    let pixel = |index: u32| {
        let at = [index % size, index / size];
        let index = index as usize;
        FilteredPixel {
            ideal: scene.plane.white_part_of_pixel(&scene.view, at).unwrap_or(f64::NAN),
            anisotropic_16: few[index],
            anisotropic_64: many[index],
            trilinear: trilinear[index],
            limit: limit[index],
        }
    };
    let pixels: Vec<FilteredPixel> = (0..size * size).map(pixel).collect();
    let middle = (size / 2 * size) as usize;
    Ok(StudyCase {
        place,
        distance_m: scene.view.eye.z,
        profile: pixels[middle..middle + size as usize].to_vec(),
        limit_error: error_between(&pixels, |p| [p.limit, p.ideal]),
        trilinear_error: error_between(&pixels, |p| [p.trilinear, p.ideal]),
        anisotropic_16_error: error_between(&pixels, |p| [p.anisotropic_16, p.ideal]),
        anisotropic_64_error: error_between(&pixels, |p| [p.anisotropic_64, p.ideal]),
        limit_to_anisotropic: error_between(&pixels, |p| [p.limit, p.anisotropic_16]),
        trilinear_to_anisotropic: error_between(&pixels, |p| [p.trilinear, p.anisotropic_16]),
        memory: scene.surface.memory(),
        pixels,
    })
}

fn error_between(
    pixels: &[FilteredPixel],
    two: impl Fn(&FilteredPixel) -> [f64; 2],
) -> FilterError {
    let plain = |value: f64| !(0.002..=0.998).contains(&value);
    let touched = pixels.iter().filter(|p| {
        let values = [p.ideal, p.limit, p.trilinear, p.anisotropic_16, p.anisotropic_64];
        !values.into_iter().all(plain)
    });
    let (mut largest, mut sum, mut count) = (0.0_f64, 0.0, 0.0_f64);
    for pixel in touched {
        let [a, b] = two(pixel);
        largest = largest.max((a - b).abs());
        sum += (a - b).abs();
        count += 1.0;
    }
    FilterError { largest, mean: sum / count.max(1.0) }
}

struct Scene {
    plane: HalfPlane,
    surface: LimitSurface,
    texture: MipTexture,
    view: CameraView,
}

impl Scene {
    fn new(settings: &StudySettings, place: StudyPlace) -> Result<Self, LimitSurfaceError> {
        let admissible_angle_rad = settings.pixel_angle_rad * settings.angle_share;
        let distances = DistanceSet::geometric(
            settings.least_distance_m,
            settings.least_distance_m * 16.0,
            settings.per_doubling,
        )?;
        let (near_m, far_m) = interval(&distances, place.interval)?;
        let distance_m = near_m + place.part * (far_m - near_m);
        let pixel_m = distance_m * settings.pixel_angle_rad;
        // Beside the middle of the picture, so that no pixel, triangle or texel is cut in halves.
        let plane = HalfPlane {
            on_border: dvec2(0.137, 0.293) * pixel_m,
            to_white: DVec2::from_angle(place.border_deg.to_radians()),
        };
        let triangle_angle_rad = admissible_angle_rad * settings.triangle_share;
        let cell_m = LimitGrid::cell_m_for(settings.least_distance_m, triangle_angle_rad);
        let relief = flat_relief(settings, pixel_m, cell_m)?;
        let build = ColourBuild {
            relief: &relief,
            distances: &distances,
            admissible_angle_rad,
            integral: &plane,
            cancel: &AtomicBool::new(false),
        };
        let surface = build.surface(KnotRule::ColourError(settings.limit_steps))?;
        let texture = texture_of(&plane, relief.grid());
        let view = straight_down(settings, distance_m);
        Ok(Self { plane, surface, texture, view })
    }

    /// The white part of every pixel.
    fn cast(&self, settings: &StudySettings, rays: u32, colour: RayColour<'_>) -> Vec<f64> {
        let rays = RayPattern::of(rays);
        let cast = CastSettings {
            view: self.view,
            rays,
            colour,
            ray_angle_rad: match colour {
                // The paper's reference takes the ray's own share of the pixel.
                RayColour::Anisotropic(..) => settings.pixel_angle_rad * rays.spacing_px(),
                _ => self.surface.admissible_angle_rad(),
            },
            background: Vec3::ZERO,
        };
        let picture = cast_picture(self.surface.relief(), &cast);
        picture.linear.iter().map(|linear| f64::from(linear.x)).collect()
    }
}

fn interval(distances: &DistanceSet, index: usize) -> Result<(f64, f64), LimitSurfaceError> {
    let found = distances.as_slice().get(index..index + 2).map(|pair| (pair[0], pair[1]));
    found.ok_or_else(|| LimitSurfaceError::Setting(format!("there is no interval {index}")))
}

fn straight_down(settings: &StudySettings, distance_m: f64) -> CameraView {
    let half_height = 0.5 * f64::from(settings.size_px) * settings.pixel_angle_rad;
    CameraView {
        eye: DVec3::new(0.0, 0.0, distance_m),
        heading_deg: 0.0,
        pitch_deg: -90.0,
        fov_y_deg: 2.0 * half_height.atan().to_degrees(),
        viewport_px: [settings.size_px; 2],
    }
}

/// The plane's triangles: what the picture shows, and a little more.
fn flat_relief(
    settings: &StudySettings,
    pixel_m: f64,
    cell_m: f64,
) -> Result<LimitRelief, LimitSurfaceError> {
    let half_m = 0.5 * f64::from(settings.size_px) * pixel_m + 4.0 * cell_m;
    let grid = LimitGrid::over(&Extent::new(DVec2::splat(-half_m), DVec2::splat(half_m)), cell_m)?;
    LimitRelief::new(grid, vec![0.0; grid.node_count()])
}

/// The plane as a picture with a texel a cell, each texel the mean of its square.
fn texture_of(plane: &HalfPlane, grid: &LimitGrid) -> MipTexture {
    let texel = |row: u32, column: u32| {
        let white = plane.white_part_of_square(grid.node(row, column), grid.cell_m);
        let [red, green, blue] = srgb_from_linear(Vec3::splat(white as f32));
        [red, green, blue, 255]
    };
    let size = [grid.columns as usize, grid.rows as usize];
    let texels = (0..grid.rows).flat_map(|row| (0..grid.columns).map(move |c| (row, c)));
    MipTexture::new(grid.origin, grid.cell_m, size, texels.map(|(r, c)| texel(r, c)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(settings: StudySettings) -> Vec<StudyCase> {
        let settings = StudySettings { size_px: 14, ..settings };
        let places = StudyPlace::published().into_iter();
        let cases = places.map(|place| run_study_case(&settings, place).unwrap());
        cases
            .inspect(|case| {
                let percent = |error: FilterError| format!("{:.1} %", 100.0 * error.largest);
                println!(
                    "{} deg, {}: ideal {} (trilinear {}), anisotropic {} (trilinear {})",
                    case.place.border_deg,
                    case.place.part,
                    percent(case.limit_error),
                    percent(case.trilinear_error),
                    percent(case.limit_to_anisotropic),
                    percent(case.trilinear_to_anisotropic),
                );
            })
            .collect()
    }

    /// The published claim, against the published reference.
    #[test]
    fn as_published_the_error_is_below_a_tenth_and_below_trilinear() {
        for case in run(StudySettings::published()) {
            assert!(case.limit_to_anisotropic.largest <= 0.10, "{:?}", case.place);
            assert!(case.limit_to_anisotropic.largest <= case.trilinear_to_anisotropic.largest);
            assert!(case.limit_error.largest <= case.trilinear_error.largest, "{:?}", case.place);
            assert!(case.limit_error.largest <= 0.15, "a cone of a pixel over a pixel's rays");
        }
    }

    /// The default settings, against the ideal filter.
    #[test]
    fn with_half_the_cone_the_error_is_about_a_twentieth_and_below_trilinear() {
        for case in run(StudySettings::default()) {
            // At D_min and 6 degrees up to 0.053 in a larger picture; below 0.04 elsewhere.
            assert!(case.limit_error.largest <= 0.055, "{:?}", case.place);
            assert!(case.limit_to_anisotropic.largest <= 0.05, "{:?}", case.place);
            assert!(case.limit_error.largest <= case.trilinear_error.largest, "{:?}", case.place);
            assert!(case.limit_error.mean <= case.trilinear_error.mean, "{:?}", case.place);
        }
    }

    #[test]
    fn an_interval_that_is_none_is_refused() {
        let place = StudyPlace { border_deg: 6.0, interval: 99, part: 0.5 };
        assert!(run_study_case(&StudySettings::default(), place).is_err());
    }
}
