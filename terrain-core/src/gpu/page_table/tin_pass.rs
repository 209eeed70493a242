use glam::{DVec3, Vec3, dvec3};

use super::page_bindings::PageBindings;
use super::page_ground::PageGroundGroup;
use super::request_image::RequestImage;
use crate::gpu::coordinate_pass::{CoordinatePass, draw_full_coordinates};
use crate::gpu::frame_group::FrameGroup;
use crate::gpu::ground_pipeline::{SurfaceOptions, flag, polygon_mode, surface_pipeline};
use crate::gpu::picture::TargetKind;
use crate::gpu::shader_library::PAGE_TIN;
use crate::renderer_settings::DebugView;
use crate::surface::tin::{GroundVertex, TinGround};

/// The `TinPlace` of `page_tin.wgsl`, where the members are explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct TinPlace {
    pub origin_from_eye_m: Vec3,
    pub padding: f32,
}

/// Ground made of triangles on the GPU: its vertices, and group 1 with its place.
pub(crate) struct TinBuffers {
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
    place: wgpu::Buffer,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
    written: Option<TinPlace>,
}

impl TinBuffers {
    const GROUP: u32 = 1;

    pub fn new(device: &wgpu::Device, ground: &TinGround) -> Self {
        use wgpu::BufferUsages as Usage;
        use wgpu::util::DeviceExt;
        let filled = |label, contents: &[u8], usage| {
            let label = Some(label);
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label, contents, usage })
        };
        let place = TinPlace { origin_from_eye_m: Vec3::ZERO, padding: 0.0 };
        let uniform = Usage::UNIFORM | Usage::COPY_DST;
        let place = filled("place of the ground", bytemuck::bytes_of(&place), uniform);
        let layout = group_layout(device);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("place of the ground"),
            layout: &layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: place.as_entire_binding() }],
        });
        Self {
            vertices: filled("ground", bytemuck::cast_slice(&ground.vertices), Usage::VERTEX),
            indices: filled("ground", bytemuck::cast_slice(&ground.indices), Usage::INDEX),
            index_count: ground.indices.len() as u32,
            layout,
            group,
            place,
            written: None,
        }
    }

    /// Bytes that making the buffers sent.
    pub fn sent_bytes(&self) -> u64 {
        self.vertices.size() + self.indices.size()
    }

    /// Writes where ground with this origin lies as seen from an eye, the difference taken in f64; returns the bytes
    /// sent, 0 where nothing changed.
    pub fn set_place(
        &mut self,
        queue: &wgpu::Queue,
        origin: DVec3,
        (eye, exaggeration): (DVec3, f64),
    ) -> u64 {
        let origin_from_eye_m = dvec3(origin.x, origin.y, origin.z * exaggeration) - eye;
        let place = TinPlace { origin_from_eye_m: origin_from_eye_m.as_vec3(), padding: 0.0 };
        if self.written == Some(place) {
            return 0;
        }
        queue.write_buffer(&self.place, 0, bytemuck::bytes_of(&place));
        self.written = Some(place);
        size_of::<TinPlace>() as u64
    }

    fn vertex_layout() -> wgpu::VertexBufferLayout<'static> {
        const ATTRIBUTES: [wgpu::VertexAttribute; 2] =
            wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x2];
        wgpu::VertexBufferLayout {
            array_stride: size_of::<GroundVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &ATTRIBUTES,
        }
    }
}

/// What such ground is drawn with: groups 0 to 3.
#[derive(Clone, Copy)]
pub(crate) struct TinBindings<'a> {
    pub frame: &'a FrameGroup,
    pub tin: &'a TinBuffers,
    pub pages: &'a PageBindings,
    pub ground: &'a PageGroundGroup,
}

impl TinBindings<'_> {
    fn pipeline(
        &self,
        device: &wgpu::Device,
        fragment_entry: &str,
        target: TargetKind,
        (constants, polygon_mode): (&[(&str, f64)], wgpu::PolygonMode),
    ) -> wgpu::RenderPipeline {
        let Self { frame, tin, pages, ground } = self;
        let options = SurfaceOptions {
            groups: &[&frame.layout, &tin.layout, &pages.layout, &ground.layout],
            vertices: TinBuffers::vertex_layout(),
            target,
            constants,
            polygon_mode,
        };
        surface_pipeline(device, &PAGE_TIN, ("tin_vertex", fragment_entry), &options)
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, pipeline: &wgpu::RenderPipeline) {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &self.frame.group, &[]);
        pass.set_bind_group(TinBuffers::GROUP, &self.tin.group, &[]);
        pass.set_bind_group(PageBindings::GROUP, &self.pages.group, &[]);
        pass.set_bind_group(PageGroundGroup::GROUP, &self.ground.group, &[]);
        pass.set_vertex_buffer(0, self.tin.vertices.slice(..));
        pass.set_index_buffer(self.tin.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..self.tin.index_count, 0, 0..1);
    }

    /// Draws where on the ground each pixel looks, into a texture of this size; see
    /// [`TerrainMethod::draw_coordinates`](crate::method::TerrainMethod::draw_coordinates).
    pub fn draw_coordinates(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        size_px: [u32; 2],
    ) -> wgpu::Texture {
        // A mean of places on either side of an edge would be a place on neither.
        let target = TargetKind { format: CoordinatePass::FULL_FORMAT, samples: 1 };
        let drawing: (&[(&str, f64)], _) = (&[], wgpu::PolygonMode::Fill);
        let pipeline = self.pipeline(device, "tin_coordinate_fragment", target, drawing);
        draw_full_coordinates(device, encoder, size_px, |pass| self.draw(pass, &pipeline))
    }
}

/// What decides how the picture's pipeline is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TinPassSettings {
    pub target: TargetKind,
    pub wireframe: bool,
    pub has_colours: bool,
    pub anisotropy: u32,
    /// Whether pages may show in part.
    pub fades: bool,
    pub debug_view: DebugView,
}

/// Draws ground made of triangles with imagery through a page table.
pub(crate) struct TinPass(wgpu::RenderPipeline);

impl TinPass {
    pub fn new(
        device: &wgpu::Device,
        bindings: TinBindings<'_>,
        settings: &TinPassSettings,
    ) -> Self {
        let constants = [
            ("HAS_COLOURS", flag(settings.has_colours)),
            ("MULTISAMPLED", flag(settings.target.samples > 1)),
            ("ANISOTROPY", f64::from(settings.anisotropy)),
            ("FADES", flag(settings.fades)),
            ("DEBUG_VIEW", f64::from(settings.debug_view.code())),
        ];
        let drawing: (&[(&str, f64)], _) = (&constants, polygon_mode(device, settings.wireframe));
        Self(bindings.pipeline(device, "tin_fragment", settings.target, drawing))
    }

    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, bindings: TinBindings<'_>) {
        bindings.draw(pass, &self.0);
    }
}

/// Draws what pages each pixel of such ground asks for.
pub(crate) struct TinRequestPass(wgpu::RenderPipeline);

impl TinRequestPass {
    pub fn new(device: &wgpu::Device, bindings: TinBindings<'_>, anisotropy: u32) -> Self {
        let target = TargetKind { format: RequestImage::FORMAT, samples: 1 };
        let constants = [("ANISOTROPY", f64::from(anisotropy))];
        let drawing: (&[(&str, f64)], _) = (&constants, wgpu::PolygonMode::Fill);
        Self(bindings.pipeline(device, "tin_request_fragment", target, drawing))
    }

    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, bindings: TinBindings<'_>) {
        bindings.draw(pass, &self.0);
    }
}

fn group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("place of the ground"),
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::VERTEX,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        }],
    })
}
