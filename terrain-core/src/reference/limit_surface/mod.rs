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

mod build;
mod cast;
mod colour_codes;
mod comparison;
mod dataset_ground;
mod distances;
mod error;
mod file;
mod footprint;
mod grid;
mod half_plane;
mod height_pyramid;
mod knot_budget;
mod knots;
mod mip_texture;
mod picture;
mod prepare;
mod ray_pattern;
mod relief;
mod study;
mod study_report;
mod surface;
mod triangle_colours;

pub use build::{ColourBuild, KnotRule};
pub use cast::LimitHit;
pub use comparison::{ComparedPicture, GroundComparison, compare_on_ground};
pub use dataset_ground::{node_heights_m, texture_window};
pub use distances::DistanceSet;
pub use error::LimitSurfaceError;
pub use file::{LimitFileHeader, LimitFileWriter, read_limit_file};
pub use footprint::{
    ConvergedQuadrature, FlatRelief, Footprint, FootprintIntegral, Relief, SurfaceTexture,
    disc_part_beyond,
};
pub use grid::LimitGrid;
pub use half_plane::HalfPlane;
pub use height_pyramid::HeightPyramid;
pub use knot_budget::KnotBudget;
pub use knots::KnotSearch;
pub use mip_texture::{Filtered, MipTexture};
pub use picture::{AccessCounts, CastPicture, CastSettings, RayColour, cast_picture};
pub use prepare::{
    BARE_COLOUR, LIMIT_FILE, LimitPrepareSummary, LimitRequest, prepare_limit_surface,
};
pub use ray_pattern::RayPattern;
pub use relief::LimitRelief;
pub use study::{FilterError, FilteredPixel, StudyCase, StudyPlace, StudySettings, run_study_case};
pub use study_report::{
    StudyRun, ground_table_csv, study_page, study_plot, study_profile_csv, study_table_csv,
};
pub use surface::{LimitMemory, LimitSurface};
pub use triangle_colours::{ColourRead, Knot, TriangleColours};
