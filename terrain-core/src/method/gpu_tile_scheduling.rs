//! The tile-scheduling method with all of it on the GPU: the region is reduced, tiles are selected and
//! slots are assigned in compute passes, and only the list of missing tiles comes back. What Liu Hao et
//! al., "Dynamic Scheduling and Real-time Rendering Method for Large-Scale Terrain", leave as future
//! work. Caches, mesh and drawing are those of the method that does it on the CPU.
//!
//! A frame selects by the coordinate image drawn at the end of the one before: nothing waits for a way
//! back.

use std::sync::Arc;
use std::time::Duration;

use glam::DVec2;

use super::drawn_tiles::DrawnTiles;
use super::region_state::SeenView;
use super::{FrameContext, ImageState, Moved, SceneState, TerrainMethod};
use crate::CameraView;
use crate::dataset::TileSource;
use crate::frame_setup::mesh_scale_m;
use crate::gpu::{
    CoordinatePass, DebugImage, FrameGroup, LayerDeliveries, SelectionRequest, TargetKind,
    TerrainCache, TileManagement, TileReport, TileReportRing, TileSelection,
};
use crate::layer_loading::{colour_format, open_intakes};
use crate::measure::{ByteCause, FrameRecord};
use crate::renderer_settings::RendererSettings;
use crate::selection::{Selection, TileTree, Visibility};
use crate::slot_terrain::SlotTerrain;
use crate::terrain_renderer::RenderError;

/// Draws a dataset with selection and tile management on the GPU.
pub(super) struct GpuTileScheduling {
    tree: TileTree,
    terrain: SlotTerrain,
    drawn: DrawnTiles,
    coordinate_pass: CoordinatePass,
    tile_selection: TileSelection,
    management: TileManagement,
    reports: TileReportRing,
    /// What the GPU reported last.
    report: TileReport,
    /// Always empty: which tiles are selected only the GPU knows.
    selection: Selection,

    /// Of what view, and how often, the region on the GPU was seen.
    region: Option<SeenView>,
    /// What the latest selection was made for.
    selected: Option<SelectedFor>,
    /// What the latest coordinate image was made of.
    coordinates: Option<ImageState>,
    /// What this frame's compute passes are to do, until they are recorded.
    due: Option<Due>,
    /// What the tables' places and the uniforms were last made of.
    placed: Option<SceneState>,
    /// Counts frames that uploaded tiles.
    uploads: u64,
    version: u64,
}

/// What a selection was made for: a view, by the region of another that was seen in some frame.
#[derive(Clone, Copy)]
struct SelectedFor {
    view: CameraView,
    seen: SeenView,
}

/// What a frame's management has to take in.
struct Due {
    selects: bool,
    deliveries: [LayerDeliveries; 2],
}

impl GpuTileScheduling {
    /// Opens the caches and loads level 0 of each layer.
    ///
    /// # Errors
    /// [`RenderError`] where level 0 cannot be loaded or the caches are larger than textures can be.
    pub fn open(
        cx: &mut FrameContext<'_>,
        source: &Arc<dyn TileSource>,
        tree: TileTree,
    ) -> Result<Self, RenderError> {
        let device = &cx.gpu.device;
        let slot_count = cx.settings.cache_columns * cx.settings.cache_rows;
        let format = colour_format(&**source, cx.gpu.has_block_compression());
        let mut drawn = DrawnTiles::new(cx, source, &tree, format, TerrainCache::new)?;
        let (size_px, region) = (cx.settings.coordinate_size_px, CoordinatePass::REGION_FORMAT);
        let coordinate_pass = CoordinatePass::new(device, &drawn.tiles.bindings, region, size_px);
        let image = &coordinate_pass.target;
        let tile_selection = TileSelection::new(device, &tree, image, slot_count as usize);
        let inputs = (tile_selection.selected(), tile_selection.tile_runs());
        let management = TileManagement::new(device, &tree, &mut drawn.tiles.cache, inputs);
        drawn.tiles.bindings.rebind(device, &drawn.tiles.cache.table);
        let intakes = open_intakes(source, format, cx.ledger)?;
        Ok(Self {
            terrain: SlotTerrain::new(intakes, slot_count),
            tree,
            drawn,
            coordinate_pass,
            tile_selection,
            management,
            reports: TileReportRing::new(device),
            report: TileReport::default(),
            selection: Selection::default(),
            region: None,
            selected: None,
            coordinates: None,
            due: None,
            placed: None,
            uploads: 0,
            version: 0,
        })
    }

    /// The settings that the caches, the coordinate pass and the pipelines of the mesh are made for; all
    /// others as they are by default.
    pub fn made_for(settings: &RendererSettings) -> RendererSettings {
        let RendererSettings { cache_columns, cache_rows, coordinate_size_px, lookup, .. } =
            *settings;
        RendererSettings {
            cache_columns,
            cache_rows,
            coordinate_size_px,
            lookup,
            ..Default::default()
        }
    }
}

impl TerrainMethod for GpuTileScheduling {
    /// Takes the reports that have come back, if any.
    fn receive(&mut self, _cx: &mut FrameContext<'_>) {
        while let Some((report, frame)) = self.reports.take() {
            self.terrain.receive(&report, frame);
            self.report = report;
        }
    }

    /// Decides whether the GPU is to select; it does so when the scene is set up.
    fn select(&mut self, cx: &mut FrameContext<'_>, view: &CameraView) -> f64 {
        let selects = self.wants_selection(cx.settings, view);
        let deliveries = Default::default();
        self.due = selects.then_some(Due { selects, deliveries });
        0.0
    }

    fn stream(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        _view: &CameraView,
    ) -> Moved {
        let budget_bytes = cx.settings.upload_budget_bytes;
        let (arrivals, deliveries) = self.terrain.stream(budget_bytes, cx.frame, cx.ledger);
        let moved = self.drawn.upload(cx, encoder, &self.tree, &arrivals);
        self.terrain.ground.keep(arrivals.heights);
        if self.due.is_some() || deliveries.iter().any(|layer| !layer.is_empty()) {
            let selects = self.due.is_some();
            self.due = Some(Due { selects, deliveries });
            self.version += 1;
            self.uploads += u64::from(moved.new > 0);
        }
        moved
    }

    fn data_version(&self) -> u64 {
        self.version
    }

    fn set_up(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) {
        if let Some(due) = self.due.take() {
            self.manage(cx, encoder, scene, &due);
        }
        let SceneState { view, settings, .. } = scene;
        let exaggeration = settings.vertical_exaggeration;
        let clearance_m = self.terrain.ground.clearance_m(&self.tree, view.eye, exaggeration);
        let scale_m = mesh_scale_m(&self.tree, clearance_m);
        if self.placed != Some(*scene) {
            let uniforms = self.drawn.tiles.uniforms(&self.tree, scene, scale_m);
            self.drawn.tiles.set_uniforms(cx, &uniforms);
            self.place(cx, encoder, view.eye.truncate());
            self.placed = Some(*scene);
        }
        self.drawn.set_meshes(cx, encoder, &self.tree, scene, (scale_m, true));
    }

    /// Draws the coordinate pass and reduces it to the region, unless that is done already, and asks for
    /// the report of the management.
    fn ask(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) -> bool {
        let bytes = self.reports.record(encoder, &self.management);
        cx.ledger.add(ByteCause::Readback, bytes);
        if !self.wants_coordinates(scene) {
            return false;
        }
        self.drawn.displace(encoder, [false, true]);
        let Some(mesh) = self.drawn.meshes.coordinates() else { return false };
        self.coordinate_pass.record(
            encoder,
            &self.drawn.tiles.bindings,
            mesh.parts(),
            mesh.visible(),
        );
        let (when, is_of_all) = ((cx.frame, scene.view), self.terrain.missing() == 0);
        let region = SeenView::after(self.region.as_ref(), when, is_of_all);
        self.tile_selection.see(encoder, region.grows());
        self.region = Some(region);
        self.coordinates = Some(self.coordinate_state(scene));
        true
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

    fn after_submit(&mut self, _frame: u64, _view: &CameraView) {
        self.reports.begin();
    }

    fn describe(&self, _settings: &RendererSettings, record: &mut FrameRecord) {
        let [heights, colours] = &self.report.layers;
        self.drawn.describe(record);
        record.tiles_selected = u64::from(self.report.selected);
        record.tiles_hidden = u64::from(self.report.hidden);
        record.tiles_missing = self.terrain.missing() as u64;
        record.tiles_resident = u64::from(heights.resident + colours.resident);
        record.finest_level = self.report.finest_level;
        record.region_age_frames = self.region_age_frames(record.frame);
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
            || self.reports.is_waiting()
            || self.wants_coordinates(scene)
            || self.wants_selection(&scene.settings, &scene.view)
    }

    fn wait(&self, patience: Duration) {
        self.terrain.wait(patience);
    }

    fn reconsider(&mut self) {
        self.selected = None;
        if let Some(region) = &mut self.region {
            region.reconsider();
        }
    }

    fn take_failures(&mut self) -> Vec<String> {
        self.terrain.take_failures()
    }

    fn tree(&self) -> &TileTree {
        &self.tree
    }

    fn selection(&self) -> &Selection {
        &self.selection
    }

    fn ground_height_m(&self, point: DVec2) -> Option<f64> {
        self.terrain.ground.height_m(&self.tree, point)
    }

    fn debug_texture(&self, image: DebugImage) -> Option<wgpu::TextureView> {
        match image {
            DebugImage::Coordinates => Some(self.coordinate_pass.target_view.clone()),
            image => self.drawn.atlas_view(image),
        }
    }
}

impl GpuTileScheduling {
    /// Records selection and management.
    fn manage(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
        due: &Due,
    ) {
        if due.selects {
            self.select_tiles(cx, encoder, &scene.view);
        }
        let mut pass = begin_pass(encoder, "manage tiles");
        // Frames of the management count from 1.
        let frame = cx.frame as u32 + 1;
        let sent = self.management.manage(&cx.gpu.queue, &mut pass, frame, &due.deliveries);
        cx.ledger.add(ByteCause::Uniform, sent);
        self.reports.expect(cx.frame);
    }

    /// Records the selection by what was seen last.
    fn select_tiles(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        view: &CameraView,
    ) {
        let Some(region) = &self.region else { return };
        let config = cx.settings.selection_config();
        let request = SelectionRequest {
            view,
            config: &config,
            image_origin: region.view.eye.truncate(),
            // A region that only grows counts as a whole.
            is_exact: cx.settings.visibility == Visibility::Exact && !region.grows(),
        };
        let sent = self.tile_selection.select(&cx.gpu.queue, encoder, &self.tree, &request);
        cx.ledger.add(ByteCause::Uniform, sent);
        self.selected = Some(SelectedFor { view: *view, seen: *region });
    }

    /// Brings the tables to where they are read, as seen from the eye.
    fn place(&mut self, cx: &mut FrameContext<'_>, encoder: &mut wgpu::CommandEncoder, eye: DVec2) {
        let mut pass = begin_pass(encoder, "place tiles");
        let sent = self.management.place(&cx.gpu.queue, &mut pass, eye);
        drop(pass);
        cx.ledger.add(ByteCause::Uniform, sent);
        self.management.copy_ranges(encoder, &self.drawn.tiles.bindings.frame);
    }

    fn coordinate_state(&self, scene: &SceneState) -> ImageState {
        let SceneState { view, settings, .. } = *scene;
        ImageState { view, geometry: self.uploads, settings }
    }

    /// Whether the scene's coordinates have not been drawn yet.
    fn wants_coordinates(&self, scene: &SceneState) -> bool {
        !scene.settings.freeze_selection && self.coordinates != Some(self.coordinate_state(scene))
    }

    /// Whether there is a region that the view's tiles have not been selected by yet.
    fn wants_selection(&self, settings: &RendererSettings, view: &CameraView) -> bool {
        let Some(region) = &self.region else { return false };
        let made_for = self.selected.map(|made| (made.view, made.seen.frame));
        !settings.freeze_selection && made_for != Some((*view, region.frame))
    }

    /// How many frames ago the region in use was seen; 0 where the camera has not moved since.
    fn region_age_frames(&self, frame: u64) -> Option<u64> {
        let made = self.selected?;
        Some(made.seen.age_frames(Some(&made.view), frame))
    }
}

fn begin_pass<'a>(encoder: &'a mut wgpu::CommandEncoder, label: &str) -> wgpu::ComputePass<'a> {
    encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
        label: Some(label),
        timestamp_writes: None,
    })
}
