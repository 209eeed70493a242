/// Why there is no TIN: the cause and, where there is one, the way out. The caller adds the file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TinError {
    /// The stated error is none.
    #[error("an error of at most {0} m cannot be kept; give metres, 0 or more")]
    MaxError(f64),
    /// A raster without a cell between samples.
    #[error("{columns} x {rows} samples make no surface; at least 2 x 2 are needed")]
    TooFewSamples {
        /// Samples from west to east.
        columns: usize,
        /// Samples from north to south.
        rows: usize,
    },
    /// More samples than indices.
    #[error("{columns} x {rows} samples are too many for one TIN; cut the raster or thin it")]
    TooManySamples {
        /// Samples from west to east.
        columns: usize,
        /// Samples from north to south.
        rows: usize,
    },
    /// A raster of gaps.
    #[error("nowhere do four neighbouring samples all hold data")]
    NoData,
    /// Fewer than three points.
    #[error("a surface needs three points of different x, y; there are {count}")]
    TooFewPoints {
        /// Points of different x, y.
        count: usize,
    },
    /// More points than indices.
    #[error("{count} points are too many for one triangulation; cut the area or choose a class")]
    TooManyPoints {
        /// Points of different x, y.
        count: usize,
    },
    /// No triangle to be had.
    #[error("all {count} points lie on one line; a surface needs one beside it")]
    Collinear {
        /// Points of different x, y.
        count: usize,
    },
    /// A coordinate that is no place.
    #[error("a point at {point:?} is not finite or too far away")]
    BadPoint {
        /// The point.
        point: [f64; 3],
    },
    /// No breakline meets the ground.
    #[error("none of the breaklines meets the ground; are they in the same CRS?")]
    BreaklinesElsewhere,
    /// A breakline leaves the ground where its height is not known.
    #[error("a breakline at {x}, {y} lies off the points and has no height of its own")]
    BreaklineWithoutHeight {
        /// East.
        x: f64,
        /// North.
        y: f64,
    },
    /// More than a glTF file can say of its length.
    #[error("{bytes} bytes are more than a glTF file can hold; allow a larger error")]
    TooLargeForGlb {
        /// Bytes the file would have.
        bytes: usize,
    },
    /// The caller asked to stop.
    #[error("stopped before the TIN was whole")]
    Cancelled,
}
