use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::ReferencePicture;
use super::camera_rays::CameraRays;
use super::globe_tracer::GlobeTracer;
use super::pixel_integral::{Tolerance, mean_colour, srgb_code};
use super::plane_tracer::PlaneTracer;
use super::scene::{ReferenceError, ReferenceScene};
use super::silhouette::SilhouetteTest;
use super::tracer::Tracer;
use crate::CameraView;
use crate::dataset::Shape;
use crate::progress::Progress;
use crate::renderer_settings::RendererSettings;

/// How a reference picture is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceSettings {
    /// Factor on all heights, within 0.01..=1000 as in
    /// [`RendererSettings`].
    pub vertical_exaggeration: f64,
    /// How much the sun's light on slopes shows: 0 not at all, 1 fully.
    pub shading_strength: f32,
    /// The estimated error of a pixel's colour, in 8-bit steps of its sRGB codes, at which no more
    /// rays are taken. An estimate: of the pixels 99 % come within four times the default of 1 (the
    /// demo's mountains against 1024 rays a pixel, a test in `tests/tests/reference.rs`).
    pub colour_tolerance: f64,
    /// Most rays of a pixel, whatever its error: at least 4, taken down to a power of two.
    pub most_rays: u32,
    /// Filter imagery from its finest level alone, tap by tap. Without, a ray whose footprint is
    /// wider than a texel takes it from the coarser level whose texels are no wider: the same means,
    /// made when the dataset was, to within the error of their encoding.
    pub finest_imagery: bool,
}

impl Default for ReferenceSettings {
    fn default() -> Self {
        let renderer = RendererSettings::default();
        Self {
            vertical_exaggeration: renderer.vertical_exaggeration,
            shading_strength: renderer.shading_strength,
            colour_tolerance: 1.0,
            most_rays: 256,
            finest_imagery: false,
        }
    }
}

impl ReferenceSettings {
    /// What a renderer with these settings is to be compared with.
    pub fn of_renderer(settings: &RendererSettings) -> Self {
        Self {
            vertical_exaggeration: settings.vertical_exaggeration,
            shading_strength: settings.shading_strength,
            ..Self::default()
        }
    }

    /// The settings with every value brought into its range.
    pub fn checked(mut self) -> Self {
        let renderer = RendererSettings {
            vertical_exaggeration: self.vertical_exaggeration,
            shading_strength: self.shading_strength,
            ..RendererSettings::default()
        }
        .checked();
        self.vertical_exaggeration = renderer.vertical_exaggeration;
        self.shading_strength = renderer.shading_strength;
        self.most_rays = self.most_rays.clamp(FEWEST_RAYS, 1 << 20);
        self.most_rays = 1 << self.most_rays.ilog2();
        self
    }
}

/// Takes the reference picture of a view. Uses all threads of the current rayon pool; the result
/// does not depend on their number.
///
/// # Errors
/// [`ReferenceError::View`] where the view has no pixels or numbers that make none,
/// [`ReferenceError::Load`] where a tile cannot be read, [`ReferenceError::Cancelled`] once
/// `cancelled` is set.
pub fn render_reference(
    scene: &ReferenceScene,
    view: &CameraView,
    settings: &ReferenceSettings,
    progress: &dyn Progress,
    cancelled: &AtomicBool,
) -> Result<ReferencePicture, ReferenceError> {
    check_view(view)?;
    let settings = settings.checked();
    let tracer: Box<dyn Tracer> = match scene.shape() {
        Shape::Plane => Box::new(PlaneTracer::new(scene, view, &settings)),
        Shape::Globe => Box::new(GlobeTracer::new(scene, view, &settings)),
    };
    let shot = Shot { tracer: &*tracer, settings, rays: CameraRays::new(view) };
    let work = Work { progress, cancelled, done: AtomicU64::new(0) };
    let silhouette = shot.silhouette(view, &work)?;
    let pixels = shot.pixels(view, &silhouette, &work)?;
    scene.check()?;
    Ok(ReferencePicture {
        size_px: view.viewport_px,
        rgba: pixels.iter().map(|pixel| pixel.rgba).collect(),
        coordinates: pixels.iter().map(|pixel| pixel.point).collect(),
        distance_m: pixels.iter().map(|pixel| pixel.distance_m).collect(),
        silhouette,
    })
}

/// Fewest rays of a pixel, and of one through which an edge runs: few rays might all miss what lies
/// behind it.
const FEWEST_RAYS: u32 = 4;
const FEWEST_RAYS_AT_EDGES: u32 = 32;

/// More pixels than any picture of use; their number must not overflow.
const MOST_PIXELS_A_SIDE: u32 = 1 << 15;

fn check_view(view: &CameraView) -> Result<(), ReferenceError> {
    if view.viewport_px.contains(&0) {
        return Err(ReferenceError::View("it has no pixels"));
    }
    if view.viewport_px.iter().any(|&side| side > MOST_PIXELS_A_SIDE) {
        return Err(ReferenceError::View("it has more than 32768 pixels a side"));
    }
    let angles = [view.heading_deg, view.pitch_deg, view.fov_y_deg];
    if !view.eye.is_finite() || angles.iter().any(|angle| !angle.is_finite()) {
        return Err(ReferenceError::View("a number of the camera is not finite"));
    }
    if !(view.fov_y_deg > 0.0 && view.fov_y_deg < 180.0) {
        return Err(ReferenceError::View("the field of view is not between 0 and 180 degrees"));
    }
    Ok(())
}

/// Whom to tell how far the work is, and whether to stop.
struct Work<'a> {
    progress: &'a dyn Progress,
    cancelled: &'a AtomicBool,
    done: AtomicU64,
}

impl Work<'_> {
    /// Whether to go on with the next row.
    fn go_on(&self) -> Result<(), ReferenceError> {
        match self.cancelled.load(Ordering::Relaxed) {
            true => Err(ReferenceError::Cancelled),
            false => Ok(()),
        }
    }

    fn row_done(&self, phase: &str, rows: u64) {
        let done = 1 + self.done.fetch_add(1, Ordering::Relaxed);
        self.progress.advanced(phase, done.min(rows), rows);
    }
}

/// One view of a scene.
struct Shot<'a> {
    tracer: &'a dyn Tracer,
    settings: ReferenceSettings,
    rays: CameraRays,
}

struct Pixel {
    rgba: [u8; 4],
    point: DVec3,
    distance_m: f64,
}

impl Shot<'_> {
    fn pixels(
        &self,
        view: &CameraView,
        silhouette: &[bool],
        work: &Work<'_>,
    ) -> Result<Vec<Pixel>, ReferenceError> {
        let [width, height] = view.viewport_px;
        work.done.store(0, Ordering::Relaxed);
        let rows = (0..height).into_par_iter().map(|row| {
            work.go_on()?;
            let edges = &silhouette[(row * width) as usize..];
            let pixels =
                (0..width).zip(edges).map(|(column, &edge)| self.pixel([column, row], edge));
            let pixels = pixels.collect::<Vec<_>>();
            work.row_done("reference", u64::from(height));
            Ok(pixels)
        });
        Ok(rows.collect::<Result<Vec<_>, ReferenceError>>()?.into_iter().flatten().collect())
    }

    fn pixel(&self, [column, row]: [u32; 2], is_edge: bool) -> Pixel {
        let corner = DVec2::new(f64::from(column), f64::from(row));
        let fewest_rays = if is_edge { FEWEST_RAYS_AT_EDGES } else { FEWEST_RAYS };
        let tolerance = Tolerance {
            steps: self.settings.colour_tolerance,
            fewest_rays: fewest_rays.min(self.settings.most_rays),
            most_rays: self.settings.most_rays,
        };
        let light = mean_colour(tolerance, |place, side_px| {
            let position = corner + DVec2::from_array(place);
            self.tracer.colour(position, side_px)
        });
        let [red, green, blue] = srgb_code(light);
        let centre = self.tracer.seen(self.rays.direction(corner.x + 0.5, corner.y + 0.5));
        Pixel {
            rgba: [red, green, blue, u8::MAX],
            point: centre.map_or(DVec3::NAN, |seen| seen.point),
            distance_m: centre.map_or(f64::INFINITY, |seen| seen.distance_m),
        }
    }

    /// The pixels through which edges of nearer ground run.
    fn silhouette(&self, view: &CameraView, work: &Work<'_>) -> Result<Vec<bool>, ReferenceError> {
        let [width, height] = view.viewport_px.map(|side| side as usize);
        let test = SilhouetteTest {
            tracer: self.tracer,
            rays: &self.rays,
            pixel_angle_rad: view.pixel_angle_rad(),
        };
        let position = |index: usize| [(index % (width + 1)) as f64, (index / (width + 1)) as f64];
        let corner_rows = (0..=height).into_par_iter().map(|row| {
            work.go_on()?;
            let from = row * (width + 1);
            let distances = (from..=from + width).map(|corner| test.distance_m(position(corner)));
            let distances = distances.collect::<Vec<_>>();
            work.row_done("silhouettes", height as u64 + 1);
            Ok(distances)
        });
        let corners = corner_rows.collect::<Result<Vec<_>, ReferenceError>>()?.concat();
        let crossed = |a: usize, b: usize| {
            test.is_crossed([position(a), position(b)], [corners[a], corners[b]])
        };
        // Of each corner: whether the side to the right of it is crossed, and the one below it.
        let sides: Vec<[bool; 2]> = (0..corners.len())
            .into_par_iter()
            .map(|corner| {
                let (column, row) = (corner % (width + 1), corner / (width + 1));
                let right = column < width && crossed(corner, corner + 1);
                let down = row < height && crossed(corner, corner + width + 1);
                [right, down]
            })
            .collect();
        let pixel = |index: usize| {
            let nw = index / width * (width + 1) + index % width;
            sides[nw][0] || sides[nw][1] || sides[nw + width + 1][0] || sides[nw + 1][1]
        };
        Ok((0..width * height).map(pixel).collect())
    }
}
