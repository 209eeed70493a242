//! Models beside the ground: drawn in the same pass with the same depth, whatever the ground is drawn by, their
//! textures through a page table of their own.
//!
//! A frame calls the steps in the order they stand here, each after the ground's own.

mod object_map;
mod standing;

use std::sync::Arc;
use std::time::Duration;

use glam::{DVec2, Vec4};

use self::object_map::ObjectMap;
use self::standing::StandingModels;
use super::paged_texture::{PagedSource, PagedTexture};
use super::{FrameContext, ImageState, Moved, SceneState};
use crate::CameraView;
use crate::built_for::BuiltFor;
use crate::dataset::{ColourFormat, Loaded, Shape};
use crate::frame_setup::frame_uniforms;
use crate::gpu::{
    FrameGroup, GpuContext, GpuError, ModelRun, ObjectBindings, ObjectBuffers, ObjectMaterial,
    ObjectPass, ObjectPassSettings, ObjectRequestPass, TargetKind,
};
use crate::measure::{ByteCause, FrameRecord};
use crate::renderer_settings::RendererSettings;
use crate::residency::Loading;
use crate::residency::page_table::PagesAsked;
use crate::selection::{Strategy, TileTree};
use crate::surface::models::{Model, ModelScene, TexturePack};
use crate::terrain_renderer::RenderError;
use crate::tiling::TileSet;

/// The models of a scene, where they stand and what of their texture is resident.
pub(crate) struct Objects {
    models: StandingModels,
    texture: PagedTexture,
    /// The frame's parameters: models are drawn with the same as the ground is.
    frame: FrameGroup,
    buffers: ObjectBuffers,
    has_cutouts: bool,
    /// What of the models is in view.
    runs: Vec<ModelRun>,
    triangles: u64,
    request_pass: BuiltFor<u32, ObjectRequestPass>,
    /// What finds the pages instead, with the strategy of that name.
    map: Option<ObjectMap>,
    /// The picture's pass, as long as no page fades in and while one does.
    passes: [BuiltFor<ObjectPassSettings, ObjectPass>; 2],
}

/// The ground that models stand on.
pub(crate) struct GroundBelow<'a> {
    pub tree: &'a TileTree,
    /// What it lies on.
    pub shape: Shape,
    /// Counts the changes of the heights.
    pub version: u64,
    /// True height of the ground in metres at a place of the CRS.
    pub height_m: &'a dyn Fn(DVec2) -> Option<f64>,
}

impl Objects {
    /// Slots of the texture's atlas a side, of 136 texels each: four times the pixels of 1280 x 720.
    const SLOTS_A_SIDE: u32 = 16;

    /// Brings models to the GPU and makes the coarsest pages of their texture.
    ///
    /// # Errors
    /// [`RenderError::Models`] where their textures are too large together.
    pub fn open(cx: &mut FrameContext<'_>, scene: &Arc<ModelScene>) -> Result<Self, RenderError> {
        let pack = TexturePack::new(&scene.models).map_err(RenderError::Models)?;
        let of_model = |(number, model): (usize, &Model)| {
            let materials = model.materials.iter().enumerate();
            let seen = materials.map(|(index, material)| {
                let image = pack.image_on(number, index);
                ObjectMaterial::new(material.colour, material.alpha_cutoff, image)
            });
            seen.collect::<Vec<_>>()
        };
        let materials = scene.models.iter().enumerate().flat_map(of_model).collect::<Vec<_>>();
        let device = &cx.gpu.device;
        let buffers = ObjectBuffers::new(device, &scene.models, &materials, scene.instances.len());
        cx.ledger.add(ByteCause::Mesh, buffers.sent_bytes());
        let own = Self::own_settings(cx.settings);
        let FrameContext { gpu, ledger, frame, .. } = cx;
        let mut cx = FrameContext { gpu, settings: &own, ledger, frame: *frame };
        Ok(Self {
            texture: PagedTexture::open(&mut cx, paged(pack))?,
            models: StandingModels::new(Arc::clone(scene)),
            frame: FrameGroup::new(&gpu.device),
            has_cutouts: materials.iter().any(|material| material.alpha_cutoff > 0.0),
            buffers,
            runs: Vec::new(),
            triangles: 0,
            request_pass: BuiltFor::default(),
            map: (own.strategy == Strategy::TextureMap)
                .then(|| ObjectMap::new(&gpu.device, scene.instances.len())),
            passes: Default::default(),
        })
    }

    /// The settings as the models' texture goes by them: its cache has a size of its own.
    fn own_settings(settings: &RendererSettings) -> RendererSettings {
        let side = Self::SLOTS_A_SIDE;
        RendererSettings {
            cache_columns: side,
            cache_rows: side,
            max_tiles: RendererSettings::most_tiles_of(side, side),
            ..*settings
        }
    }

    /// The settings that models are brought to the GPU for; all others as they are by default.
    pub fn made_for(settings: &RendererSettings) -> RendererSettings {
        PagedTexture::made_for(&Self::own_settings(settings))
    }

    /// Takes what the GPU has sent back since the last frame.
    pub fn receive(&mut self, frame: u64) {
        self.texture.receive(frame);
    }

    /// Chooses the pages that the view needs.
    pub fn select(&mut self, settings: &RendererSettings, view: &CameraView) {
        let settings = Self::own_settings(settings);
        if self.texture.wants_choice(&settings, view) {
            self.texture.choose(&settings, view);
        }
    }

    /// Brings what has been made of the texture to the GPU, within what the budget has left.
    pub fn stream(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        budget_bytes: u64,
    ) -> Moved {
        self.texture.stream(cx, encoder, budget_bytes)
    }

    /// Counts the changes of the picture that are not the camera's.
    pub fn version(&self) -> u64 {
        self.texture.version() + self.models.version()
    }

    /// Puts models on the ground as it is known and brings those in view to the GPU.
    pub fn set_up(
        &mut self,
        cx: &mut FrameContext<'_>,
        scene: &SceneState,
        ground: &GroundBelow<'_>,
    ) {
        self.models.stand(scene.settings.vertical_exaggeration, ground);
        let uniforms = frame_uniforms(&scene.view, ground.tree, &scene.settings, 1.0);
        cx.ledger.add(ByteCause::Uniform, self.frame.set_uniforms(&cx.gpu.queue, &uniforms));
        self.texture.set_up(cx, &Self::own_settings(&scene.settings));
        let mut rows: Vec<[Vec4; 3]> = Vec::new();
        self.runs.clear();
        self.triangles = 0;
        for (model, pose) in self.models.in_view(&scene.view, ground.shape) {
            match self.runs.last_mut() {
                Some(run) if run.model == model => run.count += 1,
                _ => self.runs.push(ModelRun { model, first: rows.len() as u32, count: 1 }),
            }
            rows.push(pose.rows());
            self.triangles += self.models.scene().models[model].triangle_count() as u64;
        }
        cx.ledger.add(ByteCause::Mesh, self.buffers.set_instances(&cx.gpu.queue, &rows));
    }

    /// Draws what pixels ask for of the texture and asks for it, unless that was done for the scene already.
    pub fn ask(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) -> bool {
        let state = self.image_state(scene);
        if !self.texture.wants_image(&state) {
            return false;
        }
        if self.map.is_some() {
            return self.ask_map(cx, encoder, state, scene);
        }
        let Self { texture, frame, buffers, runs, request_pass, .. } = self;
        let (device, anisotropy) = (&cx.gpu.device, scene.settings.anisotropy);
        texture.ask(cx, encoder, state, |pass, pages| {
            let bindings = ObjectBindings { frame, pages, objects: buffers };
            let build = || ObjectRequestPass::new(device, bindings, anisotropy);
            request_pass.get(anisotropy, build).draw(pass, bindings, runs);
        })
    }

    /// Draws the models of the scene that was set up.
    pub fn draw(
        &mut self,
        cx: &FrameContext<'_>,
        pass: &mut wgpu::RenderPass<'_>,
        target: TargetKind,
        scene: &SceneState,
    ) {
        let fades = self.texture.is_fading();
        let settings = ObjectPassSettings {
            target,
            wireframe: scene.settings.wireframe,
            anisotropy: scene.settings.anisotropy,
            fades,
            has_cutouts: self.has_cutouts,
            debug_view: scene.settings.debug_view,
        };
        let Self { frame, texture, buffers, passes, runs, .. } = self;
        let bindings = ObjectBindings { frame, pages: texture.bindings(), objects: buffers };
        let build = || ObjectPass::new(&cx.gpu.device, bindings, &settings);
        passes[usize::from(fades)].get(settings, build).draw(pass, bindings, runs);
    }

    /// After the frame's commands have been submitted.
    pub fn after_submit(&mut self, frame: u64, view: &CameraView) {
        self.texture.after_submit(frame, view);
    }

    /// Adds to the record what was drawn of the models and what pages there are.
    pub fn describe(&self, record: &mut FrameRecord) {
        let mut pages = FrameRecord { frame: record.frame, ..Default::default() };
        self.texture.describe(&mut pages);
        record.tiles_selected += pages.tiles_selected;
        record.tiles_missing += pages.tiles_missing;
        record.tiles_resident += pages.tiles_resident;
        record.triangles_drawn += self.triangles;
    }

    /// Whether pages or answers are still to come for the scene.
    pub fn is_pending(&self, scene: &SceneState) -> bool {
        self.texture.is_pending(&self.image_state(scene))
    }

    /// Has the choice made anew in the next frame, since settings have changed.
    pub fn reconsider(&mut self) {
        self.texture.reconsider();
    }

    /// Waits until every page asked for is made, at most for `patience`.
    pub fn wait(&self, patience: Duration) {
        self.texture.wait(patience);
    }

    /// Takes what went wrong with single pages since the last call, in words.
    pub fn take_failures(&mut self) -> Vec<String> {
        self.texture.take_failures()
    }

    /// The models.
    pub fn scene(&self) -> &Arc<ModelScene> {
        self.models.scene()
    }

    /// Has the texture map find the pages of a state, and asks for them.
    fn ask_map(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        state: ImageState,
        scene: &SceneState,
    ) -> bool {
        let Self { texture, frame, buffers, runs, map: Some(map), .. } = self else {
            return false;
        };
        let (gpu, mut sent) = (cx.gpu, 0);
        let has_asked = texture.ask_marked(cx, encoder, state, |encoder, over, pages| {
            let bindings = ObjectBindings { frame, pages, objects: buffers };
            sent = map.mark(gpu, encoder, scene, (bindings, runs), over);
        });
        cx.ledger.add(ByteCause::Uniform, sent);
        has_asked
    }

    /// What the latest image of the models' texture asked for.
    pub fn pages_asked(&self) -> PagesAsked {
        self.texture.asked()
    }

    /// Milliseconds that laying the models of the scene that was set up into the texture map takes, so many times
    /// over; `None` where there is no map.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn time_map(
        &mut self,
        gpu: &GpuContext,
        scene: &SceneState,
        repeats: usize,
    ) -> Result<Option<Vec<f64>>, GpuError> {
        let Self { texture, frame, buffers, runs, map: Some(map), .. } = self else {
            return Ok(None);
        };
        let bindings = ObjectBindings { frame, pages: texture.bindings(), objects: buffers };
        let over = (texture.layout(), texture.marks());
        map.time(gpu, scene, (bindings, runs), over, repeats).map(Some)
    }

    fn image_state(&self, scene: &SceneState) -> ImageState {
        let settings = Self::own_settings(&scene.settings);
        ImageState { view: scene.view, geometry: self.models.version(), settings }
    }
}

/// The packed texture as pages: made from the images in memory, so that nothing is read from disk.
fn paged(pack: TexturePack) -> PagedSource {
    let layout = pack.layout().clone();
    let present = match pack.images().is_empty() {
        true => TileSet::new(),
        false => TileSet::full(layout.coarsest_level + 1),
    };
    let load = move |tile| Ok(Loaded { tile: pack.page(tile), disk_bytes: 0 });
    PagedSource {
        layout,
        present,
        format: ColourFormat::Rgba8,
        load: Arc::new(load),
        loading: Loading { threads: 2, delay_frames: 0 },
    }
}
