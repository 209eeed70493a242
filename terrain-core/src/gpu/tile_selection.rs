use glam::DVec2;

use super::coordinate_image_bindings::CoordinateImageBindings;
use super::mark_seen_tiles_pass::MarkSeenTilesPass;
use super::reduce_region_pass::ReduceRegionPass;
use super::seen_ground_buffer::SeenGroundBuffer;
use super::select_tiles_pass::SelectTilesPass;
use super::tile_presence::presence_buffer;
use crate::CameraView;
use crate::selection::{SelectionConfig, SelectionParams, TileTree, height_units};

/// Tile scheduling's selection on the GPU, from the coordinate image to the list of tiles: what
/// [`visible_region()`](crate::selection::visible_region()) and [`select()`](crate::selection::select())
/// do on the CPU, with the same outcome, tile for tile. Nothing is read back.
pub(crate) struct TileSelection {
    runs: wgpu::Buffer,
    params: wgpu::Buffer,
    heights: wgpu::Buffer,
    seen: SeenGroundBuffer,
    image: CoordinateImageBindings,
    reduce: ReduceRegionPass,
    mark: MarkSeenTilesPass,
    select: SelectTilesPass,
    sent: Option<(SelectionParams, f64)>,
}

/// What tiles are selected for.
pub(crate) struct SelectionRequest<'a> {
    pub view: &'a CameraView,
    pub config: &'a SelectionConfig,
    /// What the offsets of the image last seen count from: its own eye, not the view's.
    pub image_origin: DVec2,
    /// Whether only what pixels of the image saw counts as visible, and not all of the box round it.
    pub is_exact: bool,
}

impl TileSelection {
    /// Selections of the tree by what `image` shows, a texture of
    /// [`CoordinatePass::REGION_FORMAT`](super::CoordinatePass::REGION_FORMAT), of at most `most_tiles`.
    pub fn new(
        device: &wgpu::Device,
        tree: &TileTree,
        image: &wgpu::Texture,
        most_tiles: usize,
    ) -> Self {
        let input = |label, size| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let known = tree.height_ranges.levels.len() as u32;
        let height_count = (0..known).map(|level| 1_u64 << (2 * level)).sum::<u64>();
        let params = input("selection", size_of::<SelectionParams>() as u64);
        let heights = input("height units", 8 * height_count.max(1));
        let seen = SeenGroundBuffer::new(device);
        let image = CoordinateImageBindings::new(device, image, &seen);
        let runs = presence_buffer(device, tree);
        Self {
            reduce: ReduceRegionPass::new(device, &image),
            mark: MarkSeenTilesPass::new(device, &params, &heights, &image),
            select: SelectTilesPass::new(device, &runs, (&params, &heights), &seen, most_tiles),
            runs,
            params,
            heights,
            seen,
            image,
            sent: None,
        }
    }

    /// Which tiles there are; see [`presence_buffer`].
    pub fn tile_runs(&self) -> &wgpu::Buffer {
        &self.runs
    }

    /// The selection: words of a head (number of tiles, tiles subdivision listed, tiles the first
    /// regularisation took off, merges, finest level, tiles hidden, whether the box stood in for the
    /// tiles seen, 0), then four words a tile (level, row, column, 0) in the order of
    /// [`Selection::tiles`](crate::selection::Selection::tiles).
    pub fn selected(&self) -> &wgpu::Buffer {
        &self.select.selected
    }

    /// What was seen last, for tests to look at.
    #[cfg(test)]
    pub fn seen_ground(&self) -> &wgpu::Buffer {
        &self.seen.buffer
    }

    /// Records that the image was drawn anew. What it shows takes the place of what was seen before, or
    /// joins it: then the image must count from the same point.
    pub fn see(&self, encoder: &mut wgpu::CommandEncoder, joins: bool) {
        if !joins {
            self.seen.clear_box(encoder);
        }
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("reduce region"),
            timestamp_writes: None,
        });
        self.reduce.record(&mut pass, &self.image);
    }

    /// Records the selection of the tiles for a view by what was seen last. Returns the bytes sent.
    pub fn select(
        &mut self,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        tree: &TileTree,
        request: &SelectionRequest<'_>,
    ) -> u64 {
        let sent = self.send(queue, tree, request);
        if request.is_exact {
            self.seen.clear_tiles(encoder);
        }
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("select tiles"),
            timestamp_writes: None,
        });
        if request.is_exact {
            self.mark.record(&mut pass, &self.image);
        }
        self.select.record(&mut pass);
        sent
    }

    /// Sends what has changed.
    fn send(
        &mut self,
        queue: &wgpu::Queue,
        tree: &TileTree,
        request: &SelectionRequest<'_>,
    ) -> u64 {
        let SelectionRequest { view, config, image_origin, is_exact } = *request;
        let params = SelectionParams::new(tree, view, config, image_origin, is_exact);
        let exaggeration = config.vertical_exaggeration;
        let mut bytes = 0;
        let before = self.sent.replace((params, exaggeration));
        if before.map(|(params, _)| params) != Some(params) {
            queue.write_buffer(&self.params, 0, bytemuck::bytes_of(&params));
            bytes += size_of::<SelectionParams>() as u64;
        }
        let scale =
            |(params, exaggeration): (SelectionParams, f64)| (params.doublings, exaggeration);
        if before.map(scale) != Some((params.doublings, exaggeration)) {
            let heights = height_units(tree, view, exaggeration);
            let words = bytemuck::cast_slice(&heights);
            queue.write_buffer(&self.heights, 0, words);
            bytes += words.len() as u64;
        }
        bytes
    }
}
