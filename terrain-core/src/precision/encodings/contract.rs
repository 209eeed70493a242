//! What an encoding must hold, and which one does.

use serde::Serialize;

use super::{Encoding, EncodingErrors, GroundCell, PlaceCell, PositionCell};

/// The bounds that the renderer's own encoding is held to, anywhere on Earth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Contract {
    /// Up to this distance from the eye positions are held to `near_tolerance_m`, metres.
    pub near_m: f64,
    /// Metres that a near position may be off.
    pub near_tolerance_m: f64,
    /// Part of a pixel's footprint that a position beyond may be off.
    pub pixel_part: f64,
    /// Part of a texel that a texture coordinate may be off, at every level.
    pub texel_part: f64,
}

impl Contract {
    /// A millimetre within a kilometre, a sixteenth of a pixel beyond, a sixteenth of a texel.
    pub const SHIPPED: Self =
        Self { near_m: 1000.0, near_tolerance_m: 1.0e-3, pixel_part: 0.0625, texel_part: 0.0625 };
}

/// The worst of a kind of error, and where it was found.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Worst {
    /// The error.
    pub value: f64,
    /// The cell, in words.
    pub at: String,
}

/// How one encoding stands against the contract.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The encoding.
    pub encoding: Encoding,
    /// Metres, up to [`Contract::near_m`].
    pub near_m: Worst,
    /// Pixels, beyond.
    pub far_pixels: Worst,
    /// Texels of the level in use.
    pub texels: Worst,
    /// Metres that ground up to [`Contract::near_m`] from the eye is too high or too low because its
    /// heights' texels are shifted; held to [`Contract::near_tolerance_m`] too.
    pub ground_m: Worst,
    /// Whether each of the four is within its bound, in this order.
    pub holds: [bool; 4],
}

/// One verdict an encoding, in the order of [`Encoding::ALL`].
pub fn verdicts(errors: &EncodingErrors, contract: &Contract) -> Vec<Verdict> {
    Encoding::ALL.map(|encoding| verdict(encoding, errors, contract)).into()
}

fn verdict(encoding: Encoding, errors: &EncodingErrors, contract: &Contract) -> Verdict {
    let [near_m, far_pixels] = worst_positions(encoding, errors, contract);
    let (mut texels, mut ground_m) = (Worst::default(), Worst::default());
    for row in errors.places.iter().filter(|row| row.encoding == encoding) {
        texels.keep(row.worst_texels, || {
            let PlaceCell { level, magnitude_m, fov_deg } = row.cell;
            format!("level {level}, coordinates {magnitude_m:e} m, field of view {fov_deg}")
        });
    }
    for row in errors.grounds.iter().filter(|row| row.encoding == encoding) {
        ground_m.keep(row.height_m, || {
            let GroundCell { level, magnitude_m, .. } = row.cell;
            format!("level {level}, coordinates {magnitude_m:e} m")
        });
    }
    let holds = [
        near_m.value < contract.near_tolerance_m,
        far_pixels.value < contract.pixel_part,
        texels.value < contract.texel_part,
        ground_m.value < contract.near_tolerance_m,
    ];
    Verdict { encoding, near_m, far_pixels, texels, ground_m, holds }
}

/// The worst near position in metres and the worst far one in pixels.
fn worst_positions(encoding: Encoding, errors: &EncodingErrors, contract: &Contract) -> [Worst; 2] {
    let [mut near_m, mut far_pixels] = [Worst::default(), Worst::default()];
    for row in errors.positions.iter().filter(|row| row.encoding == encoding) {
        let at = || {
            let PositionCell { magnitude_m, height_m, grazing_deg, fov_deg, level, .. } = row.cell;
            format!(
                "coordinates {magnitude_m:e} m, eye {height_m:e} m high, {grazing_deg} degrees above \
                 the ground, field of view {fov_deg}, level {level}"
            )
        };
        if row.cell.distance_m <= contract.near_m {
            near_m.keep(row.worst_m, at);
        } else {
            far_pixels.keep(row.worst_pixels, at);
        }
    }
    [near_m, far_pixels]
}

impl Verdict {
    /// Whether the whole contract is kept.
    pub fn is_kept(&self) -> bool {
        self.holds.iter().all(|holds| *holds)
    }
}

impl Worst {
    fn keep(&mut self, value: f64, at: impl FnOnce() -> String) {
        // A value that is no number counts as the worst there is.
        if value > self.value || value.is_nan() {
            *self = Self { value: if value.is_nan() { f64::INFINITY } else { value }, at: at() };
        }
    }
}
