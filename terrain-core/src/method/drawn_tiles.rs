//! The cached tiles on the GPU and the mesh they displace: what all methods over tiles draw, whoever
//! chooses the tiles and keeps the tables.

use std::sync::Arc;

use super::cached_tiles::{CachedTiles, MakeCache, in_slots};
use super::{FrameContext, Moved, SceneState};
use crate::built_for::BuiltFor;
use crate::dataset::{ColourFormat, TileSource};
use crate::frame_setup::mesh_radius;
use crate::gpu::{
    CoordinatePass, DebugImage, FrameGroup, MeshScene, SceneMeshes, TargetKind, TerrainPass,
    TerrainPassSettings,
};
use crate::ground_heights::height_range_m;
use crate::measure::{ByteCause, FrameRecord};
use crate::renderer_settings::{DebugView, LookupMethod};
use crate::resident_terrain::Arrivals;
use crate::selection::TileTree;
use crate::terrain_renderer::RenderError;

/// Atlases, tables and meshes of a scene, and the passes that draw them.
pub(super) struct DrawnTiles {
    pub tiles: CachedTiles,
    pub meshes: SceneMeshes,
    pub has_voids: bool,
    has_colours: bool,
    pass: BuiltFor<TerrainPassSettings, TerrainPass>,
    /// What the latest displacement was made of.
    displaced: Option<SceneState>,
}

impl DrawnTiles {
    /// Makes caches of the settings' size, with `make`, colours arriving in
    /// `format`.
    ///
    /// # Errors
    /// [`RenderError::CacheTooLarge`] where the caches are larger than textures can be.
    pub fn new(
        cx: &FrameContext<'_>,
        source: &Arc<dyn TileSource>,
        tree: &TileTree,
        format: ColourFormat,
        make: MakeCache,
    ) -> Result<Self, RenderError> {
        let tiles = CachedTiles::new(cx, tree, format, make)?;
        let linear = cx.settings.lookup == LookupMethod::Linear;
        Ok(Self {
            has_voids: source.manifest().heights.has_voids,
            has_colours: tree.colours.as_ref().is_some_and(|layer| !layer.present.is_empty()),
            meshes: SceneMeshes::new(&cx.gpu.device, &tiles.bindings, linear),
            tiles,
            pass: BuiltFor::default(),
            displaced: None,
        })
    }

    /// Brings what has arrived into its slots.
    pub fn upload(
        &self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        tree: &TileTree,
        arrivals: &Arrivals,
    ) -> Moved {
        self.tiles.send_heights(cx, encoder, tree, &arrivals.heights);
        self.tiles.send_colours(cx, encoder, tree, &in_slots(&arrivals.colours));
        Moved { new: arrivals.count() as u64, evicted: arrivals.evicted() as u64 }
    }

    /// Brings the visible parts of the meshes to the GPU and displaces the picture's, unless that is
    /// done already.
    pub fn set_meshes(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        tree: &TileTree,
        scene: &SceneState,
        (scale_m, has_coordinates): (f64, bool),
    ) {
        let mesh_scene = MeshScene {
            view: &scene.view,
            scale_m,
            radius: mesh_radius(tree, scene.view.eye.truncate(), scale_m),
            height_range_m: height_range_m(tree, scene.settings.vertical_exaggeration),
            data_extent: &tree.data_extent,
            triangle_px: scene.settings.triangle_px,
            has_coordinates,
        };
        let (sent, rebuilt) = self.meshes.set_up(&cx.gpu.device, &cx.gpu.queue, &mesh_scene);
        cx.ledger.add(ByteCause::Mesh, sent);
        if rebuilt || self.displaced != Some(*scene) {
            self.displace(encoder, [true, false]);
            self.displaced = Some(*scene);
        }
    }

    /// Displaces what is visible of the meshes of the picture and of the coordinate pass.
    pub fn displace(&self, encoder: &mut wgpu::CommandEncoder, which: [bool; 2]) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("displace"),
            timestamp_writes: None,
        });
        self.meshes.displace(&mut pass, &self.tiles.bindings, which);
    }

    /// Draws the scene that was set up; returns the group the sky is drawn with.
    pub fn draw(
        &mut self,
        cx: &FrameContext<'_>,
        pass: &mut wgpu::RenderPass<'_>,
        target: TargetKind,
        scene: &SceneState,
    ) -> &FrameGroup {
        let settings = TerrainPassSettings {
            target,
            linear_lookup: scene.settings.lookup == LookupMethod::Linear,
            wireframe: scene.settings.wireframe,
            has_colours: self.has_colours,
            has_voids: self.has_voids,
            anisotropy: scene.settings.anisotropy,
            sorts_triangles: scene.settings.debug_view == DebugView::Off,
            debug_view: scene.settings.debug_view,
        };
        let build = || TerrainPass::new(&cx.gpu.device, &self.tiles.bindings, settings);
        let terrain = self.pass.get(settings, build);
        if let Some(mesh) = self.meshes.picture() {
            terrain.draw(pass, &self.tiles.bindings, mesh.parts(), mesh.visible());
        }
        &self.tiles.bindings.frame
    }

    /// Where on the ground each pixel of the scene that was set up looks; see
    /// [`TerrainMethod::draw_coordinates`](super::TerrainMethod::draw_coordinates).
    pub fn draw_coordinates(
        &self,
        cx: &FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) -> wgpu::Texture {
        let (format, size_px) = (CoordinatePass::FULL_FORMAT, scene.view.viewport_px);
        let pass = CoordinatePass::new(&cx.gpu.device, &self.tiles.bindings, format, size_px);
        if let Some(mesh) = self.meshes.picture() {
            pass.record(encoder, &self.tiles.bindings, mesh.parts(), mesh.visible());
        }
        pass.target
    }

    /// Fills in what was drawn of the mesh.
    pub fn describe(&self, record: &mut FrameRecord) {
        let (blocks, triangles) = self.meshes.picture().map_or((0, 0), |mesh| mesh.drawn());
        (record.blocks_drawn, record.triangles_drawn) = (blocks, triangles);
    }

    /// The atlas that a debug image shows; `None` for images of other things.
    pub fn atlas_view(&self, image: DebugImage) -> Option<wgpu::TextureView> {
        match image {
            DebugImage::Coordinates => None,
            DebugImage::HeightCache => Some(self.tiles.cache.heights.height_mip(0)),
            DebugImage::ColourCache => Some(self.tiles.cache.colours.mip(0)),
        }
    }
}
