//! Streams and draws terrain far larger than memory, and measures itself while it does.

pub mod camera_view;
pub mod dataset;
pub mod geodesy;
pub mod prepare;
pub mod selection;
pub mod tiling;

pub use camera_view::CameraView;
