use glam::DVec2;

use super::{Flight, FlightError, Keyframe};
use crate::CameraView;
use crate::dataset::Shape;

/// Makes a flight of the views as they are flown, without a keyframe for every frame.
///
/// A view becomes a keyframe [`FlightRecorder::INTERVAL_S`] after the one before it. While the
/// camera stands still nothing is added; when it moves again, the moment it began is.
#[derive(Clone, Debug, Default)]
pub struct FlightRecorder {
    keyframes: Vec<Keyframe>,
    /// The latest view, where it is not a keyframe.
    latest: Option<Keyframe>,
}

impl FlightRecorder {
    /// Seconds between keyframes of a moving camera.
    pub const INTERVAL_S: f64 = 0.25;

    /// An empty recording.
    pub fn new() -> Self {
        Self::default()
    }

    /// Records the view at a time in seconds. Times that do not rise are left out.
    pub fn record(&mut self, t: f64, view: &CameraView) {
        let sample = Keyframe::of_view(t, view);
        let Some(last) = self.keyframes.last().copied() else {
            self.keyframes.push(sample);
            return;
        };
        let previous = self.latest.unwrap_or(last);
        if t.is_nan() || t <= previous.t {
            return;
        }
        let at = |t: f64, keyframe: Keyframe| Keyframe { t, ..keyframe };
        let stood_still = previous.t > last.t && at(last.t, previous) == last;
        let stands_still = at(last.t, sample) == last;
        if stood_still && !stands_still {
            self.keyframes.push(previous);
        }
        let since_s = t - self.keyframes.last().map_or(last.t, |keyframe| keyframe.t);
        if !stands_still && since_s >= Self::INTERVAL_S {
            self.keyframes.push(sample);
            self.latest = None;
        } else {
            self.latest = Some(sample);
        }
    }

    /// Number of keyframes so far.
    pub fn len(&self) -> usize {
        self.keyframes.len()
    }

    /// Whether nothing has been recorded.
    pub fn is_empty(&self) -> bool {
        self.keyframes.is_empty()
    }

    /// The flight recorded over a dataset of this shape, in the CRS that people read its places in; its time counted from the first view, which ends with the last view.
    ///
    /// # Errors
    /// As [`Flight::new`]: where nothing was recorded, or a view is out of range.
    pub fn finish(
        self,
        (crs, shape): (impl Into<String>, Shape),
        fps: f64,
    ) -> Result<Flight, FlightError> {
        let mut keyframes = self.keyframes;
        keyframes.extend(self.latest);
        let start = keyframes.first().map_or(0.0, |keyframe| keyframe.t);
        for keyframe in &mut keyframes {
            keyframe.t -= start;
            let place = shape.user_from_world(DVec2::new(keyframe.x, keyframe.y));
            (keyframe.x, keyframe.y) = (place.x, place.y);
        }
        Flight::new(crs, fps, keyframes)
    }
}
