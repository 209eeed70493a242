//! Streams and draws terrain far larger than memory, and measures itself while it does.

pub mod camera_view;
pub mod dataset;
pub mod measure;
pub mod residency;
pub mod selection;
pub mod surface;
pub mod tiling;

pub use camera_view::CameraView;
