use bytemuck::{Pod, Zeroable};
use glam::{DVec2, dvec2};

use super::atlas::AtlasGrid;
use super::frame_uniforms::TableRange;
use crate::residency::OffsetTable;
use crate::tiling::{LayerLayout, TileId, TilingScheme};

/// Where a tile lies, on the ground and in its atlas, both told from one of its texels: the twin of
/// `TilePlace` in `common/tile_lookup.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TilePlace {
    /// North-west corner of that texel relative to the eye, metres east and north (difference taken in
    /// f64).
    pub origin_from_eye_m: [f32; 2],
    /// Texels a metre.
    pub texels_per_m: f32,
    /// That texel in the atlas: its column in the low half, its row in the high.
    pub atlas_texel: u32,
}

/// Which texel of a tile the shaders tell places in it from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToldFrom {
    /// The first texel of the tile proper: floats then have a part in 2^24 of the tile's side.
    Corner,
    /// The one whose corner is nearest to the eye: places close to the eye are small numbers, and exact
    /// to a part in 2^24 of a texel or of the distance, whichever is more, however large the tile.
    NearEye,
}

impl ToldFrom {
    /// Column and row of the texel; up to the tile's size, just beyond its last.
    pub fn texel(
        self,
        scheme: &TilingScheme,
        layout: &LayerLayout,
        tile: TileId,
        eye: DVec2,
    ) -> [u32; 2] {
        if self == Self::Corner {
            return [0, 0];
        }
        let from_corner = eye - scheme.tile_origin(tile);
        let texel_m = layout.texel_size_m(scheme, tile.level);
        let size = f64::from(layout.tile_size_texels);
        [from_corner.x, -from_corner.y]
            .map(|metres| (metres / texel_m).round().clamp(0.0, size) as u32)
    }
}

impl TilePlace {
    /// Where the tile lies, seen from `eye` (metres east and north), told from one of its texels.
    /// `atlas_corner` is the place of the tile's first texel in the atlas.
    pub fn new(
        scheme: &TilingScheme,
        layout: &LayerLayout,
        tile: TileId,
        eye: DVec2,
        texel: [u32; 2],
        atlas_corner: [u32; 2],
    ) -> Self {
        let texel_m = layout.texel_size_m(scheme, tile.level);
        let from_corner = dvec2(f64::from(texel[0]), -f64::from(texel[1])) * texel_m;
        // A texture has at most 16384 texels a side: two coordinates fit in a word.
        let [x, y] = [atlas_corner[0] + texel[0], atlas_corner[1] + texel[1]];
        Self {
            origin_from_eye_m: (scheme.tile_origin(tile) + from_corner - eye).as_vec2().into(),
            texels_per_m: (1.0 / texel_m) as f32,
            atlas_texel: x | (y << 16),
        }
    }
}

/// One cached tile as the shaders see it: the twin of `TileEntry` in `common/tile_lookup.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TileEntry {
    /// Where the tile lies.
    pub place: TilePlace,
    /// Level of the tile.
    pub level: u32,
    /// Column of the tile.
    pub column: u32,
    /// Row of the tile.
    pub row: u32,
    /// Zero: the shaders' struct is a multiple of 8 bytes.
    pub padding: u32,
}

/// A layer's table together with what places its tiles on the ground and in the atlas.
pub(crate) struct TableSource<'a> {
    pub table: &'a OffsetTable,
    pub layout: LayerLayout,
    pub grid: AtlasGrid,
    pub told_from: ToldFrom,
}

impl TableSource<'_> {
    fn entries(&self, scheme: &TilingScheme, eye: DVec2) -> impl Iterator<Item = TileEntry> {
        self.table.entries.iter().map(move |entry| {
            let layout = &self.layout;
            let corner = self
                .grid
                .slot_origin_texels(entry.slot)
                .map(|corner| corner + self.layout.gutter_texels);
            let texel = self.told_from.texel(scheme, layout, entry.tile, eye);
            TileEntry {
                place: TilePlace::new(scheme, layout, entry.tile, eye, texel, corner),
                level: u32::from(entry.tile.level),
                column: entry.tile.column,
                row: entry.tile.row,
                padding: 0,
            }
        })
    }
}

/// The tile offset tables of both layers on the GPU, one after the other.
pub(crate) struct OffsetTableBuffer {
    pub entries: wgpu::Buffer,
    pub nodes: wgpu::Buffer,
    written_entries: Vec<TileEntry>,
    written_nodes: Vec<u32>,
}

impl OffsetTableBuffer {
    pub fn new(device: &wgpu::Device) -> Self {
        Self {
            entries: storage(device, "tile entries", 64 * size_of::<TileEntry>() as u64),
            nodes: storage(device, "tile nodes", 4096),
            written_entries: Vec::new(),
            written_nodes: Vec::new(),
        }
    }

    /// Makes room for so many bytes of entries and nodes that are written on the GPU. What was there is
    /// lost.
    pub fn make_room(&mut self, device: &wgpu::Device, entries_bytes: u64, nodes_bytes: u64) {
        self.entries = storage(device, "tile entries", entries_bytes);
        self.nodes = storage(device, "tile nodes", nodes_bytes);
    }

    /// Brings the tables to the GPU. Returns where each layer's table lies, the bytes sent (0 where
    /// nothing changed) and whether the buffers grew, so that they must be bound anew.
    pub fn update(
        &mut self,
        gpu: (&wgpu::Device, &wgpu::Queue),
        scheme: &TilingScheme,
        eye: DVec2,
        layers: [Option<&TableSource<'_>>; 2],
    ) -> TableUpdate {
        let (mut entries, mut nodes) = (Vec::new(), Vec::new());
        let ranges = layers.map(|layer| {
            let Some(layer) = layer else { return TableRange::default() };
            let range = TableRange {
                first_entry: entries.len() as u32,
                entry_count: layer.table.entries.len() as u32,
                first_node: nodes.len() as u32,
                root_word: layer.table.root_word,
            };
            entries.extend(layer.entries(scheme, eye));
            nodes.extend_from_slice(&layer.table.nodes);
            range
        });
        let mut update = TableUpdate { ranges, sent_bytes: 0, grew: false };
        if entries != self.written_entries {
            write(gpu, &mut self.entries, bytemuck::cast_slice(&entries), &mut update);
            self.written_entries = entries;
        }
        if nodes != self.written_nodes {
            write(gpu, &mut self.nodes, bytemuck::cast_slice(&nodes), &mut update);
            self.written_nodes = nodes;
        }
        update
    }
}

/// What [`OffsetTableBuffer::update`] did.
pub(crate) struct TableUpdate {
    pub ranges: [TableRange; 2],
    pub sent_bytes: u64,
    pub grew: bool,
}

fn storage(device: &wgpu::Device, label: &str, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage: wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::COPY_DST
            | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    })
}

fn write(
    (device, queue): (&wgpu::Device, &wgpu::Queue),
    buffer: &mut wgpu::Buffer,
    bytes: &[u8],
    update: &mut TableUpdate,
) {
    let len = bytes.len() as u64;
    if len > buffer.size() {
        *buffer = storage(device, "tile table", len.next_power_of_two());
        update.grew = true;
    }
    queue.write_buffer(buffer, 0, bytes);
    update.sent_bytes += len;
}
