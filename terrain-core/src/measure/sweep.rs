//! Turning one knob of the renderer through several values, and which of them are worth having.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::RendererSettings;

/// What a sweep turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Knob {
    /// Pixels a texel may fill before its tile is split: `texel_px`.
    TexelPx,
    /// Both `texel_px` and `triangle_px`, in multiples of what they are.
    Detail,
    /// Slots of the caches and with them the most tiles of a selection: `4x4`.
    Cache,
    /// Size of the mesh's triangles in pixels.
    TrianglePx,
    /// Size of the coordinate pass in pixels: `160x90`.
    CoordinateSize,
    /// Frames that a coordinate image is held back before it is used.
    ReadbackLatency,
    /// What counts as visible: `box` or `exact`.
    Visibility,
    /// How a page table learns what pixels need: `list`, `full` or `jittered`.
    PageFeedback,
    /// How too long a list of tiles is made short: `farthest` or `least-error`.
    Shortening,
    /// Datasets, for instance of the same sources in other encodings.
    Dataset,
}

/// Why a knob cannot be turned so.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum KnobError {
    /// There is no such knob.
    #[error("no knob {0} (there are {names})", names = Knob::NAMES.map(|(_, name)| name).join(", "))]
    Unknown(String),
    /// The knob has no such position.
    #[error("{knob}={value}: give {expected}", knob = .knob.name())]
    Value {
        /// The knob.
        knob: Knob,
        /// What it was to be set to.
        value: String,
        /// What it can be set to.
        expected: &'static str,
    },
}

impl Knob {
    /// All knobs and what they are called on the command line.
    pub const NAMES: [(Self, &'static str); 10] = [
        (Self::TexelPx, "texel-px"),
        (Self::Detail, "detail"),
        (Self::Cache, "cache"),
        (Self::TrianglePx, "triangle-px"),
        (Self::CoordinateSize, "coordinate-size"),
        (Self::ReadbackLatency, "readback-latency"),
        (Self::Visibility, "visibility"),
        (Self::PageFeedback, "page-feedback"),
        (Self::Shortening, "shortening"),
        (Self::Dataset, "dataset"),
    ];

    /// What the knob is called on the command line.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(knob, _)| *knob == self).map_or("", |(_, name)| name)
    }

    /// The settings with the knob turned to the value. A dataset is no setting: it leaves them as they
    /// are.
    ///
    /// # Errors
    /// [`KnobError::Value`] where the knob has no such position, or one out of range.
    pub fn turned(
        self,
        settings: RendererSettings,
        value: &str,
    ) -> Result<RendererSettings, KnobError> {
        let wrong = |expected| KnobError::Value { knob: self, value: value.to_owned(), expected };
        let settings = settings.checked();
        let expected = self.positions();
        let positive = || {
            let number = value.parse::<f64>().ok().filter(|n| n.is_finite() && *n > 0.0);
            number.ok_or_else(|| wrong(expected))
        };
        let sides = |most: u32| {
            let sides = two_sides(value).filter(|s| s.iter().all(|side| *side <= most));
            sides.ok_or_else(|| wrong(expected))
        };
        let turned = match self {
            Self::TexelPx => RendererSettings { texel_px: positive()?, ..settings },
            Self::TrianglePx => RendererSettings { triangle_px: positive()?, ..settings },
            Self::Detail => {
                let factor = positive()?;
                let texel_px = factor * settings.texel_px;
                let triangle_px = factor * settings.triangle_px;
                RendererSettings { texel_px, triangle_px, ..settings }
            }
            Self::Cache => {
                let [cache_columns, cache_rows] = sides(RendererSettings::MOST_SLOTS_A_SIDE)?;
                let max_tiles = RendererSettings::most_tiles_of(cache_columns, cache_rows);
                RendererSettings { cache_columns, cache_rows, max_tiles, ..settings }
            }
            Self::CoordinateSize => {
                RendererSettings { coordinate_size_px: sides(MOST_COORDINATE_PX)?, ..settings }
            }
            Self::ReadbackLatency => {
                let frames = value.parse().ok().filter(|n| *n <= MOST_LATENCY_FRAMES);
                let frames = frames.ok_or_else(|| wrong(expected))?;
                RendererSettings { readback_latency_frames: frames, ..settings }
            }
            Self::Visibility => {
                let visibility = value.parse().map_err(|_| wrong(expected))?;
                RendererSettings { visibility, ..settings }
            }
            Self::PageFeedback => {
                let page_feedback = value.parse().map_err(|_| wrong(expected))?;
                RendererSettings { page_feedback, ..settings }
            }
            Self::Shortening => {
                let shortening = value.parse().map_err(|_| wrong(expected))?;
                RendererSettings { shortening, ..settings }
            }
            Self::Dataset => settings,
        };
        // A run must not be called after a value that it was not drawn with.
        if turned.checked() == turned { Ok(turned) } else { Err(wrong(expected)) }
    }

    /// What the knob can be set to, in words.
    fn positions(self) -> &'static str {
        match self {
            Self::TexelPx => "a number from 0.1 to 64",
            Self::TrianglePx => "a number from 1 to 64",
            Self::Detail => {
                "a factor that leaves texels of 0.1 to 64 and triangles of 1 to 64 pixels"
            }
            Self::Cache => "two numbers in range, such as 8x6",
            Self::CoordinateSize => "two numbers from 8 to 2048, such as 160x90",
            Self::ReadbackLatency => "a number of frames from 0 to 16",
            Self::Visibility => "box or exact",
            Self::PageFeedback => "list, full or jittered",
            Self::Shortening => "farthest or least-error",
            Self::Dataset => "a folder",
        }
    }
}

/// Widest and highest coordinate pass.
const MOST_COORDINATE_PX: u32 = 2048;
/// Longest time a coordinate image can be held back.
const MOST_LATENCY_FRAMES: u32 = 16;

fn two_sides(text: &str) -> Option<[u32; 2]> {
    let (width, height) = text.split_once('x')?;
    let side = |text: &str| text.trim().parse::<u32>().ok().filter(|side| *side > 0);
    Some([side(width)?, side(height)?])
}

/// A knob and the values to turn it to: `texel-px=0.5,1,2`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sweep {
    /// What is turned.
    pub knob: Knob,
    /// What to, at least one.
    pub values: Vec<String>,
}

impl FromStr for Sweep {
    type Err = KnobError;

    fn from_str(text: &str) -> Result<Self, KnobError> {
        let (name, values) = text.split_once('=').unwrap_or((text, ""));
        let found = Knob::NAMES.iter().find(|(_, known)| *known == name.trim());
        let &(knob, _) = found.ok_or_else(|| KnobError::Unknown(name.trim().to_owned()))?;
        let values = values.split(',').map(|value| value.trim().to_owned()).collect::<Vec<_>>();
        for value in &values {
            if value.is_empty() {
                let expected = "one or more values with commas between them";
                return Err(KnobError::Value { knob, value: value.clone(), expected });
            }
            knob.turned(RendererSettings::default(), value)?;
        }
        Ok(Self { knob, values })
    }
}

/// The indices of the points (cost, error) that no other point beats in both, by increasing cost: the
/// Pareto front. Of equal points the first is kept; points with a value that is no number are left out.
pub fn pareto_front(points: &[[f64; 2]]) -> Vec<usize> {
    let is_number = |index: &usize| !points[*index].iter().any(|value| value.is_nan());
    let mut order = (0..points.len()).filter(is_number).collect::<Vec<_>>();
    order.sort_by(|&a, &b| {
        points[a][0].total_cmp(&points[b][0]).then(points[a][1].total_cmp(&points[b][1]))
    });
    let mut least_error = f64::INFINITY;
    order.retain(|&index| {
        let is_better = points[index][1] < least_error;
        least_error = least_error.min(points[index][1]);
        is_better
    });
    order
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn each_knob_turns_its_own_setting() {
        let turned = |text: &str| {
            let sweep = text.parse::<Sweep>().unwrap();
            sweep.knob.turned(RendererSettings::default(), &sweep.values[0]).unwrap()
        };
        let plain = RendererSettings::default();
        assert_eq!(turned("texel-px=2"), RendererSettings { texel_px: 2.0, ..plain });
        assert_eq!(turned("triangle-px=12.5"), RendererSettings { triangle_px: 12.5, ..plain });
        let fine = RendererSettings { texel_px: 2.0, triangle_px: 8.0, ..plain };
        let finer = RendererSettings { texel_px: 1.0, triangle_px: 4.0, ..plain };
        assert_eq!(Knob::Detail.turned(fine, "0.5"), Ok(finer));
        assert!(Knob::Detail.turned(fine, "0.1").is_err(), "triangles below a pixel");
        let cache = turned("cache=8x4");
        assert_eq!((cache.cache_columns, cache.cache_rows, cache.max_tiles), (8, 4, 28));
        assert_eq!(turned("coordinate-size=80x45").coordinate_size_px, [80, 45]);
        assert_eq!(turned("readback-latency=3").readback_latency_frames, 3);
        assert_eq!(turned("dataset=plain"), plain);
    }

    #[test]
    fn a_value_that_would_be_changed_is_refused() {
        for text in ["texel-px=1,1000", "texel-px=0.01", "triangle-px=0.5", "coordinate-size=4x90"]
        {
            let error = text.parse::<Sweep>().unwrap_err().to_string();
            assert!(error.contains("from"), "{error}");
        }
        for text in ["texel-px=0.1,64", "triangle-px=1,64", "coordinate-size=8x8,2048x2048"] {
            assert!(text.parse::<Sweep>().is_ok(), "{text}");
        }
    }

    #[test]
    fn a_sweep_is_a_knob_and_its_values() {
        let sweep = "texel-px = 0.5, 1,2".replace(" = ", "=").parse::<Sweep>().unwrap();
        assert_eq!((sweep.knob, sweep.values.len()), (Knob::TexelPx, 3));
        for text in ["", "texel-px", "texel-px=", "texel-px=1,,2", "texel-px=-1", "cache=0x4"] {
            assert!(text.parse::<Sweep>().is_err(), "{text}");
        }
        for text in ["cache=99x1", "coordinate-size=160", "readback-latency=1.5", "colour=1"] {
            assert!(text.parse::<Sweep>().is_err(), "{text}");
        }
        let unknown = "colour=1".parse::<Sweep>().unwrap_err().to_string();
        assert!(unknown.contains("no knob colour") && unknown.contains("texel-px"), "{unknown}");
    }

    proptest! {
        #[test]
        fn the_front_is_what_nothing_beats(
            points in proptest::collection::vec([0_u8..12, 0_u8..12], 0..30),
        ) {
            let points = points.iter().map(|p| p.map(f64::from)).collect::<Vec<_>>();
            let beats = |a: [f64; 2], b: [f64; 2]| a[0] <= b[0] && a[1] <= b[1] && a != b;
            let front = pareto_front(&points);
            for (index, point) in points.iter().enumerate() {
                let first = points.iter().position(|other| other == point) == Some(index);
                let unbeaten = first && !points.iter().any(|other| beats(*other, *point));
                prop_assert_eq!(front.contains(&index), unbeaten);
            }
            prop_assert!(front.windows(2).all(|pair| points[pair[0]][0] < points[pair[1]][0]));
        }
    }

    #[test]
    fn what_is_no_number_is_not_on_the_front() {
        assert_eq!(pareto_front(&[[f64::NAN, 0.0], [1.0, 1.0], [0.0, f64::NAN]]), [1]);
    }
}
