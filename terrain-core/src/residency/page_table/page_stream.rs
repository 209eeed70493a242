use std::collections::{BTreeSet, VecDeque};

use super::page_fades::PageFades;
use super::page_slots::PageSlots;
use super::{PageId, PageLayout};

/// The streaming of pages from disk to memory to the GPU: the paper's J1, J2, H1, H2, Q1, Q2 and the
/// algorithms A1 ([`Self::request`]), A2 ([`Self::upload`]) and A3 ([`Self::loaded`], for a thread that works
/// [`Self::to_load`] off).
///
/// `T` is what memory holds of a page; it is copied to the GPU, so that a page evicted there may come back
/// without the disk.
///
/// Departures from the paper:
/// - A page that waits in a queue and is not asked for any more leaves it again, so that a quick turn of the
///   camera does not load what nobody sees. One that is being loaded then goes to memory, not to the GPU.
/// - Pages go in the order they were asked in, not in that of their arrival in the queue.
/// - Memory for the GPU is bounded by bytes a frame instead of time, so that a frame moves the same whatever
///   the machine. One page always goes through, and those that are always resident (G1) at once.
/// - Table entries of pages that are not there point nowhere instead of to a coarser page: who reads them
///   looks on at the coarser level, so that a page costs one entry however much ground it covers.
/// - A page that cannot be loaded is a state of its own; its users ask for a coarser one.
pub struct PageStream<T> {
    layout: PageLayout,
    /// H1 of all levels: the slot of a page in J1.
    on_gpu: Vec<PageEntry>,
    /// H2 of all levels: the slot of a page in J2.
    in_memory: Vec<PageEntry>,
    /// J1.
    gpu_slots: PageSlots,
    /// J2: the slots and what is in them.
    memory_slots: PageSlots,
    payloads: Vec<Option<T>>,
    /// Q1, most urgent first: pages in memory, to be brought to the GPU.
    to_upload: VecDeque<PageId>,
    /// Q2, most urgent first: pages to be loaded.
    to_load: Vec<PageId>,
    fades: PageFades,
    /// Entries of H1 that have changed since they were last taken.
    changed: BTreeSet<PageId>,
    /// Counts requests: the time by which pages were last seen.
    now: u64,
}

/// An entry of the paper's tables H1 and H2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PageEntry {
    /// Not there and not on its way: -2.
    #[default]
    Absent,
    /// In the queue: -1.
    Queued,
    /// In this slot: 0 and more.
    At(u32),
    /// It cannot be had. Only of memory.
    Failed,
}

/// An entry of H1 as who draws sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChangedPage {
    /// The page's place in a table over all pages.
    pub address: u32,
    /// Its slot and how many of 4 parts of it show, 1 at least; `None` where it is not there.
    pub shown: Option<(u32, u32)>,
}

/// A page to bring to the GPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PageUpload {
    /// The page.
    pub page: PageId,
    /// Its slot in J1.
    pub slot: u32,
    /// The page that made way.
    pub evicted: Option<PageId>,
}

impl<T> PageStream<T> {
    /// Nothing is loaded yet; the always resident pages are asked for.
    ///
    /// `gpu_slots` is N1 and `memory_slots` N2. Both are taken as at least one more than there are always
    /// resident pages, N2 as at least N1.
    pub fn new(layout: PageLayout, gpu_slots: u32, memory_slots: u32) -> Self {
        let pages = layout.page_count() as usize;
        let resident = layout.resident_pages().count() as u32;
        let gpu_slots = gpu_slots.max(resident);
        let memory_slots = memory_slots.max(gpu_slots).max(resident + 1);
        let mut stream = Self {
            on_gpu: vec![PageEntry::Absent; pages],
            in_memory: vec![PageEntry::Absent; pages],
            gpu_slots: PageSlots::new(gpu_slots),
            memory_slots: PageSlots::new(memory_slots),
            payloads: (0..memory_slots).map(|_| None).collect(),
            to_upload: VecDeque::new(),
            to_load: Vec::new(),
            fades: PageFades::default(),
            changed: BTreeSet::new(),
            now: 0,
            layout,
        };
        stream.request(&[]);
        stream
    }

    /// The texture's layout.
    pub fn layout(&self) -> &PageLayout {
        &self.layout
    }

    /// The entry of H1.
    pub fn on_gpu(&self, page: PageId) -> PageEntry {
        self.on_gpu[self.layout.address(page) as usize]
    }

    /// The entry of H2.
    pub fn in_memory(&self, page: PageId) -> PageEntry {
        self.in_memory[self.layout.address(page) as usize]
    }

    /// Pages on the GPU and in memory.
    pub fn resident(&self) -> [usize; 2] {
        [self.gpu_slots.len(), self.memory_slots.len()]
    }

    /// The pages on the GPU and their slots, in the order of the slots.
    pub fn pages_on_gpu(&self) -> impl Iterator<Item = (PageId, u32)> + '_ {
        self.gpu_slots.pages()
    }

    /// Q2: the pages to load, most urgent first, those being loaded among them.
    pub fn to_load(&self) -> &[PageId] {
        &self.to_load
    }

    /// Pages asked for that are not on the GPU yet.
    pub fn missing(&self) -> usize {
        self.to_load.len() + self.to_upload.len()
    }

    /// A1: the pages that are seen now, most urgent first. Those on the GPU or in memory are marked as seen,
    /// those that are not are queued. What was queued before and is not seen any more leaves the queues.
    ///
    /// There must be slots on the GPU for all of them and the always resident ones together; pages that
    /// cannot be had are passed over.
    pub fn request(&mut self, seen: &[PageId]) {
        self.now += 1;
        for page in std::mem::take(&mut self.to_upload) {
            self.set_on_gpu(page, PageEntry::Absent);
        }
        for page in std::mem::take(&mut self.to_load) {
            self.set_in_memory(page, PageEntry::Absent);
        }
        let always = self.layout.resident_pages().collect::<Vec<_>>();
        for &page in always.iter().chain(seen) {
            self.request_page(page);
        }
    }

    fn request_page(&mut self, page: PageId) {
        let (k1, k2) = (self.on_gpu(page), self.in_memory(page));
        if let PageEntry::At(slot) = k1 {
            self.gpu_slots.refresh(slot, self.now);
        }
        if let PageEntry::At(slot) = k2 {
            self.memory_slots.refresh(slot, self.now);
        }
        match (k1, k2) {
            (PageEntry::Absent, PageEntry::Absent) => {
                self.set_in_memory(page, PageEntry::Queued);
                self.to_load.push(page);
            }
            (PageEntry::Absent, PageEntry::At(_)) => {
                self.set_on_gpu(page, PageEntry::Queued);
                self.to_upload.push_back(page);
            }
            _ => {}
        }
    }

    /// The end of A3: the page has been loaded. It goes to memory and, if it is still asked for, into the
    /// queue to the GPU. Where memory is full of pages seen now, a page not asked for is let go.
    pub fn loaded(&mut self, page: PageId, payload: T) {
        let before = self.in_memory(page);
        if matches!(before, PageEntry::At(_) | PageEntry::Failed) {
            return;
        }
        let is_asked_for = before == PageEntry::Queued;
        self.to_load.retain(|queued| *queued != page);
        self.set_in_memory(page, PageEntry::Absent);
        // What nobody sees goes before what was seen by the last request.
        let seen = if is_asked_for { self.now } else { self.now - 1 };
        let Some((slot, evicted)) = self.memory_slots.put(page, self.now) else { return };
        self.memory_slots.refresh(slot, seen);
        if let Some(evicted) = evicted {
            self.set_in_memory(evicted, PageEntry::Absent);
        }
        self.set_in_memory(page, PageEntry::At(slot));
        self.payloads[slot as usize] = Some(payload);
        if is_asked_for && self.on_gpu(page) == PageEntry::Absent {
            self.set_on_gpu(page, PageEntry::Queued);
            self.to_upload.push_back(page);
        }
    }

    /// The page cannot be had: it is not asked for again.
    pub fn failed(&mut self, page: PageId) {
        if !matches!(self.in_memory(page), PageEntry::At(_)) {
            self.to_load.retain(|queued| *queued != page);
            self.set_in_memory(page, PageEntry::Failed);
        }
    }

    /// A2: takes pages off the queue to the GPU as long as their bytes fit the budget, one at least, the
    /// always resident ones whatever they take. What is left stays for the next frame.
    pub fn upload(&mut self, budget_bytes: u64, bytes: impl Fn(&T) -> u64) -> Vec<PageUpload> {
        let (mut uploads, mut sent) = (Vec::new(), 0_u64);
        while let Some(&page) = self.to_upload.front() {
            let is_always_resident = self.layout.is_always_resident(page);
            let page_bytes = self.payload(page).map_or(0, &bytes);
            let fits = sent.saturating_add(page_bytes) <= budget_bytes;
            if !(fits || uploads.is_empty() || is_always_resident) {
                break;
            }
            let Some((slot, evicted)) = self.gpu_slots.put(page, self.now) else { break };
            self.to_upload.pop_front();
            if let Some(evicted) = evicted {
                self.set_on_gpu(evicted, PageEntry::Absent);
                self.fades.forget(evicted);
            }
            self.set_on_gpu(page, PageEntry::At(slot));
            if is_always_resident {
                self.gpu_slots.pin(slot);
            } else {
                self.fades.begin(page);
            }
            sent += page_bytes;
            uploads.push(PageUpload { page, slot, evicted });
        }
        uploads
    }

    /// What memory holds of the page.
    pub fn payload(&self, page: PageId) -> Option<&T> {
        match self.in_memory(page) {
            PageEntry::At(slot) => self.payloads[slot as usize].as_ref(),
            _ => None,
        }
    }

    /// One frame has passed: pages that have become resident show a part more of themselves.
    pub fn advance_fades(&mut self) {
        self.changed.extend(self.fades.advance());
    }

    /// Whether any page does not show as a whole yet.
    pub fn is_fading(&self) -> bool {
        self.fades.is_fading()
    }

    /// What of H1 matters to who draws and has changed since the last call, by address.
    pub fn take_changed(&mut self) -> Vec<ChangedPage> {
        let changed = std::mem::take(&mut self.changed);
        let shown = |page: PageId| match self.on_gpu(page) {
            PageEntry::At(slot) => Some((slot, self.fades.part(page))),
            _ => None,
        };
        let changed = changed.into_iter();
        changed
            .map(|page| ChangedPage { address: self.layout.address(page), shown: shown(page) })
            .collect()
    }

    fn set_on_gpu(&mut self, page: PageId, entry: PageEntry) {
        let address = self.layout.address(page) as usize;
        let before = std::mem::replace(&mut self.on_gpu[address], entry);
        if matches!(before, PageEntry::At(_)) || matches!(entry, PageEntry::At(_)) {
            self.changed.insert(page);
        }
    }

    fn set_in_memory(&mut self, page: PageId, entry: PageEntry) {
        let address = self.layout.address(page) as usize;
        self.in_memory[address] = entry;
    }
}
