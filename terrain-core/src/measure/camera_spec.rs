use std::str::FromStr;

use glam::{DVec2, dvec2};

use crate::CameraView;
use crate::dataset::Shape;

/// How the height of a camera is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CameraHeight {
    /// Metres above the datum (`height=`).
    AboveDatum(f64),
    /// Metres above the ground (`agl=`).
    AboveGround(f64),
}

/// A camera as it is written on the command line:
/// `x=..,y=..,height=..|agl=..,heading=..,pitch=..,fov=..`.
///
/// `x` and `y` in the dataset's CRS (longitude and latitude in degrees for a globe) and one of `height` and `agl` (metres) are required. `heading`
/// (degrees clockwise from grid north) is 0, `pitch` (degrees, negative looks down) is
/// [`CameraSpec::DEFAULT_PITCH_DEG`] and `fov` (vertical, degrees) is
/// [`CameraSpec::DEFAULT_FOV_DEG`] where not given. Order and spaces do not matter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraSpec {
    /// East and north, metres of the CRS; as it is parsed for a globe, degrees.
    pub position: DVec2,
    /// Where the eye stands above `position`.
    pub height: CameraHeight,
    /// Degrees clockwise from grid north.
    pub heading_deg: f64,
    /// Degrees above the horizon, within -90..=90.
    pub pitch_deg: f64,
    /// Vertical field of view in degrees, within 1..=170.
    pub fov_y_deg: f64,
}

/// What is wrong with a camera's text.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CameraSpecError {
    /// A part is not `name=value`.
    #[error("camera: `{part}` is not of the form name=value")]
    NotAPair {
        /// The part.
        part: String,
    },
    /// A name that is not one of a camera's.
    #[error("camera: unknown `{name}`; known are x, y, height, agl, heading, pitch, fov")]
    UnknownName {
        /// The name.
        name: String,
    },
    /// A name given twice.
    #[error("camera: `{name}` is given twice")]
    Repeated {
        /// The name.
        name: &'static str,
    },
    /// A value that is not a finite number.
    #[error("camera: {name}=`{value}` is not a number")]
    NotANumber {
        /// The name.
        name: &'static str,
        /// The value.
        value: String,
    },
    /// A value outside its range.
    #[error("camera: {name}={value} is not within {range}")]
    OutOfRange {
        /// The name.
        name: &'static str,
        /// The value.
        value: f64,
        /// The range it must be in.
        range: &'static str,
    },
    /// A required value is not there.
    #[error("camera: `{name}` is missing")]
    Missing {
        /// The name.
        name: &'static str,
    },
    /// Both ways to give a height.
    #[error("camera: give either `height` (above the datum) or `agl` (above ground), not both")]
    TwoHeights,
}

const NAMES: [&str; 7] = ["x", "y", "height", "agl", "heading", "pitch", "fov"];

impl CameraSpec {
    /// The pitch where none is given.
    pub const DEFAULT_PITCH_DEG: f64 = -15.0;
    /// The vertical field of view where none is given.
    pub const DEFAULT_FOV_DEG: f64 = 60.0;

    /// The camera with its position in metres of the CRS of a dataset of this shape.
    ///
    /// # Errors
    /// On a globe, where `y` is no latitude.
    pub fn placed_on(self, shape: Shape) -> Result<Self, CameraSpecError> {
        let value = self.position.y;
        if shape == Shape::Globe && !(-90.0..=90.0).contains(&value) {
            let range = "-90..90 degrees of latitude";
            return Err(CameraSpecError::OutOfRange { name: "y", value, range });
        }
        Ok(Self { position: shape.world_from_user(self.position), ..self })
    }

    /// The view for a picture of this size. `ground_height_m` gives the height of the terrain *as
    /// drawn* (vertical exaggeration included); it is asked only for a height above ground.
    pub fn view(
        &self,
        viewport_px: [u32; 2],
        ground_height_m: impl FnOnce(DVec2) -> f64,
    ) -> CameraView {
        let height_m = match self.height {
            CameraHeight::AboveDatum(height_m) => height_m,
            CameraHeight::AboveGround(clearance_m) => ground_height_m(self.position) + clearance_m,
        };
        CameraView {
            eye: self.position.extend(height_m),
            heading_deg: self.heading_deg,
            pitch_deg: self.pitch_deg,
            fov_y_deg: self.fov_y_deg,
            viewport_px,
        }
    }

    fn from_values(values: [Option<f64>; 7]) -> Result<Self, CameraSpecError> {
        let [x, y, height, agl, heading, pitch, fov] = values;
        let required = |value: Option<f64>, name| value.ok_or(CameraSpecError::Missing { name });
        let position = dvec2(required(x, "x")?, required(y, "y")?);
        let height = match (height, agl) {
            (Some(_), Some(_)) => return Err(CameraSpecError::TwoHeights),
            (Some(height_m), None) => CameraHeight::AboveDatum(height_m),
            (None, Some(clearance_m)) => CameraHeight::AboveGround(clearance_m),
            (None, None) => return Err(CameraSpecError::Missing { name: "height` or `agl" }),
        };
        let pitch_deg = pitch.unwrap_or(Self::DEFAULT_PITCH_DEG);
        if !(-90.0..=90.0).contains(&pitch_deg) {
            let range = "-90..90 degrees";
            return Err(CameraSpecError::OutOfRange { name: "pitch", value: pitch_deg, range });
        }
        let fov_y_deg = fov.unwrap_or(Self::DEFAULT_FOV_DEG);
        if !(1.0..=170.0).contains(&fov_y_deg) {
            let range = "1..170 degrees";
            return Err(CameraSpecError::OutOfRange { name: "fov", value: fov_y_deg, range });
        }
        let heading_deg = heading.unwrap_or(0.0);
        Ok(Self { position, height, heading_deg, pitch_deg, fov_y_deg })
    }
}

impl FromStr for CameraSpec {
    type Err = CameraSpecError;

    fn from_str(text: &str) -> Result<Self, CameraSpecError> {
        let mut values = [None; NAMES.len()];
        for part in text.split(',').map(str::trim).filter(|part| !part.is_empty()) {
            let not_a_pair = || CameraSpecError::NotAPair { part: part.to_owned() };
            let (name, value) = part.split_once('=').ok_or_else(not_a_pair)?;
            let (name, value) = (name.trim(), value.trim());
            let index = NAMES
                .iter()
                .position(|&known| known == name)
                .ok_or_else(|| CameraSpecError::UnknownName { name: name.to_owned() })?;
            let name = NAMES[index];
            let number = value.parse::<f64>().ok().filter(|number| number.is_finite());
            let not_a_number = || CameraSpecError::NotANumber { name, value: value.to_owned() };
            let number = number.ok_or_else(not_a_number)?;
            if values[index].replace(number).is_some() {
                return Err(CameraSpecError::Repeated { name });
            }
        }
        Self::from_values(values)
    }
}

impl std::fmt::Display for CameraSpec {
    /// The camera in the form it is parsed from.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (name, height_m) = match self.height {
            CameraHeight::AboveDatum(height_m) => ("height", height_m),
            CameraHeight::AboveGround(clearance_m) => ("agl", clearance_m),
        };
        let (x, y) = (self.position.x, self.position.y);
        let (heading, pitch, fov) = (self.heading_deg, self.pitch_deg, self.fov_y_deg);
        write!(f, "x={x},y={y},{name}={height_m},heading={heading},pitch={pitch},fov={fov}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geodesy::PlateCarree;

    #[test]
    fn a_full_camera_parses_and_prints_back() {
        let text = "x=463500.5,y=-6821000,height=2400,heading=215,pitch=-12.5,fov=45";
        let spec: CameraSpec = text.parse().unwrap();
        assert_eq!(spec.position, dvec2(463_500.5, -6_821_000.0));
        assert_eq!(spec.height, CameraHeight::AboveDatum(2_400.0));
        assert_eq!((spec.heading_deg, spec.pitch_deg, spec.fov_y_deg), (215.0, -12.5, 45.0));
        assert_eq!(spec.to_string(), text);
        let view = spec.view([64, 32], |_| panic!("the ground is not asked"));
        assert_eq!(view.eye, spec.position.extend(2_400.0));
    }

    #[test]
    fn on_a_globe_places_are_degrees() {
        let spec: CameraSpec = "x=190,y=-45,height=3".parse().unwrap();
        let placed = spec.placed_on(Shape::Globe).unwrap();
        let expected = PlateCarree::metres_from_degrees(dvec2(-170.0, -45.0));
        assert!((placed.position - expected).length() < 1.0e-6);
        let back = Shape::Globe.user_from_world(placed.position);
        assert!((back - dvec2(-170.0, -45.0)).length() < 1.0e-12);
        assert_eq!(spec.placed_on(Shape::Plane).unwrap(), spec);
        let lost: CameraSpec = "x=0,y=95,height=3".parse().unwrap();
        assert!(lost.placed_on(Shape::Globe).unwrap_err().to_string().contains("latitude"));
    }

    #[test]
    fn order_and_spaces_do_not_matter_and_the_rest_has_defaults() {
        let spec: CameraSpec = " agl = 150 , y=2,x= 1e3 ".parse().unwrap();
        let view = spec.view([640, 480], |point| point.x + point.y);
        assert_eq!(view.eye, glam::dvec3(1_000.0, 2.0, 1_152.0));
        assert_eq!(view.heading_deg, 0.0);
        assert_eq!(view.pitch_deg, CameraSpec::DEFAULT_PITCH_DEG);
        assert_eq!(view.fov_y_deg, CameraSpec::DEFAULT_FOV_DEG);
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, expected) in [
            ("", "camera: `x` is missing"),
            ("x=1,y=2", "camera: `height` or `agl` is missing"),
            ("x=1,y=2,height=3,agl=4", "not both"),
            ("x=1,y=2,height", "camera: `height` is not of the form name=value"),
            ("x=1,y=2,altitude=3", "unknown `altitude`"),
            ("x=1,y=2,height=3m", "camera: height=`3m` is not a number"),
            ("x=1,y=NaN,height=3", "camera: y=`NaN` is not a number"),
            ("x=inf,y=1,height=3", "camera: x=`inf` is not a number"),
            ("x=1,y=2,height=3,x=1", "camera: `x` is given twice"),
            ("x=1,y=2,height=3,pitch=-91", "camera: pitch=-91 is not within -90..90 degrees"),
            ("x=1,y=2,height=3,fov=0", "camera: fov=0 is not within 1..170 degrees"),
        ] {
            let error = text.parse::<CameraSpec>().unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
