//! The pages that plane ground needs, found by laying its triangles into a texture map.

use crate::built_for::BuiltFor;
use crate::gpu::{
    GpuContext, GroundDepthPass, MAP_GROUND, MapScene, PageGroundBindings, PageMarks, SceneMap,
    ground_triangles,
};
use crate::method::SceneState;
use crate::method::drawn_tiles::DrawnTiles;
use crate::renderer_settings::LookupMethod;
use crate::residency::page_table::PageLayout;

/// The map, and the pass that draws the ground's depth.
pub(super) struct GroundMap {
    map: SceneMap,
    /// With what decides how it is built: whether the lookup is linear, and whether there are voids.
    depth_pass: BuiltFor<(bool, bool), GroundDepthPass>,
}

impl GroundMap {
    pub fn new(device: &wgpu::Device) -> Self {
        let map = SceneMap::new(device, &MAP_GROUND, wgpu::BufferBindingType::Uniform);
        Self { map, depth_pass: BuiltFor::default() }
    }

    /// Records the marking of all pages that the ground of a scene shows; returns the bytes sent for it.
    pub fn mark(
        &mut self,
        gpu: &GpuContext,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
        (drawn, ground): (&DrawnTiles, PageGroundBindings<'_>),
        (layout, marks): (&PageLayout, &PageMarks),
    ) -> u64 {
        let Some(mesh) = drawn.meshes.picture() else { return 0 };
        let key = (scene.settings.lookup == LookupMethod::Linear, drawn.has_voids);
        let build = || GroundDepthPass::new(&gpu.device, ground, key);
        let depth_pass = self.depth_pass.get(key, build);
        let map_scene = MapScene {
            frame: &ground.frame.frame,
            marks,
            pages: ground.pages,
            layout,
            viewport_px: scene.view.viewport_px,
            face_culling: scene.settings.face_culling,
            anisotropy: scene.settings.anisotropy,
        };
        let triangles = ground_triangles(ground.ground, mesh);
        self.map.mark(gpu, encoder, map_scene, &triangles, |pass| {
            depth_pass.draw(pass, ground, mesh);
        })
    }
}
