//! The tile-scheduling method: tiles of both layers cached in atlases, tables that find a point's
//! finest tile, and a circular mesh displaced by the heights. After Liu Hao et al., "Dynamic
//! Scheduling and Real-time Rendering Method for Large-Scale Terrain"; which tiles, a
//! [`SelectionStrategy`](crate::selection::SelectionStrategy) says.

mod cache_size;
mod region_state;

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec2;

use self::cache_size::check_cache_fits;
use self::region_state::{CoordinateState, RegionState};
use super::{FrameContext, Moved, SceneState, TerrainMethod};
use crate::CameraView;
use crate::dataset::TileSource;
use crate::frame_setup::{frame_uniforms, mesh_radius, mesh_scale_m};
use crate::gpu::{
    CoordinateFeedback, CoordinatePass, DebugImage, FrameBindings, FrameGroup, MeshScene,
    SceneMeshes, TargetKind, TerrainCache, TerrainPass, TerrainPassSettings,
};
use crate::layer_loading::colour_format;
use crate::measure::{ByteCause, FrameRecord};
use crate::renderer_settings::{DebugView, LookupMethod, RendererSettings};
use crate::resident_terrain::ResidentTerrain;
use crate::selection::{
    RttQuadtree, Selection, SelectionConfig, SelectionStrategy, TileTree, visible_region,
};
use crate::terrain_renderer::RenderError;
use crate::tiling::TileId;

/// Draws a dataset as the tile-scheduling method does.
pub(super) struct TileScheduling {
    terrain: ResidentTerrain,
    has_voids: bool,
    cache: TerrainCache,
    bindings: FrameBindings,
    meshes: SceneMeshes,
    feedback: CoordinateFeedback,
    /// The coordinate image asked for in this frame, until it is submitted.
    asked: Option<wgpu::Buffer>,
    pass: Option<(TerrainPassSettings, TerrainPass)>,

    region: Option<RegionState>,
    selection: Selection,
    /// The view and the region's frame, where there was one, the latest selection was made for.
    selected: Option<(CameraView, Option<u64>)>,
    /// What the latest displacement and coordinate image were made of.
    displaced: Option<SceneState>,
    coordinates: Option<CoordinateState>,
}

impl TileScheduling {
    /// Opens the caches and loads level 0 of each layer.
    ///
    /// # Errors
    /// [`RenderError`] where level 0 cannot be loaded or the caches are larger than textures can be.
    pub fn open(
        cx: &mut FrameContext<'_>,
        source: &Arc<dyn TileSource>,
        tree: TileTree,
    ) -> Result<Self, RenderError> {
        let (gpu, settings) = (cx.gpu, cx.settings);
        let slots = (settings.cache_columns, settings.cache_rows);
        check_cache_fits(gpu, &tree, slots)?;
        let format = colour_format(&**source, gpu.has_block_compression());
        let terrain = ResidentTerrain::open(source, tree, format, slots, cx.ledger)?;
        let device = &gpu.device;
        let cache = TerrainCache::new(gpu, &terrain.tree, format, slots);
        let bindings = FrameBindings::new(device, &cache.table, &cache.heights, &cache.colours);
        Ok(Self {
            has_voids: source.manifest().heights.has_voids,
            meshes: SceneMeshes::new(device, &bindings, settings.lookup == LookupMethod::Linear),
            feedback: CoordinateFeedback::new(device, &bindings, settings),
            terrain,
            cache,
            bindings,
            asked: None,
            pass: None,
            region: None,
            selection: Selection { tiles: vec![TileId::ROOT], ..Default::default() },
            selected: None,
            displaced: None,
            coordinates: None,
        })
    }

    /// The settings that the caches, the feedback and the pipelines of the mesh are made for; all
    /// others as they are by default.
    pub fn made_for(settings: &RendererSettings) -> RendererSettings {
        let RendererSettings {
            cache_columns,
            cache_rows,
            coordinate_size_px,
            readback_latency_frames,
            lookup,
            ..
        } = *settings;
        RendererSettings {
            cache_columns,
            cache_rows,
            coordinate_size_px,
            readback_latency_frames,
            lookup,
            ..Default::default()
        }
    }
}

impl TerrainMethod for TileScheduling {
    /// Takes the newest coordinate image that has come back, if any.
    fn receive(&mut self, cx: &mut FrameContext<'_>) {
        let Some((image, count)) = self.feedback.take_newest(cx.frame) else { return };
        cx.ledger.add(ByteCause::Readback, count * self.feedback.image_bytes());
        let found = RegionState {
            region: visible_region(&image),
            frame: image.frame,
            view: image.view,
            images: 1,
            images_of_all: u32::from(self.terrain.missing() == 0),
        };
        self.region = Some(RegionState::after(self.region.as_ref(), found));
    }

    /// Selects by the latest region where the strategy needs one.
    fn select(&mut self, cx: &mut FrameContext<'_>, view: &CameraView) -> f64 {
        let settings = cx.settings;
        let state = self.region_in_use(settings);
        let is_ready = state.is_some() || !strategy(settings).needs_region();
        if !is_ready || !self.wants_selection(settings, view) {
            return 0.0;
        }
        let started = Instant::now();
        let config = SelectionConfig {
            max_tiles: settings.max_tiles,
            texel_px: settings.texel_px,
            vertical_exaggeration: settings.vertical_exaggeration,
        };
        let region = state.and_then(|state| state.region.as_ref());
        let region_frame = state.map(|state| state.frame);
        self.selection = strategy(settings).select(&self.terrain.tree, region, view, &config);
        self.selected = Some((*view, region_frame));
        started.elapsed().as_secs_f64() * 1.0e3
    }

    fn stream(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        _view: &CameraView,
    ) -> Moved {
        let budget = cx.settings.upload_budget_bytes;
        let arrivals = self.terrain.stream(&self.selection, budget, cx.frame, cx.ledger);
        let tree = &self.terrain.tree;
        let sent = self.cache.upload_heights(cx.gpu, encoder, tree, &arrivals.heights);
        cx.ledger.add(ByteCause::Dem, sent);
        let sent = self.cache.upload_colours(cx.gpu, encoder, &arrivals.colours);
        cx.ledger.add(ByteCause::Dom, sent);
        let moved = Moved { new: arrivals.count() as u64, evicted: arrivals.evicted() as u64 };
        self.terrain.keep(arrivals.heights);
        moved
    }

    fn data_version(&self) -> u64 {
        self.terrain.version
    }

    fn set_up(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) {
        let scale_m = mesh_scale_m(&self.terrain.tree, self.clearance_m(scene));
        self.set_uniforms(cx, scene, scale_m);
        self.set_meshes(cx, scene, scale_m);
        if self.displaced != Some(*scene) {
            self.displace(encoder, [true, false]);
            self.displaced = Some(*scene);
        }
    }

    /// Draws the coordinate pass and asks for its image, unless the scene's was asked for already.
    fn ask(
        &mut self,
        _cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) -> bool {
        if !self.wants_coordinates(scene) || !self.feedback.is_free() {
            return false;
        }
        self.displace(encoder, [false, true]);
        let Some(mesh) = self.meshes.coordinates() else { return false };
        self.asked = self.feedback.record(encoder, &self.bindings, mesh);
        if self.asked.is_some() {
            self.coordinates = Some(self.coordinate_state(scene));
        }
        self.asked.is_some()
    }

    fn draw(
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
            has_colours: self.terrain.has_colours(),
            has_voids: self.has_voids,
            anisotropy: scene.settings.anisotropy,
            sorts_triangles: scene.settings.debug_view == DebugView::Off,
            debug_view: scene.settings.debug_view,
        };
        let terrain = match self.pass.take() {
            Some((built_for, pass)) if built_for == settings => pass,
            _ => TerrainPass::new(&cx.gpu.device, &self.bindings, settings),
        };
        if let Some(mesh) = self.meshes.picture() {
            terrain.draw(pass, &self.bindings, mesh.parts(), mesh.visible());
        }
        self.pass = Some((settings, terrain));
        &self.bindings.frame
    }

    fn after_submit(&mut self, frame: u64, view: &CameraView) {
        if let Some(buffer) = self.asked.take() {
            self.feedback.begin(buffer, frame, *view);
        }
    }

    fn describe(&self, settings: &RendererSettings, record: &mut FrameRecord) {
        let (blocks, triangles) = self.meshes.picture().map_or((0, 0), |mesh| mesh.drawn());
        record.tiles_selected = self.selection.tiles.len() as u64;
        record.tiles_missing = self.terrain.missing() as u64;
        record.tiles_resident = self.terrain.resident() as u64;
        record.finest_level = self.selection.statistics.finest_level;
        record.region_age_frames = self.region_age_frames(settings, record.frame);
        (record.blocks_drawn, record.triangles_drawn) = (blocks, triangles);
    }

    fn draw_coordinates(
        &mut self,
        cx: &FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) -> wgpu::Texture {
        let (format, size_px) = (CoordinatePass::FULL_FORMAT, scene.view.viewport_px);
        let pass = CoordinatePass::new(&cx.gpu.device, &self.bindings, format, size_px);
        if let Some(mesh) = self.meshes.picture() {
            pass.record(encoder, &self.bindings, mesh.parts(), mesh.visible());
        }
        pass.target
    }

    fn is_pending(&self, scene: &SceneState) -> bool {
        self.terrain.missing() > 0
            || self.feedback.is_waiting()
            || self.wants_coordinates(scene)
            || self.wants_selection(&scene.settings, &scene.view)
    }

    fn wait(&self, patience: Duration) {
        self.terrain.wait(patience);
    }

    fn reconsider(&mut self) {
        self.selected = None;
        if let Some(region) = &mut self.region {
            (region.images, region.images_of_all) = (0, 0);
        }
    }

    fn take_failures(&mut self) -> Vec<String> {
        self.terrain.take_failures()
    }

    fn tree(&self) -> &TileTree {
        &self.terrain.tree
    }

    fn selection(&self) -> &Selection {
        &self.selection
    }

    fn ground_height_m(&self, point: DVec2) -> Option<f64> {
        self.terrain.ground_height_m(point)
    }

    fn debug_texture(&self, image: DebugImage) -> Option<wgpu::TextureView> {
        Some(match image {
            DebugImage::Coordinates => self.feedback.pass.target_view.clone(),
            DebugImage::HeightCache => self.cache.heights.height_mip(0),
            DebugImage::ColourCache => self.cache.colours.mip(0),
        })
    }
}

impl TileScheduling {
    /// Brings tables and uniforms to the GPU.
    fn set_uniforms(&mut self, cx: &mut FrameContext<'_>, scene: &SceneState, scale_m: f64) {
        let (view, terrain) = (&scene.view, &self.terrain);
        let eye = view.eye.truncate();
        let (heights, colours) = (&terrain.height_table, terrain.colour_table.as_ref());
        let tables = self.cache.update_tables(cx.gpu, &terrain.tree, eye, heights, colours);
        cx.ledger.add(ByteCause::Table, tables.sent_bytes);
        if tables.grew {
            self.bindings.rebind(&cx.gpu.device, &self.cache.table);
        }
        let mut uniforms = frame_uniforms(view, &terrain.tree, &scene.settings, scale_m);
        [uniforms.height_table, uniforms.colour_table] = tables.ranges;
        uniforms.height_uv_per_texel = self.cache.heights.grid.uv_per_texel();
        uniforms.colour_uv_per_texel = self.cache.colours.grid.uv_per_texel();
        let sent = self.bindings.frame.set_uniforms(&cx.gpu.queue, &uniforms);
        cx.ledger.add(ByteCause::Uniform, sent);
    }

    /// Brings the visible parts of the meshes to the GPU.
    fn set_meshes(&mut self, cx: &mut FrameContext<'_>, scene: &SceneState, scale_m: f64) {
        let terrain = &self.terrain;
        let mesh_scene = MeshScene {
            view: &scene.view,
            scale_m,
            radius: mesh_radius(&terrain.tree, scene.view.eye.truncate(), scale_m),
            height_range_m: terrain.height_range_m(scene.settings.vertical_exaggeration),
            data_extent: &terrain.tree.data_extent,
            triangle_px: scene.settings.triangle_px,
            has_coordinates: strategy(&scene.settings).needs_region(),
        };
        let (sent, rebuilt) = self.meshes.set_up(&cx.gpu.device, &cx.gpu.queue, &mesh_scene);
        cx.ledger.add(ByteCause::Mesh, sent);
        if rebuilt {
            self.displaced = None;
        }
    }

    /// Displaces what is visible of the meshes of the picture and of the coordinate pass.
    fn displace(&self, encoder: &mut wgpu::CommandEncoder, which: [bool; 2]) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("displace"),
            timestamp_writes: None,
        });
        self.meshes.displace(&mut pass, &self.bindings, which);
    }

    fn coordinate_state(&self, scene: &SceneState) -> CoordinateState {
        let SceneState { view, settings, .. } = *scene;
        CoordinateState { view, uploads: self.terrain.uploads, settings }
    }

    /// Whether the scene's coordinates have not been asked for yet.
    fn wants_coordinates(&self, scene: &SceneState) -> bool {
        !scene.settings.freeze_selection
            && strategy(&scene.settings).needs_region()
            && self.coordinates != Some(self.coordinate_state(scene))
    }

    fn wants_selection(&self, settings: &RendererSettings, view: &CameraView) -> bool {
        let region_frame = self.region_in_use(settings).map(|state| state.frame);
        !settings.freeze_selection && self.selected != Some((*view, region_frame))
    }

    /// The latest region, if the strategy goes by it.
    fn region_in_use(&self, settings: &RendererSettings) -> Option<&RegionState> {
        self.region.as_ref().filter(|_| strategy(settings).needs_region())
    }

    /// How many frames ago the region in use was seen; 0 where the camera has not moved since.
    fn region_age_frames(&self, settings: &RendererSettings, frame: u64) -> Option<u64> {
        let state = self.region_in_use(settings)?;
        let is_current = self.selected.is_some_and(|(view, _)| view == state.view);
        Some(if is_current { 0 } else { frame - state.frame })
    }

    /// Distance in metres from the eye to the ground below it.
    fn clearance_m(&self, scene: &SceneState) -> f64 {
        self.terrain.clearance_m(scene.view.eye, scene.settings.vertical_exaggeration)
    }
}

/// The method is built for strategies that choose tiles; any other is taken as the paper's.
fn strategy(settings: &RendererSettings) -> &'static dyn SelectionStrategy {
    settings.strategy.implementation().unwrap_or(&RttQuadtree)
}
