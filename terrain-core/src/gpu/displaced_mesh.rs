use super::displace_pass::DisplacePass;
use super::frame_bindings::FrameBindings;
use super::mesh_buffers::MeshBuffers;
use super::sort_triangles_pass::SortTrianglesPass;
use crate::surface::{CircularMesh, CircularMeshSettings};

/// A circular mesh on the GPU together with what is visible of it.
pub(crate) struct DisplacedMesh {
    mesh: CircularMesh,
    buffers: MeshBuffers,
    bindings: wgpu::BindGroup,
    sort_bindings: wgpu::BindGroup,
    settings: CircularMeshSettings,
    visible: Vec<u32>,
}

impl DisplacedMesh {
    /// Builds the mesh and sends it.
    pub fn new(
        device: &wgpu::Device,
        (displace, sort): (&DisplacePass, &SortTrianglesPass),
        settings: CircularMeshSettings,
    ) -> Self {
        let mesh = CircularMesh::build(&settings);
        let buffers = MeshBuffers::new(device, &mesh);
        let bindings = displace.bind_mesh(device, &buffers);
        let sort_bindings = sort.bind_mesh(device, &buffers);
        Self { mesh, buffers, bindings, sort_bindings, settings, visible: Vec::new() }
    }

    /// The mesh as built.
    pub fn mesh(&self) -> &CircularMesh {
        &self.mesh
    }

    /// Bytes sent to build the mesh.
    pub fn sent_bytes(&self) -> u64 {
        self.buffers.sent_bytes()
    }

    /// Whether the mesh is as fine as wanted and reaches at least as far.
    pub fn serves(&self, wanted: &CircularMeshSettings) -> bool {
        self.settings.spacing_ratio == wanted.spacing_ratio
            && self.settings.rho_max >= wanted.rho_max
    }

    /// Sets the blocks that are drawn; returns the bytes sent.
    pub fn set_visible(&mut self, queue: &wgpu::Queue, visible: Vec<u32>) -> u64 {
        let sent = self.buffers.set_visible(queue, &visible);
        self.visible = visible;
        sent
    }

    /// The blocks that are drawn.
    pub fn visible(&self) -> &[u32] {
        &self.visible
    }

    /// How many blocks and triangles are drawn.
    pub fn drawn(&self) -> (u64, u64) {
        let blocks = self.visible.iter().filter_map(|&index| self.mesh.blocks.get(index as usize));
        let indices = blocks.map(|block| u64::from(block.index_count)).sum::<u64>();
        (self.visible.len() as u64, indices / 3)
    }

    /// Records the displacement of the visible blocks.
    pub fn displace(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        displace: &DisplacePass,
        bindings: &FrameBindings,
    ) {
        let count = self.visible.len() as u32;
        displace.record(pass, bindings, &self.buffers, &self.bindings, count);
    }

    /// Records the sorting of the visible blocks' triangles, after their displacement.
    pub fn sort_triangles(&self, pass: &mut wgpu::ComputePass<'_>, sort: &SortTrianglesPass) {
        sort.record(pass, &self.buffers, &self.sort_bindings, self.visible.len() as u32);
    }

    /// The mesh and its buffers, for drawing.
    pub fn parts(&self) -> (&CircularMesh, &MeshBuffers) {
        (&self.mesh, &self.buffers)
    }
}
