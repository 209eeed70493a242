//! Triangulated irregular networks: few large triangles where the ground is plain, many small ones
//! where it is not.
//!
//! - [`tin_of_grid`] covers a raster with triangles that keep within a stated error of every sample.
//! - [`tin_of_points`] joins scattered points, all of them; [`tin_of_points_within`] as few as keep the
//!   others within a stated error.
//! - [`NaturalNeighbours`] interpolates scattered points, for rasters and for gaps in them.
//! - [`write_glb`] hands a TIN to other programs, [`TinGround`] reads it back to be drawn.
//!
//! Coordinates stay f64 in the dataset's CRS; heights are metres. All of it is pure, and whatever is
//! decided geometrically (which side, which circle) is decided exactly, by spade's predicates.

mod border;
mod breakline;
mod error;
mod glb;
mod greedy;
mod ground;
mod natural_neighbours;
mod sample_grid;
mod scattered;
mod thinned;
mod triangle_scan;
mod worst;

pub use breakline::{Breakline, BreaklinePoint};
pub use error::TinError;
pub use glb::{GlbPlace, write_glb};
pub use greedy::tin_of_grid;
pub use ground::{GroundVertex, TinGround};
pub use natural_neighbours::{NaturalNeighbours, NaturalSampler};
pub use sample_grid::SampleGrid;
pub use scattered::{DistinctPoints, tin_of_points};
pub use thinned::tin_of_points_within;

/// A triangulated irregular network.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tin {
    /// x and y in the dataset's CRS, height in metres. Every vertex belongs to a triangle.
    pub vertices: Vec<[f64; 3]>,
    /// Three different vertices each, counter-clockwise as seen from above.
    pub triangles: Vec<[u32; 3]>,
}

impl Tin {
    /// Smallest and largest x, y and height of all vertices; infinite where there are none.
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        for vertex in &self.vertices {
            for axis in 0..3 {
                bounds[0][axis] = bounds[0][axis].min(vertex[axis]);
                bounds[1][axis] = bounds[1][axis].max(vertex[axis]);
            }
        }
        bounds
    }
}

/// Says whether to go on; called now and then with the error still left in metres and the number of
/// vertices so far.
pub type KeepGoing<'a> = dyn FnMut(f64, usize) -> bool + 'a;

#[cfg(test)]
mod tests;
