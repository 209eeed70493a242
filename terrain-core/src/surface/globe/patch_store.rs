use std::collections::HashMap;

use super::ground::GlobeGround;
use super::patch::GlobePatch;
use super::patch_id::PatchId;
use crate::tiling::Extent;

/// The patches made so far, those least recently looked at forgotten first.
#[derive(Default)]
pub struct PatchStore {
    made: HashMap<PatchId, Made>,
    /// Counts patches made.
    serial: u64,
    turn: u64,
}

/// A patch, and which one made it is.
struct Made {
    patch: GlobePatch,
    serial: u64,
    /// The turn it was last looked at.
    turn: u64,
    /// Whether its ground has changed.
    is_stale: bool,
}

impl PatchStore {
    /// Patches kept at the least; one takes 8 KB.
    const KEPT: usize = 2048;

    /// Begins a turn: what is looked at during one is not forgotten before the next.
    pub fn begin(&mut self) {
        if self.made.len() > Self::KEPT {
            let mut turns: Vec<u64> = self.made.values().map(|made| made.turn).collect();
            let (_, &mut oldest_kept, _) = turns.select_nth_unstable(self.made.len() - Self::KEPT);
            let turn = self.turn;
            self.made.retain(|_, made| made.turn >= oldest_kept || made.turn == turn);
        }
        self.turn += 1;
    }

    /// Whether the patch was made; it may have to be made anew for its ground.
    pub fn has(&self, id: PatchId) -> bool {
        self.made.contains_key(&id)
    }

    /// The patch, made where it is not or its ground has changed, and a number that no other patch made has.
    pub fn get(&mut self, id: PatchId, ground: &GlobeGround) -> (&GlobePatch, u64) {
        let (count, turn) = (&mut self.serial, self.turn);
        let mut make = || {
            *count += 1;
            Made { patch: GlobePatch::new(id, ground), serial: *count, turn, is_stale: false }
        };
        let made = self.made.entry(id).or_insert_with(&mut make);
        if made.is_stale {
            *made = make();
        }
        made.turn = turn;
        (&made.patch, made.serial)
    }

    /// Has all patches made anew whose heights come from any of these extents.
    pub fn ground_changed(&mut self, extents: &[Extent]) {
        for made in self.made.values_mut() {
            made.is_stale |= extents.iter().any(|extent| extent.touches(&made.patch.extent));
        }
    }

    /// Has all patches made anew.
    pub fn all_changed(&mut self) {
        for made in self.made.values_mut() {
            made.is_stale = true;
        }
    }
}
