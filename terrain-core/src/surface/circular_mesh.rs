use std::f64::consts::TAU;

use bytemuck::{Pod, Zeroable};

use super::ring_layout::RingLayout;

/// How fine a [`CircularMesh`] is and how far it reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CircularMeshSettings {
    /// Spacing of the vertices over their distance from an eye at height 1 over the centre:
    /// the size a triangle is to have in pixels times the angle of a pixel in radians. Taken to the
    /// nearest value within [`CircularMeshSettings::SPACING_RATIOS`].
    pub spacing_ratio: f64,
    /// Radius the mesh covers, in units of its scale. Taken to the nearest value within
    /// [`CircularMeshSettings::RADII`].
    pub rho_max: f64,
}

impl CircularMeshSettings {
    /// The spacing ratios a mesh can have; the lowest at the largest radius gives some six million
    /// vertices.
    pub const SPACING_RATIOS: std::ops::RangeInclusive<f64> = 0.004..=0.5;
    /// The radii a mesh can have; beyond the largest, 32-bit floats no longer tell vertices apart.
    pub const RADII: std::ops::RangeInclusive<f64> = 1.0..=1.0e6;

    fn clamped(self) -> Self {
        let clamp = |value: f64, range: std::ops::RangeInclusive<f64>| {
            // `max` before `min`: a NaN becomes the lower end.
            value.max(*range.start()).min(*range.end())
        };
        Self {
            spacing_ratio: clamp(self.spacing_ratio, Self::SPACING_RATIOS),
            rho_max: clamp(self.rho_max, Self::RADII),
        }
    }
}

/// A vertex of a [`CircularMesh`], as the GPU reads it (12 bytes).
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct MeshVertex {
    /// East and north of the mesh's centre, in units of its scale.
    pub offset: [f32; 2],
    /// Distance to the neighbouring vertices (the larger of the two directions), same unit.
    pub spacing: f32,
}

/// A part of a [`CircularMesh`] that is drawn or culled as a whole: a sector of a band of rings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshBlock {
    /// First of the block's own vertices.
    pub vertex_start: u32,
    /// Number of the block's own vertices.
    pub vertex_count: u32,
    /// First of the block's indices.
    pub index_start: u32,
    /// Number of the block's indices, a multiple of 3. They count from the *mesh's* first vertex.
    pub index_count: u32,
    /// Least distance of the block's triangles from the centre, in units of the mesh's scale.
    pub rho_min: f32,
    /// Greatest distance of the block's triangles from the centre, in units of the mesh's scale.
    pub rho_max: f32,
    /// Where the sector begins: radians counter-clockwise from east, in 0..2 pi.
    pub angle_min_rad: f32,
    /// Where the sector ends: above `angle_min_rad`, at most 2 pi.
    pub angle_max_rad: f32,
}

/// A flat disc of triangles whose size grows with the distance from its centre.
///
/// The circular grid with continuous level of detail of Liu Hao et al., "Dynamic Scheduling and
/// Real-time Rendering Method for Large-Scale Terrain", section 3.3. Centred under the eye it is
/// equally dense in all directions, so turning the view costs nothing, and being one connected mesh
/// it cannot crack.
///
/// The paper fixes neither the law of the rings nor that of their segments. Here the spacing
/// between rings at radius `rho` is `alpha * sqrt(rho^2 + 1)` (see `RingLayout`), and segments halve
/// towards the centre where arcs would become much shorter than that; the rings between are joined
/// two to one without T-junctions. The mesh is *normalised*: radii are in units of a scale, about the
/// height of the eye over the ground, which the caller multiplies in.
#[derive(Clone, Debug, PartialEq)]
pub struct CircularMesh {
    /// The vertices, block by block; blocks repeat those on their borders bit for bit.
    pub vertices: Vec<MeshVertex>,
    /// Triangles, counter-clockwise seen from above, block by block and ring by ring within a block
    /// so that a vertex is used again soon after its first use.
    pub indices: Vec<u32>,
    /// The blocks, from the centre outwards.
    pub blocks: Vec<MeshBlock>,
}

/// Rings of the one block at the centre.
const CENTRE_RINGS: usize = 8;
/// Rings a block spans, and segments of a ring it spans at the most.
const BLOCK_SIZE: u32 = 16;

impl CircularMesh {
    /// Builds the mesh. Settings out of range are taken to the nearest end of their range.
    pub fn build(settings: &CircularMeshSettings) -> Self {
        let settings = settings.clamped();
        let rings = RingLayout::new(settings.spacing_ratio, settings.rho_max);
        let mut builder = MeshBuilder::new(&rings);
        let mut first = CENTRE_RINGS.min(rings.last_ring());
        builder.add_centre(first);
        while first < rings.last_ring() {
            let last = (first + BLOCK_SIZE as usize).min(rings.last_ring());
            let sectors = rings.sectors(first, last, BLOCK_SIZE);
            for sector in 0..sectors {
                builder.add_sector(first, last, sector, sectors);
            }
            first = last;
        }
        builder.mesh
    }

    /// Bytes of the vertices and indices as they go to the GPU.
    pub fn byte_len(&self) -> u64 {
        (size_of_val(&*self.vertices) + size_of_val(&*self.indices)) as u64
    }
}

struct MeshBuilder<'a> {
    rings: &'a RingLayout,
    mesh: CircularMesh,
}

impl<'a> MeshBuilder<'a> {
    fn new(rings: &'a RingLayout) -> Self {
        let mesh = CircularMesh { vertices: Vec::new(), indices: Vec::new(), blocks: Vec::new() };
        Self { rings, mesh }
    }

    /// The centre point, its fan and the rings out to `last`, all in one block.
    fn add_centre(&mut self, last: usize) {
        let (vertex_start, index_start) = (self.mesh.vertices.len(), self.mesh.indices.len());
        let centre = self.add_vertex(0, 0);
        let mut inner = self.add_closed_row(1);
        for pair in inner.windows(2) {
            self.mesh.indices.extend([centre, pair[0], pair[1]]);
        }
        for ring in 2..=last {
            let outer = self.add_closed_row(ring);
            self.add_strip(&inner, &outer);
            inner = outer;
        }
        self.finish_block(vertex_start, index_start, [0.0, self.rings.radius(last)], [0.0, TAU]);
    }

    /// One sector of the band of rings `first..=last`.
    fn add_sector(&mut self, first: usize, last: usize, sector: u32, sectors: u32) {
        let (vertex_start, index_start) = (self.mesh.vertices.len(), self.mesh.indices.len());
        let mut inner = self.add_sector_row(first, sector, sectors);
        for ring in first + 1..=last {
            let outer = self.add_sector_row(ring, sector, sectors);
            self.add_strip(&inner, &outer);
            inner = outer;
        }
        // The innermost chords reach below their ring's radius.
        let half_segment = 0.5 * TAU / f64::from(self.rings.segments(first));
        let rho_min = self.rings.radius(first) * half_segment.cos();
        let angle = |index: u32| TAU * f64::from(index) / f64::from(sectors);
        let angles_rad = [angle(sector), angle(sector + 1)];
        self.finish_block(
            vertex_start,
            index_start,
            [rho_min, self.rings.radius(last)],
            angles_rad,
        );
    }

    fn add_closed_row(&mut self, ring: usize) -> Vec<u32> {
        let segments = self.rings.segments(ring);
        let mut row: Vec<u32> = (0..segments).map(|i| self.add_vertex(ring, i)).collect();
        row.push(row[0]);
        row
    }

    fn add_sector_row(&mut self, ring: usize, sector: u32, sectors: u32) -> Vec<u32> {
        let width = self.rings.segments(ring) / sectors;
        (sector * width..=(sector + 1) * width).map(|i| self.add_vertex(ring, i)).collect()
    }

    fn add_vertex(&mut self, ring: usize, segment: u32) -> u32 {
        let offset = self.rings.position(ring, segment);
        let spacing = self.rings.vertex_spacing(ring) as f32;
        self.mesh.vertices.push(MeshVertex { offset, spacing });
        self.mesh.vertices.len() as u32 - 1
    }

    /// The triangles between two rows of equally many segments, or twice as many on the outer one.
    fn add_strip(&mut self, inner: &[u32], outer: &[u32]) {
        let indices = &mut self.mesh.indices;
        let is_transition = outer.len() > inner.len();
        for (i, pair) in inner.windows(2).enumerate() {
            let (a0, a1) = (pair[0], pair[1]);
            if is_transition {
                let (o0, o1, o2) = (outer[2 * i], outer[2 * i + 1], outer[2 * i + 2]);
                indices.extend([a0, o0, o1, a0, o1, a1, a1, o1, o2]);
            } else {
                indices.extend([a0, outer[i], outer[i + 1], a0, outer[i + 1], a1]);
            }
        }
    }

    fn finish_block(
        &mut self,
        vertex_start: usize,
        index_start: usize,
        rho: [f64; 2],
        angles_rad: [f64; 2],
    ) {
        self.mesh.blocks.push(MeshBlock {
            vertex_start: vertex_start as u32,
            vertex_count: (self.mesh.vertices.len() - vertex_start) as u32,
            index_start: index_start as u32,
            index_count: (self.mesh.indices.len() - index_start) as u32,
            rho_min: rho[0] as f32,
            rho_max: rho[1] as f32,
            angle_min_rad: angles_rad[0] as f32,
            angle_max_rad: angles_rad[1] as f32,
        });
    }
}
