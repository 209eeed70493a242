use super::page_bindings::PageBindings;
use super::page_ground::PageGroundGroup;
use super::request_image::RequestImage;
use crate::gpu::frame_bindings::FrameBindings;
use crate::gpu::ground_pipeline::{SurfaceOptions, flag, polygon_mode, surface_pipeline};
use crate::gpu::mesh_buffers::MeshBuffers;
use crate::gpu::picture::TargetKind;
use crate::gpu::shader_library::{PAGE_REQUESTS, PAGE_TERRAIN};
use crate::gpu::terrain_pass::draw_blocks;
use crate::renderer_settings::DebugView;
use crate::surface::CircularMesh;

/// What plane ground with a page table is drawn with besides the mesh: groups 0 to 3.
#[derive(Clone, Copy)]
pub(crate) struct PageGroundBindings<'a> {
    pub frame: &'a FrameBindings,
    pub pages: &'a PageBindings,
    pub ground: &'a PageGroundGroup,
}

impl<'a> PageGroundBindings<'a> {
    pub(in crate::gpu) fn layouts(&self) -> [&'a wgpu::BindGroupLayout; 4] {
        let [frame, terrain] = self.frame.layouts();
        [frame, terrain, &self.pages.layout, &self.ground.layout]
    }

    pub(in crate::gpu) fn set(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_bind_group(PageBindings::GROUP, &self.pages.group, &[]);
        pass.set_bind_group(PageGroundGroup::GROUP, &self.ground.group, &[]);
    }
}

/// What decides how the picture's pipelines are built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PageGroundPassSettings {
    pub target: TargetKind,
    pub linear_lookup: bool,
    pub wireframe: bool,
    pub has_colours: bool,
    /// Whether there is ground without data, which is then left out of the picture.
    pub has_voids: bool,
    pub anisotropy: u32,
    /// Whether pages may show in part.
    pub fades: bool,
    pub debug_view: DebugView,
}

impl PageGroundPassSettings {
    /// The values of the shader's `override` constants.
    fn constants(&self) -> [(&'static str, f64); 7] {
        [
            ("LINEAR_LOOKUP", flag(self.linear_lookup)),
            ("HAS_COLOURS", flag(self.has_colours)),
            ("HAS_VOIDS", flag(self.has_voids)),
            ("MULTISAMPLED", flag(self.target.samples > 1)),
            ("ANISOTROPY", f64::from(self.anisotropy)),
            ("FADES", flag(self.fades)),
            ("DEBUG_VIEW", f64::from(self.debug_view.code())),
        ]
    }
}

/// Draws the displaced mesh with imagery through a page table.
pub(crate) struct PageGroundPass {
    /// For triangles within one height tile. `None` for pictures of what only a lookup tells.
    within: Option<wgpu::RenderPipeline>,
    across: wgpu::RenderPipeline,
}

impl PageGroundPass {
    pub fn new(
        device: &wgpu::Device,
        bindings: PageGroundBindings<'_>,
        settings: &PageGroundPassSettings,
    ) -> Self {
        let constants = settings.constants();
        let pipeline = |entries| {
            let options = SurfaceOptions {
                groups: &bindings.layouts(),
                vertices: MeshBuffers::vertex_layout(),
                target: settings.target,
                constants: &constants,
                polygon_mode: polygon_mode(device, settings.wireframe),
            };
            surface_pipeline(device, &PAGE_TERRAIN, entries, &options)
        };
        let is_plain = settings.debug_view == DebugView::Off;
        Self {
            within: is_plain.then(|| pipeline(("page_vertex_within", "page_fragment_within"))),
            across: pipeline(("page_vertex_across", "page_fragment_across")),
        }
    }

    /// Draws the visible blocks of the mesh.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        bindings: PageGroundBindings<'_>,
        (mesh, buffers): (&CircularMesh, &MeshBuffers),
        visible: &[u32],
    ) {
        bindings.set(pass);
        let mut draw = |pipeline, indices| {
            pass.set_pipeline(pipeline);
            draw_blocks(pass, bindings.frame, (mesh, buffers), indices, visible);
        };
        match &self.within {
            Some(within) => {
                draw(within, &buffers.indices_within);
                draw(&self.across, &buffers.indices_across);
            }
            None => draw(&self.across, &buffers.indices),
        }
    }
}

/// Draws what pages each pixel of the displaced mesh asks for.
pub(crate) struct PageRequestPass {
    pipeline: wgpu::RenderPipeline,
}

impl PageRequestPass {
    pub fn new(
        device: &wgpu::Device,
        bindings: PageGroundBindings<'_>,
        (linear_lookup, has_voids, anisotropy): (bool, bool, u32),
    ) -> Self {
        let options = SurfaceOptions {
            groups: &bindings.layouts(),
            vertices: MeshBuffers::vertex_layout(),
            target: TargetKind { format: RequestImage::FORMAT, samples: 1 },
            constants: &[
                ("LINEAR_LOOKUP", flag(linear_lookup)),
                ("HAS_VOIDS", flag(has_voids)),
                ("ANISOTROPY", f64::from(anisotropy)),
            ],
            polygon_mode: wgpu::PolygonMode::Fill,
        };
        let entries = ("request_vertex", "request_fragment");
        Self { pipeline: surface_pipeline(device, &PAGE_REQUESTS, entries, &options) }
    }

    /// Draws the visible blocks of the mesh.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        bindings: PageGroundBindings<'_>,
        mesh: (&CircularMesh, &MeshBuffers),
        visible: &[u32],
    ) {
        bindings.set(pass);
        pass.set_pipeline(&self.pipeline);
        draw_blocks(pass, bindings.frame, mesh, &mesh.1.indices, visible);
    }
}
