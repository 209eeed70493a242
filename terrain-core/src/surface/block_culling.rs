//! Which blocks of the circular mesh a view can see.

use glam::{DVec2, DVec3, dvec2};

use super::{CircularMesh, MeshBlock};
use crate::CameraView;
use crate::tiling::Extent;

/// What the rounding of a block's bounds to 32 bits may cost, in parts of its outer radius.
const BOUNDS_SLACK: f64 = 1.0e-6;
/// The widest wedge that is judged as a whole, radians.
const PIECE_RAD: f64 = std::f64::consts::TAU / 32.0;

impl CircularMesh {
    /// Indices of the blocks that may be seen, in the order of [`CircularMesh::blocks`].
    ///
    /// Conservative: a block is left out only if it can be cut into narrow sectors each of which has all
    /// its volume (the sector of the ring band times the height range) outside one of the view's side planes
    /// or behind the eye, or all its ground outside `data_extent`. A wide sector as a whole may reach inside
    /// every plane at another of its ends, with nothing of it in view: far bands would then be drawn in vain, and
    /// the more the farther the data goes.
    ///
    /// * `mesh_scale_m`: metres a unit of the mesh.
    /// * `mesh_centre_offset_m`: the mesh's centre less the eye, horizontally; usually zero.
    /// * `height_min_m`, `height_max_m`: range of the terrain drawn, vertical exaggeration included.
    pub fn visible_blocks(
        &self,
        view: &CameraView,
        mesh_scale_m: f64,
        mesh_centre_offset_m: DVec2,
        height_min_m: f64,
        height_max_m: f64,
        data_extent: &Extent,
    ) -> Vec<u32> {
        let planes = inward_normals(view);
        let eye = view.eye.truncate();
        let data = Extent::new(data_extent.min - eye, data_extent.max - eye);
        let bottom_m = height_min_m.min(height_max_m) - view.eye.z;
        let top_m = height_min_m.max(height_max_m) - view.eye.z;
        let is_visible = |wedge: &Wedge| {
            let meets_data = wedge.reach(DVec2::X) >= data.min.x
                && wedge.reach(DVec2::NEG_X) >= -data.max.x
                && wedge.reach(DVec2::Y) >= data.min.y
                && wedge.reach(DVec2::NEG_Y) >= -data.max.y;
            meets_data
                && planes.iter().all(|normal| {
                    let highest = (normal.z * bottom_m).max(normal.z * top_m);
                    wedge.reach(normal.truncate()) + highest >= 0.0
                })
        };
        let is_drawn = |block: &MeshBlock| {
            let whole = Wedge::new(block, mesh_scale_m, mesh_centre_offset_m);
            is_visible(&whole) && whole.pieces(block).any(|piece| is_visible(&piece))
        };
        (0u32..).zip(&self.blocks).filter(|(_, block)| is_drawn(block)).map(|(i, _)| i).collect()
    }
}

/// Inward normals (not of unit length) of the view's side planes, and of the plane through the eye
/// square to the view. All pass through the eye.
pub(super) fn inward_normals(view: &CameraView) -> [DVec3; 5] {
    let axes = view.view_from_world();
    let (right, up, forward) = (axes.row(0), axes.row(1), -axes.row(2));
    let half_height = (0.5 * view.fov_y_deg.to_radians()).tan();
    let (to_side, to_top) = (forward * (half_height * view.aspect()), forward * half_height);
    [to_side + right, to_side - right, to_top + up, to_top - up, forward]
}

/// The unit vector at an angle counter-clockwise from east.
fn direction(angle_rad: f64) -> DVec2 {
    dvec2(angle_rad.cos(), angle_rad.sin())
}

/// The ground plan of a block relative to the eye, in metres.
#[derive(Clone, Copy)]
struct Wedge {
    centre: DVec2,
    rho_min_m: f64,
    rho_max_m: f64,
    slack_m: f64,
    /// Unit directions of the two straight sides; `None` where the wedge goes all the way round.
    sides: Option<[DVec2; 2]>,
}

impl Wedge {
    fn new(block: &MeshBlock, mesh_scale_m: f64, centre: DVec2) -> Self {
        let [from, to] = [block.angle_min_rad, block.angle_max_rad].map(f64::from);
        let is_sector = to - from < std::f64::consts::PI;
        let rho_max_m = f64::from(block.rho_max) * mesh_scale_m;
        Self {
            centre,
            rho_min_m: f64::from(block.rho_min) * mesh_scale_m,
            rho_max_m,
            slack_m: BOUNDS_SLACK * rho_max_m,
            sides: is_sector.then(|| [from, to].map(direction)),
        }
    }

    /// The block's wedge cut into narrow ones.
    fn pieces(&self, block: &MeshBlock) -> impl Iterator<Item = Self> {
        let [from, to] = [block.angle_min_rad, block.angle_max_rad].map(f64::from);
        let count = ((to - from) / PIECE_RAD).ceil();
        let angle = move |index: u32| direction(from + (to - from) * f64::from(index) / count);
        let whole = *self;
        (0..count as u32).map(move |i| Self { sides: Some([angle(i), angle(i + 1)]), ..whole })
    }

    /// The support function: the greatest `direction . p` of all points p of the wedge.
    ///
    /// With the direction's angle inside the sector that is the outer radius times its length;
    /// outside, the maximum lies on the nearer side, at its outer or inner end.
    fn reach(&self, direction: DVec2) -> f64 {
        let length = direction.length();
        let along = match self.sides {
            Some([from, to]) if from.perp_dot(direction) < 0.0 || direction.perp_dot(to) < 0.0 => {
                from.dot(direction).max(to.dot(direction))
            }
            _ => length,
        };
        let rho_m = if along > 0.0 { self.rho_max_m } else { self.rho_min_m };
        direction.dot(self.centre) + along * rho_m + length * self.slack_m
    }
}
