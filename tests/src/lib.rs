//! What the cases share: a headless GPU, sources whose true surface is known, and pictures.

mod analytic_source;
mod bench;
mod case_table;
mod headless;
mod nested_sources;
mod picture;
mod raster_fixture;
mod reluctant_source;
mod remembering;
mod ridges;
mod tiled_tiff;

pub use analytic_source::{AnalyticSource, Surface};
pub use bench::Bench;
pub use case_table::Case;
pub use headless::gpu;
pub use nested_sources::NestedSources;
pub use picture::Picture;
pub use raster_fixture::{RasterFixture, Storage};
pub use reluctant_source::Reluctant;
pub use remembering::Remembering;
pub use ridges::Ridges;
