//! The height tiles that the globe's mesh is made of: which a cover wants, and which are in memory. No GPU.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;
use std::time::Duration;

use crate::dataset::HeightTile;
use crate::measure::{ByteCause, FrameLedger};
use crate::residency::{LayerStream, TileIntake};
use crate::selection::TileTree;
use crate::surface::globe::{GlobeCover, GlobeGround, PatchStore};
use crate::tiling::{Extent, TileId};

/// Heights on their way from disk into the mesh.
pub(super) struct GlobeHeights {
    pub tree: TileTree,
    /// What the mesh is made of.
    pub ground: GlobeGround,
    stream: LayerStream<HeightTile>,
    resident: HashMap<TileId, Arc<HeightTile>>,
    /// The coarsest first.
    wanted: Vec<TileId>,
    slots: usize,
    failures: Vec<String>,
}

/// What a frame brought.
#[derive(Default)]
pub(super) struct HeightsMoved {
    pub new: u64,
    pub evicted: u64,
    /// Ground whose heights have changed.
    pub changed: Vec<Extent>,
}

impl GlobeHeights {
    /// Most tiles that a patch may want: near a pole all longitudes are one place.
    const MOST_A_PATCH: u32 = 16;

    /// Heights that `intake` loads, as many as `slots` (columns, rows) at a time.
    pub fn new(
        tree: TileTree,
        ground: GlobeGround,
        slots: (u32, u32),
        intake: TileIntake<HeightTile>,
    ) -> Self {
        Self {
            tree,
            ground,
            stream: LayerStream::new(slots, intake),
            resident: HashMap::new(),
            wanted: vec![TileId::ROOT],
            slots: (slots.0 * slots.1) as usize,
            failures: Vec::new(),
        }
    }

    /// Wants the tiles whose samples are as dense as the cover's vertices; with `keep` beside those wanted already,
    /// so that heights that come and the cover cannot go on changing each other.
    pub fn want(&mut self, cover: &GlobeCover, store: &mut PatchStore, keep: bool) {
        if self.ground.is_level() {
            return;
        }
        let mut wanted = BTreeSet::from([TileId::ROOT]);
        if keep {
            wanted.extend(&self.wanted);
        }
        for covered in &cover.patches {
            let (patch, _) = store.get(covered.id, &self.ground);
            let (extent, cell_m) = (patch.extent, patch.cell_m);
            self.add_tiles(&mut wanted, &extent, cell_m);
        }
        self.wanted = wanted.into_iter().take(self.slots).collect();
    }

    fn add_tiles(&self, wanted: &mut BTreeSet<TileId>, extent: &Extent, cell_m: f64) {
        let layer = &self.tree.heights;
        let coarsest_m = layer.layout.texel_size_m(&self.tree.scheme, 0);
        let finest = f64::from(layer.layout.finest_level());
        let mut level = (coarsest_m / cell_m).log2().ceil().clamp(0.0, finest) as u8;
        loop {
            let corner = |x: f64, y: f64| self.tree.scheme.tile_at(level, glam::dvec2(x, y));
            let (Some(first), Some(last)) =
                (corner(extent.min.x, extent.max.y), corner(extent.max.x, extent.min.y))
            else {
                return;
            };
            let columns = first.column..=last.column;
            let rows = first.row..=last.row;
            let count = (last.column - first.column + 1) * (last.row - first.row + 1);
            if count > Self::MOST_A_PATCH && level > 0 {
                level -= 1;
                continue;
            }
            let tiles = rows
                .flat_map(|row| columns.clone().map(move |column| TileId::new(level, row, column)));
            let present = |tile: TileId| {
                let line = std::iter::successors(Some(tile), |tile| tile.parent());
                line.into_iter().find(|tile| layer.present.contains(*tile))
            };
            wanted.extend(tiles.filter_map(present));
            return;
        }
    }

    /// Takes in what has been loaded, within the budget, and asks for what is missing. Never waits.
    pub fn update(
        &mut self,
        budget_bytes: u64,
        frame: u64,
        ledger: &mut FrameLedger,
    ) -> HeightsMoved {
        let update = self.stream.update(&self.wanted, budget_bytes, frame);
        ledger.add(ByteCause::Disk, update.disk_bytes);
        self.failures.extend(update.failures);
        let mut moved = HeightsMoved::default();
        for (placement, tile) in update.uploads {
            moved.new += 1;
            if let Some(evicted) = placement.evicted {
                moved.evicted += 1;
                self.resident.remove(&evicted);
            }
            self.resident.insert(placement.tile, Arc::new(tile));
        }
        let shown: BTreeSet<TileId> =
            self.stream.shown(&self.wanted).into_iter().map(|(tile, _)| tile).collect();
        let hidden: Vec<TileId> =
            self.ground.tiles().filter(|tile| !shown.contains(tile)).collect();
        for tile in hidden {
            self.ground.hide(tile);
            moved.changed.push(self.ground.extent(tile));
        }
        for tile in shown {
            let Some(content) = self.resident.get(&tile).filter(|_| !self.ground.shows(tile))
            else {
                continue;
            };
            self.ground.show(Arc::clone(content));
            moved.changed.push(self.ground.extent(tile));
        }
        moved
    }

    /// Tiles wanted that are not resident yet but will be.
    pub fn missing(&self) -> usize {
        self.stream.missing()
    }

    /// Resident tiles.
    pub fn resident(&self) -> usize {
        self.resident.len()
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
