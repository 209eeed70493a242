//! The limit-triangulated surface: colours integrated once, over distance, for every triangle.
//!
//! After the method published in Russian for the *limit-triangulated surface* (предельно
//! триангулированная поверхность): a surface is triangulated so finely that from every distance
//! beyond a least one (`D_min`) a triangle is smaller than an admissible angle. One colour a triangle
//! is then enough, and which points rays can meet is known beforehand. `docs/limit-surface.md` tells
//! what was measured.
//!
//!
//! 1. **Preparation.** For every triangle and each distance of an increasing set D, the texture is
//!    integrated over the footprint that a cone cuts out of the surface: apex at that distance on
//!    the triangle's normal, apex angle the admissible one ([`Footprint`]).
//! 2. **Reduction.** Each triangle keeps the fewest of these distances that hold an error, or all of
//!    them together the fewest that fit into memory ([`KnotSearch`], [`KnotBudget`]).
//! 3. **Run time.** A ray that meets a triangle at distance d takes the colour between the two knots
//!    around d ([`TriangleColours::colour`], formula (4)): one or two places in memory, nothing to
//!    filter.
//!
//! Points are f64 metres of the CRS; colours are linear light in 0..=1 unless named sRGB; distances
//! are metres.

mod distances;
mod error;
mod footprint;
mod grid;
mod knot_budget;
mod knots;
mod srgb;
mod triangle_colours;

pub use distances::DistanceSet;
pub use error::LimitSurfaceError;
pub use footprint::{
    ConvergedQuadrature, FlatRelief, Footprint, FootprintIntegral, Relief, SurfaceTexture,
    disc_part_beyond,
};
pub use grid::LimitGrid;
pub use knot_budget::KnotBudget;
pub use knots::KnotSearch;
pub use triangle_colours::{ColourRead, Knot, TriangleColours};
