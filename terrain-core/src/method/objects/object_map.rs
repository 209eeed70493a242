//! The pages that models need, found by laying their triangles into a texture map.

use crate::gpu::{
    GpuContext, GpuError, MAP_OBJECTS, MapScene, ModelRun, ObjectBindings, ObjectDepthPass,
    ObjectRanges, PageMarks, SceneMap,
};
use crate::method::SceneState;
use crate::residency::page_table::PageLayout;

/// The map, where its triangles lie, and the pass that draws the models' depth.
pub(super) struct ObjectMap {
    map: SceneMap,
    ranges: ObjectRanges,
    depth_pass: Option<ObjectDepthPass>,
}

impl ObjectMap {
    /// For so many instances at the most.
    pub fn new(device: &wgpu::Device, most_instances: usize) -> Self {
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        Self {
            map: SceneMap::new(device, &MAP_OBJECTS, storage),
            ranges: ObjectRanges::new(device, most_instances),
            depth_pass: None,
        }
    }

    /// Records the marking of all pages that the models of a scene show; returns the bytes sent for it.
    pub fn mark(
        &mut self,
        gpu: &GpuContext,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
        (bindings, runs): (ObjectBindings<'_>, &[ModelRun]),
        over: (&PageLayout, &PageMarks),
    ) -> u64 {
        let sent = self.ranges.set(&gpu.queue, bindings.objects, runs);
        let Self { map, ranges, depth_pass } = self;
        let depth_pass =
            depth_pass.get_or_insert_with(|| ObjectDepthPass::new(&gpu.device, bindings));
        let triangles = ranges.triangles(bindings.objects);
        let map_scene = map_scene(scene, bindings, over);
        sent + map.mark(gpu, encoder, map_scene, &triangles, |pass| {
            depth_pass.draw(pass, bindings, runs);
        })
    }

    /// Milliseconds that the marking takes, the models' depth left out, so many times over.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn time(
        &mut self,
        gpu: &GpuContext,
        scene: &SceneState,
        (bindings, runs): (ObjectBindings<'_>, &[ModelRun]),
        over: (&PageLayout, &PageMarks),
        repeats: usize,
    ) -> Result<Vec<f64>, GpuError> {
        self.ranges.set(&gpu.queue, bindings.objects, runs);
        let Self { map, ranges, depth_pass } = self;
        let depth_pass =
            depth_pass.get_or_insert_with(|| ObjectDepthPass::new(&gpu.device, bindings));
        let triangles = ranges.triangles(bindings.objects);
        let draw_depth = |pass: &mut wgpu::RenderPass<'_>| depth_pass.draw(pass, bindings, runs);
        map.time(gpu, map_scene(scene, bindings, over), &triangles, draw_depth, repeats)
    }
}

fn map_scene<'a>(
    scene: &SceneState,
    bindings: ObjectBindings<'a>,
    (layout, marks): (&'a PageLayout, &'a PageMarks),
) -> MapScene<'a> {
    MapScene {
        frame: bindings.frame,
        marks,
        pages: bindings.pages,
        layout,
        viewport_px: scene.view.viewport_px,
        face_culling: scene.settings.face_culling,
        anisotropy: scene.settings.anisotropy,
    }
}
