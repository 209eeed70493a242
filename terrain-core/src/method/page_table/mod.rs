//! The page-table method: imagery as one virtual texture, of which the GPU finds the tiles that pixels need;
//! after the paper on GPU-visible tiles (a new method for fast determination of visible texture tiles). The
//! texture is a [`PagedTexture`]; here it is drawn on plane ground.
//!
//! The mesh is that of tile scheduling. As the paper has it, the texture knows nothing of the geometry, and the
//! geometry nothing of the texture: height tiles are chosen by the view frustum, since the level a texture is
//! filtered to says little about how fine its ground must be. So nothing that comes back changes the ground in
//! view, and a still camera comes to rest by itself.

mod ground_map;
mod heights;

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec2;

use self::ground_map::GroundMap;
use self::heights::StreamedHeights;
use super::drawn_tiles::DrawnTiles;
use super::paged_texture::{PagedSource, PagedTexture};
use super::{FrameContext, ImageState, Moved, SceneState, TerrainMethod};
use crate::CameraView;
use crate::built_for::BuiltFor;
use crate::dataset::TileSource;
use crate::frame_setup::mesh_scale_m;
use crate::gpu::{
    DebugImage, FrameGroup, PageGround, PageGroundBindings, PageGroundGroup, PageGroundPass,
    PageGroundPassSettings, PageRequestPass, TargetKind, TerrainCache,
};
use crate::layer_loading::{colour_format, open_height_intake};
use crate::measure::{ByteCause, FrameRecord};
use crate::renderer_settings::{LookupMethod, RendererSettings};
use crate::residency::page_table::PagesAsked;
use crate::selection::{Selection, Strategy, TileTree, select_by_frustum};
use crate::terrain_renderer::RenderError;
use crate::tiling::TileId;

/// Draws a dataset with imagery through a page table.
pub(super) struct PageTable {
    heights: StreamedHeights,
    drawn: DrawnTiles,
    imagery: PagedTexture,
    ground: PageGroundGroup,
    request_pass: BuiltFor<RequestPassKey, PageRequestPass>,
    /// What finds the pages instead, with the strategy of that name.
    map: Option<GroundMap>,
    /// The picture's pass, as long as no page fades in and while one does.
    passes: [BuiltFor<PageGroundPassSettings, PageGroundPass>; 2],
    /// The height tiles chosen.
    selection: Selection,
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
        let drawn = DrawnTiles::new(cx, source, &tree, format, TerrainCache::of_heights)?;
        let imagery = PagedTexture::open(cx, PagedSource::imagery(source, &tree, format))?;
        let intake = open_height_intake(source, cx.ledger)?;
        Ok(Self {
            ground: PageGroundGroup::new(&gpu.device),
            heights: StreamedHeights::new(tree, slots, intake),
            drawn,
            imagery,
            request_pass: BuiltFor::default(),
            map: (settings.strategy == Strategy::TextureMap).then(|| GroundMap::new(&gpu.device)),
            passes: Default::default(),
            selection: Selection { tiles: vec![TileId::ROOT], ..Default::default() },
        })
    }

    /// The settings that the caches, the feedback and the pipelines of the mesh are made for; all others as they
    /// are by default.
    pub fn made_for(settings: &RendererSettings) -> RendererSettings {
        RendererSettings { lookup: settings.lookup, ..PagedTexture::made_for(settings) }
    }
}

impl TerrainMethod for PageTable {
    fn receive(&mut self, cx: &mut FrameContext<'_>) {
        self.imagery.receive(cx.frame);
    }

    /// Chooses pages by what was asked for last, and height tiles by the view.
    fn select(&mut self, cx: &mut FrameContext<'_>, view: &CameraView) -> f64 {
        if !self.imagery.wants_choice(cx.settings, view) {
            return 0.0;
        }
        let started = Instant::now();
        let config = cx.settings.selection_config();
        self.selection = select_by_frustum(&self.heights.tree, view, &config);
        self.imagery.choose(cx.settings, view);
        started.elapsed().as_secs_f64() * 1.0e3
    }

    fn stream(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        _view: &CameraView,
    ) -> Moved {
        let budget_bytes = cx.settings.upload_budget_bytes;
        let arrived = self.heights.update(&self.selection, budget_bytes, cx.frame, cx.ledger);
        self.drawn.tiles.send_heights(cx, encoder, &self.heights.tree, &arrived);
        let sent = arrived.iter().map(|(_, tile)| tile.samples.byte_len()).sum();
        let evicted = arrived.iter().filter(|(placement, _)| placement.evicted.is_some()).count();
        let pages = self.imagery.stream(cx, encoder, budget_bytes.saturating_sub(sent));
        let new = arrived.len() as u64 + pages.new;
        self.heights.ground.keep(arrived);
        Moved { new, evicted: evicted as u64 + pages.evicted }
    }

    fn data_version(&self) -> u64 {
        self.heights.version + self.imagery.version()
    }

    fn set_up(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) {
        let exaggeration = scene.settings.vertical_exaggeration;
        let StreamedHeights { ground, tree, table, .. } = &self.heights;
        let scale_m = mesh_scale_m(tree, ground.clearance_m(tree, scene.view.eye, exaggeration));
        self.drawn.tiles.show(cx, tree, (scene, scale_m), (table, None));
        self.imagery.set_up(cx, &scene.settings);
        let place = PageGround::new(self.imagery.layout(), &tree.scheme, scene.view.eye);
        cx.ledger.add(ByteCause::Uniform, self.ground.set(&cx.gpu.queue, &place));
        // The image of the requests is drawn with the picture's own mesh.
        self.drawn.set_meshes(cx, encoder, &self.heights.tree, scene, (scale_m, false));
    }

    /// Draws what pixels ask for and asks for it, unless that was done for the scene already.
    fn ask(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) -> bool {
        let state = self.image_state(scene);
        if !self.imagery.wants_image(&state) {
            return false;
        }
        if self.map.is_some() {
            return self.ask_map(cx, encoder, state, scene);
        }
        let key = self.request_pass_key(&scene.settings);
        let Self { drawn, imagery, ground, request_pass, .. } = self;
        let Some(mesh) = drawn.meshes.picture() else { return false };
        let device = &cx.gpu.device;
        imagery.ask(cx, encoder, state, |pass, pages| {
            let bindings = PageGroundBindings { frame: &drawn.tiles.bindings, pages, ground };
            let build = || PageRequestPass::new(device, bindings, key);
            request_pass.get(key, build).draw(pass, bindings, mesh.parts(), mesh.visible());
        })
    }

    fn draw(
        &mut self,
        cx: &FrameContext<'_>,
        pass: &mut wgpu::RenderPass<'_>,
        target: TargetKind,
        scene: &SceneState,
    ) -> &FrameGroup {
        let fades = self.imagery.is_fading();
        let settings = PageGroundPassSettings {
            target,
            linear_lookup: scene.settings.lookup == LookupMethod::Linear,
            wireframe: scene.settings.wireframe,
            has_colours: self.imagery.has_any(),
            has_voids: self.drawn.has_voids,
            anisotropy: scene.settings.anisotropy,
            fades,
            debug_view: scene.settings.debug_view,
        };
        let Self { drawn, imagery, ground, passes, .. } = self;
        let (frame, pages) = (&drawn.tiles.bindings, imagery.bindings());
        let bindings = PageGroundBindings { frame, pages, ground };
        let build = || PageGroundPass::new(&cx.gpu.device, bindings, &settings);
        let ground_pass = passes[usize::from(fades)].get(settings, build);
        if let Some(mesh) = drawn.meshes.picture() {
            ground_pass.draw(pass, bindings, mesh.parts(), mesh.visible());
        }
        &self.drawn.tiles.bindings.frame
    }

    fn after_submit(&mut self, frame: u64, view: &CameraView) {
        self.imagery.after_submit(frame, view);
    }

    fn describe(&self, _settings: &RendererSettings, record: &mut FrameRecord) {
        self.drawn.describe(record);
        self.imagery.describe(record);
        record.tiles_missing += self.heights.missing() as u64;
        record.tiles_resident += self.heights.resident() as u64;
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
        self.heights.missing() > 0 || self.imagery.is_pending(&self.image_state(scene))
    }

    fn wait(&self, patience: Duration) {
        self.heights.wait(patience);
        self.imagery.wait(patience);
    }

    fn reconsider(&mut self) {
        self.imagery.reconsider();
    }

    fn take_failures(&mut self) -> Vec<String> {
        let mut failures = self.heights.take_failures();
        failures.extend(self.imagery.take_failures());
        failures
    }

    fn tree(&self) -> &TileTree {
        &self.heights.tree
    }

    fn selection(&self) -> &Selection {
        &self.selection
    }

    fn pages_asked(&self) -> Option<PagesAsked> {
        Some(self.imagery.asked())
    }

    fn ground_height_m(&self, point: DVec2) -> Option<f64> {
        self.heights.ground.height_m(&self.heights.tree, point)
    }

    fn debug_texture(&self, image: DebugImage) -> Option<wgpu::TextureView> {
        match image {
            DebugImage::ColourCache => Some(self.imagery.atlas_view()),
            _ => self.drawn.atlas_view(image),
        }
    }
}

impl PageTable {
    /// Has the texture map find the pages of a state, and asks for them.
    fn ask_map(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        state: ImageState,
        scene: &SceneState,
    ) -> bool {
        let Self { drawn, imagery, ground, map: Some(map), .. } = self else { return false };
        let (gpu, mut sent) = (cx.gpu, 0);
        let has_asked = imagery.ask_marked(cx, encoder, state, |encoder, over, pages| {
            let bindings = PageGroundBindings { frame: &drawn.tiles.bindings, pages, ground };
            sent = map.mark(gpu, encoder, scene, (drawn, bindings), over);
        });
        cx.ledger.add(ByteCause::Uniform, sent);
        has_asked
    }

    fn request_pass_key(&self, settings: &RendererSettings) -> RequestPassKey {
        let is_linear = settings.lookup == LookupMethod::Linear;
        (is_linear, self.drawn.has_voids, settings.anisotropy)
    }

    fn image_state(&self, scene: &SceneState) -> ImageState {
        let SceneState { view, settings, .. } = *scene;
        ImageState { view, geometry: self.heights.uploads, settings }
    }
}
