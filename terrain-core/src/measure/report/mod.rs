//! What was measured, as a person reads it: plots as SVG and a page that holds everything it shows.

mod axis;
mod base64;
mod html;
mod plot;

pub use html::{HtmlReport, ReportPicture};
pub use plot::{Plot, PlotError, Series, SeriesStyle};
