//! Streams and draws terrain far larger than memory, and measures itself while it does.
//!
//! The main system is the tile scheduling of Liu Hao et al., "Dynamic Scheduling and Real-time
//! Rendering Method for Large-Scale Terrain". One type an arrow:
//!
//! - **Prepare**: rasters -> [`prepare::prepare`] -> a dataset on disk -> [`dataset::Dataset`].
//! - **A frame**: [`CameraView`] -> coordinate pass -> [`selection::CoordinateImage`] ->
//!   [`selection::VisibleRegion`] -> [`selection::subdivide`] -> [`selection::regularize`] ->
//!   [`selection::merge_farthest`] -> [`selection::Selection`] -> [`residency::TileCache`] ->
//!   [`residency::CachePlan`] -> uploads -> [`residency::OffsetTable`] -> picture ->
//!   [`measure::FrameRecord`]. [`TerrainRenderer`] runs the frame in this order.
//!   A [`selection::Strategy`] other than the paper's takes the place of the arrows up to the
//!   selection.
//!
//! Every stage between the coordinate image and the offset table is pure: no GPU, no clock, no
//! globals. World coordinates are f64 metres in the dataset's projected CRS; the GPU sees only
//! differences from the eye.
//!
//! The stages by themselves, without a GPU, over the demo's heights:
//!
//! ```
//! use std::sync::atomic::AtomicBool;
//!
//! use terrain_core::dataset::Dataset;
//! use terrain_core::prepare::{NoProgress, PrepareRequest, prepare};
//! use terrain_core::residency::{OffsetTable, TileCache};
//! use terrain_core::selection::{SeenGround, SelectionConfig, TileTree, VisibleRegion, select};
//! use terrain_core::{CameraView, tiling::TileId};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let folder = tempfile::tempdir()?;
//! let heights = concat!(env!("CARGO_MANIFEST_DIR"), "/../data/demo/dem.tif");
//! let mut request =
//!     PrepareRequest::new(vec![heights.into()], Vec::new(), folder.path().join("demo"));
//! request.epsg = Some(3395);
//! prepare(&request, &NoProgress, &AtomicBool::new(false))?;
//!
//! let dataset = Dataset::open(&request.out)?;
//! let tree = TileTree::of_source(&dataset);
//! let view = CameraView {
//!     eye: tree.data_extent.centre().extend(300_000.0),
//!     heading_deg: 0.0,
//!     pitch_deg: -45.0,
//!     fov_y_deg: 50.0,
//!     viewport_px: [1280, 720],
//! };
//! // A frame reads the region back from the GPU; here it is all there is.
//! let region = VisibleRegion::of_extent(&tree.data_extent);
//! let seen = SeenGround::of_box(&region);
//! let selection = select(&tree, Some(seen), &view, &SelectionConfig::default());
//! assert_eq!(selection.tiles[0], TileId::ROOT);
//!
//! let mut cache = TileCache::new(6, 6);
//! let plan = cache.plan(&selection.height_tiles(&tree), &|_| Some(36_992), 1 << 20, 0);
//! let table = OffsetTable::build(cache.residents());
//! assert_eq!(table.entries.len(), plan.uploads.len());
//! # Ok(())
//! # }
//! ```

mod built_for;
mod by_name;
pub mod camera_view;
pub mod dataset;
mod frame_setup;
pub mod geodesy;
pub mod gpu;
mod ground_heights;
mod layer_loading;
pub mod measure;
mod method;
pub mod precision;
pub mod prepare;
mod progress;
pub mod reference;
pub mod renderer_settings;
pub mod residency;
mod resident_terrain;
pub mod selection;
mod slot_terrain;
mod srgb;
pub mod surface;
pub mod synth;
mod terrain_renderer;
pub mod tiling;

pub use camera_view::{CameraError, CameraView};
pub use progress::{NoProgress, Progress};
pub use renderer_settings::{AntiAliasing, DebugView, LookupMethod, RendererSettings};
pub use terrain_renderer::{RenderError, TerrainRenderer};
