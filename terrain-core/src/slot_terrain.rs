//! The terrain a renderer holds where the GPU keeps the cache: what streams in of each layer, and into
//! which slots. No GPU: uploads are handed out to be carried out elsewhere.

use std::time::Duration;

use crate::dataset::{ColourTile, HeightTile};
use crate::gpu::{LayerDeliveries, TileReport};
use crate::ground_heights::GroundHeights;
use crate::layer_loading::LayerIntakes;
use crate::measure::{ByteCause, FrameLedger};
use crate::residency::{Placement, SlotStream, SlotUpdate, TileInSlot};
use crate::resident_terrain::Arrivals;

/// The tiles of a source on their way into slots that the GPU assigns.
pub(crate) struct SlotTerrain {
    /// The height tiles that have been uploaded.
    pub ground: GroundHeights,
    heights: SlotStream<HeightTile>,
    colours: Option<SlotStream<ColourTile>>,
    failures: Vec<String>,
}

impl SlotTerrain {
    /// Streams of the intakes into `slot_count` slots a layer.
    pub fn new(intakes: LayerIntakes, slot_count: u32) -> Self {
        Self {
            ground: GroundHeights::default(),
            heights: SlotStream::new(slot_count, intakes.heights),
            colours: intakes.colours.map(|colours| SlotStream::new(slot_count, colours)),
            failures: Vec::new(),
        }
    }

    /// Takes what the GPU reported of a frame. Reports come in the order of their frames.
    pub fn receive(&mut self, report: &TileReport, frame: u64) {
        let [heights, colours] = &report.layers;
        self.heights.receive(heights.asked.clone(), heights.missing as usize, frame);
        if let Some(stream) = &mut self.colours {
            stream.receive(colours.asked.clone(), colours.missing as usize, frame);
        }
    }

    /// Takes in what has been loaded, asks for what the GPU lacks, and hands out what is to be uploaded
    /// now within the budget, heights first, and what the GPU is to be told of it. Never waits.
    pub fn stream(
        &mut self,
        budget_bytes: u64,
        frame: u64,
        ledger: &mut FrameLedger,
    ) -> (Arrivals, [LayerDeliveries; 2]) {
        let heights = self.heights.update(budget_bytes, frame);
        let taken_bytes: u64 = heights.uploads.iter().map(|(_, t)| t.samples.byte_len()).sum();
        let rest_bytes = budget_bytes.saturating_sub(taken_bytes);
        let colours = self.colours.as_mut().map(|layer| layer.update(rest_bytes, frame));
        let (heights, of_heights) = self.note(heights, ledger);
        let (colours, of_colours) =
            colours.map(|update| self.note(update, ledger)).unwrap_or_default();
        (Arrivals { heights, colours }, [of_heights, of_colours])
    }

    /// Notes what a layer's update read and what failed; returns its uploads and what the GPU is to be
    /// told.
    fn note<T>(
        &mut self,
        update: SlotUpdate<T>,
        ledger: &mut FrameLedger,
    ) -> (Vec<(Placement, T)>, LayerDeliveries) {
        ledger.add(ByteCause::Disk, update.disk_bytes);
        self.failures.extend(update.failures);
        let placements = update.uploads.iter().map(|(placement, _)| placement);
        let uploaded = placements.map(|placed| TileInSlot::new(placed.tile, placed.slot)).collect();
        (update.uploads, LayerDeliveries { uploaded, failed: update.failed })
    }

    /// Wanted tiles that were not resident in the frame last reported but will be, both layers.
    pub fn missing(&self) -> usize {
        self.heights.missing() + self.colours.as_ref().map_or(0, SlotStream::missing)
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
