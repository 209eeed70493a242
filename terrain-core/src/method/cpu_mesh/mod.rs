//! A triangulation made on the CPU for the view and sent as geometry: how terrain was drawn before
//! graphics processors could read heights themselves, done as well as it can be. The mesh is
//! [`ViewMesh`]; its sources are named there.
//!
//! Height tiles are loaded into memory, never sent: what goes to the GPU of the ground's shape are the
//! vertices and triangles that have changed since the last frame. Imagery is cached in tiles as the
//! tile-scheduling method does, chosen by the view frustum.

mod colour_tiles;
mod height_tiles;

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec2;

use self::colour_tiles::ColourTiles;
use self::height_tiles::{HeightTiles, load_patch};
use super::cached_tiles::{CachedTiles, in_slots};
use super::{FrameContext, Moved, SceneState, TerrainMethod};
use crate::CameraView;
use crate::built_for::BuiltFor;
use crate::dataset::TileSource;
use crate::gpu::{
    DebugImage, FrameGroup, TargetKind, TerrainCache, ViewMeshBuffers, ViewMeshPass,
    ViewMeshPassSettings, draw_view_mesh_coordinates,
};
use crate::layer_loading::colour_format;
use crate::measure::{ByteCause, FrameRecord};
use crate::renderer_settings::{LookupMethod, RendererSettings};
use crate::residency::OffsetTable;
use crate::selection::{Selection, TileTree, select_by_frustum};
use crate::surface::view_mesh::{PatchFrame, RefineSettings, Sight, ViewMesh};
use crate::terrain_renderer::RenderError;
use crate::tiling::TileId;

/// Draws a dataset with a mesh made on the CPU.
pub(super) struct CpuMesh {
    tree: TileTree,
    has_voids: bool,
    heights: HeightTiles,
    mesh: ViewMesh,
    buffers: ViewMeshBuffers,
    colours: ColourTiles,
    tiles: CachedTiles,
    pass: BuiltFor<ViewMeshPassSettings, ViewMeshPass>,
    failures: Vec<String>,
    selection: Selection,
    /// What the latest selection was made for.
    selected: Option<CameraView>,
    /// What the mesh was last brought closer to, and whether it has come there.
    refined: Option<(CameraView, bool)>,
    /// Counts changes of the mesh.
    mesh_version: u64,
}

impl CpuMesh {
    /// How far the ground may look from the mesh, in parts of the size that texels of imagery may have.
    /// Chosen by bytes at equal error: less geometry for finer imagery costs more for the same picture.
    const TOLERANCE_TEXELS: f64 = 1.5;
    /// Most triangles of the mesh.
    const MOST_TRIANGLES: usize = 300_000;
    /// Most cuts and joins in a frame: some milliseconds of work.
    const MOST_STEPS: usize = 6_000;
    /// Bytes that a cut or a join sends: at most a vertex and four triangles.
    const STEP_BYTES: u64 =
        ViewMeshBuffers::SENT_VERTEX_BYTES + 4 * ViewMeshBuffers::SENT_TRIANGLE_BYTES;

    /// Opens the layers and loads level 0 of each.
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
        let tiles = CachedTiles::new(cx, &tree, format, TerrainCache::of_colours)?;
        let frame = PatchFrame {
            scheme: tree.scheme,
            data_extent: tree.data_extent,
            layout: tree.heights.layout,
        };
        let root = load_patch(&**source, frame, TileId::ROOT)?;
        let colours = ColourTiles::open(source, format, slots, cx.ledger)?;
        cx.ledger.add(ByteCause::Disk, root.disk_bytes);
        Ok(Self {
            has_voids: source.manifest().heights.has_voids,
            heights: HeightTiles::new(source, frame)?,
            mesh: ViewMesh::new(frame, root.tile, settings.vertical_exaggeration),
            buffers: ViewMeshBuffers::new(&gpu.device),
            colours,
            tiles,
            pass: BuiltFor::default(),
            failures: Vec::new(),
            selection: Selection { tiles: vec![TileId::ROOT], ..Default::default() },
            selected: None,
            refined: None,
            mesh_version: 0,
            tree,
        })
    }

    /// The settings that the cache is made for; all others as they are by default.
    pub fn made_for(settings: &RendererSettings) -> RendererSettings {
        let RendererSettings { cache_columns, cache_rows, .. } = *settings;
        RendererSettings { cache_columns, cache_rows, ..Default::default() }
    }
}

impl TerrainMethod for CpuMesh {
    fn select(&mut self, cx: &mut FrameContext<'_>, view: &CameraView) -> f64 {
        let settings = cx.settings;
        if settings.freeze_selection || self.selected == Some(*view) {
            return 0.0;
        }
        let started = Instant::now();
        let config = settings.selection_config();
        self.selection = select_by_frustum(&self.tree, view, &config);
        self.heights.select(&self.tree, view, &config);
        self.selected = Some(*view);
        started.elapsed().as_secs_f64() * 1.0e3
    }

    fn stream(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        view: &CameraView,
    ) -> Moved {
        let budget_bytes = cx.settings.upload_budget_bytes;
        let heights = self.take_heights(cx, view, budget_bytes);
        let size = (self.mesh.vertex_capacity(), self.mesh.triangle_count());
        let changes = self.mesh.take_changes();
        let sent = self.buffers.update(cx.gpu, encoder, size, &changes);
        self.mesh_version += u64::from(sent > 0);
        cx.ledger.add(ByteCause::Mesh, sent);
        let colours = self.stream_colours(cx, encoder, budget_bytes.saturating_sub(sent));
        Moved { new: heights.new + colours.new, evicted: heights.evicted + colours.evicted }
    }

    fn data_version(&self) -> u64 {
        self.mesh_version + self.colours.version
    }

    fn set_up(
        &mut self,
        cx: &mut FrameContext<'_>,
        _encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) {
        let tables = (&OffsetTable::build([]), self.colours.table.as_ref());
        // No mesh is scaled here.
        self.tiles.show(cx, &self.tree, (scene, 1.0), tables);
    }

    fn draw(
        &mut self,
        cx: &FrameContext<'_>,
        pass: &mut wgpu::RenderPass<'_>,
        target: TargetKind,
        scene: &SceneState,
    ) -> &FrameGroup {
        let settings = ViewMeshPassSettings {
            target,
            linear_lookup: scene.settings.lookup == LookupMethod::Linear,
            wireframe: scene.settings.wireframe,
            has_colours: self.colours.has_any(),
            has_voids: self.has_voids,
            anisotropy: scene.settings.anisotropy,
            debug_view: scene.settings.debug_view,
        };
        let build = || ViewMeshPass::new(&cx.gpu.device, &self.tiles.bindings, settings);
        let terrain = self.pass.get(settings, build);
        terrain.draw(pass, &self.tiles.bindings, &self.buffers, self.mesh.triangle_count());
        &self.tiles.bindings.frame
    }

    fn describe(&self, _settings: &RendererSettings, record: &mut FrameRecord) {
        record.tiles_selected = self.selection.tiles.len() as u64;
        record.tiles_missing = (self.heights.missing() + self.colours.missing()) as u64;
        record.tiles_resident = (self.mesh.patch_count() + self.colours.resident()) as u64;
        record.finest_level = self.selection.statistics.finest_level;
        record.triangles_drawn = self.mesh.triangle_count() as u64;
    }

    fn draw_coordinates(
        &mut self,
        cx: &FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) -> wgpu::Texture {
        let mesh = (&self.buffers, self.mesh.triangle_count());
        let size_px = scene.view.viewport_px;
        draw_view_mesh_coordinates(&cx.gpu.device, encoder, &self.tiles.bindings, mesh, size_px)
    }

    fn is_pending(&self, scene: &SceneState) -> bool {
        let is_frozen = scene.settings.freeze_selection;
        self.heights.missing() + self.colours.missing() > 0
            || self.heights.is_unfinished()
            || (!is_frozen && self.selected != Some(scene.view))
            || (!is_frozen && self.refined != Some((scene.view, true)))
    }

    fn wait(&self, patience: Duration) {
        self.heights.wait(patience);
        self.colours.wait(patience);
    }

    fn reconsider(&mut self) {
        (self.selected, self.refined) = (None, None);
    }

    fn take_failures(&mut self) -> Vec<String> {
        std::mem::take(&mut self.failures)
    }

    fn tree(&self) -> &TileTree {
        &self.tree
    }

    fn selection(&self) -> &Selection {
        &self.selection
    }

    fn ground_height_m(&self, point: DVec2) -> Option<f64> {
        self.mesh.height_at_m(point)
    }

    fn debug_texture(&self, image: DebugImage) -> Option<wgpu::TextureView> {
        (image == DebugImage::ColourCache).then(|| self.tiles.cache.colours.mip(0))
    }
}

impl CpuMesh {
    /// Brings what was loaded of the ground into the mesh, and the mesh closer to what the view wants.
    fn take_heights(
        &mut self,
        cx: &mut FrameContext<'_>,
        view: &CameraView,
        budget_bytes: u64,
    ) -> Moved {
        self.mesh.set_vertical_exaggeration(cx.settings.vertical_exaggeration);
        // Half is left for what the new ground makes of the triangles, and for imagery.
        let has_room = |mesh: &ViewMesh| changed_bytes(mesh) < budget_bytes / 2;
        let moved = self.heights.update(&self.tree, &mut self.mesh, has_room);
        cx.ledger.add(ByteCause::Disk, moved.disk_bytes);
        self.failures.extend(moved.failures);
        let is_same_ground = moved.taken + moved.let_go == 0;
        let is_done = is_same_ground && self.refined == Some((*view, true));
        if !is_done && !cx.settings.freeze_selection {
            let settings = RefineSettings {
                tolerance_px: Self::TOLERANCE_TEXELS * cx.settings.texel_px,
                most_triangles: Self::MOST_TRIANGLES,
            };
            let left_bytes = budget_bytes.saturating_sub(changed_bytes(&self.mesh));
            let steps = (left_bytes / Self::STEP_BYTES).clamp(1, Self::MOST_STEPS as u64);
            let refined = self.mesh.refine(&Sight::new(view), settings, steps as usize);
            self.refined = Some((*view, refined.is_done));
        }
        Moved { new: moved.taken, evicted: moved.let_go }
    }

    fn stream_colours(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        budget_bytes: u64,
    ) -> Moved {
        let wanted = self.selection.colour_tiles(&self.tree);
        let moved = self.colours.update(&wanted, budget_bytes, cx.frame);
        cx.ledger.add(ByteCause::Disk, moved.disk_bytes);
        self.failures.extend(moved.failures);
        let uploads = in_slots(&moved.uploads);
        self.tiles.send_colours(cx, encoder, &self.tree, &uploads);
        let evicted = moved.uploads.iter().filter(|(placement, _)| placement.evicted.is_some());
        Moved { new: moved.uploads.len() as u64, evicted: evicted.count() as u64 }
    }
}

/// Bytes that what has changed of the mesh takes to send.
fn changed_bytes(mesh: &ViewMesh) -> u64 {
    let (vertices, triangles) = mesh.changed();
    vertices as u64 * ViewMeshBuffers::SENT_VERTEX_BYTES
        + triangles as u64 * ViewMeshBuffers::SENT_TRIANGLE_BYTES
}
