use std::path::{Path, PathBuf};

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::monotone_curve::MonotoneCurve;
use crate::CameraView;
use crate::dataset::Shape;
use crate::geodesy::CoordinateSystem;

/// A camera at a moment of a flight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Keyframe {
    /// Seconds from the beginning of the flight.
    pub t: f64,
    /// East, metres of the CRS; degrees of longitude over a globe.
    pub x: f64,
    /// North, metres of the CRS; degrees of latitude over a globe, within -90..=90.
    pub y: f64,
    /// Metres above the datum.
    pub height: f64,
    /// Degrees clockwise from grid north; any number of turns.
    pub heading: f64,
    /// Degrees above the horizon, negative looks down; within -90..=90.
    pub pitch: f64,
    /// Vertical field of view in degrees, within (0, 180).
    pub fov: f64,
}

impl Keyframe {
    /// The keyframe of a view over a plane.
    pub fn of_view(t: f64, view: &CameraView) -> Self {
        Self {
            t,
            x: view.eye.x,
            y: view.eye.y,
            height: view.eye.z,
            heading: view.heading_deg,
            pitch: view.pitch_deg,
            fov: view.fov_y_deg,
        }
    }
}

/// A flight that can be repeated: keyframes and the smooth path between them.
///
/// Every component follows a curve that is exact at the keyframes and never overshoots them, so a
/// path whose keyframes clear the ground does not dip between them by itself. Headings take the
/// shortest way round from one keyframe to the next, and so do longitudes over a globe. Keyframes within
/// [`Flight::CUT_S`] are a cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Flight {
    crs: String,
    shape: Shape,
    fps: f64,
    keyframes: Vec<Keyframe>,
    /// x (unwound over a globe), y, height, heading (unwound), pitch, fov.
    curves: [MonotoneCurve; 6],
}

/// The flight as it stands in its file.
#[derive(Serialize, Deserialize)]
struct FlightFile {
    crs: String,
    fps: f64,
    keyframes: Vec<Keyframe>,
}

/// Why a flight cannot be flown. Each tells its own part; what lies beneath is its source.
#[derive(Debug, thiserror::Error)]
pub enum FlightError {
    /// The file cannot be read or written.
    #[error("{}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not a flight.
    #[error("{}: not a flight", path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: Box<FlightError>,
    },
    /// The text is not JSON of the right form.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// No keyframes.
    #[error("no keyframes")]
    NoKeyframes,
    /// Ground to fly over that has no area.
    #[error("there is no ground to fly over: its extent has no area")]
    NoArea,
    /// The frame rate is not a positive number.
    #[error("fps is {0}, not a positive number")]
    FrameRate(f64),
    /// A keyframe's value is not a number, or outside its range.
    #[error("keyframe {index}: {name} is {value}, not {expected}")]
    Value {
        /// Which keyframe, from 0.
        index: usize,
        /// Which of its values.
        name: &'static str,
        /// The value.
        value: f64,
        /// What it must be.
        expected: &'static str,
    },
    /// Keyframes not in order of time.
    #[error("keyframe {index}: t is {t}, not later than the one before it")]
    Order {
        /// Which keyframe, from 0.
        index: usize,
        /// Its time, seconds.
        t: f64,
    },
}

/// Frames a flight has at the most; beyond that a file is taken to be in error.
const FRAMES_AT_MOST: f64 = 1.0e9;

impl Flight {
    /// Two keyframes no farther apart than so many seconds are a cut: the view of the first holds until
    /// the second.
    pub const CUT_S: f64 = 1.0e-3;

    /// A flight in the CRS (such as `EPSG:32632`) at `fps` frames a second. One in `EPSG:4326`, longitude and
    /// latitude, is over a globe.
    ///
    /// # Errors
    /// Without keyframes, with keyframes that are not in order of time, or with a value that is not
    /// finite or outside its range (see [`Keyframe`]).
    pub fn new(
        crs: impl Into<String>,
        fps: f64,
        keyframes: Vec<Keyframe>,
    ) -> Result<Self, FlightError> {
        let crs = crs.into();
        let is_in_degrees = crs == format!("EPSG:{}", CoordinateSystem::WGS84);
        let shape = if is_in_degrees { Shape::Globe } else { Shape::Plane };
        validate(fps, shape, &keyframes)?;
        let times: Vec<f64> = keyframes.iter().map(|keyframe| keyframe.t).collect();
        let curve = |component: fn(&Keyframe) -> f64| {
            MonotoneCurve::new(&times, keyframes.iter().map(component).collect())
        };
        let longitudes_deg = || unwound(keyframes.iter().map(|k| k.x));
        let curves = [
            match shape {
                Shape::Plane => curve(|k| k.x),
                Shape::Globe => MonotoneCurve::new(&times, longitudes_deg()),
            },
            curve(|k| k.y),
            curve(|k| k.height),
            MonotoneCurve::new(&times, unwound(keyframes.iter().map(|k| k.heading))),
            curve(|k| k.pitch),
            curve(|k| k.fov),
        ];
        Ok(Self { crs, shape, fps, keyframes, curves })
    }

    /// The same flight elsewhere: in another CRS, with every keyframe's place (x, y) what `place` makes of it.
    ///
    /// # Errors
    /// Where a place is out of range; see [`Keyframe`].
    pub fn placed(
        &self,
        crs: impl Into<String>,
        place: impl Fn(DVec2) -> DVec2,
    ) -> Result<Self, FlightError> {
        let moved = self.keyframes.iter().map(|keyframe| {
            let DVec2 { x, y } = place(DVec2::new(keyframe.x, keyframe.y));
            Keyframe { x, y, ..*keyframe }
        });
        Self::new(crs, self.fps, moved.collect())
    }

    /// Parses the text of a flight file.
    ///
    /// # Errors
    /// Where the text is not such JSON, or as [`Flight::new`].
    pub fn from_json(text: &str) -> Result<Self, FlightError> {
        let file: FlightFile = serde_json::from_str(text)?;
        Self::new(file.crs, file.fps, file.keyframes)
    }

    /// The text of a flight file.
    ///
    /// # Errors
    /// Never in practice: all values are finite. The serialiser's own error is passed on.
    pub fn to_json(&self) -> Result<String, FlightError> {
        let (crs, keyframes) = (self.crs.clone(), self.keyframes.clone());
        Ok(serde_json::to_string_pretty(&FlightFile { crs, fps: self.fps, keyframes })?)
    }

    /// Reads a flight file.
    ///
    /// # Errors
    /// Where the file cannot be read or is no flight; the error names the file.
    pub fn read(path: &Path) -> Result<Self, FlightError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| FlightError::File { path: path.to_owned(), source })?;
        Self::from_json(&text)
            .map_err(|error| FlightError::InFile { path: path.to_owned(), source: Box::new(error) })
    }

    /// Writes a flight file.
    ///
    /// # Errors
    /// Where the file cannot be written; the error names it.
    pub fn write(&self, path: &Path) -> Result<(), FlightError> {
        std::fs::write(path, self.to_json()? + "\n")
            .map_err(|source| FlightError::File { path: path.to_owned(), source })
    }

    /// The CRS the keyframes are in.
    pub fn crs(&self) -> &str {
        &self.crs
    }

    /// Frames a second.
    pub fn fps(&self) -> f64 {
        self.fps
    }

    /// The keyframes, in order of time.
    pub fn keyframes(&self) -> &[Keyframe] {
        &self.keyframes
    }

    /// The times of the first and the last keyframe, seconds.
    pub fn time_range_s(&self) -> [f64; 2] {
        // A flight has at least one keyframe, or `new` had refused it.
        [self.keyframes[0].t, self.keyframes[self.keyframes.len() - 1].t]
    }

    /// Seconds from the first keyframe to the last.
    pub fn duration_s(&self) -> f64 {
        let [start, end] = self.time_range_s();
        end - start
    }

    /// Number of frames: one at the first keyframe, then every 1/fps seconds while the flight lasts.
    pub fn frame_count(&self) -> u64 {
        // A duration of whole frames has its last frame, whatever the rounding of its product.
        (self.duration_s() * self.fps + 1.0e-6).floor() as u64 + 1
    }

    /// The time of a frame, seconds; frames beyond the last stay at the end.
    pub fn frame_time_s(&self, frame: u64) -> f64 {
        let [start, end] = self.time_range_s();
        (start + frame as f64 / self.fps).min(end)
    }

    /// Whether the view is cut after the one time and until the other, seconds.
    pub fn is_cut_between(&self, after_s: f64, until_s: f64) -> bool {
        self.keyframes.windows(2).any(|pair| {
            let is_cut = pair[1].t - pair[0].t <= Self::CUT_S;
            is_cut && after_s < pair[1].t && pair[1].t <= until_s
        })
    }

    /// The view at the time, for a picture of this size, its eye in metres. Before the first and after the last
    /// keyframe it stands still; a NaN is taken as the beginning.
    pub fn view_at(&self, t: f64, viewport_px: [u32; 2]) -> CameraView {
        let [start, end] = self.time_range_s();
        let t = t.max(start).min(end);
        let after = self.keyframes.partition_point(|keyframe| keyframe.t <= t);
        let index = after.saturating_sub(1).min(self.keyframes.len().saturating_sub(2));
        let [x, y, height, heading, pitch, fov] = match self.keyframes.get(index + 1) {
            Some(next) => {
                let width = next.t - self.keyframes[index].t;
                let is_cut = width <= Self::CUT_S && t < next.t;
                let fraction = if is_cut { 0.0 } else { (t - self.keyframes[index].t) / width };
                self.curves.each_ref().map(|curve| curve.value(index, fraction, width))
            }
            None => {
                let only = self.keyframes[index];
                [only.x, only.y, only.height, only.heading, only.pitch, only.fov]
            }
        };
        CameraView {
            eye: self.shape.world_from_user(DVec2::new(x, y)).extend(height),
            heading_deg: heading.rem_euclid(360.0),
            pitch_deg: pitch,
            fov_y_deg: fov,
            viewport_px,
        }
    }
}

fn validate(fps: f64, shape: Shape, keyframes: &[Keyframe]) -> Result<(), FlightError> {
    let (Some(first), Some(last)) = (keyframes.first(), keyframes.last()) else {
        return Err(FlightError::NoKeyframes);
    };
    for (index, keyframe) in keyframes.iter().enumerate() {
        validate_keyframe(index, shape, keyframe)?;
    }
    for (index, pair) in keyframes.windows(2).enumerate() {
        if pair[1].t <= pair[0].t {
            return Err(FlightError::Order { index: index + 1, t: pair[1].t });
        }
    }
    let is_flyable = fps.is_finite() && fps > 0.0 && (last.t - first.t) * fps <= FRAMES_AT_MOST;
    if is_flyable { Ok(()) } else { Err(FlightError::FrameRate(fps)) }
}

fn validate_keyframe(index: usize, shape: Shape, keyframe: &Keyframe) -> Result<(), FlightError> {
    let Keyframe { t, x, y, height, heading, pitch, fov } = *keyframe;
    let is_latitude = shape == Shape::Plane || (-90.0..=90.0).contains(&y);
    let in_order = [
        ("t", t, t.is_finite(), "a number"),
        ("x", x, x.is_finite(), "a number"),
        ("y", y, y.is_finite(), "a number"),
        ("y", y, is_latitude, "a latitude within -90..90 degrees"),
        ("height", height, height.is_finite(), "a number"),
        ("heading", heading, heading.is_finite(), "a number"),
        ("pitch", pitch, (-90.0..=90.0).contains(&pitch), "within -90..90 degrees"),
        ("fov", fov, fov > 0.0 && fov < 180.0, "between 0 and 180 degrees"),
    ];
    match in_order.into_iter().find(|&(_, _, is_valid, _)| !is_valid) {
        Some((name, value, _, expected)) => {
            Err(FlightError::Value { index, name, value, expected })
        }
        None => Ok(()),
    }
}

/// The same headings or longitudes with whole turns added so that none differs from the one before it by more
/// than half a turn.
fn unwound(angles_deg: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut unwound_deg = Vec::new();
    for angle in angles_deg {
        let before = unwound_deg.last().copied().unwrap_or(angle);
        unwound_deg.push(angle - 360.0 * ((angle - before) / 360.0).round());
    }
    unwound_deg
}
