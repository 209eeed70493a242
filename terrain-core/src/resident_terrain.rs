//! The terrain a renderer holds: what streams in of each layer, what is resident, and the tables that
//! tell which tile lies where. No GPU: uploads are handed out to be carried out elsewhere.

use std::sync::Arc;
use std::time::Duration;

use crate::dataset::{ColourFormat, ColourTile, HeightTile, TileSource};
use crate::ground_heights::GroundHeights;
use crate::layer_loading::{LayerIntakes, OpenTerrainError, open_intakes};
use crate::measure::{ByteCause, FrameLedger};
use crate::residency::{LayerStream, OffsetTable, Placement};
use crate::selection::{Selection, TileTree};

/// The tiles of a source that are loaded, wait, or are resident in the caches.
pub(crate) struct ResidentTerrain {
    pub tree: TileTree,
    pub height_table: OffsetTable,
    pub colour_table: Option<OffsetTable>,
    /// Counts uploads.
    pub uploads: u64,
    /// Counts changes of what the tables show.
    pub version: u64,
    heights: LayerStream<HeightTile>,
    colours: Option<LayerStream<ColourTile>>,
    /// The resident height tiles.
    pub ground: GroundHeights,
    failures: Vec<String>,
}

/// Tiles to upload in a frame.
#[derive(Default)]
pub(crate) struct Arrivals {
    pub heights: Vec<(Placement, HeightTile)>,
    pub colours: Vec<(Placement, ColourTile)>,
}

impl ResidentTerrain {
    /// Opens the streams of both layers into caches of `slots` (columns, rows) and loads level 0,
    /// which then waits for the first frame.
    ///
    /// # Errors
    /// Where level 0 cannot be loaded or the system gives no threads.
    pub fn open(
        source: &Arc<dyn TileSource>,
        tree: TileTree,
        colour_format: ColourFormat,
        slots: (u32, u32),
        ledger: &mut FrameLedger,
    ) -> Result<Self, OpenTerrainError> {
        let LayerIntakes { heights, colours } = open_intakes(source, colour_format, ledger)?;
        Ok(Self {
            tree,
            height_table: OffsetTable::build([]),
            colour_table: None,
            uploads: 0,
            version: 0,
            heights: LayerStream::new(slots, heights),
            colours: colours.map(|colours| LayerStream::new(slots, colours)),
            ground: GroundHeights::default(),
            failures: Vec::new(),
        })
    }

    /// Takes in what has been loaded, asks for what the selection lacks, and hands out what is to be
    /// uploaded now within the budget: heights first. Never waits.
    pub fn stream(
        &mut self,
        selection: &Selection,
        budget_bytes: u64,
        frame: u64,
        ledger: &mut FrameLedger,
    ) -> Arrivals {
        let mut arrivals = Arrivals::default();
        let wanted = selection.height_tiles(&self.tree);
        let update = self.heights.update(&wanted, budget_bytes, frame);
        let height_table = OffsetTable::build(self.heights.shown(&wanted));
        let mut colour_table = None;
        ledger.add(ByteCause::Disk, update.disk_bytes);
        self.failures.extend(update.failures);
        let taken = update.uploads.iter().map(|(_, tile)| tile.samples.byte_len()).sum();
        arrivals.heights = update.uploads;
        if let Some(colours) = &mut self.colours {
            let wanted = selection.colour_tiles(&self.tree);
            let update = colours.update(&wanted, budget_bytes.saturating_sub(taken), frame);
            ledger.add(ByteCause::Disk, update.disk_bytes);
            self.failures.extend(update.failures);
            arrivals.colours = update.uploads;
            colour_table = Some(OffsetTable::build(colours.shown(&wanted)));
        }
        self.uploads += u64::from(arrivals.count() > 0);
        let is_same = (&height_table, &colour_table) == (&self.height_table, &self.colour_table);
        // A tile may come back to the slot it had: the tables are the same, its texels are not.
        if !is_same || arrivals.count() > 0 {
            self.version += 1;
            (self.height_table, self.colour_table) = (height_table, colour_table);
        }
        arrivals
    }

    /// Wanted tiles that are not resident yet but will be, both layers.
    pub fn missing(&self) -> usize {
        self.heights.missing() + self.colours.as_ref().map_or(0, LayerStream::missing)
    }

    /// Resident tiles, both layers.
    pub fn resident(&self) -> usize {
        self.heights.cache().len() + self.colours.as_ref().map_or(0, |layer| layer.cache().len())
    }

    /// Waits until everything that either layer has asked for is loaded, at most for `patience` a layer.
    pub fn wait(&self, patience: Duration) {
        self.heights.wait(patience);
        if let Some(colours) = &self.colours {
            colours.wait(patience);
        }
    }

    /// Takes what went wrong with single tiles since the last call, in words.
    pub fn take_failures(&mut self) -> Vec<String> {
        std::mem::take(&mut self.failures)
    }
}

impl Arrivals {
    /// Tiles, both layers.
    pub fn count(&self) -> usize {
        self.heights.len() + self.colours.len()
    }

    /// Tiles that made way, both layers.
    pub fn evicted(&self) -> usize {
        let heights = self.heights.iter().map(|(placement, _)| placement);
        let colours = self.colours.iter().map(|(placement, _)| placement);
        heights.chain(colours).filter(|placement| placement.evicted.is_some()).count()
    }
}
