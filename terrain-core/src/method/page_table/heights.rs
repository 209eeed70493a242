//! What is resident of the heights that a virtual texture is drawn on. No GPU.

use std::time::Duration;

use crate::dataset::HeightTile;
use crate::ground_heights::GroundHeights;
use crate::measure::{ByteCause, FrameLedger};
use crate::residency::{LayerStream, OffsetTable, Placement, TileIntake};
use crate::selection::{Selection, TileTree};

/// The heights' stream and table.
pub(super) struct StreamedHeights {
    pub tree: TileTree,
    pub table: OffsetTable,
    /// The resident tiles.
    pub ground: GroundHeights,
    /// Counts frames that uploaded heights.
    pub uploads: u64,
    /// Counts changes of what is shown.
    pub version: u64,
    stream: LayerStream<HeightTile>,
    failures: Vec<String>,
}

impl StreamedHeights {
    /// Heights that `intake` loads, into a cache of `slots` (columns, rows).
    pub fn new(tree: TileTree, slots: (u32, u32), intake: TileIntake<HeightTile>) -> Self {
        Self {
            tree,
            table: OffsetTable::build([]),
            ground: GroundHeights::default(),
            uploads: 0,
            version: 0,
            stream: LayerStream::new(slots, intake),
            failures: Vec::new(),
        }
    }

    /// Takes in what has been loaded, asks for what is missing, and hands out what is to be uploaded now within
    /// the budget. Never waits.
    pub fn update(
        &mut self,
        selection: &Selection,
        budget_bytes: u64,
        frame: u64,
        ledger: &mut FrameLedger,
    ) -> Vec<(Placement, HeightTile)> {
        let wanted = selection.height_tiles(&self.tree);
        let update = self.stream.update(&wanted, budget_bytes, frame);
        ledger.add(ByteCause::Disk, update.disk_bytes);
        self.failures.extend(update.failures);
        let table = OffsetTable::build(self.stream.shown(&wanted));
        self.uploads += u64::from(!update.uploads.is_empty());
        // A tile may come back to the slot it had: the table is the same, its texels are not.
        if table != self.table || !update.uploads.is_empty() {
            self.table = table;
            self.version += 1;
        }
        update.uploads
    }

    /// Tiles wanted that are not resident yet but will be.
    pub fn missing(&self) -> usize {
        self.stream.missing()
    }

    /// Resident tiles.
    pub fn resident(&self) -> usize {
        self.stream.cache().len()
    }

    /// Waits until everything asked for is loaded, at most for `patience`.
    pub fn wait(&self, patience: Duration) {
        self.stream.wait(patience);
    }

    /// Takes what went wrong with single tiles since the last call, in words.
    pub fn take_failures(&mut self) -> Vec<String> {
        std::mem::take(&mut self.failures)
    }
}
