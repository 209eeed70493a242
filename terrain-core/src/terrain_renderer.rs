//! The frame: the only place that knows the order in which its stages run.
//!
//! Each frame takes in what has arrived (a coordinate image drawn some frames ago, tiles from disk),
//! selects tiles, brings new ones to the GPU within the budget, displaces the mesh, asks for the next
//! coordinate image and draws. Nothing in it waits for the GPU or the disk, and nothing is done that
//! would give what the last frame already has: see `FrameNeeds`.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::{DVec2, DVec3, dvec3};

use crate::CameraView;
use crate::dataset::{ColourTile, HeightTile, LoadError, TileSource};
use crate::frame_setup::{frame_uniforms, mesh_scale_m, reach_m};
use crate::gpu::{
    CoordinateFeedback, CoordinatePass, DEPTH_FORMAT, DebugImage, DebugImagePass, DebugImageSource,
    DisplacePass, DisplacedMesh, FrameBindings, FrameTimer, GpuContext, GpuError, SkyPass,
    SortTrianglesPass, TerrainCache, TerrainPass, TerrainPassSettings, depth_attachment,
    read_texture,
};
use crate::layer_loading::{LayerStreams, colour_format, load_colours, open_streams};
use crate::measure::{ByteCause, FrameLedger, FrameRecord};
use crate::renderer_settings::{LookupMethod, RendererSettings};
use crate::residency::{LayerStream, OffsetTable};
use crate::selection::{
    Selection, SelectionConfig, TileTree, VisibleRegion, select, visible_region,
};
use crate::surface::CircularMeshSettings;
use crate::tiling::TileId;

/// Why a frame could not be drawn, or a renderer not be made.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The GPU.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A tile without which nothing can be drawn.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The system gives no threads for loading.
    #[error("cannot start the threads that load tiles: {0}")]
    Threads(#[from] std::io::Error),
    /// The dataset has no level 0.
    #[error("the dataset holds no heights: its coarsest tile is missing; prepare it again")]
    NoHeights,
}

/// The coarse mesh of the coordinate pass: how much larger its triangles are.
const COORDINATE_TRIANGLE_FACTOR: f64 = 4.0;

/// Draws a dataset as the tile-scheduling method does.
pub struct TerrainRenderer {
    gpu: Arc<GpuContext>,
    source: Arc<dyn TileSource>,
    tree: TileTree,
    settings: RendererSettings,

    heights: LayerStream<HeightTile>,
    colours: Option<LayerStream<ColourTile>>,
    /// The resident height tiles, for questions about the ground.
    resident_heights: HashMap<TileId, HeightTile>,
    height_table: OffsetTable,
    colour_table: Option<OffsetTable>,

    cache: TerrainCache,
    bindings: FrameBindings,
    displace: DisplacePass,
    sort_triangles: SortTrianglesPass,
    feedback: CoordinateFeedback,
    timer: FrameTimer,
    mesh: Option<DisplacedMesh>,
    coordinate_mesh: Option<DisplacedMesh>,
    picture: Option<PicturePasses>,
    depth: Option<DepthBuffer>,
    debug_images: Option<DebugImagePass>,

    ledger: FrameLedger,
    frame: u64,
    region: Option<RegionState>,
    selection: Selection,
    /// Counts changes of what is resident.
    data_version: u64,
    drawn: Option<SceneState>,
    displaced: Option<SceneState>,
    coordinates: Option<SceneState>,
    selected: Option<(CameraView, u64)>,
    failures: Vec<String>,
}

/// The latest region that came back.
struct RegionState {
    /// `None`: the view was empty.
    region: Option<VisibleRegion>,
    frame: u64,
}

/// What a picture depends on: equal states give equal pictures.
#[derive(Clone, Copy, PartialEq)]
struct SceneState {
    view: CameraView,
    data_version: u64,
    settings: RendererSettings,
}

/// The passes of the picture for one target format.
struct PicturePasses {
    settings: TerrainPassSettings,
    terrain: TerrainPass,
    sky: SkyPass,
}

/// The depth buffer of the picture.
struct DepthBuffer {
    view: wgpu::TextureView,
    size_px: [u32; 2],
}

/// What one frame has brought to the GPU.
#[derive(Default)]
struct Moved {
    new: u64,
    evicted: u64,
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
        let settings = settings.checked();
        let tree = TileTree::of_source(&*source);
        if !tree.heights.present.contains(TileId::ROOT) {
            return Err(RenderError::NoHeights);
        }
        let slots = (settings.cache_columns, settings.cache_rows);
        let format = colour_format(&*source, gpu.has_block_compression());
        let LayerStreams { heights, colours } = open_streams(&source, format, slots)?;
        let cache = TerrainCache::new(&gpu, &tree, format, slots);
        let bindings =
            FrameBindings::new(&gpu.device, &cache.table, &cache.heights, &cache.colours);
        let linear = settings.lookup == LookupMethod::Linear;
        let displace = DisplacePass::new(&gpu.device, &bindings, linear);
        let sort_triangles = SortTrianglesPass::new(&gpu.device);
        let feedback = CoordinateFeedback::new(&gpu.device, &bindings, settings.coordinate_size_px);
        let timer = FrameTimer::new(&gpu.device, &gpu.queue);
        let mut renderer = Self {
            gpu,
            source,
            tree,
            settings,
            heights,
            colours,
            resident_heights: HashMap::new(),
            height_table: OffsetTable::build([]),
            colour_table: None,
            cache,
            bindings,
            displace,
            sort_triangles,
            feedback,
            timer,
            mesh: None,
            coordinate_mesh: None,
            picture: None,
            depth: None,
            debug_images: None,
            ledger: FrameLedger::default(),
            frame: 0,
            region: None,
            selection: Selection { tiles: vec![TileId::ROOT], ..Default::default() },
            data_version: 0,
            drawn: None,
            displaced: None,
            coordinates: None,
            selected: None,
            failures: Vec::new(),
        };
        renderer.load_root()?;
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
        let settings = settings.checked();
        let rebuilt =
            |s: &RendererSettings| (s.cache_columns, s.cache_rows, s.coordinate_size_px, s.lookup);
        if rebuilt(&settings) != rebuilt(&self.settings) {
            let (gpu, source) = (Arc::clone(&self.gpu), Arc::clone(&self.source));
            let (frame, ledger) = (self.frame, std::mem::take(&mut self.ledger));
            *self = Self::new(gpu, source, settings)?;
            self.frame = frame;
            self.ledger = ledger;
        } else if settings != self.settings {
            self.settings = settings;
            self.selected = None;
        }
        Ok(())
    }

    /// What is drawn.
    pub fn tree(&self) -> &TileTree {
        &self.tree
    }

    /// The tiles the last frame was drawn with.
    pub fn selection(&self) -> &Selection {
        &self.selection
    }

    /// Takes what went wrong with single tiles since the last call, in words. A coarser tile shows
    /// in their place.
    pub fn take_failures(&mut self) -> Vec<String> {
        std::mem::take(&mut self.failures)
    }

    /// Height of the ground in metres above the datum, without exaggeration, from the finest
    /// resident tile that has data there. `None` outside the data.
    pub fn ground_height_m(&self, point: DVec2) -> Option<f64> {
        let layout = &self.tree.heights.layout;
        (0..=layout.finest_level()).rev().find_map(|level| {
            let tile = self.tree.scheme.tile_at(level, point)?;
            self.resident_heights.get(&tile)?.height_at_m(&self.tree.scheme, layout, point)
        })
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
    /// [`RenderError::Gpu`] where the device has failed.
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
    /// [`RenderError::Gpu`] where the device has failed.
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

    /// Where on the ground each pixel of the view looks, after drawing until nothing is missing:
    /// x, y in the dataset's CRS and the height drawn (exaggeration included), row by row from the
    /// top left, NaN where there is sky. From the same mesh and tiles as the picture.
    ///
    /// # Errors
    /// [`RenderError::Gpu`] where the device has failed.
    pub fn ground_coordinates(&mut self, view: &CameraView) -> Result<Vec<[f64; 3]>, RenderError> {
        self.settle(view)?;
        let mut encoder = self.encoder();
        let scene = self.scene(view);
        self.set_up(&scene);
        self.displace(&mut encoder, &scene, false, false);
        let format = CoordinatePass::FULL_FORMAT;
        let pass = CoordinatePass::new(&self.gpu.device, &self.bindings, format, view.viewport_px);
        if let Some(mesh) = &self.mesh {
            pass.record(&mut encoder, &self.bindings, mesh.parts(), mesh.visible());
        }
        self.gpu.queue.submit([encoder.finish()]);
        let bytes = read_texture(&self.gpu, &pass.target, view.viewport_px, 16)?;
        let world = |[x, y, z, ground]: [f32; 4]| {
            let offset = dvec3(f64::from(x), f64::from(y), f64::from(z));
            let point = if ground == 0.0 { DVec3::NAN } else { view.eye + offset };
            point.to_array()
        };
        Ok(bytemuck::pod_collect_to_vec::<u8, [f32; 4]>(&bytes).into_iter().map(world).collect())
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
        let eye_up_m = self.drawn.map_or(1.0, |scene| self.clearance_m(&scene.view)) as f32;
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

    /// Draws frames without a picture until nothing is missing.
    fn settle(&mut self, view: &CameraView) -> Result<FrameRecord, RenderError> {
        // Each round brings at least one tile or image; a scene needs a few dozen.
        const MOST_FRAMES: u32 = 2_000;
        const PATIENCE: Duration = Duration::from_millis(50);
        let mut sum = self.frame(view, None)?;
        for _ in 0..MOST_FRAMES {
            if !self.is_pending(view) {
                break;
            }
            if self.feedback.is_waiting() {
                // A failure of the wait shows in the next frame's check of the device.
                let _ = self.gpu.device.poll(wgpu::PollType::wait_indefinitely());
            } else {
                self.heights.wait(PATIENCE);
                if let Some(colours) = &self.colours {
                    colours.wait(PATIENCE);
                }
            }
            let record = self.frame(view, None)?;
            sum.add_work_of(&record);
        }
        Ok(sum)
    }

    /// One frame, with or without a picture.
    fn frame(
        &mut self,
        view: &CameraView,
        target: Option<(&wgpu::TextureView, wgpu::TextureFormat)>,
    ) -> Result<FrameRecord, RenderError> {
        let started = Instant::now();
        self.gpu.check()?;
        self.receive_region();
        let select_ms = self.select(view);
        let mut encoder = self.encoder();
        let moved = self.stream(&mut encoder);
        let scene = self.scene(view);
        let measuring = target.is_some() && self.timer.begin();
        self.set_up(&scene);
        let asks = self.wants_coordinates(&scene) && self.feedback.is_free();
        self.displace(&mut encoder, &scene, asks, measuring);
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
        let mut record = self.record(&moved, asked);
        record.select_ms = select_ms;
        record.cpu_ms = started.elapsed().as_secs_f64() * 1.0e3;
        record.frame_ms = record.cpu_ms;
        self.frame += 1;
        Ok(record)
    }

    fn encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device.create_command_encoder(&Default::default())
    }

    fn scene(&self, view: &CameraView) -> SceneState {
        SceneState { view: *view, data_version: self.data_version, settings: self.settings }
    }

    /// Whether tiles or a coordinate image are still to come for this view.
    fn is_pending(&self, view: &CameraView) -> bool {
        let missing =
            self.heights.missing() + self.colours.as_ref().map_or(0, |colours| colours.missing());
        missing > 0
            || self.feedback.is_waiting()
            || self.wants_coordinates(&self.scene(view))
            || self.wants_selection(view)
    }

    /// Whether the scene's coordinates have not been asked for yet.
    fn wants_coordinates(&self, scene: &SceneState) -> bool {
        !self.settings.freeze_selection && self.coordinates != Some(*scene)
    }

    fn wants_selection(&self, view: &CameraView) -> bool {
        let region_frame = self.region.as_ref().map_or(0, |state| state.frame);
        !self.settings.freeze_selection && self.selected != Some((*view, region_frame))
    }

    /// Takes the newest coordinate image that has come back, if any.
    fn receive_region(&mut self) {
        // A failure of the device shows in the next check.
        let _ = self.gpu.device.poll(wgpu::PollType::Poll);
        if let Some((image, count)) = self.feedback.take_newest() {
            self.ledger.add(ByteCause::Readback, count * self.feedback.image_bytes());
            let region = visible_region(&image);
            self.region = Some(RegionState { region, frame: image.frame });
        }
    }

    /// Selects the tiles of the view by the latest region; returns the milliseconds it took.
    fn select(&mut self, view: &CameraView) -> f64 {
        let Some(state) = self.region.as_ref().filter(|_| self.wants_selection(view)) else {
            return 0.0;
        };
        let started = Instant::now();
        let config = SelectionConfig {
            max_tiles: self.settings.max_tiles,
            texel_px: self.settings.texel_px,
            vertical_exaggeration: self.settings.vertical_exaggeration,
        };
        self.selection = select(&self.tree, state.region.as_ref(), view, &config);
        self.selected = Some((*view, state.frame));
        started.elapsed().as_secs_f64() * 1.0e3
    }

    /// Brings what has been loaded to the GPU within the budget and asks for what is missing.
    fn stream(&mut self, encoder: &mut wgpu::CommandEncoder) -> Moved {
        let budget = self.settings.upload_budget_bytes;
        let mut moved = Moved::default();
        let wanted = self.selection.height_tiles(&self.tree);
        let update = self.heights.update(&wanted, budget, self.frame);
        self.ledger.add(ByteCause::Disk, update.disk_bytes);
        self.failures.extend(update.failures);
        let sent = self.cache.upload_heights(&self.gpu, encoder, &self.tree, &update.uploads);
        self.ledger.add(ByteCause::Dem, sent);
        for (placement, tile) in update.uploads {
            moved.count(placement.evicted.is_some());
            if let Some(evicted) = placement.evicted {
                self.resident_heights.remove(&evicted);
            }
            self.resident_heights.insert(placement.tile, tile);
        }

        if let Some(colours) = &mut self.colours {
            let wanted = self.selection.colour_tiles(&self.tree);
            let update = colours.update(&wanted, budget.saturating_sub(sent), self.frame);
            self.ledger.add(ByteCause::Disk, update.disk_bytes);
            self.failures.extend(update.failures);
            let sent = self.cache.upload_colours(&self.gpu, encoder, &update.uploads);
            self.ledger.add(ByteCause::Dom, sent);
            for (placement, _) in &update.uploads {
                moved.count(placement.evicted.is_some());
            }
        }
        if moved.new > 0 {
            self.data_version += 1;
            self.height_table = OffsetTable::build(self.heights.cache().residents());
            self.colour_table =
                self.colours.as_ref().map(|layer| OffsetTable::build(layer.cache().residents()));
        }
        moved
    }

    /// Brings tables, uniforms and the visible parts of the meshes to the GPU for the scene.
    fn set_up(&mut self, scene: &SceneState) {
        let view = &scene.view;
        let eye = view.eye.truncate();
        let tables = self.cache.update_tables(
            &self.gpu,
            &self.tree,
            eye,
            &self.height_table,
            self.colour_table.as_ref(),
        );
        self.ledger.add(ByteCause::Table, tables.sent_bytes);
        if tables.grew {
            self.bindings.rebind(&self.gpu.device, &self.cache.table);
        }
        let scale_m = mesh_scale_m(self.clearance_m(view));
        let mut uniforms = frame_uniforms(view, &self.tree, &scene.settings, scale_m);
        [uniforms.height_table, uniforms.colour_table] = tables.ranges;
        uniforms.height_uv_per_texel = self.cache.heights.grid.uv_per_texel();
        uniforms.colour_uv_per_texel = self.cache.colours.grid.uv_per_texel();
        let sent = self.bindings.set_uniforms(&self.gpu.queue, &uniforms);
        self.ledger.add(ByteCause::Uniform, sent);
        let range = self.tree.height_ranges.range(TileId::ROOT);
        let exaggeration = scene.settings.vertical_exaggeration;
        let [low_m, high_m] = range
            .map_or([0.0; 2], |r| [r.min_m, r.max_m])
            .map(|height_m| f64::from(height_m) * exaggeration);
        let passes = (&self.displace, &self.sort_triangles);
        for (mesh, factor) in
            [(&mut self.mesh, 1.0), (&mut self.coordinate_mesh, COORDINATE_TRIANGLE_FACTOR)]
        {
            let triangle_px = scene.settings.triangle_px * factor;
            let wanted = mesh_settings(view, triangle_px, reach_m(&self.tree, eye) / scale_m);
            let mesh = match mesh.take() {
                Some(built) if built.serves(&wanted) => mesh.insert(built),
                _ => {
                    let built = DisplacedMesh::new(&self.gpu.device, passes, wanted);
                    self.ledger.add(ByteCause::Mesh, built.sent_bytes());
                    self.displaced = None;
                    mesh.insert(built)
                }
            };
            let extent = &self.tree.data_extent;
            let visible =
                mesh.mesh().visible_blocks(view, scale_m, DVec2::ZERO, low_m, high_m, extent);
            let sent = mesh.set_visible(&self.gpu.queue, visible);
            self.ledger.add(ByteCause::Mesh, sent);
        }
    }

    /// Displaces what is visible of the meshes, unless it is displaced already.
    fn displace(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
        coordinates: bool,
        measuring: bool,
    ) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("displace"),
            timestamp_writes: self.timer.first_pass(measuring),
        });
        let fresh = self.displaced == Some(*scene);
        let picture_mesh = self.mesh.as_ref().filter(|_| !fresh);
        let coordinate_mesh = self.coordinate_mesh.as_ref().filter(|_| coordinates);
        for mesh in picture_mesh.into_iter().chain(coordinate_mesh) {
            mesh.displace(&mut pass, &self.displace, &self.bindings);
        }
        if let Some(mesh) = picture_mesh {
            mesh.sort_triangles(&mut pass, &self.sort_triangles);
        }
        self.displaced = Some(*scene);
    }

    /// Draws the coordinate pass and asks for its image.
    fn ask_coordinates(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) -> Option<wgpu::Buffer> {
        let mesh = self.coordinate_mesh.as_ref()?;
        let buffer = self.feedback.record(encoder, &self.bindings, mesh)?;
        self.coordinates = Some(*scene);
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
            linear_lookup: scene.settings.lookup == LookupMethod::Linear,
            wireframe: scene.settings.wireframe,
            has_colours: self.colours.is_some(),
            has_voids: self.source.manifest().heights.has_voids,
            anisotropy: scene.settings.anisotropy,
            debug_view: scene.settings.debug_view,
        };
        let size_px = scene.view.viewport_px;
        let passes = match self.picture.take() {
            Some(passes) if passes.settings == settings => passes,
            _ => PicturePasses::new(&self.gpu.device, &self.bindings, settings),
        };
        let depth = match self.depth.take() {
            Some(depth) if depth.size_px == size_px => depth,
            _ => DepthBuffer::new(&self.gpu.device, size_px),
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(depth_attachment(&depth.view)),
            timestamp_writes: self.timer.last_pass(measuring),
            ..Default::default()
        });
        if let Some(mesh) = &self.mesh {
            passes.terrain.draw(&mut pass, &self.bindings, mesh.parts(), mesh.visible());
        }
        passes.sky.draw(&mut pass, &self.bindings);
        drop(pass);
        self.picture = Some(passes);
        self.depth = Some(depth);
        self.drawn = Some(*scene);
    }

    fn record(&mut self, moved: &Moved, coordinate_pass_drawn: bool) -> FrameRecord {
        let colours = self.colours.as_ref();
        let missing = self.heights.missing() + colours.map_or(0, |layer| layer.missing());
        let resident = self.heights.cache().len() + colours.map_or(0, |layer| layer.cache().len());
        let (blocks, triangles) = self.mesh.as_ref().map_or((0, 0), |mesh| mesh.drawn());
        let mut record = FrameRecord {
            strategy: "rtt-quadtree".to_owned(),
            frame: self.frame,
            gpu_ms: self.timer.latest_ms(),
            tiles_selected: self.selection.tiles.len() as u64,
            tiles_new: moved.new,
            tiles_missing: missing as u64,
            tiles_evicted: moved.evicted,
            tiles_resident: resident as u64,
            region_age_frames: self.region.as_ref().map(|state| self.frame - state.frame),
            finest_level: self.selection.statistics.finest_level,
            coordinate_pass_drawn,
            blocks_drawn: blocks,
            triangles_drawn: triangles,
            ..Default::default()
        };
        record.set_bytes(&self.ledger.take());
        record
    }

    /// Height of the eye above the ground below it, in drawn (exaggerated) metres.
    fn clearance_m(&self, view: &CameraView) -> f64 {
        let extent = &self.tree.data_extent;
        let below = view.eye.truncate().clamp(extent.min, extent.max);
        let lowest_m = self.tree.height_ranges.range(TileId::ROOT).map(|r| f64::from(r.min_m));
        let ground_m = self.ground_height_m(below).or(lowest_m).unwrap_or(0.0);
        let up_m = view.eye.z - ground_m * self.settings.vertical_exaggeration;
        up_m.hypot(view.eye.truncate().distance(below))
    }

    /// Loads level 0 and has it wait for the first frame.
    fn load_root(&mut self) -> Result<(), RenderError> {
        let loaded = self.source.load_heights(TileId::ROOT)?;
        self.ledger.add(ByteCause::Disk, loaded.disk_bytes);
        self.heights.supply(TileId::ROOT, loaded.tile);
        if let Some(colours) = &mut self.colours {
            let loaded = load_colours(&*self.source, self.cache.colours.format, TileId::ROOT)?;
            self.ledger.add(ByteCause::Disk, loaded.disk_bytes);
            colours.supply(TileId::ROOT, loaded.tile);
        }
        Ok(())
    }
}

impl Moved {
    fn count(&mut self, evicted: bool) {
        self.new += 1;
        self.evicted += u64::from(evicted);
    }
}

impl PicturePasses {
    fn new(device: &wgpu::Device, bindings: &FrameBindings, settings: TerrainPassSettings) -> Self {
        Self {
            terrain: TerrainPass::new(device, bindings, settings),
            sky: SkyPass::new(device, bindings, settings.target),
            settings,
        }
    }
}

impl DepthBuffer {
    fn new(device: &wgpu::Device, size_px: [u32; 2]) -> Self {
        let [width, height] = size_px;
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("depth"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: DEPTH_FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        Self { view: texture.create_view(&Default::default()), size_px }
    }
}

/// The mesh a view wants: spacing ratios in steps of a quarter octave and reaches of powers of four,
/// so that zooming and moving seldom build it anew.
fn mesh_settings(view: &CameraView, triangle_px: f64, reach: f64) -> CircularMeshSettings {
    let ratio = triangle_px * view.pixel_angle_rad();
    CircularMeshSettings {
        spacing_ratio: ((4.0 * ratio.log2()).floor() / 4.0).exp2(),
        rho_max: 4.0_f64.powf(reach.max(1.0).log(4.0).ceil()),
    }
}
