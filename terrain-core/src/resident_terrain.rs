//! The terrain a renderer holds: what streams in of each layer, what is resident, and the tables that
//! tell which tile lies where. No GPU: uploads are handed out to be carried out elsewhere.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

use glam::{DVec2, DVec3};

use crate::dataset::{ColourFormat, ColourTile, HeightTile, LoadError, TileSource};
use crate::layer_loading::{LayerStreams, load_colours, open_streams};
use crate::measure::{ByteCause, FrameLedger};
use crate::residency::{LayerStream, OffsetTable, Placement};
use crate::selection::{Selection, TileTree};
use crate::tiling::TileId;

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
    /// The resident height tiles, for questions about the ground.
    resident_heights: HashMap<TileId, HeightTile>,
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
        let LayerStreams { mut heights, mut colours } = open_streams(source, colour_format, slots)?;
        let loaded = source.load_heights(TileId::ROOT)?;
        ledger.add(ByteCause::Disk, loaded.disk_bytes);
        heights.supply(TileId::ROOT, loaded.tile);
        if let Some(colours) = &mut colours {
            let loaded = load_colours(&**source, colour_format, TileId::ROOT)?;
            ledger.add(ByteCause::Disk, loaded.disk_bytes);
            colours.supply(TileId::ROOT, loaded.tile);
        }
        Ok(Self {
            tree,
            height_table: OffsetTable::build([]),
            colour_table: None,
            uploads: 0,
            version: 0,
            heights,
            colours,
            resident_heights: HashMap::new(),
            failures: Vec::new(),
        })
    }

    /// Whether there is a colour layer.
    pub fn has_colours(&self) -> bool {
        self.colours.is_some()
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

    /// Keeps the height tiles that have been uploaded.
    pub fn keep(&mut self, heights: Vec<(Placement, HeightTile)>) {
        for (placement, tile) in heights {
            if let Some(evicted) = placement.evicted {
                self.resident_heights.remove(&evicted);
            }
            self.resident_heights.insert(placement.tile, tile);
        }
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

    /// Height of the ground in metres above the datum, without exaggeration, from the finest
    /// resident tile that has data there. `None` outside the data.
    pub fn ground_height_m(&self, point: DVec2) -> Option<f64> {
        let layout = &self.tree.heights.layout;
        (0..=layout.finest_level()).rev().find_map(|level| {
            let tile = self.tree.scheme.tile_at(level, point)?;
            self.resident_heights.get(&tile)?.height_at_m(&self.tree.scheme, layout, point)
        })
    }

    /// Distance in metres from the eye to the ground below it, heights exaggerated; to the nearest
    /// ground where the eye is not over the data.
    pub fn clearance_m(&self, eye: DVec3, vertical_exaggeration: f64) -> f64 {
        let extent = &self.tree.data_extent;
        let below = eye.truncate().clamp(extent.min, extent.max);
        let lowest_m = self.tree.height_ranges.range(TileId::ROOT).map(|r| f64::from(r.min_m));
        let ground_m = self.ground_height_m(below).or(lowest_m).unwrap_or(0.0);
        (eye.z - ground_m * vertical_exaggeration).hypot(eye.truncate().distance(below))
    }

    /// Lowest and highest ground in metres, heights exaggerated.
    pub fn height_range_m(&self, vertical_exaggeration: f64) -> [f64; 2] {
        let range = self.tree.height_ranges.range(TileId::ROOT);
        range
            .map_or([0.0; 2], |range| [range.min_m, range.max_m])
            .map(|height_m| f64::from(height_m) * vertical_exaggeration)
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

/// Why a terrain could not be opened.
#[derive(Debug, thiserror::Error)]
pub(crate) enum OpenTerrainError {
    #[error(transparent)]
    Load(#[from] LoadError),
    #[error(transparent)]
    Threads(#[from] std::io::Error),
}
