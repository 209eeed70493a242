use wgpu::util::DeviceExt;

use crate::selection::{LayerTree, TileTree};
use crate::tiling::MAX_LEVEL;

/// Which tiles exist in each layer, for shaders: the words that `common/tile_presence.wgsl` searches.
///
/// Where the runs of each level of the heights begin, then of the colours, where the last end, and
/// the runs: row, first and last column. Memory is proportional to the runs of tiles, a row of a dense
/// level being one of them: so a dataset may be deep or sparse.
fn presence_words(tree: &TileTree) -> Vec<u32> {
    let mut begins = Vec::new();
    let mut runs = Vec::new();
    for layer in [Some(&tree.heights), tree.colours.as_ref()] {
        let of_layer = layer.into_iter().flat_map(|layer: &LayerTree| layer.present.runs());
        let mut of_layer = of_layer.peekable();
        for level in 0..=MAX_LEVEL {
            begins.push((runs.len() / 3) as u32);
            while let Some((_, row, (first, last))) = of_layer.next_if(|run| run.0 == level) {
                runs.extend([row, first, last]);
            }
        }
    }
    begins.push((runs.len() / 3) as u32);
    begins.extend(runs);
    begins
}

/// The words of the tree in a buffer that shaders can read.
pub(super) fn presence_buffer(device: &wgpu::Device, tree: &TileTree) -> wgpu::Buffer {
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("tile runs"),
        contents: bytemuck::cast_slice(&presence_words(tree)),
        usage: wgpu::BufferUsages::STORAGE,
    })
}
