use super::DEPTH_FORMAT;
use super::coordinate_pass::depth_attachment;
use super::displaced_mesh::DisplacedMesh;
use super::frame_bindings::FrameBindings;
use super::sky_pass::SkyPass;
use super::terrain_pass::{TerrainPass, TerrainPassSettings};
use crate::renderer_settings::AntiAliasing;

/// The picture: terrain and sky, with the buffers they are drawn in. Pipelines are built anew when
/// their settings change, buffers when the size or the number of samples does.
#[derive(Default)]
pub(crate) struct Picture {
    passes: Option<Passes>,
    buffers: Option<Buffers>,
}

struct Passes {
    settings: TerrainPassSettings,
    terrain: TerrainPass,
    sky: SkyPass,
}

/// What a picture is drawn in besides its target.
struct Buffers {
    depth: wgpu::TextureView,
    /// The samples, where a pixel has several; their mean goes to the target.
    samples: Option<wgpu::TextureView>,
    kind: BufferKind,
}

#[derive(Clone, Copy, PartialEq, Eq)]
struct BufferKind {
    size_px: [u32; 2],
    format: wgpu::TextureFormat,
    samples: u32,
}

/// Where a picture goes.
pub(crate) struct PictureTarget<'a> {
    pub view: &'a wgpu::TextureView,
    pub size_px: [u32; 2],
    pub timestamps: Option<wgpu::RenderPassTimestampWrites<'a>>,
}

impl Picture {
    /// Samples a pixel that pictures of this format have: 1 where it cannot be multisampled.
    pub fn samples(
        device: &wgpu::Device,
        format: wgpu::TextureFormat,
        anti_aliasing: AntiAliasing,
    ) -> u32 {
        let wanted = anti_aliasing.samples();
        let features = format.guaranteed_format_features(device.features()).flags;
        let resolves = features.contains(wgpu::TextureFormatFeatureFlags::MULTISAMPLE_RESOLVE);
        if resolves && features.sample_count_supported(wanted) { wanted } else { 1 }
    }

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
        let TerrainPassSettings { target: format, samples, .. } = settings;
        let kind = BufferKind { size_px: target.size_px, format, samples };
        let buffers = match self.buffers.take() {
            Some(buffers) if buffers.kind == kind => buffers,
            _ => Buffers::new(device, kind),
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(buffers.colour_attachment(target.view))],
            depth_stencil_attachment: Some(depth_attachment(&buffers.depth)),
            timestamp_writes: target.timestamps,
            ..Default::default()
        });
        if let Some(mesh) = mesh {
            passes.terrain.draw(&mut pass, bindings, mesh.parts(), mesh.visible());
        }
        passes.sky.draw(&mut pass, bindings);
        drop(pass);
        self.passes = Some(passes);
        self.buffers = Some(buffers);
    }
}

impl Passes {
    fn new(device: &wgpu::Device, bindings: &FrameBindings, settings: TerrainPassSettings) -> Self {
        Self {
            terrain: TerrainPass::new(device, bindings, settings),
            sky: SkyPass::new(device, bindings, (settings.target, settings.samples)),
            settings,
        }
    }
}

impl Buffers {
    fn new(device: &wgpu::Device, kind: BufferKind) -> Self {
        let [width, height] = kind.size_px;
        let view = |label, format| {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: kind.samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&Default::default())
        };
        Self {
            depth: view("depth", DEPTH_FORMAT),
            samples: (kind.samples > 1).then(|| view("samples", kind.format)),
            kind,
        }
    }

    /// The attachment that ends in the target: the target itself, or samples that are not kept.
    fn colour_attachment<'a>(
        &'a self,
        target: &'a wgpu::TextureView,
    ) -> wgpu::RenderPassColorAttachment<'a> {
        let (view, resolve_target, store) = match &self.samples {
            Some(samples) => (samples, Some(target), wgpu::StoreOp::Discard),
            None => (target, None, wgpu::StoreOp::Store),
        };
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store };
        wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target, ops }
    }
}
