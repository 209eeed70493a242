//! What is resident of a virtual texture, and what is on its way. No GPU.

use std::sync::Arc;
use std::time::Duration;

use crate::dataset::{ColourFormat, ColourTile, LoadError, Loaded, TileSource};
use crate::layer_loading::{OpenTerrainError, load_colours, loading_of};
use crate::measure::{ByteCause, FrameLedger};
use crate::residency::page_table::{PageEntry, PageId, PageLayout, PageStream, PageUpload};
use crate::residency::{Loading, TileIntake};
use crate::selection::TileTree;
use crate::tiling::{TileId, TileSet};

/// Loads a page; from any thread.
type LoadPage = dyn Fn(TileId) -> Result<Loaded<ColourTile>, LoadError> + Send + Sync;

/// Where the pages of a virtual texture come from.
pub(crate) struct PagedSource {
    /// How the texture is cut.
    pub layout: PageLayout,
    /// The pages that exist, by [`PageLayout::tile_of`]. Without any there is no texture.
    pub present: TileSet,
    /// The format that pages are loaded in.
    pub format: ColourFormat,
    pub load: Arc<LoadPage>,
    pub loading: Loading,
}

impl PagedSource {
    /// The imagery of a dataset as a virtual texture; of one page that is not there where it has none.
    pub fn imagery(source: &Arc<dyn TileSource>, tree: &TileTree, format: ColourFormat) -> Self {
        let layer = tree.colours.as_ref();
        let finest_level = layer.map_or(0, |layer| layer.layout.finest_level());
        let layout = layer.map_or(tree.heights.layout, |layer| layer.layout);
        let sizes = (layout.tile_size_texels, layout.gutter_texels);
        let of_colours = Arc::clone(source);
        Self {
            layout: PageLayout::of_ground(
                &tree.scheme,
                (&tree.data_extent, tree.shape),
                finest_level,
                sizes,
            ),
            present: layer.map(|layer| layer.present.clone()).unwrap_or_default(),
            format,
            load: Arc::new(move |tile| load_colours(&*of_colours, format, tile)),
            loading: loading_of(&**source),
        }
    }
}

/// The pages' stream and the threads that load them: the paper's A3.
pub(super) struct StreamedPages {
    pub stream: PageStream<ColourTile>,
    present: TileSet,
    /// `None` where there is no texture.
    intake: Option<TileIntake<ColourTile>>,
    failures: Vec<String>,
}

impl StreamedPages {
    /// Pages that memory holds for each that the GPU does (N2 to N1).
    const MEMORY_TO_GPU: u32 = 2;

    /// Opens the stream and loads the pages that are always resident, which then wait for the first frame.
    ///
    /// # Errors
    /// Where one of them cannot be loaded or the system gives no threads.
    pub fn open(
        source: PagedSource,
        gpu_slots: u32,
        ledger: &mut FrameLedger,
    ) -> Result<Self, OpenTerrainError> {
        let PagedSource { layout, present, load, loading, .. } = source;
        let mut intake = None;
        if !present.is_empty() {
            let bytes = |tile: &ColourTile| tile.data.len() as u64;
            let mut opened = TileIntake::new(loading, Arc::clone(&load), bytes)?;
            let always = layout.resident_pages().map(|page| layout.tile_of(page));
            for tile in always.filter(|&tile| present.contains(tile)) {
                let loaded = load(tile)?;
                ledger.add(ByteCause::Disk, loaded.disk_bytes);
                opened.supply(tile, loaded.tile);
            }
            intake = Some(opened);
        }
        let memory_slots = gpu_slots.saturating_mul(Self::MEMORY_TO_GPU);
        let stream = PageStream::new(layout, gpu_slots, memory_slots);
        Ok(Self { stream, present, intake, failures: Vec::new() })
    }

    /// Whether there is a texture.
    pub fn has_any(&self) -> bool {
        self.intake.is_some()
    }

    /// The page that serves those who ask for this one: itself or, where it does not exist or cannot be had,
    /// the finest coarser one that does and can.
    pub fn serving(&self, page: PageId) -> PageId {
        let layout = self.stream.layout();
        let coarsest = layout.coarsest_level - page.level;
        let can_be_had = |page: &PageId| {
            self.present.contains(layout.tile_of(*page))
                && self.stream.in_memory(*page) != PageEntry::Failed
        };
        let mut coarser = (0..=coarsest).map(|levels| page.coarser(levels));
        coarser.find(can_be_had).unwrap_or_else(|| page.coarser(coarsest))
    }

    /// Takes in what has been loaded, asks for what is missing, and hands out what is to be uploaded now within
    /// the budget. Never waits. Returns what is uploaded, and whether a page turned out not to be had.
    pub fn update(
        &mut self,
        budget_bytes: u64,
        ledger: &mut FrameLedger,
    ) -> (Vec<PageUpload>, bool) {
        self.stream.advance_fades();
        let Some(intake) = &mut self.intake else { return Default::default() };
        let taken = intake.take_loaded();
        ledger.add(ByteCause::Disk, taken.disk_bytes);
        self.failures.extend(taken.failures);
        for (tile, content) in intake.take_all() {
            if let Some(page) = self.stream.layout().page_of(tile) {
                self.stream.loaded(page, content);
            }
        }
        let mut has_failed = false;
        for page in self.stream.to_load().to_vec() {
            if intake.has_failed(self.stream.layout().tile_of(page)) {
                self.stream.failed(page);
                has_failed = true;
            }
        }
        let uploads = self.stream.upload(budget_bytes, |tile| tile.data.len() as u64);
        let layout = self.stream.layout();
        let to_load = self.stream.to_load().iter().map(|&page| layout.tile_of(page));
        intake.ask(&to_load.collect::<Vec<_>>(), |_| false);
        (uploads, has_failed)
    }

    /// Pages wanted that are not resident yet but will be.
    pub fn missing(&self) -> usize {
        if self.has_any() { self.stream.missing() } else { 0 }
    }

    /// Waits until everything asked for is loaded, at most for `patience`.
    pub fn wait(&self, patience: Duration) {
        if let Some(intake) = &self.intake {
            intake.wait(patience);
        }
    }

    /// Takes what went wrong with single pages since the last call, in words.
    pub fn take_failures(&mut self) -> Vec<String> {
        std::mem::take(&mut self.failures)
    }
}
