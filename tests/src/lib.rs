//! What the cases share: a headless GPU, sources whose true surface is known, and pictures.

mod analytic_source;
mod headless;
mod picture;
mod raster_fixture;

pub use analytic_source::{AnalyticSource, Surface};
pub use headless::gpu;
pub use picture::Picture;
pub use raster_fixture::{RasterFixture, Storage};
