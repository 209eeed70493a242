//! Ways to bring terrain to the GPU and to draw it, one file or folder a way.
//!
//! The renderer knows the order of a frame and what all frames share (picture, timer, byte ledger); a
//! [`TerrainMethod`] carries its steps out. Strategies that differ only in which tiles they choose
//! share a method, so that a comparison of them compares nothing else.

mod cached_tiles;
mod clipmap;
mod cpu_mesh;
mod drawn_tiles;
mod globe;
mod gpu_tile_scheduling;
mod objects;
mod page_table;
mod paged_texture;
mod region_state;
mod tile_scheduling;
mod tin_ground;

use std::sync::Arc;
use std::time::Duration;

use glam::DVec2;

use self::clipmap::Clipmap;
use self::cpu_mesh::CpuMesh;
use self::globe::Globe;
use self::gpu_tile_scheduling::GpuTileScheduling;
pub(crate) use self::objects::{GroundBelow, Objects};
use self::page_table::PageTable;
use self::paged_texture::PagedTexture;
use self::tile_scheduling::TileScheduling;
use self::tin_ground::TinMethod;
use crate::CameraView;
use crate::dataset::{Shape, TileSource};
use crate::gpu::{DebugImage, FrameGroup, GpuContext, TargetKind};
use crate::measure::{FrameLedger, FrameRecord};
use crate::renderer_settings::RendererSettings;
use crate::residency::page_table::PagesAsked;
use crate::selection::{Selection, Strategy, TileTree};
use crate::surface::tin::TinGround;
use crate::terrain_renderer::RenderError;

/// What the steps of a frame work with.
pub(crate) struct FrameContext<'a> {
    pub gpu: &'a GpuContext,
    pub settings: &'a RendererSettings,
    /// Counts every byte where it moves.
    pub ledger: &'a mut FrameLedger,
    /// Number of the frame.
    pub frame: u64,
}

/// What a picture depends on: equal states give equal pictures.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct SceneState {
    pub view: CameraView,
    /// [`TerrainMethod::data_version`] when the picture was drawn.
    pub data_version: u64,
    pub settings: RendererSettings,
}

/// What an image of what the GPU sees is drawn anew for. Not the choice among what is resident: it follows from
/// the image, and commonly a still camera comes to rest so.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct ImageState {
    pub view: CameraView,
    /// Counts the changes of the geometry.
    pub geometry: u64,
    pub settings: RendererSettings,
}

/// Tiles, or parts of like size, that a frame moved.
#[derive(Clone, Copy, Default)]
pub(crate) struct Moved {
    pub new: u64,
    pub evicted: u64,
}

/// A way to bring terrain to the GPU and to draw it.
///
/// The renderer calls the steps of a frame in the order they stand here. None of them waits for the GPU
/// or the disk. Whatever the method: from its first frame on there is ground wherever there is data,
/// if coarse; it keeps the budget of uploads; and of a still camera with nothing pending it moves no
/// byte.
pub(crate) trait TerrainMethod {
    /// Takes what the GPU has sent back since the last frame. Nothing, where a method asks for nothing.
    fn receive(&mut self, _cx: &mut FrameContext<'_>) {}

    /// Chooses what the view needs; returns the milliseconds it took.
    fn select(&mut self, cx: &mut FrameContext<'_>, view: &CameraView) -> f64;

    /// Takes what has been loaded, brings it to the GPU within the budget and asks for what is missing.
    fn stream(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        view: &CameraView,
    ) -> Moved;

    /// Counts the changes of the data: for equal views and settings the picture is the same while this
    /// is.
    fn data_version(&self) -> u64;

    /// Brings the GPU to where the scene can be drawn: tables, uniforms, meshes.
    fn set_up(
        &mut self,
        cx: &mut FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    );

    /// Asks the GPU for what later frames need to know of this scene, if anything; returns whether it
    /// drew a coordinate pass for it.
    fn ask(
        &mut self,
        _cx: &mut FrameContext<'_>,
        _encoder: &mut wgpu::CommandEncoder,
        _scene: &SceneState,
    ) -> bool {
        false
    }

    /// Draws the terrain of the scene that was set up; returns the group the sky is drawn with.
    fn draw(
        &mut self,
        cx: &FrameContext<'_>,
        pass: &mut wgpu::RenderPass<'_>,
        target: TargetKind,
        scene: &SceneState,
    ) -> &FrameGroup;

    /// Whether [`Self::draw`] draws what is behind the terrain as well.
    fn draws_sky(&self) -> bool {
        false
    }

    /// After the frame's commands have been submitted.
    fn after_submit(&mut self, _frame: u64, _view: &CameraView) {}

    /// Fills in what the record tells of the method: tiles and triangles, not bytes or times. The
    /// record's frame is set.
    fn describe(&self, settings: &RendererSettings, record: &mut FrameRecord);

    /// Where on the ground each pixel of the scene that was set up looks: Rgba32Float, size of the
    /// view, east, north and up of the eye in metres, and 1; 0 in the last where there is sky.
    fn draw_coordinates(
        &mut self,
        cx: &FrameContext<'_>,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneState,
    ) -> wgpu::Texture;

    /// Whether data or feedback are still to come for the scene.
    fn is_pending(&self, scene: &SceneState) -> bool;

    /// Waits until everything that has been asked for is loaded, at most about so long.
    fn wait(&self, patience: Duration);

    /// Has the choice made anew in the next frame, since settings have changed.
    fn reconsider(&mut self);

    /// Takes what went wrong with single tiles since the last call, in words.
    fn take_failures(&mut self) -> Vec<String>;

    /// What is drawn.
    fn tree(&self) -> &TileTree;

    /// The tiles chosen last.
    fn selection(&self) -> &Selection;

    /// What the latest image of a virtual texture asked for; `None` where there is no such texture.
    fn pages_asked(&self) -> Option<PagesAsked> {
        None
    }

    /// Height of the ground in metres above the datum, without exaggeration, as well as it is known in
    /// memory. `None` outside the data.
    fn ground_height_m(&self, point: DVec2) -> Option<f64>;

    /// One of the method's own textures; `None` where it has none of the kind.
    fn debug_texture(&self, image: DebugImage) -> Option<wgpu::TextureView>;
}

/// What decides how a method is built: where this changes, it is built anew.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct MethodKey {
    kind: MethodKind,
    /// What of the settings the method's resources are made for.
    settings: RendererSettings,
}

/// The methods there are.
#[derive(Clone, Copy, PartialEq, Eq)]
enum MethodKind {
    TileScheduling,
    GpuTileScheduling,
    CpuMesh,
    Clipmap,
    PageTable,
    Tin,
}

impl MethodKey {
    /// Where the ground is a TIN, one method draws it whatever the strategy.
    pub fn of(settings: &RendererSettings, tin: Option<&Arc<TinGround>>) -> Self {
        let kind = match settings.strategy {
            _ if tin.is_some() => MethodKind::Tin,
            Strategy::RttQuadtree | Strategy::CpuFrustum => MethodKind::TileScheduling,
            Strategy::RttQuadtreeGpu => MethodKind::GpuTileScheduling,
            Strategy::CpuMesh => MethodKind::CpuMesh,
            Strategy::Clipmap => MethodKind::Clipmap,
            Strategy::PageTable | Strategy::TextureMap => MethodKind::PageTable,
        };
        let made_for = match kind {
            MethodKind::TileScheduling => TileScheduling::made_for(settings),
            MethodKind::GpuTileScheduling => GpuTileScheduling::made_for(settings),
            MethodKind::CpuMesh => CpuMesh::made_for(settings),
            MethodKind::PageTable => PageTable::made_for(settings),
            MethodKind::Tin => PagedTexture::made_for(settings),
            // Whatever changes, it keeps what it has.
            MethodKind::Clipmap => RendererSettings::default(),
        };
        Self { kind, settings: made_for }
    }
}

/// Builds the method that carries the settings' strategy out, or draws the TIN where the ground is one. Loads level 0
/// of each layer before it returns.
///
/// # Errors
/// [`RenderError`] where level 0 cannot be loaded or the GPU refuses.
pub(crate) fn open_method(
    cx: &mut FrameContext<'_>,
    source: &Arc<dyn TileSource>,
    tree: TileTree,
    tin: Option<&Arc<TinGround>>,
) -> Result<Box<dyn TerrainMethod>, RenderError> {
    if cx.settings.strategy == Strategy::TextureMap && !cx.gpu.can_map_textures() {
        return Err(RenderError::NoTextureMap(cx.gpu.adapter_name()));
    }
    if let Some(tin) = tin {
        return Ok(Box::new(TinMethod::open(cx, source, tree, tin)?));
    }
    match MethodKey::of(cx.settings, None).kind {
        MethodKind::TileScheduling => Ok(Box::new(TileScheduling::open(cx, source, tree)?)),
        MethodKind::GpuTileScheduling => Ok(Box::new(GpuTileScheduling::open(cx, source, tree)?)),
        MethodKind::CpuMesh => Ok(Box::new(CpuMesh::open(cx, source, tree)?)),
        MethodKind::Clipmap => Ok(Box::new(Clipmap::open(cx, source, tree)?)),
        // Without a TIN, what comes nearest to one.
        MethodKind::PageTable | MethodKind::Tin => {
            let is_globe = source.manifest().shape == Shape::Globe;
            match cx.settings.strategy {
                Strategy::PageTable if is_globe => Ok(Box::new(Globe::open(cx, source, tree)?)),
                _ => Ok(Box::new(PageTable::open(cx, source, tree)?)),
            }
        }
    }
}
