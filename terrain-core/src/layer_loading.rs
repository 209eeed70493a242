//! How the layers of a source are loaded for a given GPU.

use std::sync::Arc;

use crate::dataset::{ColourFormat, ColourTile, HeightTile, LoadError, Loaded, TileSource};
use crate::measure::{ByteCause, FrameLedger};
use crate::residency::{Loading, TileIntake};
use crate::tiling::TileId;

/// The intakes of both layers.
pub(crate) struct LayerIntakes {
    pub heights: TileIntake<HeightTile>,
    /// Where the source has imagery.
    pub colours: Option<TileIntake<ColourTile>>,
}

/// How a layer of the source is loaded: with threads enough that reading and decoding overlap, and the
/// frame's own thread stays free.
pub(crate) fn loading_of(source: &dyn TileSource) -> Loading {
    Loading { threads: 2, delay_frames: source.delay_frames() }
}

/// Intakes of the source's layers, colours arriving in `format`. Level 0 of each is loaded before this
/// returns, and waits for its upload.
///
/// # Errors
/// Where level 0 cannot be loaded or the system gives no threads.
pub(crate) fn open_intakes(
    source: &Arc<dyn TileSource>,
    format: ColourFormat,
    ledger: &mut FrameLedger,
) -> Result<LayerIntakes, OpenTerrainError> {
    let heights = open_height_intake(source, ledger)?;
    Ok(LayerIntakes { heights, colours: open_colour_intake(source, format, ledger)? })
}

/// The intake of the heights alone, as [`open_intakes`] opens it.
///
/// # Errors
/// Where level 0 cannot be loaded or the system gives no threads.
pub(crate) fn open_height_intake(
    source: &Arc<dyn TileSource>,
    ledger: &mut FrameLedger,
) -> Result<TileIntake<HeightTile>, OpenTerrainError> {
    let of_heights = Arc::clone(source);
    let load = Arc::new(move |tile| of_heights.load_heights(tile));
    let mut heights =
        TileIntake::new(loading_of(&**source), load, |tile: &HeightTile| tile.samples.byte_len())?;
    let loaded = source.load_heights(TileId::ROOT)?;
    ledger.add(ByteCause::Disk, loaded.disk_bytes);
    heights.supply(TileId::ROOT, loaded.tile);
    Ok(heights)
}

/// The intake of the colours alone, as [`open_intakes`] opens it; `None` without imagery.
///
/// # Errors
/// Where level 0 cannot be loaded or the system gives no threads.
pub(crate) fn open_colour_intake(
    source: &Arc<dyn TileSource>,
    format: ColourFormat,
    ledger: &mut FrameLedger,
) -> Result<Option<TileIntake<ColourTile>>, OpenTerrainError> {
    if source.manifest().colours.is_none() || source.colours_present().is_empty() {
        return Ok(None);
    }
    let of_colours = Arc::clone(source);
    let load = Arc::new(move |tile| load_colours(&*of_colours, format, tile));
    let mut colours =
        TileIntake::new(loading_of(&**source), load, |tile: &ColourTile| tile.data.len() as u64)?;
    let loaded = load_colours(&**source, format, TileId::ROOT)?;
    ledger.add(ByteCause::Disk, loaded.disk_bytes);
    colours.supply(TileId::ROOT, loaded.tile);
    Ok(Some(colours))
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

/// Why a terrain could not be opened.
#[derive(Debug, thiserror::Error)]
pub(crate) enum OpenTerrainError {
    #[error(transparent)]
    Load(#[from] LoadError),
    #[error(transparent)]
    Threads(#[from] std::io::Error),
}
