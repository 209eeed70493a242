use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::time::Duration;

use glam::DVec2;

use super::{
    LevelFill, TexelRect, clip_level_count, level_size_texels, tiles_under, window_around,
};
use crate::dataset::{LoadError, Loaded};
use crate::residency::{Loading, TileLoader};
use crate::selection::LayerTree;
use crate::tiling::{TileId, TilingScheme};

/// One layer's clipmap on its way from disk to the textures: the windows of its levels, the tiles they
/// are filled from, and what is still to be loaded.
pub struct ClipLayer<T: Send + 'static> {
    scheme: TilingScheme,
    layer: LayerTree,
    clip_size: u32,
    keeping: TileKeeping,
    /// Level 0 first.
    levels: Vec<LevelFill>,
    /// Levels that are wanted, from level 0 on; the others keep what they have and show nothing.
    wanted_levels: usize,
    loader: TileLoader<Result<Loaded<T>, LoadError>>,
    /// Tiles in memory.
    tiles: HashMap<TileId, T>,
    /// Tiles that cannot be loaded, and why. Their level ends before them.
    failed: BTreeMap<TileId, String>,
    /// Bytes that 16 texels take on their way to the GPU.
    bytes_of_16_texels: u64,
    missing: usize,
}

/// Which tiles stay in memory once their texels are in the texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TileKeeping {
    /// All that meet a window: they answer questions about the ground.
    Window,
    /// Those that reach beyond a window, whose other texels may be needed next.
    Border,
}

/// Texels to send to the texture of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClipStrip {
    /// The level, 0 the coarsest.
    pub level: u8,
    /// The texels.
    pub rect: TexelRect,
    /// What of the level is in the texture once they are there.
    pub filled: TexelRect,
}

/// What one frame moves in a layer.
#[derive(Debug, Default)]
pub struct ClipLayerUpdate {
    /// Texels to send now, in this order.
    pub strips: Vec<ClipStrip>,
    /// Bytes read from disk since the last frame.
    pub disk_bytes: u64,
    /// Failures since the last frame, in words.
    pub failures: Vec<String>,
}

impl<T: Send + 'static> ClipLayer<T> {
    /// A clipmap of a layer with windows of `clip_size` texels a side, loading with `threads` workers.
    /// `bytes_of_16_texels`: what the budget is told that so many texels take on their way to the GPU.
    ///
    /// # Errors
    /// Where the system gives no thread.
    pub fn new(
        scheme: TilingScheme,
        layer: LayerTree,
        (clip_size, keeping, bytes_of_16_texels): (u32, TileKeeping, u64),
        loading: Loading,
        load: Arc<dyn Fn(TileId) -> Result<Loaded<T>, LoadError> + Send + Sync>,
    ) -> std::io::Result<Self> {
        let levels = vec![LevelFill::default(); usize::from(clip_level_count(&layer.layout))];
        Ok(Self {
            scheme,
            layer,
            clip_size,
            keeping,
            levels,
            wanted_levels: 1,
            loader: TileLoader::new(loading, load)?,
            tiles: HashMap::new(),
            failed: BTreeMap::new(),
            bytes_of_16_texels: bytes_of_16_texels.max(1),
            missing: 0,
        })
    }

    /// Gives the layer a tile that was loaded elsewhere.
    pub fn supply(&mut self, tile: TileId, payload: T) {
        self.tiles.insert(tile, payload);
    }

    /// The layer.
    pub fn layer(&self) -> &LayerTree {
        &self.layer
    }

    /// Side of a window in texels.
    pub fn clip_size(&self) -> u32 {
        self.clip_size
    }

    /// Changes the windows' side, for textures that are new and hold nothing.
    pub fn resize(&mut self, clip_size: u32) {
        self.clip_size = clip_size;
        self.levels.iter_mut().for_each(LevelFill::clear);
    }

    /// A tile in memory.
    pub fn tile(&self, tile: TileId) -> Option<&T> {
        self.tiles.get(&tile)
    }

    /// Tiles in memory.
    pub fn tile_count(&self) -> usize {
        self.tiles.len()
    }

    /// Levels that are wanted, from level 0 on.
    pub fn wanted_levels(&self) -> usize {
        self.wanted_levels
    }

    /// Levels there are.
    pub fn levels(&self) -> usize {
        self.levels.len()
    }

    /// What the budget is told that strips take.
    pub fn bytes_of(&self, strips: &[ClipStrip]) -> u64 {
        strips.iter().map(|strip| strip.rect.area() * self.bytes_of_16_texels / 16).sum()
    }

    /// Tiles that are still to come and strips that wait for their turn.
    pub fn missing(&self) -> usize {
        self.missing
    }

    /// Side of a level's texel in metres.
    pub fn texel_size_m(&self, level: usize) -> f64 {
        self.layer.layout.texel_size_m(&self.scheme, level as u8)
    }

    /// What the wanted levels show, level 0 first: what is filled of each, cropped so that it ends at
    /// least `margin` texels inside what the next coarser one shows.
    pub fn shown(&self, margin: u32) -> Vec<TexelRect> {
        let mut shown = Vec::<TexelRect>::with_capacity(self.wanted_levels);
        for (level, fill) in self.levels.iter().take(self.wanted_levels).enumerate() {
            let size = level_size_texels(&self.layer.layout, level as u8);
            let frame = match shown.last() {
                Some(coarser) => inset_of_finer(coarser, margin, size),
                None => TexelRect::new([0; 2], [size; 2]),
            };
            shown.push(fill.filled().intersection(&frame));
        }
        shown
    }

    /// Takes what has been loaded, so that it counts from now on.
    pub fn take_loaded(&mut self) -> ClipLayerUpdate {
        let mut update = ClipLayerUpdate::default();
        for (tile, result) in self.loader.poll() {
            match result {
                Ok(loaded) => {
                    update.disk_bytes += loaded.disk_bytes;
                    self.tiles.insert(tile, loaded.tile);
                }
                Err(error) => self.give_up(tile, error.to_string(), &mut update),
            }
        }
        for panic in self.loader.take_panics() {
            self.give_up(panic.tile, panic.to_string(), &mut update);
        }
        update
    }

    /// Moves the windows of the first `wanted_levels` levels to the eye, plans what to send within the
    /// budget, round the eye first and coarser levels before finer ones, and asks for the tiles that are not there. A strip goes through
    /// whatever the budget. Never waits.
    pub fn update(
        &mut self,
        eye: DVec2,
        wanted_levels: usize,
        budget_bytes: u64,
    ) -> ClipLayerUpdate {
        let mut update = self.take_loaded();
        self.wanted_levels = wanted_levels.clamp(1, self.levels.len());
        for level in 0..self.wanted_levels {
            let texel = self.texel_of(eye, level);
            let size = level_size_texels(&self.layer.layout, level as u8);
            let window = window_around(texel, size, self.clip_size);
            self.levels[level].move_to(window, texel);
        }
        let waits = self.plan_strips(budget_bytes, &mut update);
        let requests = self.requests(eye);
        self.missing = requests.len() + waits;
        self.loader.set_wanted(&requests);
        update
    }

    /// Drops the tiles nothing needs any more; to be called once the strips have been sent.
    pub fn drop_tiles(&mut self) {
        let (levels, wanted, layout) = (&self.levels, self.wanted_levels, &self.layer.layout);
        let keeping = self.keeping;
        self.tiles.retain(|tile, _| {
            let level = usize::from(tile.level);
            if level == 0 || level >= wanted {
                return level == 0;
            }
            let size = layout.tile_size_texels;
            let rect = TexelRect::new([tile.column * size, tile.row * size], [size; 2]);
            let in_window = rect.intersection(&levels[level].window());
            let reaches_beyond = in_window != rect || !levels[level].filled().covers(&rect);
            !in_window.is_empty() && (keeping == TileKeeping::Window || reaches_beyond)
        });
    }

    /// Waits until everything asked for is loaded, at most for `timeout`.
    pub fn wait(&self, timeout: Duration) {
        self.loader.wait_all(timeout);
    }

    fn give_up(&mut self, tile: TileId, reason: String, update: &mut ClipLayerUpdate) {
        update.failures.push(reason.clone());
        self.failed.insert(tile, reason);
    }

    /// The eye in texels of the level, from the root's corner.
    fn texel_of(&self, eye: DVec2, level: usize) -> [f64; 2] {
        let texel_m = self.texel_size_m(level);
        let from_corner = eye - self.scheme.origin;
        [from_corner.x / texel_m, -from_corner.y / texel_m]
    }

    /// Whether the texels under a rectangle can be sent. Ground without a tile holds no data.
    fn is_ready(&self, rect: &TexelRect, level: u8) -> bool {
        tiles_under(rect, &self.layer.layout, level)
            .all(|tile| self.tiles.contains_key(&tile) || !self.layer.present.contains(tile))
    }

    /// Fills in the strips to send; returns how many levels have more for the next frame.
    fn plan_strips(&mut self, budget_bytes: u64, update: &mut ClipLayerUpdate) -> usize {
        let mut left = budget_bytes;
        loop {
            let most_texels = left.saturating_mul(16) / self.bytes_of_16_texels;
            let mut ready = self.ready_strips(most_texels);
            // All levels grow outwards together; of equals the coarser goes first.
            ready.sort_by(|a, b| self.levels[a.0].part().total_cmp(&self.levels[b.0].part()));
            let Some(&(level, rect)) = ready.first() else { return 0 };
            let bytes = rect.area() * self.bytes_of_16_texels / 16;
            if bytes > left && !update.strips.is_empty() {
                return ready.len();
            }
            left = left.saturating_sub(bytes);
            self.levels[level].take(&rect);
            let filled = self.levels[level].filled();
            update.strips.push(ClipStrip { level: level as u8, rect, filled });
        }
    }

    /// The strip that each wanted level could send next, coarsest level first.
    fn ready_strips(&self, most_texels: u64) -> Vec<(usize, TexelRect)> {
        let tile_size = self.layer.layout.tile_size_texels;
        let levels = self.levels.iter().take(self.wanted_levels).enumerate();
        let strip = |(level, fill): (usize, &LevelFill)| {
            let is_ready = |rect: &TexelRect| self.is_ready(rect, level as u8);
            Some((level, fill.next_strip(tile_size, most_texels, is_ready)?))
        };
        levels.filter_map(strip).collect()
    }

    /// The tiles under what the windows lack: nearest to the eye first, counted in tiles of their own
    /// level, and of those equally near the coarser one.
    fn requests(&self, eye: DVec2) -> Vec<TileId> {
        let mut requests = Vec::new();
        let levels = self.levels.iter().take(self.wanted_levels).enumerate();
        for (level, fill) in levels.filter(|(_, fill)| !fill.is_complete()) {
            let size = self.layer.layout.tile_size_texels;
            let lacks = |tile: &TileId| {
                let rect = TexelRect::new([tile.column * size, tile.row * size], [size; 2]);
                !fill.filled().covers(&rect.intersection(&fill.window()))
                    && !self.tiles.contains_key(tile)
                    && self.layer.present.contains(*tile)
                    && !self.failed.contains_key(tile)
            };
            let tile_size_m = self.scheme.tile_size_m(level as u8);
            let distance = |tile: &TileId| {
                let from_eye = self.scheme.tile_extent(*tile).centre() - eye;
                (from_eye.abs().max_element() / tile_size_m).round() as u64
            };
            let tiles = tiles_under(&fill.window(), &self.layer.layout, level as u8);
            requests.extend(tiles.filter(lacks).map(|tile| (distance(&tile), tile)));
        }
        requests.sort_unstable();
        requests.into_iter().map(|(_, tile)| tile).collect()
    }
}

/// What a level may show where the next coarser one shows `coarser`: its ground less `margin` texels
/// on every side where that is not the end of the level, whose side has `size` texels.
fn inset_of_finer(coarser: &TexelRect, margin: u32, size: u32) -> TexelRect {
    let low = |at: u32| if at == 0 { 0 } else { 2 * at + margin };
    let high = |at: u32| if 2 * at >= size { size } else { (2 * at).saturating_sub(margin) };
    let inset = TexelRect {
        west: low(coarser.west),
        north: low(coarser.north),
        east: high(coarser.east),
        south: high(coarser.south),
    };
    if coarser.is_empty() || inset.is_empty() { TexelRect::default() } else { inset }
}
