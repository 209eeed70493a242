//! The terrain of a clipmap: both layers' windows, what is known of the ground in memory, and which
//! levels the eye's height asks for. No GPU.

use std::sync::Arc;
use std::time::Duration;

use glam::{DVec2, DVec3};

use crate::dataset::{ColourFormat, ColourTile, HeightEncoding, HeightTile, TileSource};
use crate::layer_loading::{OpenTerrainError, load_colours, loading_of};
use crate::measure::{ByteCause, FrameLedger};
use crate::residency::clipmap::{
    ClipLayer, ClipSizes, ClipStrip, TexelRect, TileKeeping, clip_sizes, is_level_wanted,
};
use crate::selection::TileTree;
use crate::tiling::TileId;

/// The windows of both layers.
pub(super) struct ClipTerrain {
    pub tree: TileTree,
    pub heights: ClipLayer<HeightTile>,
    pub colours: Option<ClipLayer<ColourTile>>,
    pub colour_format: ColourFormat,
    /// Counts changes of what the windows show.
    pub version: u64,
    shown: [Vec<TexelRect>; 2],
    failures: Vec<String>,
}

/// Where windows lie and how many levels they need.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ClipFocus {
    pub eye: DVec3,
    /// Size a texel of the imagery, or of the heights without it, may have as seen from the eye.
    pub texel_rad: f64,
    pub vertical_exaggeration: f64,
}

/// Strips to send in a frame.
#[derive(Default)]
pub(super) struct ClipArrivals {
    pub heights: Vec<ClipStrip>,
    pub colours: Vec<ClipStrip>,
}

/// What the budget is told that 16 texels take.
const STEPS_BYTES: u64 = 32;
const FLOAT_BYTES: u64 = 64;

/// Texels by which a level stays inside the coarser one, so that the coarser one can be sampled wherever
/// the finer one fades into it.
const NESTING_TEXELS: u32 = 8;

impl ClipTerrain {
    /// Opens both layers and loads level 0, which waits for the first frame.
    ///
    /// # Errors
    /// Where level 0 cannot be loaded or the system gives no threads.
    pub fn open(
        source: &Arc<dyn TileSource>,
        tree: TileTree,
        colour_format: ColourFormat,
        ledger: &mut FrameLedger,
    ) -> Result<Self, OpenTerrainError> {
        let least = clip_sizes(&tree, f64::INFINITY, texel_bytes(colour_format));
        let manifest = source.manifest();
        let height_bytes = match manifest.heights.encoding {
            HeightEncoding::Steps => STEPS_BYTES,
            HeightEncoding::Float => FLOAT_BYTES,
        };
        let of_heights = Arc::clone(source);
        let mut heights = ClipLayer::new(
            tree.scheme,
            tree.heights.clone(),
            (least.heights, TileKeeping::Window, height_bytes),
            loading_of(&**source),
            Arc::new(move |tile| of_heights.load_heights(tile)),
        )?;
        let loaded = source.load_heights(TileId::ROOT)?;
        ledger.add(ByteCause::Disk, loaded.disk_bytes);
        heights.supply(TileId::ROOT, loaded.tile);
        let colours = match tree.colours.clone().filter(|layer| !layer.present.is_empty()) {
            Some(layer) => {
                let of_colours = Arc::clone(source);
                let mut colours = ClipLayer::new(
                    tree.scheme,
                    layer,
                    (least.colours, TileKeeping::Border, colour_format.byte_len(4)),
                    loading_of(&**source),
                    Arc::new(move |tile| load_colours(&*of_colours, colour_format, tile)),
                )?;
                let loaded = load_colours(&**source, colour_format, TileId::ROOT)?;
                ledger.add(ByteCause::Disk, loaded.disk_bytes);
                colours.supply(TileId::ROOT, loaded.tile);
                Some(colours)
            }
            None => None,
        };
        Ok(Self {
            tree,
            heights,
            colours,
            colour_format,
            version: 0,
            shown: Default::default(),
            failures: Vec::new(),
        })
    }

    /// The windows' sizes.
    pub fn sizes(&self) -> ClipSizes {
        let colours = self.colours.as_ref().map_or(0, ClipLayer::clip_size);
        ClipSizes { heights: self.heights.clip_size(), colours }
    }

    /// The windows' sizes that texels of this size ask for.
    pub fn sizes_for(&self, texel_rad: f64) -> ClipSizes {
        let sizes = clip_sizes(&self.tree, texel_rad, texel_bytes(self.colour_format));
        ClipSizes { colours: if self.colours.is_some() { sizes.colours } else { 0 }, ..sizes }
    }

    /// Changes the windows' sizes, for new textures.
    pub fn resize(&mut self, sizes: ClipSizes) {
        self.heights.resize(sizes.heights);
        if let Some(colours) = &mut self.colours {
            colours.resize(sizes.colours);
        }
    }

    /// Takes in what has been loaded, asks for what the windows lack, and hands out the strips to send
    /// now within the budget: heights first. Never waits.
    pub fn stream(
        &mut self,
        focus: &ClipFocus,
        budget_bytes: u64,
        ledger: &mut FrameLedger,
    ) -> ClipArrivals {
        let mut arrivals = ClipArrivals::default();
        let eye = focus.eye.truncate();
        let loaded = self.heights.take_loaded();
        let (levels, clearance_m) = self.wanted_heights(focus);
        let update = self.heights.update(eye, levels, budget_bytes);
        ledger.add(ByteCause::Disk, loaded.disk_bytes + update.disk_bytes);
        self.failures.extend(loaded.failures.into_iter().chain(update.failures));
        arrivals.heights = update.strips;
        if let Some(colours) = &mut self.colours {
            let levels = (0..)
                .take_while(|&level| {
                    let texel_m = colours.texel_size_m(level);
                    level == 0 || is_level_wanted(texel_m, clearance_m, focus.texel_rad)
                })
                .take(colours.levels())
                .count();
            let left = budget_bytes.saturating_sub(self.heights.bytes_of(&arrivals.heights));
            let update = colours.update(eye, levels, left);
            ledger.add(ByteCause::Disk, update.disk_bytes);
            self.failures.extend(update.failures);
            arrivals.colours = update.strips;
        }
        let shown = [self.shown_heights(), self.shown_colours()];
        let moves = !arrivals.heights.is_empty() || !arrivals.colours.is_empty();
        if moves || shown != self.shown {
            self.version += 1;
            self.shown = shown;
        }
        arrivals
    }

    /// Drops the tiles nothing needs any more, once the strips have been sent.
    pub fn drop_tiles(&mut self) {
        self.heights.drop_tiles();
        if let Some(colours) = &mut self.colours {
            colours.drop_tiles();
        }
    }

    /// What each level of the heights shows.
    pub fn shown_heights(&self) -> Vec<TexelRect> {
        self.heights.shown(NESTING_TEXELS)
    }

    /// What each level of the imagery shows; empty without any.
    pub fn shown_colours(&self) -> Vec<TexelRect> {
        self.colours.as_ref().map_or_else(Vec::new, |colours| colours.shown(NESTING_TEXELS))
    }

    /// Tiles and strips still to come, both layers.
    pub fn missing(&self) -> usize {
        self.heights.missing() + self.colours.as_ref().map_or(0, ClipLayer::missing)
    }

    /// Tiles in memory, both layers.
    pub fn tile_count(&self) -> usize {
        self.heights.tile_count() + self.colours.as_ref().map_or(0, ClipLayer::tile_count)
    }

    /// Finest level in use of either layer.
    pub fn finest_level(&self) -> u8 {
        let colours = self.colours.as_ref().map_or(0, ClipLayer::wanted_levels);
        (self.heights.wanted_levels().max(colours) - 1) as u8
    }

    /// Waits until everything that has been asked for is loaded, at most for `patience` a layer.
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

    /// Height of the ground in metres above the datum, without exaggeration, from the finest tile in
    /// memory that has data there. `None` outside the data.
    pub fn ground_height_m(&self, point: DVec2) -> Option<f64> {
        (0..self.heights.wanted_levels()).rev().find_map(|level| self.height_m(level, point))
    }

    /// Distance in metres from the eye to the ground below it, heights exaggerated; to the nearest
    /// ground where the eye is not over the data.
    pub fn clearance_m(&self, eye: DVec3, vertical_exaggeration: f64) -> f64 {
        let below = self.below(eye);
        let lowest_m = self.tree.height_ranges.range(TileId::ROOT).map(|r| f64::from(r.min_m));
        let ground_m = self.ground_height_m(below).or(lowest_m).unwrap_or(0.0);
        clearance_over_m(eye, below, ground_m * vertical_exaggeration)
    }

    /// Lowest and highest ground in metres, heights exaggerated.
    pub fn height_range_m(&self, vertical_exaggeration: f64) -> [f64; 2] {
        let range = self.tree.height_ranges.range(TileId::ROOT);
        range
            .map_or([0.0; 2], |range| [range.min_m, range.max_m])
            .map(|height_m| f64::from(height_m) * vertical_exaggeration)
    }

    /// Height levels that the eye's height asks for, and its distance to the ground.
    ///
    /// Whether a level is wanted is judged by the next coarser one, which then holds the ground below
    /// the eye: the answer depends on the data alone once that is loaded, and cannot flicker.
    fn wanted_heights(&self, focus: &ClipFocus) -> (usize, f64) {
        let below = self.below(focus.eye);
        let lowest_m =
            self.tree.height_ranges.range(TileId::ROOT).map_or(0.0, |r| f64::from(r.min_m));
        let clearance_m = |ground_m: f64| {
            clearance_over_m(focus.eye, below, ground_m * focus.vertical_exaggeration)
        };
        let texel_rad = focus.texel_rad * self.height_texels_a_colour_texel();
        let mut nearest_m = clearance_m(lowest_m);
        let mut wanted = 0;
        for level in 0..self.heights.levels() {
            let texel_m = self.heights.texel_size_m(level);
            if level > 0 && !is_level_wanted(texel_m, nearest_m, texel_rad) {
                break;
            }
            wanted = level + 1;
            if let Some(ground_m) = self.height_m(level, below) {
                nearest_m = clearance_m(ground_m);
            }
        }
        (wanted, nearest_m)
    }

    /// Side of a texel of the heights in texels of the imagery of the same level; 1 without imagery.
    fn height_texels_a_colour_texel(&self) -> f64 {
        let heights = f64::from(self.tree.heights.layout.tile_size_texels);
        let colours = self.colours.as_ref();
        colours.map_or(1.0, |layer| f64::from(layer.layer().layout.tile_size_texels) / heights)
    }

    /// Height of a level at a point, if its tile is in memory and has data there.
    fn height_m(&self, level: usize, point: DVec2) -> Option<f64> {
        let tile = self.tree.scheme.tile_at(level as u8, point)?;
        let layout = &self.tree.heights.layout;
        self.heights.tile(tile)?.height_at_m(&self.tree.scheme, layout, point)
    }

    /// The point of the data nearest to the eye on the map.
    fn below(&self, eye: DVec3) -> DVec2 {
        eye.truncate().clamp(self.tree.data_extent.min, self.tree.data_extent.max)
    }
}

fn clearance_over_m(eye: DVec3, below: DVec2, ground_m: f64) -> f64 {
    (eye.z - ground_m).hypot(eye.truncate().distance(below))
}

/// Bytes that a texel of the format takes.
fn texel_bytes(format: ColourFormat) -> f64 {
    format.byte_len(4) as f64 / 16.0
}
