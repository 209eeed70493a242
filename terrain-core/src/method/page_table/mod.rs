//! The page-table method: imagery as one virtual texture, of which the GPU finds the tiles that pixels need;
//! after the paper on GPU-visible tiles (a new method for fast determination of visible texture tiles). What is
//! resident is planned in [`crate::residency::page_table`], whose page names the paper's tables; what the GPU
//! does is in `gpu/page_table/`.
//!
//! The mesh is that of tile scheduling. As the paper has it, the texture knows nothing of the geometry, and the
//! geometry nothing of the texture: height tiles are chosen by the view frustum, since the level a texture is
//! filtered to says little about how fine its ground must be. So nothing that comes back changes the ground in
//! view, and a still camera comes to rest by itself.
//!
//! `texel_px` sets how large texels may be drawn: the levels of all footprints are log2 of it coarser. Where
//! more pages are seen than there is room for, all are drawn so many eighths of a level coarser that they fit.

mod terrain;

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec2;

use self::terrain::{PagedArrivals, PagedTerrain};
use super::drawn_tiles::DrawnTiles;
use super::region_state::CoordinateState;
use super::{FrameContext, Moved, SceneState, TerrainMethod};
use crate::CameraView;
use crate::dataset::{ColourTile, TileSource};
use crate::frame_setup::mesh_scale_m;
use crate::gpu::{
    DebugImage, FrameGroup, GpuContext, PageBindings, PageFeedbackRing, PageGround,
    PageGroundBindings, PageGroundGroup, PageGroundPass, PageGroundPassSettings, PageRequestPass,
    PageTableUniforms, TargetKind,
};
use crate::layer_loading::colour_format;
use crate::measure::{ByteCause, FrameRecord};
use crate::renderer_settings::{LookupMethod, RendererSettings};
use crate::residency::page_table::{PageId, PageRequest, PageUpload, SeenPages, fitting};
use crate::selection::{Selection, TileTree, select_by_frustum};
use crate::terrain_renderer::RenderError;
use crate::tiling::TileId;

/// Draws a dataset with imagery through a page table.
pub(super) struct PageTable {
    terrain: PagedTerrain,
    drawn: DrawnTiles,
    pages: PageBindings,
    ground: PageGroundGroup,
    feedback: PageFeedbackRing,
    request_pass: Option<(RequestPassKey, PageRequestPass)>,
    /// The picture's pass, as long as no page fades in and while one does.
    passes: [Option<(PageGroundPassSettings, PageGroundPass)>; 2],
    seen: SeenPages,
    /// The height tiles chosen.
    selection: Selection,
    /// Eighths of a level that all pages are drawn coarser for them to fit.
    coarser_steps: i32,
    /// The pages chosen, beside those that are always resident.
    chosen_pages: Vec<PageId>,
    /// The view that height tiles were chosen for, and the latest image's frame, if any, that pages were.
    chosen: Option<(CameraView, Option<u64>)>,
    /// What the latest images were asked for, and how many.
    asked: Option<(CoordinateState, u32)>,
}

/// What decides how the pass of the requests is built: whether the lookup is linear, whether there are voids, and
/// the most taps.
type RequestPassKey = (bool, bool, u32);

impl PageTable {
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
        let drawn = DrawnTiles::new(cx, source, &tree, format)?;
        let terrain = PagedTerrain::open(source, tree, format, slots, cx.ledger)?;
        let layout = terrain.pages.layout();
        let pages = PageBindings::new(&gpu.device, layout, &drawn.tiles.cache.colours);
        Ok(Self {
            feedback: PageFeedbackRing::new(&gpu.device, layout, &pages, settings),
            ground: PageGroundGroup::new(&gpu.device),
            terrain,
            drawn,
            pages,
            request_pass: None,
            passes: [None, None],
            seen: SeenPages::default(),
            selection: Selection { tiles: vec![TileId::ROOT], ..Default::default() },
            coarser_steps: 0,
            chosen_pages: Vec::new(),
            chosen: None,
            asked: None,
        })
    }

    /// The settings that the caches, the feedback and the pipelines of the mesh are made for; all others as they
    /// are by default.
    pub fn made_for(settings: &RendererSettings) -> RendererSettings {
        let RendererSettings {
            cache_columns,
            cache_rows,
            page_feedback,
            readback_latency_frames,
            lookup,
            ..
        } = *settings;
        RendererSettings {
            cache_columns,
            cache_rows,
            page_feedback,
            readback_latency_frames,
            lookup,
            ..Default::default()
        }
    }
}

impl TerrainMethod for PageTable {
    /// Takes what pixels of earlier frames asked for, if any of it has come back.
    fn receive(&mut self, cx: &mut FrameContext<'_>) {
        let back = self.feedback.take(self.terrain.pages.layout(), cx.frame);
        if back.is_cut_off {
            self.asked = None;
        }
        for image in back.images {
            self.seen.take(image, self.feedback.period());
        }
    }

    /// Chooses pages by what was asked for last, and height tiles by the view.
    fn select(&mut self, cx: &mut FrameContext<'_>, view: &CameraView) -> f64 {
        if !self.wants_choice(cx.settings, view) {
            return 0.0;
        }
        let started = Instant::now();
        let config = cx.settings.selection_config();
        self.selection = select_by_frustum(&self.terrain.tree, view, &config);
        let asked = self.seen.asked();
        let layout = self.terrain.pages.layout();
        let most_pages = config.max_tiles.saturating_sub(1);
        let serving = |page| self.terrain.serving(page);
        let (coarser_steps, pages) = fitting(layout, &asked, most_pages, serving);
        self.terrain.pages.request(&pages);
        self.chosen_pages = pages;
        self.terrain.version += u64::from(coarser_steps != self.coarser_steps);
        self.coarser_steps = coarser_steps;
        self.chosen = Some(self.choice_for(view));
        started.elapsed().as_secs_f64() * 1.0e3
    }

    fn stream(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        _view: &CameraView,
    ) -> Moved {
        let budget = cx.settings.upload_budget_bytes;
        let (arrivals, has_failed) =
            self.terrain.stream(&self.selection, budget, cx.frame, cx.ledger);
        if has_failed {
            self.chosen = None;
        }
        let moved = self.upload(cx, encoder, &arrivals);
        let changed = self.terrain.pages.take_changed();
        self.terrain.version += u64::from(!changed.is_empty());
        cx.ledger.add(ByteCause::Table, self.pages.set_entries(&cx.gpu.queue, &changed));
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
        let exaggeration = scene.settings.vertical_exaggeration;
        let PagedTerrain { ground, tree, .. } = &self.terrain;
        let scale_m = mesh_scale_m(tree, ground.clearance_m(tree, scene.view.eye, exaggeration));
        let tables = (&self.terrain.height_table, None);
        self.drawn.tiles.show(cx, tree, (scene, scale_m), tables);
        let sent = self.set_page_uniforms(cx.gpu, scene);
        cx.ledger.add(ByteCause::Uniform, sent);
        // The image of the requests is drawn with the picture's own mesh.
        let scale = (scale_m, false);
        self.drawn.set_meshes(cx, encoder, &self.terrain.tree, scene, scale);
    }

    /// Draws what pixels ask for and asks for it, unless that was done for the scene already.
    fn ask(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) -> bool {
        if !self.wants_image(scene) || !self.feedback.is_free() {
            return false;
        }
        let key = self.request_pass_key(&scene.settings);
        let request_pass = match self.request_pass.take() {
            Some((built_for, pass)) if built_for == key => pass,
            _ => PageRequestPass::new(&cx.gpu.device, self.ground_bindings(), key),
        };
        let Self { drawn, pages, ground, feedback, .. } = self;
        let Some(mesh) = drawn.meshes.picture() else { return false };
        let bindings = PageGroundBindings { frame: &drawn.tiles.bindings, pages, ground };
        let gpu = (&cx.gpu.device, &cx.gpu.queue);
        let bytes = feedback.record(gpu, encoder, scene.view.viewport_px, pages, |pass| {
            request_pass.draw(pass, bindings, mesh.parts(), mesh.visible());
        });
        self.request_pass = Some((key, request_pass));
        let Some(bytes) = bytes else { return false };
        cx.ledger.add(ByteCause::Readback, bytes);
        let state = self.image_state(scene);
        let before = self.asked.filter(|(asked, _)| *asked == state);
        self.asked = Some((state, before.map_or(0, |(_, images)| images) + 1));
        true
    }

    fn draw(
        &mut self,
        cx: &FrameContext<'_>,
        pass: &mut wgpu::RenderPass<'_>,
        target: TargetKind,
        scene: &SceneState,
    ) -> &FrameGroup {
        let fades = self.terrain.pages.is_fading();
        let settings = PageGroundPassSettings {
            target,
            linear_lookup: scene.settings.lookup == LookupMethod::Linear,
            wireframe: scene.settings.wireframe,
            has_colours: self.terrain.has_colours(),
            has_voids: self.drawn.has_voids,
            anisotropy: scene.settings.anisotropy,
            fades,
            debug_view: scene.settings.debug_view,
        };
        let ground_pass = match self.passes[usize::from(fades)].take() {
            Some((built_for, pass)) if built_for == settings => pass,
            _ => PageGroundPass::new(&cx.gpu.device, self.ground_bindings(), &settings),
        };
        if let Some(mesh) = self.drawn.meshes.picture() {
            ground_pass.draw(pass, self.ground_bindings(), mesh.parts(), mesh.visible());
        }
        self.passes[usize::from(fades)] = Some((settings, ground_pass));
        &self.drawn.tiles.bindings.frame
    }

    fn after_submit(&mut self, frame: u64, view: &CameraView) {
        self.feedback.begin(frame, view);
    }

    fn describe(&self, _settings: &RendererSettings, record: &mut FrameRecord) {
        self.drawn.describe(record);
        let layout = self.terrain.pages.layout();
        let finest = self.chosen_pages.first().map_or(layout.coarsest_level, |page| page.level);
        record.tiles_selected = (self.chosen_pages.len() + layout.resident_pages().count()) as u64;
        record.tiles_missing = self.terrain.missing() as u64;
        record.tiles_resident = self.terrain.resident() as u64;
        record.finest_level = layout.coarsest_level - finest;
        record.region_age_frames = self.image_age_frames(record.frame);
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
            || self.terrain.pages.is_fading()
            || self.feedback.is_waiting()
            || self.wants_image(scene)
            || self.wants_choice(&scene.settings, &scene.view)
    }

    fn wait(&self, patience: Duration) {
        self.terrain.wait(patience);
    }

    fn reconsider(&mut self) {
        self.chosen = None;
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
        self.drawn.atlas_view(image)
    }
}

impl PageTable {
    fn ground_bindings(&self) -> PageGroundBindings<'_> {
        let Self { drawn, pages, ground, .. } = self;
        PageGroundBindings { frame: &drawn.tiles.bindings, pages, ground }
    }

    fn request_pass_key(&self, settings: &RendererSettings) -> RequestPassKey {
        let is_linear = settings.lookup == LookupMethod::Linear;
        (is_linear, self.drawn.has_voids, settings.anisotropy)
    }

    /// Brings tiles and pages into their slots.
    fn upload(
        &self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        arrivals: &PagedArrivals,
    ) -> Moved {
        let PagedTerrain { tree, pages, .. } = &self.terrain;
        self.drawn.tiles.send_heights(cx, encoder, tree, &arrivals.heights);
        let content = |upload: PageUpload| Some((upload.slot, pages.payload(upload.page)?));
        let tiles: Vec<(u32, &ColourTile)> =
            arrivals.pages.iter().copied().filter_map(content).collect();
        self.drawn.tiles.send_colours(cx, encoder, tree, &tiles);
        Moved { new: arrivals.count(), evicted: arrivals.evicted() }
    }

    /// Brings the page table's parameters to the GPU; returns the bytes.
    fn set_page_uniforms(&mut self, gpu: &GpuContext, scene: &SceneState) -> u64 {
        let Self { terrain, drawn, pages, ground, coarser_steps, .. } = self;
        let layout = terrain.pages.layout();
        let request_bias = scene.settings.texel_px.log2() as f32;
        let lookup_bias = request_bias + *coarser_steps as f32 / PageRequest::STEPS as f32;
        let biases = [request_bias, lookup_bias];
        let table = PageTableUniforms::new(layout, &drawn.tiles.cache.colours.grid, biases);
        let place = PageGround::new(layout, &terrain.tree.scheme, scene.view.eye);
        pages.set_uniforms(&gpu.queue, &table) + ground.set(&gpu.queue, &place)
    }

    fn image_state(&self, scene: &SceneState) -> CoordinateState {
        let SceneState { view, settings, .. } = *scene;
        CoordinateState { view, uploads: self.terrain.height_uploads, settings }
    }

    /// Whether not all images of the scene have been asked for yet.
    fn wants_image(&self, scene: &SceneState) -> bool {
        let period = self.feedback.period();
        let has_all = |(state, images)| state == self.image_state(scene) && images >= period;
        let needs_any = !scene.settings.freeze_selection && self.terrain.has_colours();
        needs_any && !self.asked.is_some_and(has_all)
    }

    fn wants_choice(&self, settings: &RendererSettings, view: &CameraView) -> bool {
        !settings.freeze_selection && self.chosen != Some(self.choice_for(view))
    }

    /// What a choice for the view by the latest image is made for.
    fn choice_for(&self, view: &CameraView) -> (CameraView, Option<u64>) {
        (*view, self.seen.latest().map(|(frame, _)| frame))
    }

    /// How many frames ago the latest image was drawn; 0 where the camera has not moved since.
    fn image_age_frames(&self, frame: u64) -> Option<u64> {
        let (seen_in, seen_from) = self.seen.latest()?;
        let is_current = self.chosen.is_some_and(|(view, _)| view == seen_from);
        Some(if is_current { 0 } else { frame - seen_in })
    }
}
