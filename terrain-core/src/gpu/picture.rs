use super::DEPTH_FORMAT;
use super::coordinate_pass::depth_attachment;
use super::displaced_mesh::DisplacedMesh;
use super::frame_bindings::FrameBindings;
use super::sky_pass::SkyPass;
use super::terrain_pass::{TerrainPass, TerrainPassSettings};

/// The picture: terrain and sky with their depth buffer. Pipelines are built anew when their settings
/// change, the depth buffer when the size does.
#[derive(Default)]
pub(crate) struct Picture {
    passes: Option<Passes>,
    depth: Option<DepthBuffer>,
}

struct Passes {
    settings: TerrainPassSettings,
    terrain: TerrainPass,
    sky: SkyPass,
}

struct DepthBuffer {
    view: wgpu::TextureView,
    size_px: [u32; 2],
}

/// Where a picture goes.
pub(crate) struct PictureTarget<'a> {
    pub view: &'a wgpu::TextureView,
    pub size_px: [u32; 2],
    pub timestamps: Option<wgpu::RenderPassTimestampWrites<'a>>,
}

impl Picture {
    /// Draws the visible terrain, and the sky where there is none.
    pub fn record(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        bindings: &FrameBindings,
        mesh: Option<&DisplacedMesh>,
        settings: TerrainPassSettings,
        target: PictureTarget<'_>,
    ) {
        let passes = match self.passes.take() {
            Some(passes) if passes.settings == settings => passes,
            _ => Passes::new(device, bindings, settings),
        };
        let depth = match self.depth.take() {
            Some(depth) if depth.size_px == target.size_px => depth,
            _ => DepthBuffer::new(device, target.size_px),
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target.view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(depth_attachment(&depth.view)),
            timestamp_writes: target.timestamps,
            ..Default::default()
        });
        if let Some(mesh) = mesh {
            passes.terrain.draw(&mut pass, bindings, mesh.parts(), mesh.visible());
        }
        passes.sky.draw(&mut pass, bindings);
        drop(pass);
        self.passes = Some(passes);
        self.depth = Some(depth);
    }
}

impl Passes {
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
