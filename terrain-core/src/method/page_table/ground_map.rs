//! The pages that plane ground needs, found by laying its triangles into a texture map.

use crate::gpu::{
    DepthPyramid, GpuContext, GroundDepthPass, GroundTriangles, MAP_GROUND, MapBindings,
    PageGroundBindings, PageMarks, TextureMapPass, TextureMapUniforms,
};
use crate::method::SceneState;
use crate::method::drawn_tiles::DrawnTiles;
use crate::renderer_settings::LookupMethod;
use crate::residency::page_table::{FaceCulling, PageLayout};

/// The passes of the map and the scene's depth.
pub(super) struct GroundMap {
    triangles: GroundTriangles,
    /// For pictures of the latest one's size.
    depth: Option<DepthPyramid>,
    depth_pass: Option<((bool, bool), GroundDepthPass)>,
    pass: Option<(MapPassKey, TextureMapPass)>,
}

/// What decides how the map's passes are built: where back faces are dropped, the most taps, and the most triangles
/// there may be.
type MapPassKey = (FaceCulling, u32, u32);

/// What a map is made of, beside its scene.
#[derive(Clone, Copy)]
pub(super) struct MappedGround<'a> {
    pub drawn: &'a DrawnTiles,
    pub ground: PageGroundBindings<'a>,
    pub layout: &'a PageLayout,
}

impl GroundMap {
    pub fn new(device: &wgpu::Device) -> Self {
        Self { triangles: GroundTriangles::new(device), depth: None, depth_pass: None, pass: None }
    }

    /// Records the marking of all pages that the scene shows; returns the bytes sent for it.
    pub fn mark(
        &mut self,
        gpu: &GpuContext,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
        mapped: MappedGround<'_>,
        marks: &PageMarks,
    ) -> u64 {
        let Some(mesh) = mapped.drawn.meshes.picture() else { return 0 };
        let device = &gpu.device;
        let uniforms = TextureMapUniforms::new(mapped.layout, scene.view.viewport_px);
        let sent = self.triangles.set(&gpu.queue, &uniforms);
        self.draw_depth(device, encoder, scene, mapped);
        let Some(depth) = &self.depth else { return sent };
        let (circular, buffers) = mesh.parts();
        let group = self.triangles.bind(device, mapped.ground.ground, buffers, depth);
        let bindings = MapBindings {
            frame: &mapped.ground.frame.frame,
            marks,
            pages: mapped.ground.pages,
            triangles: (&self.triangles.layout, &group),
        };
        let most_triangles = circular.indices.len() as u32 / 3;
        let key = (scene.settings.face_culling, scene.settings.anisotropy, most_triangles);
        let pass = match self.pass.take() {
            Some((built_for, pass)) if built_for == key => pass,
            _ => {
                let how = (scene.settings.face_culling, scene.settings.anisotropy);
                let over = (&MAP_GROUND, &bindings);
                TextureMapPass::new(device, over, &uniforms, how, most_triangles)
            }
        };
        pass.record(encoder, &bindings, &GroundTriangles::of_mesh(mesh.parts(), mesh.visible()));
        self.pass = Some((key, pass));
        sent
    }

    /// Records the scene's depth, as far as the ground makes it.
    fn draw_depth(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
        MappedGround { drawn, ground, .. }: MappedGround<'_>,
    ) {
        let size_px = scene.view.viewport_px;
        let depth = match self.depth.take() {
            Some(depth) if depth.size_px() == size_px => depth,
            _ => DepthPyramid::new(device, size_px),
        };
        let key = (scene.settings.lookup == LookupMethod::Linear, drawn.has_voids);
        let pass = match self.depth_pass.take() {
            Some((built_for, pass)) if built_for == key => pass,
            _ => GroundDepthPass::new(device, ground, key),
        };
        if let Some(mesh) = drawn.meshes.picture() {
            depth.record(encoder, |target| pass.draw(target, ground, mesh.parts(), mesh.visible()));
        }
        self.depth = Some(depth);
        self.depth_pass = Some((key, pass));
    }
}
