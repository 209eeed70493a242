use std::sync::{Arc, LazyLock};

use glam::{DVec2, dvec2};
use terrain_core::CameraView;
use terrain_core::dataset::TileSource;

use crate::{AnalyticSource, Remembering, Surface};

/// The ground most cases fly over: ridges of some 1000 m with a pattern on them that shows which level a
/// place is drawn from.
pub struct Ridges;

impl Ridges {
    /// Side of the root, metres.
    pub const ROOT_M: f64 = 65_536.0;

    /// Height in metres; the origin is the root's centre.
    pub fn height_m(p: DVec2) -> f64 {
        900.0 * (p.x / 4000.0).sin() * (p.y / 5000.0).cos() + 200.0 * (p.x / 900.0).sin()
    }

    /// The ridges, greener or redder than blue everywhere: what shows behind them is blue.
    pub fn surface() -> Surface {
        Surface {
            height_m: Self::height_m,
            colour: |p| {
                let waves = (p.x / 37.0).sin() * (p.y / 53.0).cos() + (p.x / 610.0).sin();
                [(140.0 + 40.0 * waves) as u8, 130, (50.0 - 15.0 * waves) as u8]
            },
        }
    }

    /// Six levels of heights and imagery with the root's centre at the world's origin; each tile is made
    /// once for all.
    pub fn source() -> Arc<dyn TileSource> {
        static SOURCE: LazyLock<Arc<Remembering<AnalyticSource>>> =
            LazyLock::new(|| Arc::new(Remembering::new(Ridges::source_at(DVec2::ZERO))));
        Arc::clone(&SOURCE) as _
    }

    /// The same with the root's centre at this place in the world.
    pub fn source_at(centre: DVec2) -> AnalyticSource {
        AnalyticSource::new(Self::surface(), centre, Self::ROOT_M, [6, 6])
    }

    /// A view, 320 x 180 pixels, from a place to the south of the middle, `eye_m` above the datum.
    pub fn view(heading_deg: f64, pitch_deg: f64, eye_m: f64) -> CameraView {
        CameraView {
            eye: dvec2(-3_000.0, -9_000.0).extend(eye_m),
            heading_deg,
            pitch_deg,
            fov_y_deg: 50.0,
            viewport_px: [320, 180],
        }
    }
}
