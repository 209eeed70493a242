//! The clipmap method: of every level a window round the eye for heights and for imagery, and a mesh of
//! nested rings. After Losasso and Hoppe, "Geometry Clipmaps: Terrain Rendering Using Nested Regular
//! Grids" (2004), Asirvatham and Hoppe, "Terrain Rendering Using GPU-Based Geometry Clipmaps" (2005),
//! and, for the imagery, Tanner, Migdal and Jones, "The Clipmap: A Virtual Mipmap" (1998).
//!
//! `texel_px` sets the windows' size, `triangle_px` the rings'. Departures, beside those that
//! [`crate::residency::clipmap`] and [`crate::surface::ClipMesh`] name:
//!
//! - Windows of heights and rings are not one: windows are as fine as the light on the slopes asks,
//!   rings as fine as triangles are to be, and a vertex takes its height from the level whose texels are
//!   half its spacing, the mean of the four round it. Rings may so be finer than the data, where the
//!   papers add detail of their own, and nothing about them changes while windows fill.
//! - A level that is still being filled fades into the coarser one over its outermost texels, heights and
//!   imagery alike, where the papers crop its mesh.
//! - Heights are sent as they are stored, 2 bytes a texel at full precision, not as residuals of the
//!   coarser level; slopes are derived on the GPU.

mod terrain;

use std::sync::Arc;
use std::time::Duration;

use glam::DVec2;

use self::terrain::{ClipArrivals, ClipFocus, ClipTerrain};
use super::{FrameContext, Moved, SceneState, TerrainMethod};
use crate::CameraView;
use crate::built_for::BuiltFor;
use crate::dataset::TileSource;
use crate::frame_setup::frame_uniforms;
use crate::gpu::{
    ClipBindings, ClipDecodePass, ClipFrame, ClipHeightUpload, ClipHeightsPass, ClipLevel,
    ClipMeshBuffers, ClipPass, ClipPassSettings, ClipTextureSizes, ClipTextures, DebugImage,
    FrameGroup, GpuContext, TargetKind, WrittenTexels, draw_clip_coordinates,
};
use crate::layer_loading::colour_format;
use crate::measure::{ByteCause, FrameRecord};
use crate::renderer_settings::RendererSettings;
use crate::residency::clipmap::{ClipLayer, ClipStrip, pieces};
use crate::selection::{Selection, TileTree};
use crate::surface::{ClipMesh, ClipMeshView};
use crate::terrain_renderer::RenderError;

/// Draws a dataset by clipmaps.
pub(super) struct Clipmap {
    terrain: ClipTerrain,
    has_voids: bool,
    textures: ClipTextures,
    heights_pass: ClipHeightsPass,
    decode_pass: Option<ClipDecodePass>,
    frame: FrameGroup,
    bindings: ClipBindings,
    mesh: ClipMeshBuffers,
    pass: BuiltFor<ClipPassSettings, ClipPass>,
    /// What the windows were moved to last.
    focus: Option<ClipFocus>,
    /// No tiles: windows take the place of a selection.
    selection: Selection,
}

/// Part of a window's side over which a level fades into the next coarser one.
const FADE_PART: f32 = 1.0 / 16.0;

impl Clipmap {
    /// Opens the layers and loads level 0 of each.
    ///
    /// # Errors
    /// [`RenderError`] where level 0 cannot be loaded.
    pub fn open(
        cx: &mut FrameContext<'_>,
        source: &Arc<dyn TileSource>,
        tree: TileTree,
    ) -> Result<Self, RenderError> {
        let device = &cx.gpu.device;
        let format = colour_format(&**source, cx.gpu.has_block_compression());
        let terrain = ClipTerrain::open(source, tree, format, cx.ledger)?;
        let textures = ClipTextures::new(device, texture_sizes(cx.gpu, &terrain));
        Ok(Self {
            has_voids: source.manifest().heights.has_voids,
            heights_pass: ClipHeightsPass::new(device),
            decode_pass: ClipDecodePass::new(device, &textures),
            frame: FrameGroup::new(device),
            bindings: ClipBindings::new(device, &textures),
            mesh: ClipMeshBuffers::new(device),
            pass: BuiltFor::default(),
            focus: None,
            selection: Selection::default(),
            textures,
            terrain,
        })
    }
}

impl TerrainMethod for Clipmap {
    /// Nothing: which texels are needed follows from the eye's place alone.
    fn select(&mut self, _cx: &mut FrameContext<'_>, _view: &CameraView) -> f64 {
        0.0
    }

    fn stream(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        view: &CameraView,
    ) -> Moved {
        let focus = self.focus_of(cx.settings, view);
        self.focus = Some(focus);
        self.fit_textures(cx.gpu, focus.texel_rad);
        let budget = cx.settings.upload_budget_bytes;
        let arrivals = self.terrain.stream(&focus, budget, cx.ledger);
        let mut moved = Moved::default();
        cx.ledger.add(ByteCause::Dem, self.send_heights(cx.gpu, encoder, &arrivals, &mut moved));
        cx.ledger.add(ByteCause::Dom, self.send_colours(cx.gpu, encoder, &arrivals, &mut moved));
        let texels = |strips: &[ClipStrip]| strips.iter().map(|strip| strip.rect.area()).sum();
        cx.ledger.add_texels(ByteCause::Dem, texels(&arrivals.heights));
        cx.ledger.add_texels(ByteCause::Dom, texels(&arrivals.colours));
        self.terrain.drop_tiles();
        moved
    }

    fn data_version(&self) -> u64 {
        self.terrain.version
    }

    fn set_up(
        &mut self,
        cx: &mut FrameContext<'_>,
        _encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) {
        let (queue, settings) = (&cx.gpu.queue, &scene.settings);
        let uniforms = frame_uniforms(&scene.view, &self.terrain.tree, settings, 0.0);
        cx.ledger.add(ByteCause::Uniform, self.frame.set_uniforms(queue, &uniforms));
        let mesh = self.mesh_of(scene);
        let levels = self.levels_seen_from(scene.view.eye.truncate());
        cx.ledger.add(ByteCause::Uniform, self.bindings.set_frame(queue, &self.clip_frame(&mesh)));
        cx.ledger.add(ByteCause::Table, self.bindings.set_levels(queue, levels));
        let height_range_m = self.terrain.height_range_m(settings.vertical_exaggeration);
        let extent = &self.terrain.tree.data_extent;
        let visible = mesh.visible_blocks(&scene.view, height_range_m, extent);
        let sent = self.mesh.set(&cx.gpu.device, queue, mesh.block_cells(), visible);
        cx.ledger.add(ByteCause::Mesh, sent);
    }

    fn draw(
        &mut self,
        cx: &FrameContext<'_>,
        pass: &mut wgpu::RenderPass<'_>,
        target: TargetKind,
        scene: &SceneState,
    ) -> &FrameGroup {
        let settings = ClipPassSettings {
            target,
            wireframe: scene.settings.wireframe,
            has_colours: self.terrain.colours.is_some(),
            has_voids: self.has_voids,
            anisotropy: scene.settings.anisotropy,
            debug_view: scene.settings.debug_view,
        };
        let build = || ClipPass::new(&cx.gpu.device, &self.frame, &self.bindings, &settings);
        let terrain = self.pass.get(settings, build);
        terrain.draw(pass, &self.frame, &self.bindings, &self.mesh);
        &self.frame
    }

    fn describe(&self, _settings: &RendererSettings, record: &mut FrameRecord) {
        record.tiles_missing = self.terrain.missing() as u64;
        record.tiles_resident = self.terrain.tile_count() as u64;
        record.finest_level = self.terrain.finest_level();
        (record.blocks_drawn, record.triangles_drawn) = self.mesh.drawn();
    }

    fn draw_coordinates(
        &mut self,
        cx: &FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) -> wgpu::Texture {
        let groups = (&self.frame, &self.bindings);
        let size_px = scene.view.viewport_px;
        draw_clip_coordinates(&cx.gpu.device, encoder, groups, &self.mesh, size_px)
    }

    fn is_pending(&self, scene: &SceneState) -> bool {
        self.terrain.missing() > 0
            || self.focus != Some(self.focus_of(&scene.settings, &scene.view))
    }

    fn wait(&self, patience: Duration) {
        self.terrain.wait(patience);
    }

    /// The next frame does so in any case.
    fn reconsider(&mut self) {}

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
        self.terrain.ground_height_m(point)
    }

    /// The finest level in use.
    fn debug_texture(&self, image: DebugImage) -> Option<wgpu::TextureView> {
        let finest = |levels: usize| (levels - 1) as u32;
        match image {
            DebugImage::Coordinates => None,
            DebugImage::HeightCache => {
                let level = finest(self.terrain.heights.wanted_levels());
                Some(ClipTextures::level(&self.textures.heights, level))
            }
            DebugImage::ColourCache => {
                let level = finest(self.terrain.colours.as_ref()?.wanted_levels());
                Some(ClipTextures::level(self.textures.colours(), level))
            }
        }
    }
}

impl Clipmap {
    /// What the windows are to be moved to: nowhere else while the selection is frozen.
    fn focus_of(&self, settings: &RendererSettings, view: &CameraView) -> ClipFocus {
        let focus = ClipFocus {
            eye: view.eye,
            texel_rad: settings.texel_px * view.pixel_angle_rad(),
            vertical_exaggeration: settings.vertical_exaggeration,
        };
        self.focus.filter(|_| settings.freeze_selection).unwrap_or(focus)
    }

    /// Makes new textures where the windows are to have another size.
    fn fit_textures(&mut self, gpu: &GpuContext, texel_rad: f64) {
        let sizes = self.terrain.sizes_for(texel_rad);
        if sizes != self.terrain.sizes() {
            self.terrain.resize(sizes);
            self.textures = ClipTextures::new(&gpu.device, texture_sizes(gpu, &self.terrain));
            self.decode_pass = ClipDecodePass::new(&gpu.device, &self.textures);
            self.bindings.rebind(&gpu.device, &self.textures);
        }
    }

    /// Sends strips of heights; returns the bytes.
    fn send_heights(
        &self,
        gpu: &GpuContext,
        encoder: &mut wgpu::CommandEncoder,
        arrivals: &ClipArrivals,
        moved: &mut Moved,
    ) -> u64 {
        let layer = &self.terrain.heights;
        let upload = |strip: &ClipStrip| {
            let pieces = pieces(&strip.rect, &layer.layer().layout, strip.level, layer.clip_size());
            ClipHeightUpload {
                strip: *strip,
                pieces: pieces.into_iter().map(|piece| (piece, layer.tile(piece.tile))).collect(),
                texel_size_m: layer.texel_size_m(usize::from(strip.level)),
            }
        };
        let uploads = arrivals.heights.iter().map(upload).collect::<Vec<_>>();
        moved.new += uploads.iter().map(|upload| upload.pieces.len() as u64).sum::<u64>();
        self.heights_pass.record(&gpu.device, encoder, &self.textures, &uploads)
    }

    /// Sends strips of imagery; returns the bytes.
    fn send_colours(
        &self,
        gpu: &GpuContext,
        encoder: &mut wgpu::CommandEncoder,
        arrivals: &ClipArrivals,
        moved: &mut Moved,
    ) -> u64 {
        let Some(layer) = &self.terrain.colours else { return 0 };
        let (mut sent, mut written) = (0, Vec::new());
        for strip in &arrivals.colours {
            let level = u32::from(strip.level);
            let layout = &layer.layer().layout;
            for piece in pieces(&strip.rect, layout, strip.level, layer.clip_size()) {
                let tile = layer.tile(piece.tile);
                sent += self.textures.write_colours(&gpu.queue, level, &piece, tile);
                written.push(WrittenTexels { level, first: piece.target, size: piece.size });
            }
        }
        if let Some(pass) = &self.decode_pass {
            pass.record(encoder, &written);
        }
        moved.new += written.len() as u64;
        sent
    }

    fn mesh_of(&self, scene: &SceneState) -> ClipMesh {
        let (tree, settings) = (&self.terrain.tree, &scene.settings);
        let layout = &tree.heights.layout;
        let eye = scene.view.eye;
        ClipMesh::new(&ClipMeshView {
            scheme: &tree.scheme,
            data_extent: &tree.data_extent,
            eye: eye.truncate(),
            clearance_m: self.terrain.clearance_m(eye, settings.vertical_exaggeration),
            triangle_rad: settings.triangle_px * scene.view.pixel_angle_rad(),
            least_spacing_m: 0.5 * layout.texel_size_m(&tree.scheme, layout.finest_level()),
        })
    }

    /// The levels in use, heights first, as seen from the eye.
    fn levels_seen_from(&self, eye: DVec2) -> Vec<ClipLevel> {
        let terrain = &self.terrain;
        let scheme = &terrain.tree.scheme;
        let heights = terrain.shown_heights();
        let colours = terrain.shown_colours();
        let of_heights = (0..).zip(&heights).map(|(level, shown)| {
            let layout = &terrain.heights.layer().layout;
            ClipLevel::new(scheme, layout, level, shown, eye, terrain.heights.clip_size())
        });
        let of_colours = terrain.colours.iter().flat_map(|layer| {
            (0..).zip(&colours).map(|(level, shown)| {
                let layout = &layer.layer().layout;
                ClipLevel::new(scheme, layout, level, shown, eye, layer.clip_size())
            })
        });
        of_heights.chain(of_colours).collect()
    }

    fn clip_frame(&self, mesh: &ClipMesh) -> ClipFrame {
        let terrain = &self.terrain;
        let sizes = terrain.sizes();
        let level_0_m = terrain.heights.texel_size_m(0);
        let colour_levels = terrain.colours.as_ref().map_or(0, ClipLayer::wanted_levels);
        ClipFrame {
            reference_from_eye_m: mesh.reference_from_eye_m.as_vec2().into(),
            unit_m: mesh.unit_m as f32,
            ring_cells: mesh.cells as f32,
            patch_columns: mesh.block_cells() + 1,
            mesh_level: (2.0 * level_0_m / mesh.unit_m).log2() as f32,
            height_levels: terrain.heights.wanted_levels() as u32,
            colour_levels: colour_levels as u32,
            height_fade_texels: sizes.heights as f32 * FADE_PART,
            colour_fade_texels: sizes.colours as f32 * FADE_PART,
        }
    }
}

/// The textures that the terrain's windows need; of imagery that there is none, a stub.
fn texture_sizes(gpu: &GpuContext, terrain: &ClipTerrain) -> ClipTextureSizes {
    let sizes = terrain.sizes();
    let colours = terrain.colours.as_ref();
    ClipTextureSizes {
        heights: [sizes.heights, terrain.heights.levels() as u32],
        colours: colours.map_or([4, 1], |layer| [sizes.colours, layer.levels() as u32]),
        colour_format: terrain.colour_format,
        // A program on the CPU decodes a block anew for every sample.
        decodes_blocks: gpu.is_software(),
    }
}
