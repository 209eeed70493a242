use std::collections::BTreeSet;

use super::PageId;

/// The slots of one memory (the paper's J1 or J2) and when the page in each was seen last.
///
/// The paper's priority queue of pairs (k, t): of the pages not seen at the present time the one seen
/// longest ago goes first, of several the one in the lowest slot.
#[derive(Clone, Debug)]
pub(super) struct PageSlots {
    slots: Vec<Slot>,
    /// Slots that were never filled, the lowest last.
    free: Vec<u32>,
    /// (t, k) of the pages that may be evicted.
    by_time: BTreeSet<(u64, u32)>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Slot {
    page: Option<PageId>,
    seen: u64,
    is_pinned: bool,
}

impl PageSlots {
    pub fn new(count: u32) -> Self {
        Self {
            slots: vec![Slot::default(); count as usize],
            free: (0..count).rev().collect(),
            by_time: BTreeSet::new(),
        }
    }

    /// The pages and their slots, in the order of the slots.
    pub fn pages(&self) -> impl Iterator<Item = (PageId, u32)> + '_ {
        (0..).zip(&self.slots).filter_map(|(slot, held)| Some((held.page?, slot)))
    }

    /// Number of pages.
    pub fn len(&self) -> usize {
        self.slots.len() - self.free.len()
    }

    /// Notes that the page in the slot was seen now.
    pub fn refresh(&mut self, slot: u32, now: u64) {
        let held = &mut self.slots[slot as usize];
        if !held.is_pinned {
            self.by_time.remove(&(held.seen, slot));
            self.by_time.insert((now, slot));
        }
        held.seen = now;
    }

    /// Puts a page into a free slot or that of the page seen longest ago, if that was before `now`.
    /// Returns the slot and the page that made way; `None` where all pages were seen now.
    pub fn put(&mut self, page: PageId, now: u64) -> Option<(u32, Option<PageId>)> {
        let slot = match self.free.pop() {
            Some(slot) => slot,
            None => {
                let &(seen, slot) = self.by_time.first()?;
                if seen >= now {
                    return None;
                }
                self.by_time.pop_first();
                slot
            }
        };
        let held = Slot { page: Some(page), seen: now, is_pinned: false };
        let before = std::mem::replace(&mut self.slots[slot as usize], held);
        self.by_time.insert((now, slot));
        Some((slot, before.page))
    }

    /// Keeps the page in the slot for ever.
    pub fn pin(&mut self, slot: u32) {
        let held = &mut self.slots[slot as usize];
        held.is_pinned = true;
        self.by_time.remove(&(held.seen, slot));
    }
}
