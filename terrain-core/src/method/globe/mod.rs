//! The globe: the ellipsoid of WGS 84, with the dataset's heights on it where it has any, and its imagery through a
//! page table. The mesh is [`crate::surface::globe`], the texture a [`PagedTexture`].
//!
//! The eye of a view is in metres on the plate carrée and above the ellipsoid, its heading and pitch are in the
//! directions east, north and up that the ground below it has; "relative metres" are in these everywhere on the
//! GPU, which is told differences from the eye only.

mod heights;
mod mesh;
mod patch_slots;

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec2;

use self::heights::GlobeHeights;
use self::mesh::GlobeMesh;
use super::paged_texture::{PagedSource, PagedTexture};
use super::{FrameContext, ImageState, Moved, SceneState, TerrainMethod};
use crate::CameraView;
use crate::built_for::BuiltFor;
use crate::dataset::TileSource;
use crate::frame_setup::frame_uniforms;
use crate::gpu::{
    DebugImage, FrameGroup, GlobeBindings, GlobeGroup, GlobePass, GlobePassSettings,
    GlobeRequestPass, GlobeUniforms, TargetKind, draw_globe_coordinates,
};
use crate::layer_loading::{colour_format, open_height_intake};
use crate::measure::{ByteCause, FrameRecord};
use crate::renderer_settings::RendererSettings;
use crate::selection::{Selection, TileTree};
use crate::surface::globe::GlobeGround;
use crate::terrain_renderer::RenderError;
use crate::tiling::TileId;

/// Draws a dataset of the whole globe.
pub(super) struct Globe {
    heights: GlobeHeights,
    mesh: GlobeMesh,
    imagery: PagedTexture,
    frame: FrameGroup,
    globe: GlobeGroup,
    /// By the most taps.
    request_pass: BuiltFor<u32, GlobeRequestPass>,
    /// The picture's pass, as long as no page fades in and while one does.
    passes: [BuiltFor<GlobePassSettings, GlobePass>; 2],
    /// The view that heights were wanted for, and the mesh's version then.
    wanted_for: Option<(CameraView, u64)>,
    selection: Selection,
}

impl Globe {
    /// Opens the caches and loads level 0 of each layer.
    ///
    /// # Errors
    /// [`RenderError`] where level 0 cannot be loaded or the cache is larger than textures can be.
    pub fn open(
        cx: &mut FrameContext<'_>,
        source: &Arc<dyn TileSource>,
        tree: TileTree,
    ) -> Result<Self, RenderError> {
        let (gpu, settings) = (cx.gpu, cx.settings);
        let slots = (settings.cache_columns, settings.cache_rows);
        let format = colour_format(&**source, gpu.has_block_compression());
        let imagery = PagedTexture::open(cx, PagedSource::imagery(source, &tree, format))?;
        let intake = open_height_intake(source, cx.ledger)?;
        let range = source.manifest().heights.range;
        let range_m = [range.min_m, range.max_m].map(f64::from);
        let ground = GlobeGround::new(tree.scheme, tree.heights.layout, range_m);
        let mesh = GlobeMesh::new(gpu);
        cx.ledger.add(ByteCause::Mesh, mesh.buffers.triangle_bytes());
        Ok(Self {
            heights: GlobeHeights::new(tree, ground, slots, intake),
            mesh,
            imagery,
            frame: FrameGroup::new(&gpu.device),
            globe: GlobeGroup::new(&gpu.device),
            request_pass: BuiltFor::default(),
            passes: Default::default(),
            wanted_for: None,
            selection: Selection { tiles: vec![TileId::ROOT], ..Default::default() },
        })
    }

    fn image_state(&self, scene: &SceneState) -> ImageState {
        let SceneState { view, settings, .. } = *scene;
        ImageState { view, geometry: self.mesh.version, settings }
    }

    /// Wants the heights that the latest cover is to have.
    fn want_heights(&mut self) {
        let version = self.mesh.version;
        let Some((cover, view, store)) = self.mesh.cover_and_store() else { return };
        if self.wanted_for == Some((*view, version)) {
            return;
        }
        let is_same_view = self.wanted_for.is_some_and(|(before, _)| before == *view);
        self.heights.want(cover, store, is_same_view);
        self.wanted_for = Some((*view, version));
    }

    /// Whether the latest cover's heights are still to be asked for.
    fn wants_heights(&self) -> bool {
        let latest = self.mesh.cover().map(|(_, view)| (*view, self.mesh.version));
        !self.heights.ground.is_level() && self.wanted_for != latest
    }
}

impl TerrainMethod for Globe {
    fn receive(&mut self, cx: &mut FrameContext<'_>) {
        self.imagery.receive(cx.frame);
    }

    /// Chooses pages by what was asked for last, and heights by the mesh of the frame before.
    fn select(&mut self, cx: &mut FrameContext<'_>, view: &CameraView) -> f64 {
        let started = Instant::now();
        if !cx.settings.freeze_selection {
            self.want_heights();
        }
        if self.imagery.wants_choice(cx.settings, view) {
            self.imagery.choose(cx.settings, view);
        }
        started.elapsed().as_secs_f64() * 1.0e3
    }

    fn stream(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        view: &CameraView,
    ) -> Moved {
        let budget_bytes = cx.settings.upload_budget_bytes;
        let heights = self.heights.update(budget_bytes, cx.frame, cx.ledger);
        self.mesh.ground_changed(&heights.changed);
        if self.heights.ground.exaggerate(cx.settings.vertical_exaggeration) {
            self.mesh.all_changed();
        }
        let mesh = self.mesh.show(cx.gpu, &self.heights.ground, view, cx.settings);
        cx.ledger.add(ByteCause::Mesh, mesh.sent_bytes);
        let left_bytes = budget_bytes.saturating_sub(mesh.sent_bytes);
        let pages = self.imagery.stream(cx, encoder, left_bytes);
        Moved {
            new: heights.new + mesh.new + pages.new,
            evicted: heights.evicted + mesh.evicted + pages.evicted,
        }
    }

    fn data_version(&self) -> u64 {
        self.mesh.version + self.imagery.version()
    }

    fn set_up(
        &mut self,
        cx: &mut FrameContext<'_>,
        _encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) {
        let SceneState { view, settings, .. } = scene;
        // Another view than the frame's, where a picture is drawn beside the frames.
        let mesh = self.mesh.show(cx.gpu, &self.heights.ground, view, settings);
        cx.ledger.add(ByteCause::Mesh, mesh.sent_bytes);
        let (tree, queue) = (&self.heights.tree, &cx.gpu.queue);
        let uniforms = frame_uniforms(view, tree, settings, 1.0);
        cx.ledger.add(ByteCause::Uniform, self.frame.set_uniforms(queue, &uniforms));
        let exaggeration = settings.vertical_exaggeration;
        let layout = self.imagery.layout();
        let globe = GlobeUniforms::new(layout, &tree.scheme, view.eye, exaggeration);
        cx.ledger.add(ByteCause::Uniform, self.globe.set(queue, &globe));
        self.imagery.set_up(cx, settings);
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
        let Self { frame, globe, mesh, imagery, request_pass, .. } = self;
        let (device, taps) = (&cx.gpu.device, scene.settings.anisotropy);
        imagery.ask(cx, encoder, state, |pass, pages| {
            let bindings = GlobeBindings { frame, globe, pages };
            let build = || GlobeRequestPass::new(device, bindings, taps);
            request_pass.get(taps, build).draw(pass, bindings, &mesh.buffers, mesh.drawn());
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
        let settings = GlobePassSettings {
            target,
            wireframe: scene.settings.wireframe,
            has_colours: self.imagery.has_any(),
            anisotropy: scene.settings.anisotropy,
            fades,
            debug_view: scene.settings.debug_view,
        };
        let Self { frame, globe, mesh, imagery, passes, .. } = self;
        let bindings = GlobeBindings { frame, globe, pages: imagery.bindings() };
        let build = || GlobePass::new(&cx.gpu.device, bindings, &settings);
        let globe_pass = passes[usize::from(fades)].get(settings, build);
        globe_pass.draw(pass, bindings, &mesh.buffers, mesh.drawn());
        &self.frame
    }

    fn draws_sky(&self) -> bool {
        true
    }

    fn after_submit(&mut self, frame: u64, view: &CameraView) {
        self.imagery.after_submit(frame, view);
    }

    fn describe(&self, _settings: &RendererSettings, record: &mut FrameRecord) {
        self.imagery.describe(record);
        record.tiles_missing += self.heights.missing() as u64;
        record.tiles_resident += self.heights.resident() as u64;
        record.blocks_drawn = self.mesh.drawn().len() as u64;
        record.triangles_drawn = self.mesh.triangle_count();
    }

    fn draw_coordinates(
        &mut self,
        cx: &FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) -> wgpu::Texture {
        let groups = (&self.frame, &self.globe);
        let mesh = (&self.mesh.buffers, self.mesh.drawn());
        draw_globe_coordinates(&cx.gpu.device, encoder, groups, mesh, scene.view.viewport_px)
    }

    fn is_pending(&self, scene: &SceneState) -> bool {
        let is_frozen = scene.settings.freeze_selection;
        self.heights.missing() > 0
            || self.mesh.is_pending(&scene.view, &scene.settings)
            || (!is_frozen && self.wants_heights())
            || self.imagery.is_pending(&self.image_state(scene))
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

    fn ground_height_m(&self, point: DVec2) -> Option<f64> {
        self.heights.ground.height_m(GlobeGround::within(point))
    }

    fn debug_texture(&self, image: DebugImage) -> Option<wgpu::TextureView> {
        (image == DebugImage::ColourCache).then(|| self.imagery.atlas_view())
    }
}
