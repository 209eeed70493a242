//! What is resident of a terrain whose imagery comes through a page table: heights in tiles, pages of the
//! imagery. No GPU.

use std::sync::Arc;
use std::time::Duration;

use crate::dataset::{ColourFormat, ColourTile, HeightTile, TileSource};
use crate::ground_heights::GroundHeights;
use crate::layer_loading::{LayerIntakes, OpenTerrainError, open_intakes};
use crate::measure::{ByteCause, FrameLedger};
use crate::residency::page_table::{PageEntry, PageId, PageLayout, PageStream, PageUpload};
use crate::residency::{LayerStream, OffsetTable, Placement, TileIntake};
use crate::selection::{LayerTree, Selection, TileTree};

/// The heights' stream and table, and the pages'.
pub(super) struct PagedTerrain {
    pub tree: TileTree,
    pub height_table: OffsetTable,
    pub pages: PageStream<ColourTile>,
    /// The resident height tiles.
    pub ground: GroundHeights,
    /// Counts frames that uploaded heights.
    pub height_uploads: u64,
    /// Counts changes of what is shown.
    pub version: u64,
    heights: LayerStream<HeightTile>,
    /// The paper's A3: threads that load pages. `None` without imagery.
    colours: Option<TileIntake<ColourTile>>,
    failures: Vec<String>,
}

/// What a frame brings to the GPU.
#[derive(Default)]
pub(super) struct PagedArrivals {
    pub heights: Vec<(Placement, HeightTile)>,
    /// Their content is in the stream's memory.
    pub pages: Vec<PageUpload>,
}

impl PagedArrivals {
    /// Tiles and pages.
    pub fn count(&self) -> u64 {
        (self.heights.len() + self.pages.len()) as u64
    }

    /// Tiles and pages that made way.
    pub fn evicted(&self) -> u64 {
        let tiles = self.heights.iter().filter(|(placement, _)| placement.evicted.is_some());
        let pages = self.pages.iter().filter(|upload| upload.evicted.is_some());
        (tiles.count() + pages.count()) as u64
    }
}

impl PagedTerrain {
    /// Pages that memory holds for each that the GPU does (N2 to N1).
    const MEMORY_TO_GPU: u32 = 2;

    /// Opens the streams of both layers into caches of `slots` (columns, rows) and loads level 0, which then
    /// waits for the first frame.
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
        let gpu_slots = slots.0 * slots.1;
        let memory_slots = gpu_slots.saturating_mul(Self::MEMORY_TO_GPU);
        Ok(Self {
            height_table: OffsetTable::build([]),
            pages: PageStream::new(page_layout(&tree), gpu_slots, memory_slots),
            ground: GroundHeights::default(),
            height_uploads: 0,
            version: 0,
            heights: LayerStream::new(slots, heights),
            colours,
            failures: Vec::new(),
            tree,
        })
    }

    /// Whether there is imagery.
    pub fn has_colours(&self) -> bool {
        self.colours.is_some()
    }

    /// The page that serves those who ask for this one: itself or, where it does not exist or cannot be had,
    /// the finest coarser one that does and can.
    pub fn serving(&self, page: PageId) -> PageId {
        let layout = self.pages.layout();
        let coarsest = layout.coarsest_level - page.level;
        let coarser = (0..=coarsest).map(|levels| page.coarser(levels));
        let Some(layer) = &self.tree.colours else { return page.coarser(coarsest) };
        let can_be_had = |page: &PageId| {
            layer.present.contains(layout.tile_of(*page))
                && self.pages.in_memory(*page) != PageEntry::Failed
        };
        coarser.clone().find(can_be_had).unwrap_or_else(|| page.coarser(coarsest))
    }

    /// Takes in what has been loaded, asks for what is missing, and hands out what is to be uploaded now within
    /// the budget: heights first. Never waits. Returns what is uploaded, and whether a page turned out not to
    /// be had.
    pub fn stream(
        &mut self,
        selection: &Selection,
        budget_bytes: u64,
        frame: u64,
        ledger: &mut FrameLedger,
    ) -> (PagedArrivals, bool) {
        let wanted = selection.height_tiles(&self.tree);
        let update = self.heights.update(&wanted, budget_bytes, frame);
        ledger.add(ByteCause::Disk, update.disk_bytes);
        self.failures.extend(update.failures);
        let taken = update.uploads.iter().map(|(_, tile)| tile.samples.byte_len()).sum();
        let table = OffsetTable::build(self.heights.shown(&wanted));
        let (pages, has_failed) = self.stream_pages(budget_bytes.saturating_sub(taken), ledger);
        self.height_uploads += u64::from(!update.uploads.is_empty());
        // A tile may come back to the slot it had: the table is the same, its texels are not.
        if table != self.height_table || !update.uploads.is_empty() {
            self.height_table = table;
            self.version += 1;
        }
        (PagedArrivals { heights: update.uploads, pages }, has_failed)
    }

    fn stream_pages(
        &mut self,
        budget_bytes: u64,
        ledger: &mut FrameLedger,
    ) -> (Vec<PageUpload>, bool) {
        self.pages.advance_fades();
        let Some(intake) = &mut self.colours else { return Default::default() };
        let taken = intake.take_loaded();
        ledger.add(ByteCause::Disk, taken.disk_bytes);
        self.failures.extend(taken.failures);
        for (tile, content) in intake.take_all() {
            if let Some(page) = self.pages.layout().page_of(tile) {
                self.pages.loaded(page, content);
            }
        }
        let mut has_failed = false;
        for page in self.pages.to_load().to_vec() {
            if intake.has_failed(self.pages.layout().tile_of(page)) {
                self.pages.failed(page);
                has_failed = true;
            }
        }
        let uploads = self.pages.upload(budget_bytes, |tile| tile.data.len() as u64);
        let layout = self.pages.layout();
        let to_load = self.pages.to_load().iter().map(|&page| layout.tile_of(page));
        intake.ask(&to_load.collect::<Vec<_>>(), |_| false);
        (uploads, has_failed)
    }

    /// Tiles and pages wanted that are not resident yet but will be.
    pub fn missing(&self) -> usize {
        let pages = if self.has_colours() { self.pages.missing() } else { 0 };
        self.heights.missing() + pages
    }

    /// Resident tiles and pages.
    pub fn resident(&self) -> usize {
        self.heights.cache().len() + self.pages.resident()[0]
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

/// The imagery as a virtual texture; without imagery one of a single page.
fn page_layout(tree: &TileTree) -> PageLayout {
    let layout = tree.colours.as_ref().map(|layer: &LayerTree| layer.layout);
    let finest_level = layout.map_or(0, |layout| layout.finest_level());
    let layout = layout.unwrap_or(tree.heights.layout);
    let sizes = (layout.tile_size_texels, layout.gutter_texels);
    PageLayout::of_ground(&tree.scheme, (&tree.data_extent, tree.shape), finest_level, sizes)
}
