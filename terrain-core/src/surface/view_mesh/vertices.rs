use glam::IVec2;

use super::height_patch::GroundSample;
use super::indexed_list::ChangedIds;

/// A vertex of the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewVertex {
    /// Fixed-point units from the root's north-west corner: x to the east, y to the south; 0 to 2^30.
    pub position: IVec2,
    /// Metres above the datum, without exaggeration.
    pub height_m: f32,
    /// Metres gained per metre east and north.
    pub slope: [f32; 2],
    /// Part of the four nearest samples, by their weights, that hold data.
    pub coverage: f32,
}

impl ViewVertex {
    /// The vertex of the ground at a position.
    pub fn new(position: IVec2, ground: GroundSample) -> Self {
        let GroundSample { height_m, slope, coverage } = ground;
        Self { position, height_m, slope, coverage }
    }
}

/// The vertices there are, by number, and which have changed.
#[derive(Default)]
pub(super) struct Vertices {
    vertices: Vec<ViewVertex>,
    is_live: Vec<bool>,
    free: Vec<u32>,
    changed: ChangedIds,
}

impl Vertices {
    /// Numbers are below this.
    pub fn capacity(&self) -> usize {
        self.vertices.len()
    }

    /// A vertex by its number.
    pub fn get(&self, number: u32) -> &ViewVertex {
        &self.vertices[number as usize]
    }

    /// Adds a vertex; returns its number.
    pub fn add(&mut self, vertex: ViewVertex) -> u32 {
        let number = self.free.pop().unwrap_or(self.vertices.len() as u32);
        let index = number as usize;
        if index == self.vertices.len() {
            self.vertices.push(vertex);
            self.is_live.push(true);
        } else {
            (self.vertices[index], self.is_live[index]) = (vertex, true);
        }
        self.changed.mark(number);
        number
    }

    /// Frees the number of a vertex.
    pub fn remove(&mut self, number: u32) {
        self.is_live[number as usize] = false;
        self.free.push(number);
    }

    /// Puts other ground at a vertex; without data there, its height stays.
    pub fn set_ground(&mut self, number: u32, ground: GroundSample) {
        let old = self.vertices[number as usize];
        let mut new = ViewVertex::new(old.position, ground);
        if new.coverage == 0.0 {
            new.height_m = old.height_m;
        }
        if new != old {
            self.vertices[number as usize] = new;
            self.changed.mark(number);
        }
    }

    /// How many numbers have changed.
    pub fn changed(&self) -> usize {
        self.changed.len()
    }

    /// Takes the changed vertices that there still are, their numbers rising.
    pub fn take_changed(&mut self) -> Vec<(u32, ViewVertex)> {
        let numbers = self.changed.take().into_iter();
        let live = numbers.filter(|&number| self.is_live[number as usize]);
        live.map(|number| (number, self.vertices[number as usize])).collect()
    }
}
