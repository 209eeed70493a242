use std::path::Path;

use glam::{DVec2, DVec3, USizeVec2, Vec2, Vec3, dvec2};
use serde::Deserialize;

use crate::dataset::{Crs, Shape};
use crate::surface::models::{Model, ModelError};

/// A vertex of ground, as the GPU reads it: five words, without gaps.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct GroundVertex {
    /// Metres east, north and up of the ground's origin.
    pub position_m: Vec3,
    /// Metres that the ground rises a metre east and north.
    pub slope: Vec2,
}

/// Ground made of triangles, read from a file that [`write_glb`](super::write_glb) wrote, at its place.
#[derive(Clone, Debug)]
pub struct TinGround {
    /// Place of the vertices' origin: x and y in the CRS, metres above the datum.
    pub origin: DVec3,
    /// Vertices relative to it.
    pub vertices: Vec<GroundVertex>,
    /// Three a triangle, counter-clockwise as seen from above.
    pub indices: Vec<u32>,
    epsg: Option<u32>,
    lookup: TriangleGrid,
}

/// What the node of such a file says besides.
#[derive(Deserialize)]
struct Extras {
    crs: Option<String>,
    origin: [f64; 3],
    metres_per_unit: [f64; 2],
}

impl TinGround {
    /// Reads a file.
    ///
    /// # Errors
    /// [`ModelError`] where the file is no glTF, does not say where it lies, or is not placed in metres.
    pub fn load(path: &Path) -> Result<Self, ModelError> {
        let model = Model::load(path)?;
        Self::of_model(&model).map_err(|reason| ModelError { path: path.to_owned(), reason })
    }

    /// The ground of a file already read.
    ///
    /// # Errors
    /// In words; as [`Self::load`].
    pub fn of_model(model: &Model) -> Result<Self, String> {
        let extras = model.extras.as_deref().and_then(|text| serde_json::from_str(text).ok());
        let Some(Extras { crs, origin, metres_per_unit }) = extras else {
            return Err("it does not say where it lies: no TIN of terrain tin".to_owned());
        };
        let epsg = crs.and_then(|crs| crs.strip_prefix("EPSG:")?.parse().ok());
        if metres_per_unit != [1.0; 2] {
            return Err("its CRS is not in metres; make it of a raster in the dataset's".to_owned());
        }
        let vertex = |position_m: Vec3, normal: Vec3| GroundVertex {
            position_m,
            slope: -normal.truncate() / normal.z.max(1.0e-3),
        };
        let vertices = model.vertices.iter();
        let vertices: Vec<_> = vertices.map(|v| vertex(v.position_m, v.normal)).collect();
        Ok(Self {
            lookup: TriangleGrid::new(&vertices, &model.indices),
            origin: DVec3::from(origin),
            indices: model.indices.clone(),
            vertices,
            epsg,
        })
    }

    /// Checks that it lies on the ground of a dataset of this CRS and shape.
    ///
    /// # Errors
    /// In words, where that is a globe, or both name a CRS and they differ.
    pub fn check_place(&self, crs: &Crs, shape: Shape) -> Result<(), String> {
        if shape == Shape::Globe {
            return Err("a TIN lies on a plane, and the dataset is a globe".to_owned());
        }
        match (self.epsg, crs.epsg) {
            (Some(theirs), Some(ours)) if theirs != ours => {
                Err(format!("the TIN is in EPSG:{theirs}, the dataset is in EPSG:{ours}"))
            }
            _ => Ok(()),
        }
    }

    /// Height in metres above the datum at a place of the CRS; `None` beside the triangles.
    pub fn height_m(&self, place: DVec2) -> Option<f64> {
        let local = place - self.origin.truncate();
        let corner = |index: u32| self.vertices[index as usize].position_m.as_dvec3();
        let heights = self.lookup.near(local).filter_map(|triangle| {
            let corners = self.indices.get(3 * triangle as usize..)?.first_chunk::<3>()?;
            height_in(corners.map(corner), local)
        });
        heights.map(|height_m| self.origin.z + height_m).next()
    }
}

/// Height of a triangle at a place; `None` beside it.
fn height_in([a, b, c]: [DVec3; 3], place: DVec2) -> Option<f64> {
    let weight = |from: DVec3, to: DVec3| (to - from).truncate().perp_dot(place - from.truncate());
    let weights = [weight(b, c), weight(c, a), weight(a, b)];
    let area = weights.iter().sum::<f64>();
    // What lies on an edge belongs to both sides, however it is rounded.
    let is_inside = area > 0.0 && weights.iter().all(|weight| *weight >= -1.0e-9 * area);
    is_inside.then(|| (weights[0] * a.z + weights[1] * b.z + weights[2] * c.z) / area)
}

/// Which triangles may lie at a place: lists of them for the cells of a grid.
#[derive(Clone, Debug)]
struct TriangleGrid {
    min: DVec2,
    cell_m: DVec2,
    cells: USizeVec2,
    /// Where each cell's list begins, and the end of the last.
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl TriangleGrid {
    /// About as many cells as triangles.
    fn new(vertices: &[GroundVertex], indices: &[u32]) -> Self {
        let places = || vertices.iter().map(|vertex| vertex.position_m.as_dvec3().truncate());
        let min = places().fold(DVec2::INFINITY, DVec2::min);
        let max = places().fold(DVec2::NEG_INFINITY, DVec2::max);
        let side = ((indices.len() / 3) as f64).sqrt().ceil().clamp(1.0, 2_048.0);
        let cell_m = ((max - min) / side).max(DVec2::splat(f64::MIN_POSITIVE));
        let cells = USizeVec2::splat(side as usize);
        let mut grid = Self { min, cell_m, cells, starts: Vec::new(), triangles: Vec::new() };
        let ranges = indices.as_chunks::<3>().0.iter().map(|corners| {
            let corners = corners.map(|corner| vertices[corner as usize].position_m);
            let low = corners.iter().copied().fold(Vec3::INFINITY, Vec3::min);
            let high = corners.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
            [low, high].map(|corner| grid.cell(corner.as_dvec3().truncate()))
        });
        let ranges: Vec<_> = ranges.collect();
        let cells_of = |[low, high]: [USizeVec2; 2]| {
            (low.y..=high.y).flat_map(move |y| (low.x..=high.x).map(move |x| y * cells.x + x))
        };
        let mut starts = vec![0_u32; cells.x * cells.y + 1];
        ranges.iter().flat_map(|range| cells_of(*range)).for_each(|cell| starts[cell + 1] += 1);
        for cell in 1..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let mut ends = starts.clone();
        grid.triangles = vec![0; starts[cells.x * cells.y] as usize];
        for (range, triangle) in ranges.iter().zip(0..) {
            for cell in cells_of(*range) {
                grid.triangles[ends[cell] as usize] = triangle;
                ends[cell] += 1;
            }
        }
        grid.starts = starts;
        grid
    }

    fn cell(&self, place: DVec2) -> USizeVec2 {
        let cell = ((place - self.min) / self.cell_m).max(DVec2::ZERO);
        let last = (self.cells - 1).as_dvec2();
        cell.min(dvec2(last.x, last.y)).as_usizevec2()
    }

    /// The triangles of the cell that holds the place, or the nearest one.
    fn near(&self, place: DVec2) -> impl Iterator<Item = u32> + '_ {
        let cell = self.cell(place);
        let index = cell.y * self.cells.x + cell.x;
        let list = self.starts[index] as usize..self.starts[index + 1] as usize;
        self.triangles[list].iter().copied()
    }
}
