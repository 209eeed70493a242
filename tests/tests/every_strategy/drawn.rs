//! A look at everything that comes out of a frame.

use glam::{DVec2, DVec3, dvec2};
use terrain_core::CameraView;
use terrain_core::measure::FrameRecord;
use terrain_tests::{Bench, Picture};

/// Part of a pixel within which a point must lie in its pixel: the contract of the positions.
pub const PLACE_CONTRACT_PX: f64 = 1.0 / 16.0;

/// Draws the view until nothing is missing; the renderer is then at rest.
pub fn settle_to_rest(bench: &mut Bench, view: &CameraView) -> FrameRecord {
    let record = bench.settle(view).unwrap();
    assert_eq!(record.tiles_missing, 0, "{view:?}: {record:?}");
    assert!(!bench.renderer.needs_frame(view), "{view:?} goes on for ever");
    record
}

/// Draws the view until nothing is missing and looks at everything that comes out.
pub fn check(bench: &mut Bench, what: &str, view: &CameraView) -> Drawn {
    println!("{what}: {view:?}");
    settle_to_rest(bench, view);
    let picture = bench.picture().unwrap();
    // Neither ground nor sky is black anywhere; NaN and infinity are.
    let black = picture.rgba.chunks_exact(4).filter(|pixel| pixel[..3] == [0; 3]).count();
    assert_eq!(black, 0, "black pixels");
    assert!(picture.rgba.chunks_exact(4).all(|pixel| pixel[3] == 255), "see-through");
    for tile in &bench.renderer.selection().tiles {
        assert!(bench.renderer.tree().heights.present.contains(*tile), "{tile}");
    }
    let points = bench.ground_points(view).unwrap();
    let whole = |point: &DVec3| point.is_finite() || point.to_array().iter().all(|c| c.is_nan());
    assert!(points.iter().all(whole), "a point is neither ground nor sky");
    Drawn { view: *view, points }
}

/// The points of the ground that a view shows.
pub struct Drawn {
    pub view: CameraView,
    /// One a pixel, row by row; NaN where there is sky.
    pub points: Vec<DVec3>,
}

impl Drawn {
    /// The points of ground alone.
    pub fn ground(&self) -> impl Iterator<Item = DVec3> {
        self.points.iter().copied().filter(|point| point.is_finite())
    }

    /// Largest distance in pixels between where a point lies in the picture and its pixel's centre.
    pub fn place_error_px(&self) -> f64 {
        let ground = self.points.iter().enumerate().filter(|(_, point)| point.is_finite());
        let errors = ground.map(|(index, &point)| {
            let centre = pixel_centre(index, &self.view);
            let place = self.view.pixel_from_world(point).map_or(DVec2::NAN, DVec2::from);
            // `max` would drop a NaN.
            let error = place.distance(centre);
            if error.is_nan() { f64::INFINITY } else { error }
        });
        errors.fold(0.0, f64::max)
    }
}

/// Centre of a pixel of the view, counted row by row.
pub fn pixel_centre(index: usize, view: &CameraView) -> DVec2 {
    let width = view.viewport_px[0] as usize;
    dvec2((index % width) as f64 + 0.5, (index / width) as f64 + 0.5)
}

/// Straight down on the ridges: the whole picture is ground.
pub fn down() -> CameraView {
    let view = terrain_tests::Ridges::view(20.0, -90.0, 6_000.0);
    CameraView { eye: dvec2(0.0, 0.0).extend(view.eye.z), viewport_px: [192, 108], ..view }
}

/// Pixels of a picture of the ridges that are not ground: that is greener or redder than blue, and what
/// lies behind it is blue.
pub fn holes(picture: &Picture) -> usize {
    let is_hole = |pixel: &[u8]| pixel[2] > pixel[0] && pixel[2] > pixel[1];
    picture.rgba.chunks_exact(4).filter(|pixel| is_hole(pixel)).count()
}
