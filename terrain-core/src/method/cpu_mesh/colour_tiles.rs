//! The imagery of a mesh: cached tiles and the table that finds them, as tile scheduling has them.

use std::sync::Arc;
use std::time::Duration;

use crate::dataset::{ColourFormat, ColourTile, TileSource};
use crate::layer_loading::{OpenTerrainError, open_colour_intake};
use crate::measure::FrameLedger;
use crate::residency::{LayerStream, OffsetTable, Placement};
use crate::tiling::TileId;

/// The colour layer's stream and table; empty without imagery.
pub(super) struct ColourTiles {
    stream: Option<LayerStream<ColourTile>>,
    /// `None` without imagery, and before the first frame.
    pub table: Option<OffsetTable>,
    /// Counts changes of what the table shows.
    pub version: u64,
}

/// What a frame moves.
#[derive(Default)]
pub(super) struct ColoursMoved {
    pub uploads: Vec<(Placement, ColourTile)>,
    pub disk_bytes: u64,
    pub failures: Vec<String>,
}

impl ColourTiles {
    /// Opens the stream into a cache of `slots` (columns, rows) and loads level 0, which then waits for
    /// the first frame.
    ///
    /// # Errors
    /// Where level 0 cannot be loaded or the system gives no thread.
    pub fn open(
        source: &Arc<dyn TileSource>,
        format: ColourFormat,
        slots: (u32, u32),
        ledger: &mut FrameLedger,
    ) -> Result<Self, OpenTerrainError> {
        let intake = open_colour_intake(source, format, ledger)?;
        let stream = intake.map(|intake| LayerStream::new(slots, intake));
        Ok(Self { stream, table: None, version: 0 })
    }

    /// Whether there is imagery.
    pub fn has_any(&self) -> bool {
        self.stream.is_some()
    }

    /// Takes what has been loaded, asks for what is missing of the wanted tiles and hands out what is to
    /// be uploaded now. Never waits.
    pub fn update(&mut self, wanted: &[TileId], budget_bytes: u64, frame: u64) -> ColoursMoved {
        let Some(stream) = &mut self.stream else { return ColoursMoved::default() };
        let update = stream.update(wanted, budget_bytes, frame);
        let table = Some(OffsetTable::build(stream.shown(wanted)));
        // A tile may come back to the slot it had: the table is the same, its texels are not.
        if table != self.table || !update.uploads.is_empty() {
            self.version += 1;
            self.table = table;
        }
        let (disk_bytes, failures) = (update.disk_bytes, update.failures);
        ColoursMoved { uploads: update.uploads, disk_bytes, failures }
    }

    /// Wanted tiles that are not resident yet but will be.
    pub fn missing(&self) -> usize {
        self.stream.as_ref().map_or(0, LayerStream::missing)
    }

    /// Resident tiles.
    pub fn resident(&self) -> usize {
        self.stream.as_ref().map_or(0, |stream| stream.cache().len())
    }

    /// Waits until everything asked for is loaded, at most for `patience`.
    pub fn wait(&self, patience: Duration) {
        if let Some(stream) = &self.stream {
            stream.wait(patience);
        }
    }
}
