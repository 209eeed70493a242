use std::collections::HashMap;

use crate::surface::globe::PatchId;

/// Which patch is in which slot on the GPU. No GPU.
pub(super) struct PatchSlots {
    slots: Vec<Slot>,
    of: HashMap<PatchId, usize>,
}

#[derive(Clone, Copy, Default)]
struct Slot {
    patch: Option<PatchId>,
    /// Which making of the patch it holds.
    serial: u64,
    /// The turn in which it was last drawn.
    turn: u64,
}

/// Where a patch goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PatchPlace {
    pub slot: u32,
    /// Whether the slot does not hold it yet, and whether it held another one.
    pub is_new: bool,
    pub evicts: bool,
}

impl PatchSlots {
    pub fn new(slots: u32) -> Self {
        Self { slots: vec![Slot::default(); slots as usize], of: HashMap::new() }
    }

    /// The slot for a patch made as `serial` that is drawn in this turn, which never falls: its own, or that drawn
    /// from longest ago. `None` where all others are drawn in this turn.
    pub fn place(&mut self, patch: PatchId, serial: u64, turn: u64) -> Option<PatchPlace> {
        if let Some(&index) = self.of.get(&patch) {
            let slot = &mut self.slots[index];
            let is_new = slot.serial != serial;
            (slot.serial, slot.turn) = (serial, turn);
            return Some(PatchPlace { slot: index as u32, is_new, evicts: false });
        }
        let age = |slot: &Slot| (slot.patch.is_some(), slot.turn);
        let (index, slot) = self.slots.iter_mut().enumerate().min_by_key(|(_, slot)| age(slot))?;
        if slot.patch.is_some() && slot.turn == turn {
            return None;
        }
        let evicted = slot.patch.replace(patch);
        (slot.serial, slot.turn) = (serial, turn);
        if let Some(evicted) = evicted {
            self.of.remove(&evicted);
        }
        self.of.insert(patch, index);
        Some(PatchPlace { slot: index as u32, is_new: true, evicts: evicted.is_some() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patch(column: u32) -> PatchId {
        PatchId { level: 9, face: 2, column, row: 7 }
    }

    #[test]
    fn the_longest_unseen_makes_way_and_nothing_drawn_does() {
        let mut slots = PatchSlots::new(2);
        let place = |slot, is_new, evicts| Some(PatchPlace { slot, is_new, evicts });
        assert_eq!(slots.place(patch(1), 1, 1), place(0, true, false));
        assert_eq!(slots.place(patch(2), 2, 1), place(1, true, false));
        assert_eq!(slots.place(patch(3), 3, 1), None, "both are drawn");
        assert_eq!(slots.place(patch(2), 2, 2), place(1, false, false));
        assert_eq!(slots.place(patch(3), 3, 2), place(0, true, true));
        assert_eq!(slots.place(patch(2), 4, 3), place(1, true, false), "made anew");
    }
}
