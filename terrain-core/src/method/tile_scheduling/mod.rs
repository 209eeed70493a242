//! The tile-scheduling method: tiles of both layers cached in atlases, tables that find a point's
//! finest tile, and a circular mesh displaced by the heights. After Liu Hao et al., "Dynamic
//! Scheduling and Real-time Rendering Method for Large-Scale Terrain"; which tiles, a
//! [`SelectionStrategy`](crate::selection::SelectionStrategy) says.

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec2;

use super::drawn_tiles::DrawnTiles;
use super::region_state::RegionState;
use super::{FrameContext, ImageState, Moved, SceneState, TerrainMethod};
use crate::CameraView;
use crate::dataset::TileSource;
use crate::frame_setup::mesh_scale_m;
use crate::gpu::{CoordinateFeedback, DebugImage, FrameGroup, TargetKind, TerrainCache};
use crate::layer_loading::colour_format;
use crate::measure::{ByteCause, FrameRecord};
use crate::renderer_settings::RendererSettings;
use crate::resident_terrain::ResidentTerrain;
use crate::selection::{RttQuadtree, Selection, SelectionStrategy, TileTree};
use crate::terrain_renderer::RenderError;
use crate::tiling::TileId;

/// Draws a dataset as the tile-scheduling method does.
pub(super) struct TileScheduling {
    terrain: ResidentTerrain,
    drawn: DrawnTiles,
    feedback: CoordinateFeedback,
    /// The coordinate image asked for in this frame, until it is submitted.
    asked: Option<wgpu::Buffer>,

    region: Option<RegionState>,
    selection: Selection,
    /// The view and the region's frame, where there was one, the latest selection was made for.
    selected: Option<(CameraView, Option<u64>)>,
    /// What the latest coordinate image was made of.
    coordinates: Option<ImageState>,
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
        let format = colour_format(&**source, gpu.has_block_compression());
        let drawn = DrawnTiles::new(cx, source, &tree, format, TerrainCache::new)?;
        let terrain = ResidentTerrain::open(source, tree, format, slots, cx.ledger)?;
        Ok(Self {
            feedback: CoordinateFeedback::new(&gpu.device, &drawn.tiles.bindings, settings),
            terrain,
            drawn,
            asked: None,
            region: None,
            selection: Selection { tiles: vec![TileId::ROOT], ..Default::default() },
            selected: None,
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
        let is_of_all = self.terrain.missing() == 0;
        self.region = Some(RegionState::after(self.region.as_ref(), image, is_of_all));
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
        let config = settings.selection_config();
        let seen = state.and_then(|state| state.visible(settings.visibility));
        let region_frame = state.map(|state| state.seen.frame);
        self.selection = strategy(settings).select(&self.terrain.tree, seen, view, &config);
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
        let moved = self.drawn.upload(cx, encoder, &self.terrain.tree, &arrivals);
        self.terrain.ground.keep(arrivals.heights);
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
        let Self { terrain, drawn, .. } = self;
        let tables = (&terrain.height_table, terrain.colour_table.as_ref());
        drawn.tiles.show(cx, &terrain.tree, (scene, scale_m), tables);
        let has_coordinates = strategy(&scene.settings).needs_region();
        let scale = (scale_m, has_coordinates);
        self.drawn.set_meshes(cx, encoder, &self.terrain.tree, scene, scale);
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
        self.drawn.displace(encoder, [false, true]);
        let Some(mesh) = self.drawn.meshes.coordinates() else { return false };
        self.asked = self.feedback.record(encoder, &self.drawn.tiles.bindings, mesh);
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
        self.drawn.draw(cx, pass, target, scene)
    }

    fn after_submit(&mut self, frame: u64, view: &CameraView) {
        if let Some(buffer) = self.asked.take() {
            self.feedback.begin(buffer, frame, *view);
        }
    }

    fn describe(&self, settings: &RendererSettings, record: &mut FrameRecord) {
        self.drawn.describe(record);
        record.tiles_selected = self.selection.tiles.len() as u64;
        record.tiles_missing = self.terrain.missing() as u64;
        record.tiles_resident = self.terrain.resident() as u64;
        record.tiles_hidden = self.selection.statistics.hidden as u64;
        record.finest_level = self.selection.statistics.finest_level;
        record.region_age_frames = self.region_age_frames(settings, record.frame);
    }

    fn draw_coordinates(
        &mut self,
        cx: &FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) -> wgpu::Texture {
        self.drawn.draw_coordinates(cx, encoder, scene)
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
            region.seen.reconsider();
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
        self.terrain.ground.height_m(&self.terrain.tree, point)
    }

    fn debug_texture(&self, image: DebugImage) -> Option<wgpu::TextureView> {
        match image {
            DebugImage::Coordinates => Some(self.feedback.pass.target_view.clone()),
            image => self.drawn.atlas_view(image),
        }
    }
}

impl TileScheduling {
    fn coordinate_state(&self, scene: &SceneState) -> ImageState {
        let SceneState { view, settings, .. } = *scene;
        ImageState { view, geometry: self.terrain.uploads, settings }
    }

    /// Whether the scene's coordinates have not been asked for yet.
    fn wants_coordinates(&self, scene: &SceneState) -> bool {
        !scene.settings.freeze_selection
            && strategy(&scene.settings).needs_region()
            && self.coordinates != Some(self.coordinate_state(scene))
    }

    fn wants_selection(&self, settings: &RendererSettings, view: &CameraView) -> bool {
        let region_frame = self.region_in_use(settings).map(|state| state.seen.frame);
        !settings.freeze_selection && self.selected != Some((*view, region_frame))
    }

    /// The latest region, if the strategy goes by it.
    fn region_in_use(&self, settings: &RendererSettings) -> Option<&RegionState> {
        self.region.as_ref().filter(|_| strategy(settings).needs_region())
    }

    /// How many frames ago the region in use was seen; 0 where the camera has not moved since.
    fn region_age_frames(&self, settings: &RendererSettings, frame: u64) -> Option<u64> {
        let state = self.region_in_use(settings)?;
        Some(state.seen.age_frames(self.selected.as_ref().map(|(view, _)| view), frame))
    }

    /// Distance in metres from the eye to the ground below it.
    fn clearance_m(&self, scene: &SceneState) -> f64 {
        let ResidentTerrain { ground, tree, .. } = &self.terrain;
        ground.clearance_m(tree, scene.view.eye, scene.settings.vertical_exaggeration)
    }
}

/// The method is built for strategies that choose tiles; any other is taken as the paper's.
fn strategy(settings: &RendererSettings) -> &'static dyn SelectionStrategy {
    settings.strategy.implementation().unwrap_or(&RttQuadtree)
}
