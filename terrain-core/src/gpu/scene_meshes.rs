use std::f64::consts::TAU;

use glam::DVec2;

use super::displace_pass::DisplacePass;
use super::displaced_mesh::DisplacedMesh;
use super::frame_bindings::FrameBindings;
use super::sort_triangles_pass::SortTrianglesPass;
use crate::CameraView;
use crate::surface::CircularMeshSettings;
use crate::tiling::Extent;

/// The two meshes of a scene, the picture's and the coarser one of the coordinate pass, and the
/// passes that displace them. Each is built anew only when a view asks for one much finer or wider.
pub(crate) struct SceneMeshes {
    displace: DisplacePass,
    sort_triangles: SortTrianglesPass,
    picture: Option<DisplacedMesh>,
    coordinates: Option<DisplacedMesh>,
}

/// What of the ground a view may see.
pub(crate) struct MeshScene<'a> {
    pub view: &'a CameraView,
    /// Metres a unit of the mesh.
    pub scale_m: f64,
    /// Radius the mesh is to have, in units of its scale.
    pub radius: f64,
    /// Lowest and highest ground, exaggerated.
    pub height_range_m: [f64; 2],
    pub data_extent: &'a Extent,
    pub triangle_px: f64,
    /// Whether there may be a coordinate pass.
    pub has_coordinates: bool,
}

impl SceneMeshes {
    /// How much larger the coordinate pass's triangles are.
    const COORDINATE_TRIANGLE_FACTOR: f64 = 4.0;

    pub fn new(device: &wgpu::Device, bindings: &FrameBindings, linear_lookup: bool) -> Self {
        Self {
            displace: DisplacePass::new(device, bindings, linear_lookup),
            sort_triangles: SortTrianglesPass::new(device),
            picture: None,
            coordinates: None,
        }
    }

    /// The picture's mesh; `None` before the first scene.
    pub fn picture(&self) -> Option<&DisplacedMesh> {
        self.picture.as_ref()
    }

    /// The coordinate pass's mesh; `None` before the first scene.
    pub fn coordinates(&self) -> Option<&DisplacedMesh> {
        self.coordinates.as_ref()
    }

    /// Brings the meshes that are needed to the scene. Returns the bytes sent and whether a mesh was built anew, so
    /// that nothing of it is displaced yet.
    pub fn set_up(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        scene: &MeshScene<'_>,
    ) -> (u64, bool) {
        let passes = (&self.displace, &self.sort_triangles);
        let (mut sent, mut rebuilt) = (0, false);
        let picture = Some((&mut self.picture, 1.0));
        let coordinates = (&mut self.coordinates, Self::COORDINATE_TRIANGLE_FACTOR);
        let coordinates = scene.has_coordinates.then_some(coordinates);
        for (mesh, factor) in picture.into_iter().chain(coordinates) {
            let wanted = scene.mesh_settings(factor);
            let mesh = match mesh.take() {
                Some(built) if built.serves(&wanted) => mesh.insert(built),
                _ => {
                    let built = DisplacedMesh::new(device, passes, wanted);
                    sent += built.sent_bytes();
                    rebuilt = true;
                    mesh.insert(built)
                }
            };
            let visible = scene.visible_blocks(mesh);
            sent += mesh.set_visible(queue, visible);
        }
        (sent, rebuilt)
    }

    /// Records the displacement of what is visible of either mesh.
    pub fn displace(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        bindings: &FrameBindings,
        [picture, coordinates]: [bool; 2],
    ) {
        let picture = self.picture.as_ref().filter(|_| picture);
        let coordinates = self.coordinates.as_ref().filter(|_| coordinates);
        for mesh in picture.into_iter().chain(coordinates) {
            mesh.displace(pass, &self.displace, bindings);
        }
        if let Some(mesh) = picture {
            mesh.sort_triangles(pass, &self.sort_triangles);
        }
    }
}

impl MeshScene<'_> {
    /// About how many vertices a mesh may have.
    const MOST_VERTICES: f64 = 1.0e6;

    /// The mesh the view wants: spacing ratios in steps of a quarter octave and reaches of powers of
    /// four, so that zooming and moving seldom build it anew.
    fn mesh_settings(&self, factor: f64) -> CircularMeshSettings {
        let rho_max = 4.0_f64.powf(self.radius.max(1.0).log(4.0).ceil());
        // Rings times segments: asinh(radius) / ratio times 2 pi / ratio. A telephoto view would want
        // more than memory holds, most of it out of sight.
        let least_ratio = (TAU * rho_max.asinh() / Self::MOST_VERTICES).sqrt();
        let ratio = (self.triangle_px * factor * self.view.pixel_angle_rad()).max(least_ratio);
        CircularMeshSettings { spacing_ratio: ((4.0 * ratio.log2()).floor() / 4.0).exp2(), rho_max }
    }

    fn visible_blocks(&self, mesh: &DisplacedMesh) -> Vec<u32> {
        let [low_m, high_m] = self.height_range_m;
        mesh.mesh().visible_blocks(
            self.view,
            self.scale_m,
            DVec2::ZERO,
            low_m,
            high_m,
            self.data_extent,
        )
    }
}
