//! Everything that touches the GPU: one file a pass or resource. Planning happens elsewhere, in pure
//! code; what is here executes plans. wgpu types do not leave this module, `method/`,
//! `terrain_renderer.rs` with its folder and the application's viewer.

mod adapter_survey;
mod atlas;
mod build_tile_table_pass;
mod clipmap;
mod colour_atlas;
mod compute_pipeline;
mod context;
mod coordinate_feedback;
mod coordinate_image_bindings;
mod coordinate_pass;
mod cover_pipeline;
mod debug_image_pass;
mod derive_colours_pass;
mod derive_heights_pass;
mod displace_pass;
mod displaced_mesh;
mod frame_bindings;
mod frame_group;
mod frame_uniforms;
mod globe;
mod ground_pipeline;
mod height_atlas;
mod limit_surface_buffers;
mod limit_surface_pass;
mod manage_tiles_pass;
mod mark_seen_tiles_pass;
mod mesh_buffers;
mod objects;
mod offscreen_target;
mod offset_table_buffer;
mod page_table;
mod picture;
mod place_tiles_pass;
mod precision_depth_probe;
mod precision_probe;
mod readback_ring;
mod reduce_region_pass;
mod scene_meshes;
mod seen_ground_buffer;
mod select_tiles_pass;
pub mod shader_library;
mod sky_pass;
mod sort_triangles_pass;
mod terrain_cache;
mod terrain_pass;
mod texture_map;
mod tile_management;
mod tile_presence;
mod tile_report;
mod tile_report_ring;
mod tile_selection;
mod timestamps;
#[cfg(test)]
mod twin_tests;
mod uniform_group;
mod view_mesh_buffers;
mod view_mesh_pass;

pub use adapter_survey::{AdapterReport, CapabilityReport, LimitReport, survey_adapters};
pub(crate) use clipmap::{
    ClipBindings, ClipDecodePass, ClipFrame, ClipHeightUpload, ClipHeightsPass, ClipLevel,
    ClipMeshBuffers, ClipPass, ClipPassSettings, ClipTextureSizes, ClipTextures, WrittenTexels,
    draw_clip_coordinates,
};
pub use context::{AdapterChoice, GpuContext, GpuError};
pub(crate) use coordinate_feedback::CoordinateFeedback;
pub(crate) use coordinate_pass::CoordinatePass;
pub use debug_image_pass::{DEBUG_IMAGE_FORMAT, DebugImage};
pub(crate) use debug_image_pass::{DebugImagePass, DebugImageSource};
pub(crate) use frame_bindings::FrameBindings;
pub(crate) use frame_group::FrameGroup;
pub use frame_uniforms::{FrameUniforms, TableRange};
pub(crate) use globe::{
    DrawnPatch, GlobeBindings, GlobeGroup, GlobePass, GlobePassSettings, GlobeRequestPass,
    GlobeUniforms, PatchBuffers, draw_globe_coordinates,
};
pub use limit_surface_pass::{LimitGpuColour, LimitGpuPicture, LimitSurfacePass};
pub(crate) use manage_tiles_pass::LayerDeliveries;
pub(crate) use objects::{
    ModelRun, ObjectBindings, ObjectBuffers, ObjectDepthPass, ObjectMaterial, ObjectPass,
    ObjectPassSettings, ObjectRequestPass,
};
pub(crate) use offscreen_target::read_texture;
pub use offscreen_target::{OFFSCREEN_FORMAT, OffscreenTarget};
pub use offset_table_buffer::{TileEntry, TilePlace, ToldFrom};
pub(crate) use page_table::{
    PageAtlas, PageBindings, PageFeedbackRing, PageGround, PageGroundBindings, PageGroundGroup,
    PageGroundPass, PageGroundPassSettings, PageMarks, PageRequestPass, PageTableUniforms,
    TinBindings, TinBuffers, TinPass, TinPassSettings, TinRequestPass,
};
pub(crate) use picture::{Picture, PictureTarget, TargetKind};
pub use precision_depth_probe::probe_depth;
pub use precision_probe::{
    Answer, NativeFloat, Operands, Outcome, Results, Trial, probe_encodings, probe_floats,
    probe_native, probe_span,
};
pub(crate) use scene_meshes::{MeshScene, SceneMeshes};
pub(crate) use shader_library::{MAP_GROUND, MAP_OBJECTS};
pub(crate) use terrain_cache::TerrainCache;
pub(crate) use terrain_pass::{TerrainPass, TerrainPassSettings};
#[cfg(test)]
pub(crate) use texture_map::{DepthPyramid, MipRange, TextureMapUniforms};
pub(crate) use texture_map::{GroundDepthPass, MapScene, ObjectRanges, SceneMap, ground_triangles};
pub(crate) use tile_management::TileManagement;
pub(crate) use tile_report::TileReport;
pub(crate) use tile_report_ring::TileReportRing;
pub(crate) use tile_selection::{SelectionRequest, TileSelection};
pub(crate) use timestamps::FrameTimer;
pub(crate) use view_mesh_buffers::ViewMeshBuffers;
pub(crate) use view_mesh_pass::{ViewMeshPass, ViewMeshPassSettings, draw_view_mesh_coordinates};

/// Depth format of every pass: float, because depth runs in reverse from 1 near to 0 at infinity.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
