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

    /// Whether the patch is made.
    pub fn has(&self, id: PatchId) -> bool {
        self.made.contains_key(&id)
    }

    /// The patch, made where it is not, and a number that no other patch made has.
    pub fn get(&mut self, id: PatchId, ground: &GlobeGround) -> (&GlobePatch, u64) {
        let (serial, turn) = (&mut self.serial, self.turn);
        let made = self.made.entry(id).or_insert_with(|| {
            *serial += 1;
            Made { patch: GlobePatch::new(id, ground), serial: *serial, turn }
        });
        made.turn = turn;
        (&made.patch, made.serial)
    }

    /// Forgets all patches with heights from any of these extents.
    pub fn forget_over(&mut self, extents: &[Extent]) {
        let is_touched =
            |made: &Made| extents.iter().any(|extent| extent.touches(&made.patch.extent));
        self.made.retain(|_, made| !is_touched(made));
    }

    /// Forgets all patches.
    pub fn clear(&mut self) {
        self.made.clear();
    }
}
