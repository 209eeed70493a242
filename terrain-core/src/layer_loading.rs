//! How the layers of a source are loaded for a given GPU.

use std::sync::Arc;

use crate::dataset::{ColourFormat, ColourTile, HeightTile, LoadError, Loaded, TileSource};
use crate::residency::LayerStream;
use crate::tiling::TileId;

/// The streams of both layers.
pub(crate) struct LayerStreams {
    pub heights: LayerStream<HeightTile>,
    /// Where the source has imagery.
    pub colours: Option<LayerStream<ColourTile>>,
}

/// Worker threads a layer: reading and decoding overlap, and the frame's own thread stays free.
pub(crate) const LOADING_THREADS: usize = 2;

/// Streams of the source's layers into caches of `slots` (columns, rows), colours arriving in
/// `format`.
pub(crate) fn open_streams(
    source: &Arc<dyn TileSource>,
    format: ColourFormat,
    slots: (u32, u32),
) -> std::io::Result<LayerStreams> {
    let of_heights = Arc::clone(source);
    let of_colours = Arc::clone(source);
    let has_colours = source.manifest().colours.is_some() && !source.colours_present().is_empty();
    Ok(LayerStreams {
        heights: LayerStream::new(
            slots,
            LOADING_THREADS,
            Arc::new(move |tile| of_heights.load_heights(tile)),
            |tile| tile.samples.byte_len(),
        )?,
        colours: has_colours
            .then(|| {
                let load = move |tile| load_colours(&*of_colours, format, tile);
                LayerStream::new(slots, LOADING_THREADS, Arc::new(load), |tile| {
                    tile.data.len() as u64
                })
            })
            .transpose()?,
    })
}

/// The format colours are to have on the GPU: the source's, or plain RGBA where the device does not
/// read compressed blocks.
pub(crate) fn colour_format(source: &dyn TileSource, has_block_compression: bool) -> ColourFormat {
    match source.manifest().colours.as_ref().map(|layer| layer.format) {
        Some(format) if has_block_compression => format,
        _ => ColourFormat::Rgba8,
    }
}

/// Loads a colour tile and brings it into the format.
pub(crate) fn load_colours(
    source: &dyn TileSource,
    format: ColourFormat,
    tile: TileId,
) -> Result<Loaded<ColourTile>, LoadError> {
    let loaded = source.load_colours(tile)?;
    if loaded.tile.format == format {
        return Ok(loaded);
    }
    Ok(Loaded { tile: loaded.tile.into_rgba8(), disk_bytes: loaded.disk_bytes })
}
