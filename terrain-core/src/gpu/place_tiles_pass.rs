use bytemuck::{Pod, Zeroable};
use glam::DVec2;
use wgpu::util::DeviceExt;

use super::atlas::AtlasGrid;
use super::build_tile_table_pass::BuildTileTablePass;
use super::compute_pipeline::{bind_group, compute_pipeline};
use super::offset_table_buffer::ToldFrom;
use super::shader_library::PLACE_TILES;
use crate::tiling::{LayerLayout, TilingScheme};

/// The twin of `PlacedLayer` in `place_tiles.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(super) struct PlacedLayer {
    pub columns: u32,
    pub slot_texels: u32,
    pub gutter_texels: u32,
    pub texels_per_m: f32,
    pub step_texels: u32,
    pub step_bits: u32,
    pub padding: [u32; 2],
}

impl PlacedLayer {
    /// A layer whose tiles lie in an atlas of this grid. Told from near the eye, its tiles are told from
    /// every texel's corner, or from every `step_texels`th where a side of a tile is that many times a
    /// power of two: for whole units to lie there.
    pub fn new(
        scheme: &TilingScheme,
        layout: &LayerLayout,
        grid: &AtlasGrid,
        told_from: ToldFrom,
    ) -> Self {
        let step_bits = layout.tile_size_texels.trailing_zeros();
        let step_texels = layout.tile_size_texels >> step_bits;
        Self {
            columns: grid.columns,
            slot_texels: grid.slot_size_texels,
            gutter_texels: layout.gutter_texels,
            texels_per_m: (1.0 / layout.texel_size_m(scheme, 0)) as f32,
            step_texels: if told_from == ToldFrom::NearEye { step_texels } else { 0 },
            step_bits,
            padding: [0; 2],
        }
    }
}

/// The twin of `Ground` in `place_tiles.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct Ground {
    pub metres_mantissa: u32,
    pub metres_exponent: i32,
    pub padding: [u32; 2],
    pub layers: [PlacedLayer; 2],
}

impl Ground {
    /// Units a root side, as a power of two: borders of tiles and of their texels are whole units, on a
    /// planet's root a unit is less than a micrometre, and 64 bits reach 2^16 root sides from it.
    const UNIT_BITS: i32 = 46;

    pub fn new(scheme: &TilingScheme, layers: [PlacedLayer; 2]) -> Self {
        // `root_size_m` is positive and finite: mantissa in 1..2.
        let exponent = scheme.root_size_m.log2().floor() as i32;
        let mantissa = scheme.root_size_m * f64::from(-exponent).exp2();
        let (mantissa, exponent) = match (mantissa * 2.0_f64.powi(31)).round() {
            // Rounded up to the next power of two, or the logarithm was.
            carried if carried >= 2.0_f64.powi(32) => (carried / 2.0, exponent + 1),
            low if low < 2.0_f64.powi(31) => (low * 2.0, exponent - 1),
            mantissa => (mantissa, exponent),
        };
        let metres_exponent = exponent - 31 - Self::UNIT_BITS;
        Self { metres_mantissa: mantissa as u32, metres_exponent, padding: [0; 2], layers }
    }

    /// A point east and south of the root's corner in units, two words each, the low one first. Points
    /// more than 2^16 root sides away are taken to that distance.
    pub fn units(scheme: &TilingScheme, point: DVec2) -> [u32; 4] {
        let parts = [point.x - scheme.origin.x, scheme.origin.y - point.y];
        let units = parts.map(|metres| {
            let units = metres / scheme.root_size_m * f64::from(Self::UNIT_BITS).exp2();
            let reach = 2.0_f64.powi(62);
            units.round().clamp(-reach, reach) as i64
        });
        let [x, y] = units.map(|units| [units as u32, (units >> 32) as u32]);
        [x[0], x[1], y[0], y[1]]
    }
}

/// Says where the tiles of the tables lie, seen from the eye: writes the entries that drawing reads.
pub(crate) struct PlaceTilesPass {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    eye: wgpu::Buffer,
    written_eye: Option<[u32; 4]>,
}

impl PlaceTilesPass {
    const WORKGROUP: u32 = 64;

    /// A pass that reads the table and writes `entries`, which has room for both layers.
    pub fn new(
        device: &wgpu::Device,
        ground: &Ground,
        table: &BuildTileTablePass,
        entries: &wgpu::Buffer,
    ) -> Self {
        let pipeline = compute_pipeline(device, &PLACE_TILES);
        let ground = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("ground"),
            contents: bytemuck::bytes_of(ground),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let eye = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("eye"),
            size: 16,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let buffers = [&ground, &eye, &table.table, entries];
        let group = bind_group(device, &pipeline, 0, &buffers);
        Self { pipeline, group, eye, written_eye: None }
    }

    /// Moves the eye to this point, in metres, for the next recordings; returns the bytes sent, 0 where
    /// it is there already.
    pub fn set_eye(&mut self, queue: &wgpu::Queue, scheme: &TilingScheme, eye: DVec2) -> u64 {
        let units = Ground::units(scheme, eye);
        if self.written_eye == Some(units) {
            return 0;
        }
        queue.write_buffer(&self.eye, 0, bytemuck::cast_slice(&units));
        self.written_eye = Some(units);
        size_of_val(&units) as u64
    }

    /// Records the pass for so many layers of at most `entries` entries each.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, layers: u32, entries: u32) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.dispatch_workgroups(entries.div_ceil(Self::WORKGROUP), layers, 1);
    }
}
