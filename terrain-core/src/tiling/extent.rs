use glam::DVec2;
use serde::{Deserialize, Serialize};

/// An axis-aligned rectangle of ground, in metres of the dataset's CRS.
///
/// `min` is the south-west corner and `max` the north-east one. An extent may be degenerate (zero
/// width or height), never inverted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Extent {
    /// South-west corner.
    pub min: DVec2,
    /// North-east corner.
    pub max: DVec2,
}

impl Extent {
    /// The extent from its south-west to its north-east corner.
    pub fn new(min: DVec2, max: DVec2) -> Self {
        Self { min, max }
    }

    /// Width (east-west) and height (north-south) in metres.
    pub fn size_m(&self) -> DVec2 {
        self.max - self.min
    }

    /// The middle of the extent.
    pub fn centre(&self) -> DVec2 {
        0.5 * (self.min + self.max)
    }

    /// Whether the point lies inside or on the border.
    pub fn contains(&self, point: DVec2) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }

    /// Whether the two share area (touching borders do not count).
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.cmplt(other.max).all() && other.min.cmplt(self.max).all()
    }

    /// Whether the two share at least a point (touching borders count).
    pub fn touches(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// The smallest extent holding both.
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The common part, or `None` where they do not even touch.
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        self.touches(other)
            .then(|| Self { min: self.min.max(other.min), max: self.max.min(other.max) })
    }

    /// The extent grown by `margin_m` on every side.
    pub fn grown(&self, margin_m: f64) -> Self {
        Self { min: self.min - DVec2::splat(margin_m), max: self.max + DVec2::splat(margin_m) }
    }

    /// Horizontal distance in metres from a point to the nearest point of the extent, 0 inside.
    pub fn distance_m(&self, point: DVec2) -> f64 {
        (self.min - point).max(point - self.max).max(DVec2::ZERO).length()
    }
}
