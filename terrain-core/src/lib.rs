//! Streams and draws terrain far larger than memory, and measures itself while it does.

pub mod camera_view;
pub mod dataset;
mod frame_setup;
pub mod geodesy;
pub mod gpu;
mod layer_loading;
pub mod measure;
pub mod prepare;
pub mod renderer_settings;
pub mod residency;
pub mod selection;
pub mod surface;
mod terrain_renderer;
pub mod tiling;

pub use camera_view::CameraView;
pub use renderer_settings::{DebugView, LookupMethod, RendererSettings};
pub use terrain_renderer::{RenderError, TerrainRenderer};
