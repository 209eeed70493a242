// Which tiles exist in each layer, as runs of columns a row: see TilePresence in the library.

// First, for each level of either layer, where its runs begin, and at last where they end; then three
// words a run, sorted: its row, its first column and its last.
@group(1) @binding(0) var<storage, read> tile_runs: array<u32>;

const RUN_LEVELS: u32 = 25u;

fn is_present(layer: u32, level: u32, row: u32, column: u32) -> bool {
    let level_index = layer * RUN_LEVELS + level;
    let first = tile_runs[level_index];
    // The first run behind the tile; the one before it may hold it.
    var low = first;
    var high = tile_runs[level_index + 1u];
    while low < high {
        let middle = (low + high) / 2u;
        let word = 2u * RUN_LEVELS + 1u + 3u * middle;
        let is_behind = tile_runs[word] > row || (tile_runs[word] == row && tile_runs[word + 1u] > column);
        if is_behind {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    if low == first {
        return false;
    }
    let word = 2u * RUN_LEVELS + 1u + 3u * (low - 1u);
    return tile_runs[word] == row && tile_runs[word + 2u] >= column;
}
