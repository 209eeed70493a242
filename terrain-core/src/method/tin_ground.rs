//! Ground made of triangles (a TIN) in place of a dataset's heights, with the dataset's imagery through a page table.
//!
//! All triangles are on the GPU from the beginning; what streams is the imagery, by what pixels ask for. Light is that
//! of the slopes at the vertices.

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec2;

use super::paged_texture::{PagedSource, PagedTexture};
use super::{FrameContext, ImageState, Moved, SceneState, TerrainMethod};
use crate::CameraView;
use crate::built_for::BuiltFor;
use crate::dataset::TileSource;
use crate::frame_setup::frame_uniforms;
use crate::gpu::{
    DebugImage, FrameGroup, PageGround, PageGroundGroup, TargetKind, TinBindings, TinBuffers,
    TinPass, TinPassSettings, TinRequestPass,
};
use crate::layer_loading::colour_format;
use crate::measure::{ByteCause, FrameRecord};
use crate::renderer_settings::RendererSettings;
use crate::selection::{Selection, TileTree};
use crate::surface::tin::TinGround;
use crate::terrain_renderer::RenderError;
use crate::tiling::TileId;

/// Draws a TIN with a dataset's imagery.
pub(super) struct TinMethod {
    tree: TileTree,
    tin: Arc<TinGround>,
    buffers: TinBuffers,
    frame: FrameGroup,
    ground: PageGroundGroup,
    imagery: PagedTexture,
    request_pass: BuiltFor<u32, TinRequestPass>,
    /// The picture's pass, as long as no page fades in and while one does.
    passes: [BuiltFor<TinPassSettings, TinPass>; 2],
    /// No tile is ever chosen but the root.
    selection: Selection,
}

impl TinMethod {
    /// Brings the triangles to the GPU and loads level 0 of the imagery.
    ///
    /// # Errors
    /// [`RenderError`] where level 0 cannot be loaded or the cache is larger than textures can be.
    pub fn open(
        cx: &mut FrameContext<'_>,
        source: &Arc<dyn TileSource>,
        tree: TileTree,
        tin: &Arc<TinGround>,
    ) -> Result<Self, RenderError> {
        let device = &cx.gpu.device;
        let format = colour_format(&**source, cx.gpu.has_block_compression());
        let buffers = TinBuffers::new(device, tin);
        cx.ledger.add(ByteCause::Mesh, buffers.sent_bytes());
        Ok(Self {
            imagery: PagedTexture::open(cx, PagedSource::imagery(source, &tree, format))?,
            frame: FrameGroup::new(device),
            ground: PageGroundGroup::new(device),
            tin: Arc::clone(tin),
            tree,
            buffers,
            request_pass: BuiltFor::default(),
            passes: Default::default(),
            selection: Selection { tiles: vec![TileId::ROOT], ..Default::default() },
        })
    }

    fn bindings(&self) -> TinBindings<'_> {
        let Self { frame, buffers, imagery, ground, .. } = self;
        TinBindings { frame, tin: buffers, pages: imagery.bindings(), ground }
    }
}

fn image_state(scene: &SceneState) -> ImageState {
    ImageState { view: scene.view, geometry: 0, settings: scene.settings }
}

impl TerrainMethod for TinMethod {
    fn receive(&mut self, cx: &mut FrameContext<'_>) {
        self.imagery.receive(cx.frame);
    }

    fn select(&mut self, cx: &mut FrameContext<'_>, view: &CameraView) -> f64 {
        if !self.imagery.wants_choice(cx.settings, view) {
            return 0.0;
        }
        let started = Instant::now();
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
        self.imagery.stream(cx, encoder, budget_bytes)
    }

    fn data_version(&self) -> u64 {
        self.imagery.version()
    }

    fn set_up(
        &mut self,
        cx: &mut FrameContext<'_>,
        _encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) {
        let (queue, eye) = (&cx.gpu.queue, scene.view.eye);
        let uniforms = frame_uniforms(&scene.view, &self.tree, &scene.settings, 1.0);
        let place = PageGround::new(self.imagery.layout(), &self.tree.scheme, eye);
        let seen_from = (eye, scene.settings.vertical_exaggeration);
        let sent = self.frame.set_uniforms(queue, &uniforms)
            + self.ground.set(queue, &place)
            + self.buffers.set_place(queue, self.tin.origin, seen_from);
        cx.ledger.add(ByteCause::Uniform, sent);
        self.imagery.set_up(cx, &scene.settings);
    }

    /// Draws what pixels ask for and asks for it, unless that was done for the scene already.
    fn ask(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) -> bool {
        let state = image_state(scene);
        if !self.imagery.wants_image(&state) {
            return false;
        }
        let Self { frame, buffers, imagery, ground, request_pass, .. } = self;
        let (device, anisotropy) = (&cx.gpu.device, scene.settings.anisotropy);
        imagery.ask(cx, encoder, state, |pass, pages| {
            let bindings = TinBindings { frame, tin: buffers, pages, ground };
            let build = || TinRequestPass::new(device, bindings, anisotropy);
            request_pass.get(anisotropy, build).draw(pass, bindings);
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
        let settings = TinPassSettings {
            target,
            wireframe: scene.settings.wireframe,
            has_colours: self.imagery.has_any(),
            anisotropy: scene.settings.anisotropy,
            fades,
            debug_view: scene.settings.debug_view,
        };
        let Self { frame, buffers, imagery, ground, passes, .. } = self;
        let bindings = TinBindings { frame, tin: buffers, pages: imagery.bindings(), ground };
        let build = || TinPass::new(&cx.gpu.device, bindings, &settings);
        passes[usize::from(fades)].get(settings, build).draw(pass, bindings);
        &self.frame
    }

    fn after_submit(&mut self, frame: u64, view: &CameraView) {
        self.imagery.after_submit(frame, view);
    }

    fn describe(&self, _settings: &RendererSettings, record: &mut FrameRecord) {
        self.imagery.describe(record);
        record.triangles_drawn = (self.tin.indices.len() / 3) as u64;
    }

    fn draw_coordinates(
        &mut self,
        cx: &FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) -> wgpu::Texture {
        self.bindings().draw_coordinates(&cx.gpu.device, encoder, scene.view.viewport_px)
    }

    fn is_pending(&self, scene: &SceneState) -> bool {
        self.imagery.is_pending(&image_state(scene))
    }

    fn wait(&self, patience: Duration) {
        self.imagery.wait(patience);
    }

    fn reconsider(&mut self) {
        self.imagery.reconsider();
    }

    fn take_failures(&mut self) -> Vec<String> {
        self.imagery.take_failures()
    }

    fn tree(&self) -> &TileTree {
        &self.tree
    }

    fn selection(&self) -> &Selection {
        &self.selection
    }

    /// Of the triangles, all of which are known.
    fn ground_height_m(&self, point: DVec2) -> Option<f64> {
        self.tin.height_m(point)
    }

    fn debug_texture(&self, image: DebugImage) -> Option<wgpu::TextureView> {
        (image == DebugImage::ColourCache).then(|| self.imagery.atlas_view())
    }
}
