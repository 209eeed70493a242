//! The height tiles a mesh takes its ground from: which are wanted, loaded, in use and let go.

use std::collections::HashSet;
use std::sync::Arc;
use std::time::Duration;

use glam::DVec3;

use crate::CameraView;
use crate::dataset::{LoadError, Loaded, TileSource};
use crate::layer_loading::loading_of;
use crate::residency::{Taken, TileIntake};
use crate::selection::{SelectionConfig, TileTree, select_by_frustum};
use crate::surface::view_mesh::{HeightPatch, PatchFrame, ViewMesh};
use crate::tiling::TileId;

type LoadedPatch = Result<Loaded<Arc<HeightPatch>>, LoadError>;

/// Height tiles on their way from disk into a mesh, and out again.
pub(super) struct HeightTiles {
    intake: TileIntake<Arc<HeightPatch>>,
    /// Wanted by the latest view, the coarsest first.
    wanted: Vec<TileId>,
    /// What the latest view asked for them by.
    asked: Option<(CameraView, SelectionConfig)>,
    missing: usize,
    /// Whether tiles are to be let go that there was no room for yet.
    has_needless: bool,
}

/// What a frame moved.
#[derive(Default)]
pub(super) struct HeightsMoved {
    pub taken: u64,
    pub let_go: u64,
    pub disk_bytes: u64,
    pub failures: Vec<String>,
}

impl HeightTiles {
    /// Most tiles a view may want. A tile and what is known of its errors take some 170 KB.
    const MOST_WANTED: usize = 512;
    /// Most tiles in use, those out of view that may be seen again counted.
    const MOST_IN_USE: usize = 768;
    /// A tile out of view is let go when the one above it would do even if texels were to be drawn at
    /// this part of their size.
    const KEEP_PART: f64 = 0.7;

    /// Starts loading from the source.
    ///
    /// # Errors
    /// Where the system gives no thread.
    pub fn new(source: &Arc<dyn TileSource>, frame: PatchFrame) -> std::io::Result<Self> {
        let (source, loading) = (Arc::clone(source), loading_of(&**source));
        let load = move |tile| load_patch(&*source, frame, tile);
        Ok(Self {
            // What goes to the GPU of a patch is the mesh's to say.
            intake: TileIntake::new(loading, Arc::new(load), |_| 0)?,
            wanted: vec![TileId::ROOT],
            asked: None,
            missing: 0,
            has_needless: false,
        })
    }

    /// Chooses the tiles for the view: all in view whose texels the tile above would draw too large.
    pub fn select(&mut self, tree: &TileTree, view: &CameraView, config: &SelectionConfig) {
        let config = SelectionConfig { max_tiles: Self::MOST_WANTED, ..*config };
        self.wanted = select_by_frustum(tree, view, &config).height_tiles(tree);
        self.asked = Some((*view, config));
    }

    /// Wanted tiles that are not in use yet but will be.
    pub fn missing(&self) -> usize {
        self.missing
    }

    /// Whether an update would change the mesh even if no tile came.
    pub fn is_unfinished(&self) -> bool {
        self.has_needless
    }

    /// Waits until everything asked for is loaded, at most for `patience`.
    pub fn wait(&self, patience: Duration) {
        self.intake.wait(patience);
    }

    /// Takes what has been loaded into the mesh and lets go what it no longer needs, a tile at least and
    /// then as long as `has_room`; asks for what is missing. Never waits.
    pub fn update(
        &mut self,
        tree: &TileTree,
        mesh: &mut ViewMesh,
        has_room: impl Fn(&ViewMesh) -> bool,
    ) -> HeightsMoved {
        let Taken { disk_bytes, failures } = self.intake.take_loaded();
        let mut moved = HeightsMoved { disk_bytes, failures, ..HeightsMoved::default() };
        let wanted: HashSet<_> = self.wanted.iter().copied().collect();
        self.take_into(mesh, &has_room, &mut moved);
        self.has_needless = self.let_go(tree, mesh, &wanted, &has_room, &mut moved);
        let is_missing = |tile: &&TileId| !mesh.uses(**tile) && !self.is_hopeless(**tile);
        let missing = self.wanted.iter().filter(is_missing).copied().collect::<Vec<_>>();
        self.missing = missing.len();
        let is_absent = |tile: &&TileId| self.intake.ready_bytes(**tile).is_none();
        let requests = missing.iter().filter(is_absent).copied().collect::<Vec<_>>();
        self.intake.ask(&requests, |tile| wanted.contains(&tile));
        moved
    }

    /// Whether the tile, or one above it that it needs, cannot be loaded.
    fn is_hopeless(&self, tile: TileId) -> bool {
        let line = std::iter::successors(Some(tile), |tile| tile.parent());
        line.into_iter().any(|tile| self.intake.has_failed(tile))
    }

    /// The coarsest first: a tile is of no use before the one above it.
    fn take_into(
        &mut self,
        mesh: &mut ViewMesh,
        has_room: &impl Fn(&ViewMesh) -> bool,
        moved: &mut HeightsMoved,
    ) {
        for tile in &self.wanted {
            if moved.taken > 0 && !has_room(mesh) {
                break;
            }
            let is_useful = tile.parent().is_some_and(|parent| mesh.uses(parent));
            let Some(patch) = is_useful.then(|| self.intake.take(*tile)).flatten() else {
                continue;
            };
            mesh.use_patch(patch);
            moved.taken += 1;
        }
    }

    /// Lets tiles go that are neither in view nor nearly so fine as to be wanted; and, where there are too
    /// many, others out of view. Returns whether there are more than there was room for.
    fn let_go(
        &self,
        tree: &TileTree,
        mesh: &mut ViewMesh,
        wanted: &HashSet<TileId>,
        has_room: &impl Fn(&ViewMesh) -> bool,
        moved: &mut HeightsMoved,
    ) -> bool {
        let Some((view, config)) = &self.asked else { return false };
        let fineness = |tile: TileId| {
            let parent = tile.parent()?;
            let distance_m = distance_m(tree, parent, view.eye, config.vertical_exaggeration);
            Some(tree.texel_size_m(parent.level) / distance_m)
        };
        let needed = Self::KEEP_PART * config.texel_px * view.pixel_angle_rad();
        let candidates = mesh.tiles_in_use().filter(|tile| !wanted.contains(tile));
        let mut unwanted =
            candidates.filter_map(|tile| Some((fineness(tile)?, tile))).collect::<Vec<_>>();
        // The least needed first, and of those within one another the finest.
        unwanted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        for (fineness, tile) in unwanted {
            if fineness > needed && mesh.patch_count() <= Self::MOST_IN_USE {
                break;
            }
            if moved.taken + moved.let_go > 0 && !has_room(mesh) {
                return true;
            }
            let before = mesh.patch_count();
            mesh.drop_patch(tile);
            moved.let_go += (before - mesh.patch_count()) as u64;
        }
        false
    }
}

/// Distance in metres from the eye to the nearest point the tile's ground may have.
fn distance_m(tree: &TileTree, tile: TileId, eye: DVec3, vertical_exaggeration: f64) -> f64 {
    let horizontal_m = tree.scheme.tile_extent(tile).distance_m(eye.truncate());
    let vertical_m = tree.height_ranges.range(tile).map_or(0.0, |range| {
        let [a, b] = [range.min_m, range.max_m].map(|h| f64::from(h) * vertical_exaggeration);
        (a.min(b) - eye.z).max(eye.z - a.max(b)).max(0.0)
    });
    horizontal_m.hypot(vertical_m)
}

/// Loads a height tile and makes it ready for a mesh.
pub(super) fn load_patch(source: &dyn TileSource, frame: PatchFrame, tile: TileId) -> LoadedPatch {
    let Loaded { tile: heights, disk_bytes } = source.load_heights(tile)?;
    let present = source.heights_present();
    let has_finer = tile.level < frame.layout.finest_level()
        && tile.children().into_iter().any(|child| present.contains(child));
    let patch = HeightPatch::new(heights, frame, !has_finer);
    Ok(Loaded { tile: Arc::new(patch), disk_bytes })
}
