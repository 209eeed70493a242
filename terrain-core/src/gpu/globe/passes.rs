use super::globe_group::GlobeGroup;
use super::patch_buffers::{DrawnPatch, PatchBuffers};
use crate::gpu::coordinate_pass::{CoordinatePass, draw_full_coordinates};
use crate::gpu::frame_group::FrameGroup;
use crate::gpu::ground_pipeline::{SurfaceOptions, flag, polygon_mode, surface_pipeline};
use crate::gpu::page_table::{PageBindings, RequestImage};
use crate::gpu::picture::TargetKind;
use crate::gpu::shader_library::{GLOBE, GLOBE_COORDINATES, GLOBE_REQUESTS, GLOBE_SKY};
use crate::gpu::sky_pass::SkyPass;
use crate::renderer_settings::DebugView;

/// What the globe is drawn with besides its mesh: groups 0 to 2.
#[derive(Clone, Copy)]
pub(crate) struct GlobeBindings<'a> {
    pub frame: &'a FrameGroup,
    pub globe: &'a GlobeGroup,
    pub pages: &'a PageBindings,
}

impl<'a> GlobeBindings<'a> {
    fn layouts(&self) -> [&'a wgpu::BindGroupLayout; 3] {
        [&self.frame.layout, &self.globe.layout, &self.pages.layout]
    }

    fn set(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_bind_group(0, &self.frame.group, &[]);
        pass.set_bind_group(GlobeGroup::GROUP, &self.globe.group, &[]);
        pass.set_bind_group(PageBindings::GROUP, &self.pages.group, &[]);
    }
}

/// What decides how the picture's pipelines are built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct GlobePassSettings {
    pub target: TargetKind,
    pub wireframe: bool,
    pub has_colours: bool,
    pub anisotropy: u32,
    /// Whether pages may show in part.
    pub fades: bool,
    pub debug_view: DebugView,
}

/// Draws the globe and the sky behind it.
pub(crate) struct GlobePass {
    ground: wgpu::RenderPipeline,
    sky: SkyPass,
}

impl GlobePass {
    pub fn new(
        device: &wgpu::Device,
        bindings: GlobeBindings<'_>,
        settings: &GlobePassSettings,
    ) -> Self {
        let options = SurfaceOptions {
            groups: &bindings.layouts(),
            vertices: PatchBuffers::vertex_layout(),
            target: settings.target,
            constants: &[
                ("HAS_COLOURS", flag(settings.has_colours)),
                ("ANISOTROPY", f64::from(settings.anisotropy)),
                ("FADES", flag(settings.fades)),
                ("DEBUG_VIEW", f64::from(settings.debug_view.code())),
            ],
            polygon_mode: polygon_mode(device, settings.wireframe),
        };
        let entries = ("globe_vertex", "globe_fragment");
        let groups = [&bindings.frame.layout, &bindings.globe.layout];
        let sky_entries = ("globe_sky_vertex", "globe_sky_fragment");
        Self {
            ground: surface_pipeline(device, &GLOBE, entries, &options),
            sky: SkyPass::with(device, &GLOBE_SKY, sky_entries, &groups, settings.target),
        }
    }

    /// Draws the patches, then the sky where there is none.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        bindings: GlobeBindings<'_>,
        buffers: &PatchBuffers,
        patches: &[DrawnPatch],
    ) {
        bindings.set(pass);
        pass.set_pipeline(&self.ground);
        buffers.draw(pass, patches);
        self.sky.draw(pass, bindings.frame);
    }
}

/// Draws what pages each pixel of the globe asks for.
pub(crate) struct GlobeRequestPass {
    pipeline: wgpu::RenderPipeline,
}

impl GlobeRequestPass {
    /// With so many taps at the most.
    pub fn new(device: &wgpu::Device, bindings: GlobeBindings<'_>, anisotropy: u32) -> Self {
        let options = SurfaceOptions {
            groups: &bindings.layouts(),
            vertices: PatchBuffers::vertex_layout(),
            target: TargetKind { format: RequestImage::FORMAT, samples: 1 },
            constants: &[("ANISOTROPY", f64::from(anisotropy))],
            polygon_mode: wgpu::PolygonMode::Fill,
        };
        let entries = ("globe_request_vertex", "globe_request_fragment");
        Self { pipeline: surface_pipeline(device, &GLOBE_REQUESTS, entries, &options) }
    }

    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        bindings: GlobeBindings<'_>,
        buffers: &PatchBuffers,
        patches: &[DrawnPatch],
    ) {
        bindings.set(pass);
        pass.set_pipeline(&self.pipeline);
        buffers.draw(pass, patches);
    }
}

/// Draws where on the globe each pixel looks, in the format that measurement reads back.
pub(crate) fn draw_globe_coordinates(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    (frame, globe): (&FrameGroup, &GlobeGroup),
    (buffers, patches): (&PatchBuffers, &[DrawnPatch]),
    size_px: [u32; 2],
) -> wgpu::Texture {
    let options = SurfaceOptions {
        groups: &[&frame.layout, &globe.layout],
        vertices: PatchBuffers::vertex_layout(),
        // A mean of places on either side of an edge would be a place on neither.
        target: TargetKind { format: CoordinatePass::FULL_FORMAT, samples: 1 },
        constants: &[],
        polygon_mode: wgpu::PolygonMode::Fill,
    };
    let entries = ("globe_place_vertex", "globe_place_fragment");
    let pipeline = surface_pipeline(device, &GLOBE_COORDINATES, entries, &options);
    draw_full_coordinates(device, encoder, size_px, |pass| {
        pass.set_bind_group(0, &frame.group, &[]);
        pass.set_bind_group(GlobeGroup::GROUP, &globe.group, &[]);
        pass.set_pipeline(&pipeline);
        buffers.draw(pass, patches);
    })
}
