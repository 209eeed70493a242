//! The frame: the only place that knows the order in which its stages run.
//!
//! Each frame takes in what has arrived (a coordinate image drawn some frames ago, tiles from disk),
//! selects tiles, brings new ones to the GPU within the budget, displaces the mesh, asks for the next
//! coordinate image and draws. Nothing in it waits for the GPU or the disk, and nothing is done that
//! would give what the last frame already has: see `SceneState`.

mod error;
mod frame_record;
mod map_timing;
mod models;
mod still_camera;

use std::sync::Arc;
use std::time::Instant;

use glam::DVec2;

pub use self::error::RenderError;
use self::frame_record::StageClock;
use crate::CameraView;
use crate::dataset::TileSource;
use crate::gpu::{
    DebugImage, DebugImagePass, DebugImageSource, FrameTimer, GpuContext, Picture, PictureTarget,
};
use crate::measure::{FrameLedger, FrameRecord};
use crate::method::{
    FrameContext, MethodKey, Moved, Objects, SceneState, TerrainMethod, open_method,
};
use crate::renderer_settings::RendererSettings;
use crate::residency::page_table::PagesAsked;
use crate::selection::{Selection, TileTree};
use crate::surface::tin::TinGround;
use crate::tiling::TileId;

/// Draws a dataset, by the method that carries the settings' strategy out.
pub struct TerrainRenderer {
    gpu: Arc<GpuContext>,
    source: Arc<dyn TileSource>,
    settings: RendererSettings,
    method: Box<dyn TerrainMethod>,
    /// The ground, where it is a TIN instead of the source's heights.
    tin: Option<Arc<TinGround>>,
    /// Models beside the ground, where there are any.
    objects: Option<Objects>,
    picture: Picture,
    timer: FrameTimer,
    debug_images: Option<DebugImagePass>,
    ledger: FrameLedger,
    frame: u64,
    /// What the latest picture was made of.
    drawn: Option<SceneState>,
    /// The version of the models that it shows.
    drawn_objects: u64,
}

impl TerrainRenderer {
    /// A renderer of the source. Loads level 0 of each layer before it returns, so that from the
    /// first frame on there is a tile for every point.
    ///
    /// # Errors
    /// [`RenderError`] where level 0 cannot be loaded or the GPU refuses.
    pub fn new(
        gpu: Arc<GpuContext>,
        source: Arc<dyn TileSource>,
        settings: RendererSettings,
    ) -> Result<Self, RenderError> {
        Self::open(gpu, source, settings, None)
    }

    /// [`Self::new`] with the ground of a TIN, if there is one.
    fn open(
        gpu: Arc<GpuContext>,
        source: Arc<dyn TileSource>,
        settings: RendererSettings,
        tin: Option<Arc<TinGround>>,
    ) -> Result<Self, RenderError> {
        let settings = settings.for_adapter(gpu.is_software());
        let tree = TileTree::of_source(&*source);
        if !tree.heights.present.contains(TileId::ROOT) {
            return Err(RenderError::NoHeights);
        }
        let mut ledger = FrameLedger::default();
        let mut cx = FrameContext { gpu: &gpu, settings: &settings, ledger: &mut ledger, frame: 0 };
        let method = open_method(&mut cx, &source, tree, tin.as_ref())?;
        gpu.check()?;
        Ok(Self {
            timer: FrameTimer::new(&gpu.device, &gpu.queue),
            picture: Picture::default(),
            gpu,
            source,
            settings,
            method,
            tin,
            objects: None,
            debug_images: None,
            ledger,
            frame: 0,
            drawn: None,
            drawn_objects: 0,
        })
    }

    /// The settings in force.
    pub fn settings(&self) -> &RendererSettings {
        &self.settings
    }

    /// Changes the settings from the next frame on. A change of the method, of its caches' size or of
    /// the lookup begins with empty caches.
    ///
    /// # Errors
    /// [`RenderError`] where the caches cannot be made anew; the old settings then stay.
    pub fn set_settings(&mut self, settings: RendererSettings) -> Result<(), RenderError> {
        let settings = settings.for_adapter(self.gpu.is_software());
        let key = |settings| MethodKey::of(settings, self.tin.as_ref());
        if key(&settings) != key(&self.settings) {
            self.renew(settings, self.tin.clone())?;
        } else if settings != self.settings {
            let before = std::mem::replace(&mut self.settings, settings);
            self.method.reconsider();
            self.reconsider_models(&before)?;
        }
        Ok(())
    }

    /// Begins anew with other settings or other ground; models stay.
    fn renew(
        &mut self,
        settings: RendererSettings,
        tin: Option<Arc<TinGround>>,
    ) -> Result<(), RenderError> {
        let (gpu, source) = (Arc::clone(&self.gpu), Arc::clone(&self.source));
        let mut renewed = Self::open(gpu, source, settings, tin)?;
        renewed.frame = self.frame;
        if let Some(scene) = self.models() {
            renewed.set_models(Some(Arc::clone(scene)))?;
        }
        // What has moved since the last frame's record and what opening anew moved both count.
        renewed.ledger.add_all(&self.ledger.totals());
        *self = renewed;
        Ok(())
    }

    /// What is drawn.
    pub fn tree(&self) -> &TileTree {
        self.method.tree()
    }

    /// The tiles the last frame was drawn with.
    pub fn selection(&self) -> &Selection {
        self.method.selection()
    }

    /// The pages of the imagery's virtual texture that what came back last asked for, and how fine it wanted
    /// them; `None` with strategies that have no such texture.
    pub fn pages_asked(&self) -> Option<PagesAsked> {
        self.method.pages_asked()
    }

    /// The same of the texture of models; `None` without any.
    pub fn model_pages_asked(&self) -> Option<PagesAsked> {
        self.objects.as_ref().map(Objects::pages_asked)
    }

    /// Takes what went wrong with single tiles since the last call, in words. A coarser tile shows
    /// in their place.
    pub fn take_failures(&mut self) -> Vec<String> {
        let mut failures = self.method.take_failures();
        failures.extend(self.objects.as_mut().map(Objects::take_failures).unwrap_or_default());
        failures
    }

    /// Height of the ground in metres above the datum, without exaggeration, as well as it is known in
    /// memory. `None` outside the data.
    pub fn ground_height_m(&self, point: DVec2) -> Option<f64> {
        self.method.ground_height_m(point)
    }

    /// Whether a frame for this view would show or do anything the last one did not. A window need
    /// not draw where it would not.
    pub fn needs_frame(&self, view: &CameraView) -> bool {
        let scene = self.scene(view);
        let is_drawn = self.drawn == Some(scene) && self.drawn_objects == self.objects_version();
        !is_drawn || self.is_pending(&scene)
    }

    /// Draws one frame into `target`, whose size must be the view's.
    ///
    /// Never waits for the GPU or the disk. Of a still camera with nothing pending, only the picture
    /// itself is drawn again.
    ///
    /// # Errors
    /// [`RenderError::Camera`] where the view is none, [`RenderError::Gpu`] where the device has failed.
    pub fn render(
        &mut self,
        view: &CameraView,
        target: &wgpu::TextureView,
        format: wgpu::TextureFormat,
    ) -> Result<FrameRecord, RenderError> {
        self.frame(view, Some((target, format)))
    }

    /// Draws frames of a still camera until nothing is missing, then the picture into `target`.
    /// Waits for disk and GPU. The record sums up all of them.
    ///
    /// # Errors
    /// [`RenderError::Camera`] where the view is none, [`RenderError::Gpu`] where the device has failed.
    pub fn render_settled(
        &mut self,
        view: &CameraView,
        target: &wgpu::TextureView,
        format: wgpu::TextureFormat,
    ) -> Result<FrameRecord, RenderError> {
        let mut sum = self.settle(view)?;
        let last = self.render(view, target, format)?;
        sum.add_work_of(&last);
        Ok(sum)
    }

    /// Draws one of the renderer's own textures into `target`, which has
    /// [`DEBUG_IMAGE_FORMAT`](crate::gpu::DEBUG_IMAGE_FORMAT) and this size, for people to look at.
    /// No part of a frame: nothing is counted.
    pub fn draw_debug_image(
        &mut self,
        image: DebugImage,
        target: &wgpu::TextureView,
        size_px: [u32; 2],
    ) {
        let pass = match self.debug_images.take() {
            Some(pass) => pass,
            None => DebugImagePass::new(&self.gpu.device),
        };
        let range = self.source.manifest().heights.range;
        let range_m = match image {
            DebugImage::Coordinates => [0.0, self.eye_above_ground_m() as f32],
            DebugImage::HeightCache => [range.min_m, range.max_m],
            DebugImage::ColourCache => [0.0, 1.0],
        };
        let texture = self.method.debug_texture(image);
        let source = DebugImageSource { image, texture: texture.as_ref(), range_m };
        let mut encoder = self.encoder();
        pass.record(&self.gpu.device, &mut encoder, &source, (target, size_px));
        self.gpu.queue.submit([encoder.finish()]);
        self.debug_images = Some(pass);
    }

    /// One frame, with or without a picture.
    fn frame(
        &mut self,
        view: &CameraView,
        target: Option<(&wgpu::TextureView, wgpu::TextureFormat)>,
    ) -> Result<FrameRecord, RenderError> {
        let started = Instant::now();
        view.check()?;
        self.gpu.check()?;
        // A failure of the device shows in the next check.
        let _ = self.gpu.device.poll(wgpu::PollType::Poll);
        let mut encoder = self.encoder();
        let measuring = target.is_some() && self.timer.begin();
        self.timer.stamp_beginning(&mut encoder, measuring);
        let mut record = FrameRecord::default();
        let mut stage = StageClock::new();
        let (method, mut cx) = self.method_and_context();
        method.receive(&mut cx);
        self.receive_for_models();
        record.receive_ms = stage.ms();
        let (method, mut cx) = self.method_and_context();
        record.select_ms = method.select(&mut cx, view);
        self.select_for_models(view);
        stage.ms();
        let moved = self.stream(&mut encoder, view);
        record.stream_ms = stage.ms();
        let scene = self.scene(view);
        self.set_up(&mut encoder, &scene);
        record.set_up_ms = stage.ms();
        let (method, mut cx) = self.method_and_context();
        record.coordinate_pass_drawn = method.ask(&mut cx, &mut encoder, &scene);
        self.ask_for_models(&mut encoder, &scene);
        if let Some((target, format)) = target {
            self.draw(&mut encoder, &scene, target, format, measuring);
        }
        record.draw_ms = stage.ms();
        self.timer.resolve(&mut encoder, measuring);
        self.gpu.queue.submit([encoder.finish()]);
        self.timer.after_submit();
        self.method.after_submit(self.frame, view);
        if let Some(objects) = &mut self.objects {
            objects.after_submit(self.frame, view);
        }
        record.submit_ms = stage.ms();
        self.describe(&mut record, moved);
        record.cpu_ms = started.elapsed().as_secs_f64() * 1.0e3;
        record.frame_ms = record.cpu_ms;
        self.frame += 1;
        Ok(record)
    }

    /// Brings what has been loaded to the GPU: the ground first, models with what it leaves of the budget.
    fn stream(&mut self, encoder: &mut wgpu::CommandEncoder, view: &CameraView) -> Moved {
        let before = self.ledger.totals();
        let (method, mut cx) = self.method_and_context();
        let moved = method.stream(&mut cx, encoder, view);
        self.stream_models(encoder, moved, &before)
    }

    /// Brings the GPU to where the scene can be drawn.
    fn set_up(&mut self, encoder: &mut wgpu::CommandEncoder, scene: &SceneState) {
        let (method, mut cx) = self.method_and_context();
        method.set_up(&mut cx, encoder, scene);
        self.set_up_models(scene);
    }

    /// Whether anything is still to come for the scene.
    fn is_pending(&self, scene: &SceneState) -> bool {
        let objects = self.objects.as_ref();
        self.method.is_pending(scene) || objects.is_some_and(|objects| objects.is_pending(scene))
    }

    /// Draws terrain, models and sky.
    fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
        target: &wgpu::TextureView,
        format: wgpu::TextureFormat,
        measuring: bool,
    ) {
        let Self { gpu, settings, ledger, frame, method, objects, picture, timer, .. } = self;
        let kind = Picture::target_kind(&gpu.device, format, scene.settings.anti_aliasing);
        let target = PictureTarget {
            view: target,
            size_px: scene.view.viewport_px,
            timestamps: timer.last_pass(measuring),
        };
        let cx = FrameContext { gpu, settings, ledger, frame: *frame };
        let has_own_sky = method.draws_sky();
        picture.record(&gpu.device, encoder, kind, target, |pass| {
            let frame = method.draw(&cx, pass, kind, scene);
            if let Some(objects) = objects {
                objects.draw(&cx, pass, kind, scene);
            }
            (!has_own_sky).then_some(frame)
        });
        self.drawn = Some(*scene);
        self.drawn_objects = self.objects_version();
    }

    fn method_and_context(&mut self) -> (&mut dyn TerrainMethod, FrameContext<'_>) {
        let Self { gpu, settings, ledger, frame, method, .. } = self;
        (&mut **method, FrameContext { gpu, settings, ledger, frame: *frame })
    }

    fn encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device.create_command_encoder(&Default::default())
    }

    fn scene(&self, view: &CameraView) -> SceneState {
        let data_version = self.method.data_version();
        SceneState { view: *view, data_version, settings: self.settings }
    }

    /// Distance in metres of the last picture's eye to the ground below it, or to level 0's lowest
    /// where it is not over the data.
    fn eye_above_ground_m(&self) -> f64 {
        let Some(scene) = self.drawn else { return 1.0 };
        let eye = scene.view.eye;
        let lowest_m = f64::from(self.source.manifest().heights.range.min_m);
        let ground_m = self.method.ground_height_m(eye.truncate()).unwrap_or(lowest_m);
        (eye.z - ground_m * scene.settings.vertical_exaggeration).abs().max(1.0)
    }
}
