//! The tiles of a layer as a quadtree that grows, and reads its tiles, where it is touched.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec2;

use crate::dataset::LoadError;
use crate::tiling::{MAX_LEVEL, TileId, TileSet, TilingScheme};

/// The content of a tile read, and the bytes it takes in memory.
type LoadTile<T> = dyn Fn(TileId) -> Result<(T, u64), LoadError> + Send + Sync;

/// A layer whose tiles are read on first touch and then kept. Shared between threads without locks
/// once a tile is there; who touches one that is being read waits for it.
pub(super) struct LazyTiles<T> {
    root: LazyTile<T>,
    scheme: TilingScheme,
    present: TileSet,
    load: Box<LoadTile<T>>,
    loaded_bytes: AtomicU64,
    failure: OnceLock<LoadError>,
}

/// One tile of the quadtree. It may be absent itself: its ground is then an ancestor's.
pub(super) struct LazyTile<T> {
    pub id: TileId,
    /// Where its four quarters meet.
    pub middle: DVec2,
    is_present: bool,
    content: OnceLock<Option<Box<T>>>,
    children: OnceLock<Option<Box<[LazyTile<T>; 4]>>>,
}

impl<T> LazyTile<T> {
    fn new(id: TileId, scheme: &TilingScheme, present: &TileSet) -> Self {
        let is_present = present.contains(id);
        let middle = scheme.tile_extent(id).centre();
        Self { id, middle, is_present, content: OnceLock::new(), children: OnceLock::new() }
    }

    /// Whether the layer has this tile.
    pub fn is_present(&self) -> bool {
        self.is_present
    }
}

impl<T> LazyTiles<T> {
    /// The layer with these tiles. A tile is found through its ancestors, as in every dataset that
    /// is prepared: one without a parent is not seen.
    pub fn new(
        scheme: TilingScheme,
        present: TileSet,
        load: impl Fn(TileId) -> Result<(T, u64), LoadError> + Send + Sync + 'static,
    ) -> Self {
        Self {
            root: LazyTile::new(TileId::ROOT, &scheme, &present),
            scheme,
            present,
            load: Box::new(load),
            loaded_bytes: AtomicU64::new(0),
            failure: OnceLock::new(),
        }
    }

    /// The tile of level 0.
    pub fn root(&self) -> &LazyTile<T> {
        &self.root
    }

    /// The four tiles below, in the order of [`TileId::quadrant`]; `None` where none of them is
    /// present.
    pub fn children<'a>(&'a self, tile: &'a LazyTile<T>) -> Option<&'a [LazyTile<T>; 4]> {
        let grow = || {
            if tile.id.level >= MAX_LEVEL {
                return None;
            }
            let children = tile.id.children();
            let has_any = children.iter().any(|&child| self.present.contains(child));
            let new = |child| LazyTile::new(child, &self.scheme, &self.present);
            has_any.then(|| Box::new(children.map(new)))
        };
        tile.children.get_or_init(grow).as_deref()
    }

    /// The tile's content; `None` where it is absent or could not be read (see [`Self::failure`]).
    pub fn content<'a>(&'a self, tile: &'a LazyTile<T>) -> Option<&'a T> {
        if !tile.is_present {
            return None;
        }
        let read = || match (self.load)(tile.id) {
            Ok((content, bytes)) => {
                self.loaded_bytes.fetch_add(bytes, Ordering::Relaxed);
                Some(Box::new(content))
            }
            Err(error) => {
                // The first failure is told; a second one has the same cause as a rule.
                let _ = self.failure.set(error);
                None
            }
        };
        tile.content.get_or_init(read).as_deref()
    }

    /// The finest tile present that holds `wanted`, itself included.
    pub fn nearest(&self, wanted: TileId) -> Option<&LazyTile<T>> {
        let mut tile = &self.root;
        let mut nearest = tile.is_present.then_some(tile);
        while tile.id.level < wanted.level {
            let Some(children) = self.children(tile) else { break };
            tile = &children[wanted.ancestor_at(tile.id.level + 1).quadrant() as usize];
            nearest = tile.is_present.then_some(tile).or(nearest);
        }
        nearest
    }

    /// Bytes that the tiles read so far take in memory.
    pub fn loaded_bytes(&self) -> u64 {
        self.loaded_bytes.load(Ordering::Relaxed)
    }

    /// The first tile that could not be read.
    pub fn failure(&self) -> Option<&LoadError> {
        self.failure.get()
    }
}
