use super::DEPTH_FORMAT;
use super::coordinate_pass::depth_attachment;
use super::frame_group::FrameGroup;
use super::sky_pass::SkyPass;
use crate::built_for::BuiltFor;
use crate::renderer_settings::AntiAliasing;

/// The picture: terrain and sky, with the buffers they are drawn in. The sky's pipeline is built anew
/// when the kind of target changes, buffers when the size does.
#[derive(Default)]
pub(crate) struct Picture {
    sky: BuiltFor<TargetKind, SkyPass>,
    buffers: Option<Buffers>,
}

/// What pipelines that draw into a picture are built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TargetKind {
    pub format: wgpu::TextureFormat,
    /// Samples a pixel.
    pub samples: u32,
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
    target: TargetKind,
}

/// Where a picture goes.
pub(crate) struct PictureTarget<'a> {
    pub view: &'a wgpu::TextureView,
    pub size_px: [u32; 2],
    pub timestamps: Option<wgpu::RenderPassTimestampWrites<'a>>,
}

impl Picture {
    /// The target of pictures of this format: with one sample a pixel where it cannot be multisampled.
    pub fn target_kind(
        device: &wgpu::Device,
        format: wgpu::TextureFormat,
        anti_aliasing: AntiAliasing,
    ) -> TargetKind {
        let wanted = anti_aliasing.samples();
        let features = format.guaranteed_format_features(device.features()).flags;
        let resolves = features.contains(wgpu::TextureFormatFeatureFlags::MULTISAMPLE_RESOLVE);
        let is_smooth = resolves && features.sample_count_supported(wanted);
        TargetKind { format, samples: if is_smooth { wanted } else { 1 } }
    }

    /// Draws the terrain, which `draw_terrain` does, and the sky where there is none, with the group that it
    /// returns; none where it has drawn the sky as well.
    pub fn record<'f>(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        kind: TargetKind,
        target: PictureTarget<'_>,
        draw_terrain: impl FnOnce(&mut wgpu::RenderPass<'_>) -> Option<&'f FrameGroup>,
    ) {
        let buffer_kind = BufferKind { size_px: target.size_px, target: kind };
        let buffers = match self.buffers.take() {
            Some(buffers) if buffers.kind == buffer_kind => buffers,
            _ => Buffers::new(device, buffer_kind),
        };
        let buffers = self.buffers.insert(buffers);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(buffers.colour_attachment(target.view))],
            depth_stencil_attachment: Some(depth_attachment(&buffers.depth)),
            timestamp_writes: target.timestamps,
            ..Default::default()
        });
        let Some(frame) = draw_terrain(&mut pass) else { return };
        let sky = self.sky.get(kind, || SkyPass::new(device, frame, kind));
        sky.draw(&mut pass, frame);
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
                sample_count: kind.target.samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&Default::default())
        };
        Self {
            depth: view("depth", DEPTH_FORMAT),
            samples: (kind.target.samples > 1).then(|| view("samples", kind.target.format)),
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
