use bytemuck::{Pod, Zeroable};
use wgpu::util::DeviceExt;

use super::compute_pipeline::{bind_group, compute_pipeline};
use super::shader_library::MANAGE_TILES;
use super::tile_report::TileReport;
use crate::residency::TileInSlot;
use crate::selection::TileTree;

/// The twin of `ManagedLayer` in `manage_tiles.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct ManagedLayer {
    pub slot_count: u32,
    pub finest_level: u32,
    pub padding: [u32; 2],
}

/// The twin of `Slot` in `manage_tiles.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(super) struct Slot {
    pub level: u32,
    pub row: u32,
    pub column: u32,
    pub state: u32,
    pub last_wanted: u32,
}

impl Slot {
    /// The tile is asked for.
    pub const RESERVED: u32 = 1;
}

/// The twin of the fixed members of `Deliveries` in `manage_tiles.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct DeliveriesHead {
    pub frame: u32,
    pub padding: u32,
    pub counts: [[u32; 2]; 2],
}

/// What the CPU has brought of one layer in a frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct LayerDeliveries {
    /// Tiles uploaded into the slots they were asked for.
    pub uploaded: Vec<TileInSlot>,
    /// Tiles that cannot be had.
    pub failed: Vec<TileInSlot>,
}

impl LayerDeliveries {
    /// Whether nothing has been brought.
    pub fn is_empty(&self) -> bool {
        self.uploaded.is_empty() && self.failed.is_empty()
    }
}

/// Keeps the slots of both layers on the GPU: which tile gets which, what is to be loaded, what is shown.
pub(crate) struct ManageTilesPass {
    pipeline: wgpu::ComputePipeline,
    groups: [wgpu::BindGroup; 2],
    /// Layers that have tiles: the heights, and the colours where there are any.
    pub(super) layers: u32,
    deliveries: wgpu::Buffer,
    #[cfg(test)]
    pub(super) slots: wgpu::Buffer,
    pub(super) shown: wgpu::Buffer,
    pub(super) report: wgpu::Buffer,
}

impl ManageTilesPass {
    /// Slots of a layer, and tiles of a selection, at the most: `MOST_SLOTS` of the shaders.
    pub const MOST_SLOTS: u32 = 1600;
    /// Tiles of a layer that are asked for at a time: `MOST_ASKED` of the shader.
    pub const MOST_ASKED: u32 = 32;
    /// Bytes of what the shader reports: a head and both lists.
    pub const REPORT_BYTES: u64 = TileReport::HEAD_BYTES + 2 * 8 * Self::MOST_ASKED as u64;

    const TILE_BYTES: u64 = 16;
    /// A count and the tiles.
    const SHOWN_BYTES: u64 = 16 + Self::TILE_BYTES * Self::MOST_SLOTS as u64;

    /// A cache of `slot_count` slots a layer. `selected` holds the selection, laid out as
    /// [`TileSelection::selected`](super::TileSelection::selected) tells; where all its words are 0 that
    /// is level 0; `runs` is [`presence_buffer`](super::tile_presence::presence_buffer). Level 0 is asked for from the beginning, for the first slot.
    pub fn new(
        device: &wgpu::Device,
        tree: &TileTree,
        slot_count: u32,
        (selected, runs): (&wgpu::Buffer, &wgpu::Buffer),
    ) -> Self {
        let pipeline = compute_pipeline(device, &MANAGE_TILES);
        let layer = |finest_level: u8| ManagedLayer {
            slot_count,
            finest_level: u32::from(finest_level),
            padding: [0; 2],
        };
        let colours = tree.colours.as_ref().map_or(0, |layer| layer.layout.finest_level());
        let layers = [layer(tree.heights.layout.finest_level()), layer(colours)];
        let filled = |label, contents: &[u8], usage| {
            let usage = usage | wgpu::BufferUsages::COPY_SRC;
            let descriptor =
                wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage };
            device.create_buffer_init(&descriptor)
        };
        let storage = wgpu::BufferUsages::STORAGE;
        let constants = bytemuck::cast_slice(&layers);
        let constants = filled("managed layers", constants, wgpu::BufferUsages::UNIFORM);
        let slots = filled("tile slots", bytemuck::cast_slice(&first_slots()), storage);
        let empty = |label, size| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: storage | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            })
        };
        let most = u64::from(Self::MOST_ASKED);
        let deliveries =
            empty("tile deliveries", size_of::<DeliveriesHead>() as u64 + 2 * 2 * 8 * most);
        let workings = 2 * 2 * Self::TILE_BYTES * u64::from(Self::MOST_SLOTS);
        let workings = empty("tile workings", workings);
        let shown = empty("shown slots", 2 * Self::SHOWN_BYTES);
        let report = empty("tile report", Self::REPORT_BYTES);
        let buffers = [&constants, selected, &deliveries, &slots, &workings, &shown, &report];
        let groups =
            [bind_group(device, &pipeline, 0, &buffers), bind_group(device, &pipeline, 1, &[runs])];
        let layers =
            1 + u32::from(tree.colours.as_ref().is_some_and(|layer| !layer.present.is_empty()));
        Self {
            pipeline,
            groups,
            layers,
            deliveries,
            #[cfg(test)]
            slots,
            shown,
            report,
        }
    }

    /// Tells the next recording of the pass what has been brought: at most [`Self::MOST_ASKED`] tiles
    /// of each kind and layer. `frame` rises from 1. Returns the bytes sent.
    pub fn set_deliveries(
        &self,
        queue: &wgpu::Queue,
        frame: u32,
        deliveries: &[LayerDeliveries; 2],
    ) -> u64 {
        let counts = [0, 1].map(|layer| {
            let LayerDeliveries { uploaded, failed } = &deliveries[layer];
            [uploaded.len() as u32, failed.len() as u32]
        });
        let head = DeliveriesHead { frame, padding: 0, counts };
        let mut bytes = bytemuck::bytes_of(&head).to_vec();
        for LayerDeliveries { uploaded, failed } in deliveries {
            bytes.extend_from_slice(bytemuck::cast_slice(uploaded));
            bytes.extend_from_slice(bytemuck::cast_slice(failed));
        }
        queue.write_buffer(&self.deliveries, 0, &bytes);
        bytes.len() as u64
    }

    /// Records the pass.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>) {
        pass.set_pipeline(&self.pipeline);
        for (index, group) in (0..).zip(&self.groups) {
            pass.set_bind_group(index, group, &[]);
        }
        pass.dispatch_workgroups(self.layers, 1, 1);
    }
}

/// The slots of both layers before the first frame: the first is reserved for level 0.
fn first_slots() -> Vec<Slot> {
    let mut slots = vec![Slot::default(); 2 * ManageTilesPass::MOST_SLOTS as usize];
    for slot in slots.iter_mut().step_by(ManageTilesPass::MOST_SLOTS as usize) {
        slot.state = Slot::RESERVED;
    }
    slots
}
