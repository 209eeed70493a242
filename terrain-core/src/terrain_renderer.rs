//! The frame: the only place that knows the order in which its stages run.
//!
//! Each frame takes in what has arrived (a coordinate image drawn some frames ago, tiles from disk),
//! selects tiles, brings new ones to the GPU within the budget, displaces the mesh, asks for the next
//! coordinate image and draws. Nothing in it waits for the GPU or the disk, and nothing is done that
//! would give what the last frame already has: see `SceneState`.

mod cache_size;
mod error;
mod frame_record;
mod scene_state;
mod still_camera;

use std::sync::Arc;
use std::time::Instant;

use glam::DVec2;

use self::cache_size::check_cache_fits;
pub use self::error::RenderError;
use self::scene_state::{CoordinateState, RegionState, SceneState};
use crate::CameraView;
use crate::dataset::TileSource;
use crate::frame_setup::{frame_uniforms, mesh_radius, mesh_scale_m};
use crate::gpu::{
    CoordinateFeedback, DebugImage, DebugImagePass, DebugImageSource, FrameBindings, FrameTimer,
    GpuContext, MeshScene, Picture, PictureTarget, SceneMeshes, TerrainCache, TerrainPassSettings,
};
use crate::layer_loading::colour_format;
use crate::measure::{ByteCause, FrameLedger, FrameRecord};
use crate::renderer_settings::{DebugView, LookupMethod, RendererSettings};
use crate::resident_terrain::{Arrivals, ResidentTerrain};
use crate::selection::{Selection, SelectionConfig, TileTree, visible_region};
use crate::tiling::TileId;

/// Draws a dataset as the tile-scheduling method does.
pub struct TerrainRenderer {
    gpu: Arc<GpuContext>,
    source: Arc<dyn TileSource>,
    settings: RendererSettings,
    terrain: ResidentTerrain,

    cache: TerrainCache,
    bindings: FrameBindings,
    meshes: SceneMeshes,
    feedback: CoordinateFeedback,
    picture: Picture,
    timer: FrameTimer,
    debug_images: Option<DebugImagePass>,

    ledger: FrameLedger,
    frame: u64,
    region: Option<RegionState>,
    selection: Selection,
    /// What the latest picture, displacement and coordinate image were made of.
    drawn: Option<SceneState>,
    displaced: Option<SceneState>,
    coordinates: Option<CoordinateState>,
    /// The view and the region's frame, where there was one, the latest selection was made for.
    selected: Option<(CameraView, Option<u64>)>,
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
        let settings = settings.for_adapter(gpu.is_software());
        let tree = TileTree::of_source(&*source);
        if !tree.heights.present.contains(TileId::ROOT) {
            return Err(RenderError::NoHeights);
        }
        let slots = (settings.cache_columns, settings.cache_rows);
        check_cache_fits(&gpu, &tree, slots)?;
        let format = colour_format(&*source, gpu.has_block_compression());
        let mut ledger = FrameLedger::default();
        let terrain = ResidentTerrain::open(&source, tree, format, slots, &mut ledger)?;
        let device = &gpu.device;
        let cache = TerrainCache::new(&gpu, &terrain.tree, format, slots);
        let bindings = FrameBindings::new(device, &cache.table, &cache.heights, &cache.colours);
        let renderer = Self {
            meshes: SceneMeshes::new(device, &bindings, settings.lookup == LookupMethod::Linear),
            feedback: CoordinateFeedback::new(device, &bindings, &settings),
            timer: FrameTimer::new(device, &gpu.queue),
            picture: Picture::default(),
            gpu,
            source,
            settings,
            terrain,
            cache,
            bindings,
            debug_images: None,
            ledger,
            frame: 0,
            region: None,
            selection: Selection { tiles: vec![TileId::ROOT], ..Default::default() },
            drawn: None,
            displaced: None,
            coordinates: None,
            selected: None,
        };
        renderer.gpu.check()?;
        Ok(renderer)
    }

    /// The settings in force.
    pub fn settings(&self) -> &RendererSettings {
        &self.settings
    }

    /// Changes the settings from the next frame on; a change of the caches' size or of the lookup
    /// empties the caches.
    ///
    /// # Errors
    /// [`RenderError`] where the caches cannot be made anew; the old settings then stay.
    pub fn set_settings(&mut self, settings: RendererSettings) -> Result<(), RenderError> {
        let settings = settings.for_adapter(self.gpu.is_software());
        let rebuilt = |s: &RendererSettings| {
            let slots = (s.cache_columns, s.cache_rows);
            (slots, s.coordinate_size_px, s.readback_latency_frames, s.lookup)
        };
        if rebuilt(&settings) != rebuilt(&self.settings) {
            let (gpu, source) = (Arc::clone(&self.gpu), Arc::clone(&self.source));
            let mut renewed = Self::new(gpu, source, settings)?;
            renewed.frame = self.frame;
            // What has moved since the last frame's record and what opening anew moved both count.
            renewed.ledger.add_all(&self.ledger.totals());
            *self = renewed;
        } else if settings != self.settings {
            self.settings = settings;
            self.selected = None;
            if let Some(region) = &mut self.region {
                (region.images, region.images_of_all) = (0, 0);
            }
        }
        Ok(())
    }

    /// What is drawn.
    pub fn tree(&self) -> &TileTree {
        &self.terrain.tree
    }

    /// The tiles the last frame was drawn with.
    pub fn selection(&self) -> &Selection {
        &self.selection
    }

    /// Takes what went wrong with single tiles since the last call, in words. A coarser tile shows
    /// in their place.
    pub fn take_failures(&mut self) -> Vec<String> {
        self.terrain.take_failures()
    }

    /// Height of the ground in metres above the datum, without exaggeration, from the finest
    /// resident tile that has data there. `None` outside the data.
    pub fn ground_height_m(&self, point: DVec2) -> Option<f64> {
        self.terrain.ground_height_m(point)
    }

    /// Whether a frame for this view would show or do anything the last one did not. A window need
    /// not draw where it would not.
    pub fn needs_frame(&self, view: &CameraView) -> bool {
        self.drawn != Some(self.scene(view)) || self.is_pending(view)
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
        let heights = self.cache.heights.height_mip(0);
        let colours = self.cache.colours.mip(0);
        let range = self.source.manifest().heights.range;
        let eye_up_m = self.drawn.map_or(1.0, |scene| self.clearance_m(&scene)) as f32;
        let (texture, range_m) = match image {
            DebugImage::Coordinates => (&self.feedback.pass.target_view, [0.0, eye_up_m]),
            DebugImage::HeightCache => (&heights, [range.min_m, range.max_m]),
            DebugImage::ColourCache => (&colours, [0.0, 1.0]),
        };
        let source = DebugImageSource { image, texture, range_m };
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
        self.receive_region();
        let select_ms = self.select(view);
        let mut encoder = self.encoder();
        let measuring = target.is_some() && self.timer.begin();
        self.timer.stamp_beginning(&mut encoder, measuring);
        let arrivals = self.stream(&mut encoder);
        let moved = (arrivals.count() as u64, arrivals.evicted() as u64);
        self.terrain.keep(arrivals.heights);
        let scene = self.scene(view);
        self.set_up(&scene);
        let asks = self.wants_coordinates(&scene) && self.feedback.is_free();
        self.displace(&mut encoder, &scene, asks);
        let ticket = if asks { self.ask_coordinates(&mut encoder, &scene) } else { None };
        if let Some((target, format)) = target {
            self.draw(&mut encoder, &scene, target, format, measuring);
        }
        self.timer.resolve(&mut encoder, measuring);
        self.gpu.queue.submit([encoder.finish()]);
        self.timer.after_submit();
        let asked = ticket.is_some();
        if let Some(buffer) = ticket {
            self.feedback.begin(buffer, self.frame, *view);
        }
        let mut record = self.record(moved, asked);
        record.select_ms = select_ms;
        record.cpu_ms = started.elapsed().as_secs_f64() * 1.0e3;
        record.frame_ms = record.cpu_ms;
        self.frame += 1;
        Ok(record)
    }

    fn encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device.create_command_encoder(&Default::default())
    }

    /// Takes the newest coordinate image that has come back, if any.
    fn receive_region(&mut self) {
        // A failure of the device shows in the next check.
        let _ = self.gpu.device.poll(wgpu::PollType::Poll);
        if let Some((image, count)) = self.feedback.take_newest(self.frame) {
            self.ledger.add(ByteCause::Readback, count * self.feedback.image_bytes());
            let region = visible_region(&image);
            let found = RegionState {
                region,
                frame: image.frame,
                view: image.view,
                images: 1,
                images_of_all: u32::from(self.terrain.missing() == 0),
            };
            self.region = Some(RegionState::after(self.region.as_ref(), found));
        }
    }

    /// Selects the tiles of the view, by the latest region where the strategy needs one; returns the
    /// milliseconds it took.
    fn select(&mut self, view: &CameraView) -> f64 {
        let state = self.region_in_use();
        let is_ready = state.is_some() || !self.strategy().needs_region();
        if !is_ready || !self.wants_selection(view) {
            return 0.0;
        }
        let started = Instant::now();
        let config = SelectionConfig {
            max_tiles: self.settings.max_tiles,
            texel_px: self.settings.texel_px,
            vertical_exaggeration: self.settings.vertical_exaggeration,
        };
        let region = state.and_then(|state| state.region.as_ref());
        let region_frame = state.map(|state| state.frame);
        self.selection = self.strategy().select(&self.terrain.tree, region, view, &config);
        self.selected = Some((*view, region_frame));
        started.elapsed().as_secs_f64() * 1.0e3
    }

    /// Brings what has been loaded to the GPU within the budget and asks for what is missing.
    fn stream(&mut self, encoder: &mut wgpu::CommandEncoder) -> Arrivals {
        let budget = self.settings.upload_budget_bytes;
        let ledger = &mut self.ledger;
        let arrivals = self.terrain.stream(&self.selection, budget, self.frame, ledger);
        let tree = &self.terrain.tree;
        let sent = self.cache.upload_heights(&self.gpu, encoder, tree, &arrivals.heights);
        ledger.add(ByteCause::Dem, sent);
        let sent = self.cache.upload_colours(&self.gpu, encoder, &arrivals.colours);
        ledger.add(ByteCause::Dom, sent);
        arrivals
    }

    /// Brings tables, uniforms and the visible parts of the meshes to the GPU for the scene.
    fn set_up(&mut self, scene: &SceneState) {
        let (view, terrain) = (&scene.view, &self.terrain);
        let eye = view.eye.truncate();
        let (heights, colours) = (&terrain.height_table, terrain.colour_table.as_ref());
        let tables = self.cache.update_tables(&self.gpu, &terrain.tree, eye, heights, colours);
        self.ledger.add(ByteCause::Table, tables.sent_bytes);
        if tables.grew {
            self.bindings.rebind(&self.gpu.device, &self.cache.table);
        }
        let scale_m = mesh_scale_m(&terrain.tree, self.clearance_m(scene));
        let mut uniforms = frame_uniforms(view, &terrain.tree, &scene.settings, scale_m);
        [uniforms.height_table, uniforms.colour_table] = tables.ranges;
        uniforms.height_uv_per_texel = self.cache.heights.grid.uv_per_texel();
        uniforms.colour_uv_per_texel = self.cache.colours.grid.uv_per_texel();
        let sent = self.bindings.set_uniforms(&self.gpu.queue, &uniforms);
        self.ledger.add(ByteCause::Uniform, sent);
        let mesh_scene = MeshScene {
            view,
            scale_m,
            radius: mesh_radius(&terrain.tree, eye, scale_m),
            height_range_m: terrain.height_range_m(scene.settings.vertical_exaggeration),
            data_extent: &terrain.tree.data_extent,
            triangle_px: scene.settings.triangle_px,
            has_coordinates: self.strategy().needs_region(),
        };
        let (sent, rebuilt) = self.meshes.set_up(&self.gpu.device, &self.gpu.queue, &mesh_scene);
        self.ledger.add(ByteCause::Mesh, sent);
        if rebuilt {
            self.displaced = None;
        }
    }

    /// Displaces what is visible of the meshes, unless it is displaced already.
    fn displace(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
        coordinates: bool,
    ) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("displace"),
            timestamp_writes: None,
        });
        let picture = self.displaced != Some(*scene);
        self.meshes.displace(&mut pass, &self.bindings, [picture, coordinates]);
        self.displaced = Some(*scene);
    }

    /// Draws the coordinate pass and asks for its image.
    fn ask_coordinates(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) -> Option<wgpu::Buffer> {
        let mesh = self.meshes.coordinates()?;
        let buffer = self.feedback.record(encoder, &self.bindings, mesh)?;
        self.coordinates = Some(self.coordinate_state(scene));
        Some(buffer)
    }

    /// Draws terrain and sky.
    fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
        target: &wgpu::TextureView,
        format: wgpu::TextureFormat,
        measuring: bool,
    ) {
        let settings = TerrainPassSettings {
            target: format,
            samples: Picture::samples(&self.gpu.device, format, scene.settings.anti_aliasing),
            linear_lookup: scene.settings.lookup == LookupMethod::Linear,
            wireframe: scene.settings.wireframe,
            has_colours: self.terrain.has_colours(),
            has_voids: self.source.manifest().heights.has_voids,
            anisotropy: scene.settings.anisotropy,
            sorts_triangles: scene.settings.debug_view == DebugView::Off,
            debug_view: scene.settings.debug_view,
        };
        let target = PictureTarget {
            view: target,
            size_px: scene.view.viewport_px,
            timestamps: self.timer.last_pass(measuring),
        };
        let mesh = self.meshes.picture();
        self.picture.record(&self.gpu.device, encoder, &self.bindings, mesh, settings, target);
        self.drawn = Some(*scene);
    }
}
